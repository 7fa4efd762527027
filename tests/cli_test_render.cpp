// The program from outside: render and info, their files and figures.
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "cli_test.h"
#include "image/decode.h"
#include "image/exr.h"

namespace sheen {
namespace {

TEST_F(CliTest, renderNamesItsOutput) {
    const Outcome run = call(kReference);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("wrote     scene.exr (16x12, reference)"), std::string::npos) << run.out;
    const LoadedExr exr = readExr(file("scene.exr"));
    EXPECT_EQ(exr.width, 16);
    EXPECT_EQ(exr.height, 12);
    EXPECT_EQ(exr.colors.count("variance"), 1u);
    EXPECT_EQ(exr.colors.count("N"), 0u);
    EXPECT_EQ(files(), (std::vector<std::string>{"scene.bin", "scene.exr", "scene.gltf"}));
}

TEST_F(CliTest, renderAllLayers) {
    EXPECT_EQ(call(std::string(kReference) + " --layers all --camera front -o a.exr").code, 0);
    EXPECT_EQ(readExr(file("a.exr")).colors.count("N"), 1u);
}

TEST_F(CliTest, filesSayHowTheyWereMade) {
    ASSERT_EQ(call("render scene.gltf --aa 1 --size 16x12 --accuracy 2 -o a.exr").code, 0);
    const Imf::InputFile in(file("a.exr").c_str());
    const auto text = [&](const char* name) {
        return in.header().typedAttribute<Imf::StringAttribute>(name).value();
    };
    EXPECT_EQ(text("software").rfind("sheen ", 0), 0u);
    EXPECT_EQ(text("sheen.scene"), "scene.gltf");
    EXPECT_EQ(text("sheen.method"), "radiance");
    const std::string options = text("sheen.options");
    EXPECT_EQ(options.rfind("--size=16x12 ", 0), 0u) << options;
    for (const char* part :
         {" --aa=1 ", " --accuracy=2 ", " --method=radiance ", " --bounces=all"}) {
        EXPECT_NE(options.find(part), std::string::npos) << part << " of " << options;
    }
    for (const char* other : {"--spp", "--threads", "--output", "--exposure"}) {
        EXPECT_EQ(options.find(other), std::string::npos) << other << " of " << options;
    }
    const auto number = [&](const char* name) {
        return in.header().typedAttribute<Imf::FloatAttribute>(name).value();
    };
    EXPECT_EQ(number("sheen.accuracy"), 2.0f);
    EXPECT_GT(number("sheen.records"), 0.0f);
    EXPECT_LE(number("sheen.estimate_low"), number("sheen.estimate_high"));
    const std::string first = textOf(file("a.exr"));
    ASSERT_EQ(call("render scene.gltf --accuracy 2.0 --size 16x12 --threads 1 -o a.exr --aa 1 "
                   "--bounces all")
                  .code,
              0);
    EXPECT_TRUE(textOf(file("a.exr")) == first);
}

// Masks of materials and nodes, by the names of the scene's file.
TEST_F(CliTest, renderMakesMasks) {
    ASSERT_EQ(call("render scene.gltf --size 64x48 --bounces 1 --layers all -o a.exr").code, 0);
    const LoadedExr exr = readExr(file("a.exr"));
    for (const char* layer : {"CryptoMaterial00", "CryptoObject00"}) {
        const Image<vec3>& first = exr.colors.at(layer);
        const Image<float>& second = exr.scalars.at(std::string(layer) + ".A");
        const Image<float>& alpha = exr.scalars.at("A");
        int partly = 0;
        for (size_t i = 0; i < first.pixels.size(); ++i) {
            const float covered = first.pixels[i].y + second.pixels[i];
            EXPECT_NEAR(covered, alpha.pixels[i], 0.01f) << layer << " " << i;
            partly += covered > 0.0f && covered < 1.0f ? 1 : 0;
        }
        EXPECT_GT(partly, 0) << "edges are smooth";
    }
}

TEST_F(CliTest, renderPng) {
    for (const char* exposure : {"", " --exposure auto", " --exposure -2", " --exposure=1.5"}) {
        const Outcome run = call(std::string(kReference) + " -o a.PNG" + exposure);
        EXPECT_EQ(run.code, 0) << run.err;
        EXPECT_EQ(textOf(file("a.PNG")).substr(1, 3), "PNG");
    }
}

TEST_F(CliTest, renderJsonHoldsEveryFigure) {
    const Outcome run = call(std::string(kReference) + " --json - -o a.exr --threads 1");
    ASSERT_EQ(run.code, 0) << run.err;
    const Json json = Json::parse(run.out);
    for (const char* key : {"method", "size", "threads", "records", "seconds", "pixels_uncovered",
                            "nonfinite_pixels", "negative_pixels", "estimated_rel_rmse", "accuracy",
                            "gather_size", "passes", "diffuse_share", "corrected_share",
                            "too_glossy_share", "sh_order", "gl_renderer", "mrays_per_second"}) {
        EXPECT_TRUE(json.contains(key)) << key;
    }
    for (const char* key : {"total", "load", "gbuffer", "shadow", "placement", "gather", "project",
                            "splat", "compose", "trace", "denoise", "write"}) {
        EXPECT_TRUE(json["seconds"].contains(key)) << key;
    }
    EXPECT_EQ(json["size"], Json::array({16, 12}));
    EXPECT_EQ(json["threads"], 1);
    EXPECT_GT(json["seconds"]["total"].get<double>(), 0.0);
}

// A configuration whose one view doubles what is linear.
TEST_F(CliTest, renderShowsByAViewOfAConfiguration) {
    std::ofstream(file("double.ocio"))
        << "ocio_profile_version: 2\nroles: {default: lin, scene_linear: lin}\n"
           "displays:\n  screen:\n    - !<View> {name: doubled, colorspace: twice}\n"
           "colorspaces:\n  - !<ColorSpace> {name: lin}\n"
           "  - !<ColorSpace> {name: twice, from_scene_reference: "
           "!<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}}\n";
    const std::string render = std::string(kReference) + " --exposure 0 -o ";
    ASSERT_EQ(call(render + "a.png --ocio double.ocio --view doubled").code, 0);
    ASSERT_EQ(call(render + "b.png --ocio double.ocio --view screen/doubled").code, 0);
    EXPECT_EQ(textOf(file("a.png")), textOf(file("b.png")));
    ASSERT_EQ(call(std::string(kReference) + " -o a.exr").code, 0);
    std::ifstream png(file("a.png"), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(png)), {});
    const DecodedImage shown =
        decodeImage({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
    const LoadedExr exr = readExr(file("a.exr"));
    const Image<vec3>& beauty = colorLayer(exr, "beauty");
    int lit = 0;
    for (size_t i = 0; i < beauty.pixels.size(); ++i) {
        const float alpha = exr.scalars.at("A").pixels[i];
        if (alpha < 1.0f) {
            continue;  // there a PNG has the colour of what covers the pixel
        }
        const float expected = std::min(2.0f * beauty.pixels[i].x, 1.0f);
        EXPECT_NEAR(static_cast<float>(shown.rgba[4 * i]) / 65535.0f, expected, 1.0f / 255.0f);
        lit += expected > 0.1f ? 1 : 0;
    }
    EXPECT_GT(lit, 0);
    expectError(render + "a.png --ocio double.ocio --view film", ExitCode::kUsage,
                "screen/doubled");
    expectError(render + "a.png --view film", ExitCode::kUsage, "--ocio");
    expectError(render + "a.exr --ocio double.ocio --view doubled", ExitCode::kUsage, "PNG only");
    std::ofstream(file("broken.ocio")) << "ocio_profile_version: 2\nroles: [";
    expectError(render + "a.png --ocio broken.ocio --view film", ExitCode::kInput, "broken.ocio");
    expectError(render + "a.png --ocio none.ocio --view film", ExitCode::kInput, "none.ocio");
}

// Where there is no EGL it says so.
// Another way to keep the same light, which says that it is less sure of it.
TEST_F(CliTest, renderKeepsLightByPhotons) {
    const auto estimateOf = [&](const std::string& options) {
        const Outcome run =
            call("render scene.gltf --size 24x16 --aa 1 --json a.json -o a.exr " + options);
        EXPECT_EQ(run.code, 0) << run.err;
        EXPECT_EQ(run.out.find("nodes of a cut") != std::string::npos, !options.empty()) << run.out;
        return Json::parse(textOf(file("a.json")))["estimated_rel_rmse"].get<double>();
    };
    const double sure = estimateOf("");
    const Image<vec3> by_elements = colorLayer(readExr(file("a.exr")), "indirect");
    EXPECT_NEAR(estimateOf("--kept-by photons"), std::hypot(sure, 0.05), 0.02);
    const Image<vec3> by_photons = colorLayer(readExr(file("a.exr")), "indirect");
    double sum = 0.0, other = 0.0;
    for (size_t i = 0; i < by_elements.pixels.size(); ++i) {
        sum += by_elements.pixels[i].y;
        other += by_photons.pixels[i].y;
    }
    EXPECT_NEAR(other, sum, 0.03 * sum);
    expectError("render scene.gltf --kept-by photons --bounces 1", ExitCode::kUsage, "--bounces 1");
    expectError("render scene.gltf --kept-by photons --target-error 0.02", ExitCode::kUsage,
                "--kept-by elements");
    expectError("render scene.gltf --kept-by photons --method octree", ExitCode::kUsage,
                "--kept-by");
}

TEST_F(CliTest, renderByEitherOpenglIsTheSameImage) {
    const std::string render = "render scene.gltf --size 64x48 --bounces 1 --gather ";
    expectError(render + "ray --gl vulkan", ExitCode::kUsage, "--gl");
    for (const std::string road : {"ray", "hemicube"}) {
        ASSERT_EQ(call(render + road + " --gl osmesa -o a.exr").code, 0);
        const Outcome run = call(render + road + " --gl egl -o b.exr");
        if (run.code != 0) {
            EXPECT_EQ(run.code, 4) << run.err;
            EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
            // Any other error is one.
            ASSERT_NE(run.err.find("EGL finds no display"), std::string::npos) << run.err;
            GTEST_SKIP() << "no EGL here: " << run.err;
        }
        const Image<vec3> a = colorLayer(readExr(file("a.exr")), "indirect");
        const Image<vec3> b = colorLayer(readExr(file("b.exr")), "indirect");
        double squares = 0.0, sum = 0.0;
        for (size_t i = 0; i < a.pixels.size(); ++i) {
            squares += std::pow(luminance(a.pixels[i] - b.pixels[i]), 2.0);
            sum += luminance(a.pixels[i]);
        }
        const auto count = static_cast<double>(a.pixels.size());
        EXPECT_GT(sum, 0.0);
        EXPECT_LT(std::sqrt(squares / count), 1e-3 * sum / count) << road;
    }
}

TEST_F(CliTest, renderReusesAFileOfRecordsAndRefusesAStaleOne) {
    const auto reused = [this](const std::string& options) {
        const Outcome run = call(
            "render scene.gltf --size 64x48 --bounces 1 -o a.exr --json - "
            "--cache a.records " +
            options);
        EXPECT_EQ(run.code, 0) << run.err;
        const Json json = Json::parse(run.out);
        return std::pair(json["records_reused"].get<int>(), json["records"].get<int>());
    };
    const auto [none, gathered] = reused("");
    EXPECT_EQ(none, 0);
    EXPECT_GT(gathered, 0);
    EXPECT_EQ(reused(""), std::pair(gathered, gathered));
    const auto [some, all] = reused("--camera-at 0.1,1,4");
    EXPECT_GT(some, 0);
    EXPECT_GE(all, some);

    const Outcome other = call("render scene.gltf --size 64x48 --bounces 2 --cache a.records");
    EXPECT_EQ(other.code, 3);
    EXPECT_NE(other.err.find("records of other options"), std::string::npos) << other.err;
    std::string text = textOf(file("scene.gltf"));
    text.replace(text.find("\"roughnessFactor\": 0.6"), 22, "\"roughnessFactor\": 0.7");
    std::ofstream(file("scene.gltf")) << text;
    const Outcome stale = call("render scene.gltf --size 64x48 --bounces 1 --cache a.records");
    EXPECT_EQ(stale.code, 3);
    EXPECT_NE(stale.err.find("before it changed"), std::string::npos) << stale.err;
    EXPECT_EQ(call("render scene.gltf --method reference --cache b.records").code, 2);
}

TEST_F(CliTest, recordsOfClustersAreCounted) {
    const char* const render = "render scene.gltf --size 64x48 -o a.exr --json - --placement";
    const auto stats = [&](const std::string& options) {
        const Outcome run = call(fmt::format("{} {}", render, options));
        EXPECT_EQ(run.code, 0) << run.err;
        return Json::parse(run.out);
    };
    EXPECT_EQ(stats("scan")["records_of_clusters"], 0);
    const Json json = stats("kmeans");
    EXPECT_EQ(json["pixels_uncovered"], 0);
    EXPECT_GT(json["records_of_clusters"], 0);
    EXPECT_LT(json["records_of_clusters"], json["records"]);
    const std::string image = textOf(file("a.exr"));
    stats("kmeans --threads 1");
    EXPECT_TRUE(textOf(file("a.exr")) == image);
    const Outcome run = call("render scene.gltf --size 64x48 -o a.exr --placement kmeans");
    EXPECT_NE(run.out.find(" of clusters); pixels without one: 0"), std::string::npos) << run.out;
}

TEST_F(CliTest, edgesAreSmoothByDefaultWhereTheMethodHasThat) {
    const auto samples = [this](const std::string& options) {
        const Outcome run = call("render scene.gltf --size 16x12 -o a.exr --json - " + options);
        EXPECT_EQ(run.code, 0) << run.err;
        return Json::parse(run.out)["aa"].get<int>();
    };
    EXPECT_EQ(samples(""), 16);
    EXPECT_EQ(samples("--aa 2"), 2);
    EXPECT_EQ(samples("--method octree"), 1);
    EXPECT_EQ(samples("--gather hemicube"), 1);
    for (const char* options : {"--aa 3", "--aa 0", "--method octree --aa 4",
                                "--method denoised --aa 2", "--gather border --aa 16"}) {
        const Outcome run = call(fmt::format("render scene.gltf --size 16x12 {}", options));
        EXPECT_EQ(run.code, 2) << options;
        EXPECT_NE(run.err.find("--aa"), std::string::npos) << run.err;
    }
}

TEST_F(CliTest, aTargetErrorIsReachedOrMissedAloud) {
    const char* const render = "render scene.gltf --size 24x16 -o a.exr --json a.json";
    const Outcome reached = call(fmt::format("{} --target-error 0.5", render));
    ASSERT_EQ(reached.code, 0) << reached.err;
    EXPECT_EQ(reached.err, "");
    Json json = Json::parse(textOf(file("a.json")));
    EXPECT_LE(json["estimated_rel_rmse"].get<double>(), 0.5);
    EXPECT_EQ(json["passes"], 1);

    const Outcome missed = call(fmt::format("{} --gather-size 8 --target-error 0.002", render));
    ASSERT_EQ(missed.code, 0) << missed.err;
    json = Json::parse(textOf(file("a.json")));
    const bool reported = missed.err.find("--target-error 0.002") != std::string::npos;
    EXPECT_EQ(reported, json["estimated_rel_rmse"].get<double>() > 0.002);
    EXPECT_GT(json["passes"].get<int>(), 1);
}

TEST_F(CliTest, aTimeLimitTooShortIsSaidAndTheImageIsWhole) {
    const Outcome late =
        call("render scene.gltf --size 160x120 -o a.exr --json a.json --time-limit 0.1");
    ASSERT_EQ(late.code, 0) << late.err;
    const Json json = Json::parse(textOf(file("a.json")));
    EXPECT_EQ(json["pixels_uncovered"], 0);
    const bool said = late.err.find("--time-limit 0.1: the image took") != std::string::npos;
    EXPECT_EQ(said, json["seconds"]["total"].get<double>() > 0.1) << late.err;
    if (said) {
        EXPECT_EQ(json["passes"], 1);
        EXPECT_EQ(json["accuracy"], 2.0);
    }
}

TEST_F(CliTest, everyWayToGatherRenders) {
    const char* const cached = "render scene.gltf --size 24x16 --gather-size 16";
    for (const char* gather : {"ray", "hemicube", "border", "plane", "larsen"}) {
        SCOPED_TRACE(gather);
        const Outcome run = call(
            fmt::format("{} --gather {} -o {}.exr --json {}.json", cached, gather, gather, gather));
        ASSERT_EQ(run.code, 0) << run.err;
        const Json json = Json::parse(textOf(file(std::string(gather) + ".json")));
        EXPECT_EQ(json["method"], "radiance");
        EXPECT_EQ(json["gather"], gather);
        EXPECT_NE(run.out.find(fmt::format("\ngather    {}\n", gather)), std::string::npos)
            << run.out;
        EXPECT_EQ(json["size"], Json::array({24, 16}));
        EXPECT_GT(json["records"].get<int>(), 0);
        EXPECT_GT(json["pixels_geometry"].get<int>(), 0);
        EXPECT_LT(json["pixels_geometry"].get<int>(), 24 * 16);
        for (const char* key : {"pixels_uncovered", "nonfinite_pixels"}) {
            EXPECT_EQ(json[key], 0) << key;
        }
        EXPECT_NE(json["gl_renderer"], "");
        EXPECT_FALSE(json.contains("mrays_per_second"));
        for (const char* key : {"gather", "project", "placement"}) {
            EXPECT_GE(json["seconds"][key].get<double>(), 0.0) << key;
        }
        EXPECT_EQ(json["seconds"]["trace"], 0.0);
    }
    EXPECT_NE(textOf(file("hemicube.exr")), textOf(file("ray.exr")));
    EXPECT_NE(textOf(file("hemicube.exr")), textOf(file("border.exr")));
}

TEST_F(CliTest, recordsGatherByRaysUnlessAsked) {
    const char* const cached = "render scene.gltf --size 24x16 --gather-size 16";
    ASSERT_EQ(call(fmt::format("{} --gather ray -o ray.exr", cached)).code, 0);
    const Outcome run = call(fmt::format("{} -o default.exr --json default.json", cached));
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("gather    ray\n"), std::string::npos) << run.out;
    EXPECT_EQ(Json::parse(textOf(file("default.json")))["gather"], "ray");
    EXPECT_EQ(textOf(file("default.exr")), textOf(file("ray.exr")));
}

TEST_F(CliTest, baselinesRender) {
    const char* const small = "render scene.gltf --size 24x16 --json - --layers all";
    const Outcome octree =
        call(fmt::format("{} --method octree --accuracy 0.5 --gather-size 8 -o octree.exr", small));
    ASSERT_EQ(octree.code, 0) << octree.err;
    const Json cached = Json::parse(octree.out);
    EXPECT_EQ(cached["method"], "octree");
    EXPECT_GT(cached["records"].get<int>(), 0);
    EXPECT_EQ(cached["pixels_uncovered"], 0);
    EXPECT_GT(cached["seconds"]["gather"].get<double>(), 0.0);
    EXPECT_EQ(cached["gl_renderer"], "");
    EXPECT_FALSE(cached.contains("gather"));
    const Outcome irradiance = call(fmt::format("{} --method irradiance -o irradiance.exr", small));
    ASSERT_EQ(irradiance.code, 0) << irradiance.err;
    EXPECT_EQ(Json::parse(irradiance.out)["gather"], "ray");
    EXPECT_EQ(readExr(file("octree.exr")).colors.count("indirect_diffuse"), 1u);

    const Outcome denoised =
        call(fmt::format("{} --method denoised --spp 16 --bounces 2 -o denoised.exr", small));
    ASSERT_EQ(denoised.code, 0) << denoised.err;
    const Json traced = Json::parse(denoised.out);
    EXPECT_EQ(traced["records"], 0);
    EXPECT_FALSE(traced.contains("gather"));
    EXPECT_GT(traced["seconds"]["denoise"].get<double>(), 0.0);
    EXPECT_GT(traced["mrays_per_second"].get<double>(), 0.0);
    // What a filter blurred no variance knows: such an image is no reference.
    EXPECT_EQ(readExr(file("denoised.exr")).colors.count("variance"), 0u);

    for (const char* other : {"octree.exr", "denoised.exr"}) {
        EXPECT_EQ(call(fmt::format("compare {} octree.exr --layer direct", other)).code, 0);
    }
    // Options given to both caches under one name reach the one that was asked for.
    ASSERT_EQ(call("render scene.gltf --size 24x16 --method octree --accuracy 1.5 -o b.exr").code,
              0);
    EXPECT_NE(textOf(file("octree.exr")), textOf(file("b.exr")));
}

TEST_F(CliTest, hintsRender) {
    const char* const small = "render scene.gltf --size 24x16 --method hints --hints 500";
    const Outcome run = call(fmt::format("{} -o a.exr --json - --layers all", small));
    ASSERT_EQ(run.code, 0) << run.err;
    const Json json = Json::parse(run.out);
    EXPECT_EQ(json["method"], "hints");
    EXPECT_EQ(json["aa"], 1);
    EXPECT_EQ(json["records"], 0);
    EXPECT_GT(json["hints"].get<int>(), 100);
    EXPECT_GT(json["lit_samples"].get<int>(), 0);
    EXPECT_EQ(json["gl_renderer"], "");
    EXPECT_TRUE(json["estimated_rel_rmse"].is_null());
    const LoadedExr exr = readExr(file("a.exr"));
    EXPECT_EQ(exr.colors.count("indirect_diffuse"), 1u);
    EXPECT_EQ(exr.scalars.count("weight.Y") + exr.scalars.count("records.Y"), 0u);
    // Pixels see what those of other methods do, so that they are compared.
    ASSERT_EQ(call("render scene.gltf --size 24x16 --aa 1 -o cache.exr").code, 0);
    EXPECT_EQ(call("compare a.exr cache.exr --layer direct").code, 0);
    // Threads change nothing; bounces, order and number do.
    ASSERT_EQ(call(fmt::format("{} -o b.exr --layers all --threads 1", small)).code, 0);
    EXPECT_EQ(textOf(file("a.exr")), textOf(file("b.exr")));
    for (const char* option : {"--bounces 1", "--sh-order 2", "--hints 1000"}) {
        const std::string text = option == std::string("--hints 1000")
                                     ? "render scene.gltf --size 24x16 --method hints"
                                     : small;
        ASSERT_EQ(call(fmt::format("{} {} -o b.exr --layers all", text, option)).code, 0);
        EXPECT_NE(textOf(file("a.exr")), textOf(file("b.exr"))) << option;
    }
    EXPECT_NE(call(fmt::format("{} -o b.exr", small)).out.find("hints     "), std::string::npos);
}

TEST_F(CliTest, threadsAndRepetitionChangeNothing) {
    ASSERT_EQ(call(std::string(kReference) + " -o a.exr --threads 1").code, 0);
    ASSERT_EQ(call(std::string(kReference) + " -o b.exr --threads 2").code, 0);
    ASSERT_EQ(call(std::string(kReference) + " -o c.exr --seed 1").code, 0);
    EXPECT_EQ(textOf(file("a.exr")), textOf(file("b.exr")));
    EXPECT_NE(textOf(file("a.exr")), textOf(file("c.exr")));
}

TEST_F(CliTest, interruptedRenderLeavesNothing) {
    const std::vector<std::string> before = files();
    // `timeout` sends the signal to the render once it is under way.
    const std::string command = fmt::format(
        "cd '{}' && timeout --signal=INT 1 '{}' render scene.gltf --method reference "
        "--size 4096x4096 --spp 65536 >/dev/null 2>&1 </dev/null",
        folder_.string(), SHEEN_PROGRAM);
    EXPECT_NE(std::system(command.c_str()), 0);
    EXPECT_EQ(files(), before);
}

TEST_F(CliTest, infoText) {
    const Outcome run = call("info scene.gltf");
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("2 triangles"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("plaster: roughness 0.6 (alpha 0.36)"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("light 0 lamp: point"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("camera 0 front"), std::string::npos) << run.out;
}

TEST_F(CliTest, infoJson) {
    ASSERT_EQ(call("info scene.gltf --json a.json").code, 0);
    const Json json = Json::parse(textOf(file("a.json")));
    EXPECT_EQ(json["triangles"], 2);
    EXPECT_EQ(json["vertices"], 6);
    EXPECT_EQ(json["materials"][0]["name"], "plaster");
    EXPECT_EQ(json["lights"][0]["kind"], "point");
    EXPECT_EQ(json["cameras"][0]["name"], "front");
    EXPECT_EQ(json["bounds"]["upper"], Json::array({4.0, 8.0, 4.0}));
}

TEST_F(CliTest, pathsArePrintedAsTraced) {
    const Outcome run = call("render scene.gltf --method reference --size 8x8 --spp 5 --json -");
    EXPECT_EQ(Json::parse(run.out)["spp"], 8);  // four replicates of two
}

// One record has no neighbours to judge it; probes do.
TEST_F(CliTest, aPixelAloneHasAnEstimate) {
    const Outcome run = call("render scene.gltf --size 1x1");
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("estimate  rel_rmse"), std::string::npos) << run.out;
    const Json json = Json::parse(call("render scene.gltf --size 1x1 --json -").out);
    EXPECT_EQ(json["records"], 1);
    const auto estimate = json["estimated_rel_rmse"].get<double>();
    EXPECT_GT(estimate, 0.0);
    EXPECT_LT(estimate, 0.1);
    EXPECT_LE(json["estimate_low"].get<double>(), estimate);
    EXPECT_GE(json["estimate_high"].get<double>(), estimate);
}

TEST_F(CliTest, aGivenSkyShowsUnlessTransparent) {
    for (const char* method :
         {"radiance", "irradiance", "reference", "denoised", "octree", "hints"}) {
        for (const bool transparent : {false, true}) {
            const Outcome run = call(
                fmt::format("render scene.gltf --method {} --size 24x16 -o a.exr --environment "
                            "1,2,3 --environment-strength 2 {}",
                            method, transparent ? "--transparent" : ""));
            ASSERT_EQ(run.code, 0) << run.err;
            const LoadedExr exr = readExr(file("a.exr"));
            ASSERT_EQ(exr.primitive.at(0, 0), kNoPrimitive);
            EXPECT_EQ(exr.scalars.at("A").at(0, 0), transparent ? 0.0f : 1.0f) << method;
            EXPECT_EQ(exr.colors.at("beauty").at(0, 0), transparent ? vec3(0.0f) : vec3(2, 4, 6))
                << method;
        }
    }
}

// Apart where the scene has something specular, and then judged alike.
TEST_F(CliTest, causticsAreALayerOfTheirOwn) {
    std::string polished = kScene;
    const std::string rough = "\"roughnessFactor\": 0.6";
    polished.replace(polished.find(rough), rough.size(), "\"roughnessFactor\": 0.2");
    std::ofstream(file("polished.gltf")) << polished;
    const auto layers = [this](const std::string& command, const char* output) {
        const Outcome run = call(fmt::format("{} --size 16x16 --aa 1 -o {}", command, output));
        EXPECT_EQ(run.code, 0) << run.err;
        return readExr(file(output)).colors;
    };
    EXPECT_EQ(layers("render scene.gltf", "rough.exr").count("caustic"), 0u);
    const auto apart = layers("render polished.gltf --caustics 20000", "apart.exr");
    ASSERT_EQ(apart.count("caustic"), 1u);
    const auto whole = layers("render polished.gltf --caustics none", "whole.exr");
    EXPECT_EQ(whole.count("caustic"), 0u);
    const std::string reference = "render polished.gltf --method reference --spp 64";
    EXPECT_EQ(layers(reference, "truth.exr").count("variance_global"), 1u);
    EXPECT_EQ(layers(reference + " --caustics none", "all.exr").count("caustic"), 0u);
    double caustic = 0.0;
    for (const vec3& light : apart.at("caustic").pixels) {
        caustic += light.y;
    }
    EXPECT_GT(caustic, 0.0);
    // Whatever the layers hold, they are told apart, or added.
    for (const char* pair : {"whole.exr truth.exr", "apart.exr all.exr"}) {
        expectError(fmt::format("compare {}", pair), ExitCode::kInput, "indirect+caustic");
        EXPECT_EQ(call(fmt::format("compare {} --layer caustic", pair)).code, 3);
        const Outcome sum = call(fmt::format("compare {} --layer indirect+caustic --json -", pair));
        EXPECT_NE(sum.out.find("rel_rmse"), std::string::npos) << sum.err;
    }
    const Outcome both = call("compare truth.exr all.exr --layer indirect+caustic --json -");
    EXPECT_LT(Json::parse(both.out)["rel_rmse"].get<double>(), 1e-3) << both.err;
}

}  // namespace
}  // namespace sheen
