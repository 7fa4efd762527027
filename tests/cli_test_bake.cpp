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
