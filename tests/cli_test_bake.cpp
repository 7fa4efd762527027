// sheen bake from outside.
#include "cli_test.h"

namespace sheen {
namespace {

class CliBakeTest : public CliTest {};

TEST_F(CliBakeTest, writesWhatItIsAskedFor) {
    const Outcome baked =
        call("bake scene.gltf --size 32 -q -o a.glb -o a.exr -o a.png --json a.json");
    ASSERT_EQ(baked.code, 0) << baked.err;
    const Json json = Json::parse(textOf(file("a.json")));
    EXPECT_EQ(json.at("size"), 32);
    EXPECT_GT(json.at("texels_covered"), 100);
    EXPECT_EQ(json.at("texels_uncovered"), 0);
    const Outcome info = call("info a.glb");
    EXPECT_EQ(info.code, 0) << info.err;
    EXPECT_NE(info.out.find("2 triangles"), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("MOZ_lightmap"), std::string::npos) << info.out;
    EXPECT_EQ(call("bake scene.gltf --size 32 -q --method texels -o b.exr").code, 0);
    EXPECT_EQ(call("compare a.exr b.exr").code, 0);
    // Paths come in four replicates, and what is said is what was traced.
    EXPECT_EQ(
        call("bake scene.gltf --size 32 -q --method reference --spp 5 -o d.exr --json d.json").code,
        0);
    EXPECT_EQ(Json::parse(textOf(file("d.json"))).at("spp"), 8);
    // Its own coordinates will do.
    EXPECT_EQ(call("bake a.glb --environment 1,1,1 --size 32 -q -o c.exr --json c.json").code, 0);
    EXPECT_EQ(Json::parse(textOf(file("c.json"))).at("own_coordinates"), true);
}

// Floor and wall do not fit into one.
TEST_F(CliBakeTest, severalLightmapsWhereOneIsTooSmall) {
    const std::string atlas = "bake scene.gltf --size 56 --texels-per-metre 6 -q ";
    const Outcome baked = call(atlas + "--directional -o a.glb -o a.exr -o a.png --json a.json");
    ASSERT_EQ(baked.code, 0) << baked.err;
    const Json json = Json::parse(textOf(file("a.json")));
    EXPECT_EQ(json.at("pages"), 2);
    EXPECT_EQ(json.at("outputs"), Json({"a.glb", "a.0.exr", "a.1.exr", "a.0.png", "a.1.png"}));
    EXPECT_FALSE(fs::exists(file("a.exr")));
    EXPECT_TRUE(fs::exists(file("a.1.png")));
    EXPECT_NE(textOf(file("a.1.exr")).find("sh3.B"), std::string::npos);
    const Outcome shown = call("render a.glb --size 16x12 -o r.exr --json r.json");
    EXPECT_EQ(shown.code, 0) << shown.err;
    EXPECT_EQ(Json::parse(textOf(file("r.json"))).at("method"), "lightmap");
    ASSERT_EQ(call(atlas + "--method texels -o b.exr").code, 0);
    EXPECT_EQ(call("compare a.0.exr b.0.exr").code, 0);
    EXPECT_EQ(call("compare a.1.exr b.1.exr").code, 0);
    EXPECT_NE(textOf(file("a.0.exr")), textOf(file("a.1.exr")));
    EXPECT_NE(textOf(file("a.0.png")), textOf(file("a.1.png")));
    expectError(atlas + "-o c.exr --json c.1.exr", ExitCode::kUsage, "is the file of --json");
}

TEST_F(CliBakeTest, whatIsBakedIsShown) {
    ASSERT_EQ(call("bake scene.gltf --size 32 -q -o a.glb").code, 0);
    const Outcome shown = call("render a.glb --size 16x12 -o a.exr --json a.json");
    EXPECT_EQ(shown.code, 0) << shown.err;
    EXPECT_EQ(shown.err.find("lightmap"), std::string::npos) << shown.err;
    EXPECT_EQ(Json::parse(textOf(file("a.json"))).at("method"), "lightmap");
    EXPECT_NE(call("render a.glb --size 16x12 -o b.exr").out.find("lightmap"), std::string::npos);
    // Frames of an animation are not.
    const Outcome frames = call("animate a.glb --fps 1 --frames 0..0 --size 16x12 -o f_%04d.exr");
    EXPECT_EQ(frames.code, 0) << frames.err;
    EXPECT_NE(frames.err.find("lightmaps are ignored"), std::string::npos) << frames.err;
    // Its light is nowhere else.
    const Outcome records = call("render a.glb --method radiance --size 16x12 -o b.exr");
    EXPECT_EQ(records.code, 0) << records.err;
    EXPECT_NE(records.err.find("lightmaps are ignored"), std::string::npos) << records.err;
    expectError("render a.glb --accuracy 0.5 -o c.exr", ExitCode::kUsage,
                "by which a file with lightmaps is shown");
    expectError("render a.glb --bounces 2 -o c.exr", ExitCode::kUsage, "they were baked with");
    expectError("render scene.gltf --method lightmap -o c.exr", ExitCode::kUsage,
                "has no lightmaps");
}

// What is kept is copied aside while it grows, since the bake may end at any time.
TEST_F(CliBakeTest, whatWasInterruptedGoesOn) {
    const std::string bake = "bake scene.gltf --size 64 --accuracy 0.05 --method texels";
    ASSERT_EQ(call(bake + " -q -o whole.exr").code, 0);
    EXPECT_FALSE(fs::exists(file("whole.exr.unfinished")));
    std::ofstream(file("copy.sh")) << fmt::format(
        "'{}' {} -q -o parts.exr & job=$!\n"
        "size() {{ stat -c %s copy 2>/dev/null || echo 0; }}\n"
        "while [ $(size) -lt 65536 ] && kill -0 $job; do cp parts.exr.unfinished copy; done\n"
        "kill -9 $job; wait $job\n"
        "rm -f parts.exr; mv copy parts.exr.unfinished",
        SHEEN_PROGRAM, bake);
    callShell("sh copy.sh");
    ASSERT_TRUE(fs::exists(file("parts.exr.unfinished")));
    const Outcome rest = call(bake + " -o parts.exr --json parts.json");
    ASSERT_EQ(rest.code, 0) << rest.err;
    EXPECT_EQ(rest.err.find("anew"), std::string::npos) << rest.err;
    const Json json = Json::parse(textOf(file("parts.json")));
    EXPECT_GT(json.at("records_continued"), 0);
    EXPECT_LE(json.at("records_continued"), json.at("records"));
    EXPECT_TRUE(textOf(file("parts.exr")) == textOf(file("whole.exr")));
    EXPECT_FALSE(fs::exists(file("parts.exr.unfinished")));
}

// Nine coefficients of three channels, as THREE.SphericalHarmonics3.fromArray() takes them.
TEST_F(CliBakeTest, lightProbes) {
    const Outcome baked =
        call("bake scene.gltf --probes 3x2x1 -q -o a.json -o a.exr --json figures.json");
    ASSERT_EQ(baked.code, 0) << baked.err;
    const Json probes = Json::parse(textOf(file("a.json")));
    EXPECT_EQ(probes.at("counts"), Json({3, 2, 1}));
    ASSERT_EQ(probes.at("probes").size(), 6);
    const Json& second = probes.at("probes").at(1);
    EXPECT_EQ(second.at("position"), Json({0.0, 2.0, 0.0}));
    EXPECT_EQ(second.at("sh").size(), 27);
    EXPECT_GT(second.at("sh").at(0), 0.0);
    EXPECT_EQ(Json::parse(textOf(file("figures.json"))).at("probes"), 6);
    EXPECT_EQ(call("bake scene.gltf --probes 5 -q -o b.json").code, 0);
    EXPECT_EQ(Json::parse(textOf(file("b.json"))).at("counts"), Json({2, 2, 2}));
    expectError("bake scene.gltf --probes 3x2 -o c.json", ExitCode::kUsage, "must be NxNxN");
    expectError("bake scene.gltf --probes 0 -o c.json", ExitCode::kUsage, "must be NxNxN");
    expectError("bake scene.gltf --probes 2x2x2 -o c.glb", ExitCode::kUsage, "must end in .json");
    expectError("bake scene.gltf --probes 2x2x2 --size 64 -o c.json", ExitCode::kUsage, "--size");
    expectError("bake scene.gltf -o c.json", ExitCode::kUsage, "--probes asks for");
}

TEST_F(CliBakeTest, directionsGoIntoExrAlone) {
    ASSERT_EQ(call("bake scene.gltf --size 32 -q --directional -o a.exr -o a.glb").code, 0);
    for (const char* channel : {"sh0.R", "sh3.B"}) {
        EXPECT_NE(textOf(file("a.exr")).find(channel), std::string::npos) << channel;
    }
    expectError("bake scene.gltf --directional -o b.glb", ExitCode::kUsage, "no output is a .exr");
    expectError("bake scene.gltf --directional --method reference -o b.exr", ExitCode::kUsage,
                "finds irradiance alone");
}

TEST_F(CliBakeTest, refusesWhatCannotBe) {
    expectError("bake scene.gltf -o a.jpg", ExitCode::kUsage, "must end in .glb, .exr or .png");
    expectError("bake scene.gltf --spp 4 -o a.exr", ExitCode::kUsage, "only --method reference");
    expectError("bake scene.gltf --method reference --accuracy 1 -o a.exr", ExitCode::kUsage,
                "--spp makes it finer");
    expectError("bake scene.gltf --size 16 --texels-per-metre 100 -o a.exr", ExitCode::kUsage,
                "ask for at most");
    expectError("bake scene.gltf --unlit -o a.exr", ExitCode::kUsage, "no output is a .glb");
    expectError("bake scene.gltf --transparent -o a.exr", ExitCode::kUsage, "--transparent");
    expectError("bake nothing.glb -o a.exr", ExitCode::kInput, "no such file");
    fs::create_symlink("scene.gltf", file("soft.glb"));
    expectError("bake scene.gltf -o soft.glb", ExitCode::kUsage, "would overwrite");
    expectError("bake scene.gltf -o a.exr -o a.exr", ExitCode::kUsage, "is the file of -o");
}

}  // namespace
}  // namespace sheen
