// The program from outside: chart and compare.
#include "cli_test.h"
#include "image/exr.h"

namespace sheen {
namespace {

TEST_F(CliTest, chartErrors) {
    std::ofstream(file("text.glb")) << "this is no scene\n";
    std::ofstream(file("taken")) << "a file\n";
    fs::create_directory(file("charts"));
    fs::create_directory(file("charts/chart.html"));
    expectError("chart scene.gltf", ExitCode::kUsage, "--output is required");
    expectError("chart -o new", ExitCode::kUsage, "SCENE is required");
    expectError("chart scene.gltf -o new --methods radiance,magic", ExitCode::kUsage, "magic");
    expectError("chart scene.gltf -o new --size 8", ExitCode::kUsage, "--size 8");
    for (const char* option : {"--reference-spp 15", "--reference-spp many", "--repeats 0"}) {
        expectError(fmt::format("chart scene.gltf -o new {}", option), ExitCode::kUsage, "--re");
    }
    expectError("chart scene.gltf ./scene.gltf -o new", ExitCode::kUsage, "given twice");
    expectError("chart scene.gltf -o new --camera side", ExitCode::kUsage, "--camera side");
    expectError("chart scene.gltf none.glb -o new", ExitCode::kInput, "none.glb");
    expectError("chart scene.gltf text.glb -o new", ExitCode::kInput, "text.glb");
    expectError("chart scene.gltf -o taken", ExitCode::kEnvironment, "taken");
    expectError("chart scene.gltf -o taken/new", ExitCode::kEnvironment, "taken/new");
    expectError("chart scene.gltf -o charts --size 8x8 --reference-spp 16", ExitCode::kEnvironment,
                "chart.html");
    EXPECT_TRUE(fs::is_empty(file("charts/references"))) << "found before the long work";
}

TEST_F(CliTest, chartOfASceneWithoutLight) {
    std::string dark = kScene;
    const std::string lamp = "\"intensity\": 20.0";
    dark.replace(dark.find(lamp), lamp.size(), "\"intensity\": 0.0");
    std::ofstream(file("dark.gltf")) << dark;
    const Outcome run = call("chart dark.gltf -o new --size 8x8 --reference-spp 16");
    EXPECT_EQ(run.code, 3) << run.err;
    EXPECT_NE(run.err.find("error: dark.gltf: camera 'front' sees no indirect light"),
              std::string::npos)
        << run.err;
    EXPECT_FALSE(fs::exists(file("new/chart.html")));
}

TEST_F(CliTest, chartWritesItsFiles) {
    const std::string command =
        "chart scene.gltf -o a/chart --methods reference --size 8x8 --reference-spp 32 --repeats 1";
    const Outcome run = call(command);
    ASSERT_EQ(run.code, 0) << run.err;
    for (const char* line :
         {"[1/5] scene, reference, 32 paths a pixel: ", "[5/5] scene, path tracer, spp 1024: "}) {
        EXPECT_NE(run.err.find(line), std::string::npos) << run.err;
    }
    EXPECT_NE(run.out.find("wrote     a/chart/chart.html"), std::string::npos) << run.out;
    for (const char* name : {"chart.html", "chart.csv", "chart.json"}) {
        EXPECT_TRUE(fs::exists(folder_ / "a/chart" / name)) << name;
    }
    const Json json = Json::parse(textOf(file("a/chart/chart.json")));
    EXPECT_EQ(json["scenes"][0]["points"].size(), 4u);
    const Outcome again = call(command);
    EXPECT_EQ(again.code, 0);
    EXPECT_EQ(again.err, "4 of 4 runs were measured before\n");
    EXPECT_EQ(Json::parse(textOf(file("a/chart/chart.json"))), json);
}

TEST_F(CliTest, interruptedChartLeavesNoHalfFile) {
    // The signal reaches the chart alone, which takes the render that it measures with it.
    const std::string command = fmt::format(
        "cd '{}' && timeout --foreground --signal=INT 2 '{}' chart scene.gltf -o chart "
        "--methods reference --size 512x512 --reference-spp 16 --repeats 99 >/dev/null 2>&1 "
        "</dev/null",
        folder_.string(), SHEEN_PROGRAM);
    EXPECT_NE(std::system(command.c_str()), 0);
    const auto half_files = [this] {
        int count = 0;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / "chart")) {
            count += entry.path().extension() == ".tmp" ? 1 : 0;
        }
        return count;
    };
    for (int i = 0; half_files() > 0 && i < 50; ++i) {
        usleep(100000);  // the render ends by itself, a moment after the chart
    }
    EXPECT_EQ(half_files(), 0);
    EXPECT_FALSE(fs::exists(file("chart/chart.html")));
}

// Two frames of 4 x 4 pixels: the reference 1 everywhere, the test 1.1; with `variance`.
void writePair(const std::string& test, const std::string& reference, float variance) {
    Frame frame;
    frame.primitive = Image<uint32_t>(4, 4, 0u);
    frame.indirect = Image<vec3>(4, 4, vec3(1.0f));
    frame.direct = Image<vec3>(4, 4, vec3(2.0f));
    frame.indirect_variance = Image<vec3>(4, 4, vec3(variance));
    writeExr(reference, frame, ExrLayers::kBasic);
    frame.indirect = Image<vec3>(4, 4, vec3(1.1f));
    frame.primitive.at(0, 0) = 1;
    writeExr(test, frame, ExrLayers::kBasic);
}

TEST_F(CliTest, compareFigures) {
    writePair(file("a.exr"), file("b.exr"), 0.0f);
    const Outcome run = call("compare a.exr b.exr --json - --heatmap h.png");
    ASSERT_EQ(run.code, 0) << run.err;
    const Json json = Json::parse(run.out);
    EXPECT_EQ(json.size(), 11u);
    EXPECT_NEAR(json["rel_rmse"].get<double>(), 0.1, 1e-6);
    EXPECT_NEAR(json["rel_mse"].get<double>(), 0.01, 1e-6);
    EXPECT_NEAR(json["bias"].get<double>(), 0.1, 1e-6);
    EXPECT_EQ(json["noise_share"], 0.0);
    EXPECT_EQ(json["excluded"], 1);
    EXPECT_EQ(json["noise_median"], 0.0);
    EXPECT_EQ(json["noise_p99"], 0.0);
    for (const char* key : {"median", "p99", "max", "tile_max"}) {
        EXPECT_TRUE(json.contains(key)) << key;
    }
    EXPECT_EQ(textOf(file("h.png")).substr(1, 3), "PNG");
    const Outcome text = call("compare a.exr b.exr");
    EXPECT_NE(text.out.find("rel_rmse    10.000%"), std::string::npos) << text.out;
}

TEST_F(CliTest, compareTakesTheVarianceOff) {
    writePair(file("a.exr"), file("b.exr"), 0.0036f);
    const Outcome run = call("compare a.exr b.exr --json -");
    ASSERT_EQ(run.code, 0) << run.err;
    const Json json = Json::parse(run.out);
    EXPECT_NEAR(json["rel_rmse"].get<double>(), 0.08, 1e-6);
    EXPECT_NEAR(json["noise_share"].get<double>(), 0.36, 1e-5);
    // Of a normal variable's absolute values half lie below 0.6745 of its standard deviation.
    EXPECT_NEAR(json["noise_median"].get<double>(), 0.67449 * 0.06 / 1.01, 1e-5);
}

TEST_F(CliTest, compareRefusesANoisyReference) {
    writePair(file("a.exr"), file("b.exr"), 0.006f);
    const Outcome run = call("compare a.exr b.exr --json a.json");
    EXPECT_EQ(run.code, 3);
    EXPECT_NE(run.err.find("not judged: 60% of the difference"), std::string::npos) << run.err;
    EXPECT_NEAR(Json::parse(textOf(file("a.json")))["noise_share"].get<double>(), 0.6, 1e-5);
}

TEST_F(CliTest, compareMismatches) {
    writePair(file("a.exr"), file("b.exr"), 0.0f);
    Frame wide;
    wide.primitive = Image<uint32_t>(5, 4, 0u);
    wide.indirect = Image<vec3>(5, 4, vec3(1.0f));
    writeExr(file("wide.exr"), wide, ExrLayers::kBasic);
    Frame nothing;
    nothing.primitive = Image<uint32_t>(4, 4, kNoPrimitive);
    nothing.indirect = Image<vec3>(4, 4);
    writeExr(file("nothing.exr"), nothing, ExrLayers::kBasic);
    std::ofstream(file("text.exr")) << "no image\n";

    expectError("compare a.exr none.exr", ExitCode::kInput, "none.exr: no such file");
    expectError("compare text.exr b.exr", ExitCode::kInput, "text.exr: not an EXR file");
    expectError("compare a.exr b.exr --layer indirect_diffuse", ExitCode::kInput,
                "no layer 'indirect_diffuse'");
    expectError("compare wide.exr b.exr", ExitCode::kInput, "5");
    EXPECT_EQ(call("compare nothing.exr b.exr").code, 3);
    EXPECT_EQ(call("compare a.exr b.exr --layer direct").code, 0);
}

TEST_F(CliTest, compareReferenceWithItself) {
    ASSERT_EQ(call(std::string(kReference) + " -o a.exr").code, 0);
    ASSERT_EQ(call(std::string(kReference) + " -o b.exr --seed 1").code, 0);
    const Outcome same = call("compare a.exr a.exr --json -");
    ASSERT_EQ(same.code, 0) << same.err;
    EXPECT_EQ(Json::parse(same.out)["rel_rmse"], 0.0);
    // Two renders of equal noise: half of the squared difference is the reference's.
    const Json other = Json::parse(call("compare b.exr a.exr --json -").out);
    EXPECT_GT(other["noise_share"].get<double>(), 0.2);
}

TEST_F(CliTest, compareNamesTheFile) {
    ASSERT_EQ(call("render scene.gltf --size 8x8 -o small.exr").code, 0);
    ASSERT_EQ(call("render scene.gltf --size 9x8 -o large.exr").code, 0);
    expectError("compare small.exr large.exr", ExitCode::kInput,
                "small.exr has 8x8 pixels, large.exr 9x8");
}

TEST_F(CliTest, comparesFoldersAsAPage) {
    for (const char* folder : {"a", "b", "none"}) {
        fs::create_directory(file(folder));
    }
    const std::string render = "render scene.gltf --size 16x12 --bounces 1 --aa 1 --caustics none ";
    ASSERT_EQ(call(render + "--accuracy 2 -o a/one.exr").code, 0);
    ASSERT_EQ(call(render + "--method reference --spp 4096 -o b/one.exr").code, 0);
    fs::copy(file("b/one.exr"), file("a/same.exr"));
    fs::copy(file("b/one.exr"), file("b/same.exr"));
    fs::copy(file("b/one.exr"), file("b/lonely.exr"));
    Outcome run = call("compare a b --page page.html --json figures.json");
    EXPECT_NE(run.err.find("lonely.exr is not there"), std::string::npos) << run.err;
    const std::string page = textOf(file("page.html"));
    EXPECT_LT(page.find("one.exr"), page.find("same.exr")) << "the worst first";
    EXPECT_EQ(page.find("http"), std::string::npos) << "no network";
    const Json figures = Json::parse(textOf(file("figures.json")));
    ASSERT_EQ(figures.size(), 2u);
    EXPECT_EQ(figures[1]["image"], "same.exr");
    EXPECT_EQ(figures[1]["rel_rmse"], 0.0);

    std::ofstream(file("a/broken.exr")) << "no image";
    fs::copy(file("b/one.exr"), file("b/broken.exr"));
    run = call("compare a b --page page.html");
    EXPECT_EQ(run.code, 3);
    EXPECT_NE(textOf(file("page.html")).find("not an EXR file"), std::string::npos);
    EXPECT_EQ(call("compare a none --page page.html").code, 3);
    EXPECT_EQ(call("compare a missing --page page.html").code, 3);
    EXPECT_EQ(call("compare a b --page page.png").code, 2);
}

}  // namespace
}  // namespace sheen
