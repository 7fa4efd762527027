// The program from outside: images that show nothing, and machines that have too little memory.
#include "cli_test.h"
#include "image/exr.h"
#include "scene_test_gltf.h"

namespace sheen {
namespace {

#ifdef SHEEN_SANITIZED
constexpr bool kReservesAllAddresses = true;
#else
constexpr bool kReservesAllAddresses = false;
#endif

// kScene with `from` replaced by `to`.
std::string changed(const std::string& from, const std::string& to) {
    std::string scene = kScene;
    scene.replace(scene.find(from), from.size(), to);
    return scene;
}

// A cube of half-width 1 around the origin, facing outward; a camera at the origin, a lamp outside.
GltfFile cubeAroundTheCamera() {
    GltfFile file;
    std::vector<float> corners;
    for (int i = 0; i < 8; ++i) {
        for (int c = 0; c < 3; ++c) {
            corners.push_back((i >> c & 1) != 0 ? 1.0f : -1.0f);
        }
    }
    Json& primitive = file.addPrimitive(corners);
    primitive["indices"] =
        file.addAccessor<uint8_t>({0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,  //
                                   2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6},
                                  kUnsignedByte, "SCALAR", 1);
    file.json["cameras"] =
        Json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}}});
    file.json["nodes"].push_back({{"name", "eye"}, {"camera", 0}});
    file.json["extensions"]["KHR_lights_punctual"]["lights"] =
        Json::array({{{"type", "point"}, {"intensity", 100}}});
    file.json["nodes"].push_back(
        {{"translation", {0, 3, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    return file;
}

class CliLimitsTest : public CliTest {
  protected:
    // As call(), with an address space of so many MiB.
    Outcome callLimited(int mebibytes, const std::string& arguments) const {
        const std::string command =
            fmt::format("cd '{}' && (ulimit -v {} && exec '{}' {}) >'{}/out' 2>'{}/err' </dev/null",
                        folder_.string(), 1024 * mebibytes, SHEEN_PROGRAM, arguments,
                        base_.path().string(), base_.path().string());
        const int status = std::system(command.c_str());
        return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status),
                .out = textOf(base_.path() / "out"),
                .err = withoutProgress(textOf(base_.path() / "err"))};
    }

    // A black image comes with exactly one warning, and no estimate of its error.
    void expectBlack(const std::string& scene, const std::string& why) const {
        for (const char* method :
             {"", "--method irradiance", "--method octree", "--method reference --spp 16"}) {
            SCOPED_TRACE(method);
            const Outcome run = call(
                fmt::format("render {} --size 24x16 -o a.exr --json a.json {}", scene, method));
            EXPECT_EQ(run.code, 0) << run.err;
            EXPECT_EQ(run.err.rfind(fmt::format("sheen: warning: {}: camera ", scene), 0), 0u)
                << run.err;
            EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
            EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
            const Json json = Json::parse(textOf(file("a.json")));
            EXPECT_TRUE(json["estimated_rel_rmse"].is_null()) << json["estimated_rel_rmse"];
            EXPECT_EQ(run.out.find("rel_rmse of the indirect"), std::string::npos) << run.out;
        }
    }
};

TEST_F(CliLimitsTest, aCameraThatIsTurnedAway) {
    std::ofstream(file("away.gltf")) << changed("\"translation\": [0, 1, 4]",
                                                "\"translation\": [0, 1, 40], "
                                                "\"rotation\": [0, 1, 0, 0]");
    expectBlack("away.gltf", "'front' sees no surface");
}

TEST_F(CliLimitsTest, aRoomWithoutLight) {
    std::ofstream(file("dark.gltf")) << changed("\"intensity\": 20.0", "\"intensity\": 0.0");
    expectBlack("dark.gltf", "'front' sees surfaces but no light");
}

// Without a light at all the file gets a studio, of which records that are rasterised see the key.
TEST_F(CliLimitsTest, aFileWithoutLight) {
    std::ofstream(file("unlit.gltf"))
        << changed(R"(, "extensions": {"KHR_lights_punctual": {"light": 0}})", "");
    const auto said = [this](const std::string& options) {
        const Outcome run = call("render unlit.gltf --size 24x16 -o a.exr " + options);
        EXPECT_EQ(run.code, 0) << run.err;
        return run.err;
    };
    EXPECT_NE(said("").find("a studio's grey sky and a key light"), std::string::npos);
    EXPECT_EQ(readExr(file("a.exr")).scalars.at("A").at(0, 0), 1.0f);
    EXPECT_NE(said("--transparent").find("a studio's grey sky"), std::string::npos);
    EXPECT_EQ(readExr(file("a.exr")).scalars.at("A").at(0, 0), 0.0f);
    EXPECT_NE(said("--gather hemicube").find("lit by a key light"), std::string::npos);
    EXPECT_NE(said("--environment none").find("the image is black"), std::string::npos);
}

TEST_F(CliLimitsTest, aCameraInsideASolid) {
    writeFile(file("cube.glb"), cubeAroundTheCamera().glb());
    expectBlack("cube.glb", "'eye' is inside a solid");
    // The same cube as a room, facing inward.
    GltfFile room = cubeAroundTheCamera();
    std::string& bytes = room.binary;
    const size_t first = room.json["bufferViews"][1]["byteOffset"];
    for (size_t t = 0; t < 12; ++t) {
        std::swap(bytes[first + 3 * t], bytes[first + 3 * t + 1]);
    }
    writeFile(file("room.glb"), room.glb());
    expectBlack("room.glb", "'eye' sees surfaces but no light");
}

TEST_F(CliLimitsTest, aTargetErrorInTheDarkEnds) {
    std::ofstream(file("dark.gltf")) << changed("\"intensity\": 20.0", "\"intensity\": 0.0");
    const Outcome run =
        call("render dark.gltf --size 24x16 -o a.exr --json - --target-error 0.002");
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(Json::parse(run.out)["passes"], 1);
}

TEST_F(CliLimitsTest, methodsWithoutAnEstimateHaveNone) {
    const Outcome run = call(std::string(kReference) + " --json - -o a.exr");
    EXPECT_TRUE(Json::parse(run.out)["estimated_rel_rmse"].is_null());
    EXPECT_EQ(run.err, "");
}

// The light's scale changes nothing but the image's.
TEST_F(CliLimitsTest, dimAndBrightLightsAreRight) {
    std::vector<Image<vec3>> images;
    const std::vector<double> scales = {1.0, 0x1p-36, 0x1p36};
    for (const double scale : scales) {
        std::ofstream(file("scaled.gltf"))
            << changed("\"intensity\": 20.0", fmt::format("\"intensity\": {}", 20.0 * scale));
        const Outcome run = call("render scaled.gltf --size 24x16 -o a.exr");
        ASSERT_EQ(run.code, 0) << run.err;
        EXPECT_EQ(run.err, "");
        images.push_back(colorLayer(readExr(file("a.exr")), "indirect"));
    }
    // That of scale one is in halves.
    constexpr float kRelative = 1.0f / 1024.0f;
    for (size_t k = 1; k < images.size(); ++k) {
        for (size_t i = 0; i < images[0].pixels.size(); ++i) {
            const float expected = images[0].pixels[i].y;
            EXPECT_NEAR(images[k].pixels[i].y / scales[k], expected, kRelative * expected + 1e-6f)
                << scales[k] << " " << i;
        }
    }
}

TEST_F(CliLimitsTest, anImageTooLargeForTheMachine) {
    if (kReservesAllAddresses) {
        GTEST_SKIP() << "a sanitizer reserves more addresses than any limit leaves";
    }
    for (const char* method : {"", "--method reference --spp 16", "--method octree"}) {
        const Outcome run = callLimited(
            8192, fmt::format("render scene.gltf {} --size 16384x16384 -o a.exr", method));
        EXPECT_EQ(run.code, 4) << run.err;
        EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
        EXPECT_NE(run.err.find("16384x16384"), std::string::npos) << run.err;
        EXPECT_NE(run.err.find("smaller --size"), std::string::npos) << run.err;
    }
}

TEST_F(CliLimitsTest, tooFewAddresses) {
    if (kReservesAllAddresses) {
        GTEST_SKIP() << "a sanitizer reserves more addresses than any limit leaves";
    }
    for (int mebibytes = 350; mebibytes <= 700; mebibytes += 50) {
        for (const char* command :
             {"render scene.gltf --size 24x16 -o a.exr --threads 2",
              "render scene.gltf --size 24x16 -o a.exr --threads 2 --gather hemicube",
              "render scene.gltf --size 24x16 -o a.exr --threads 2 --method reference --spp 16"}) {
            const Outcome run = callLimited(mebibytes, command);
            EXPECT_EQ(run.code, 4) << mebibytes << " " << command << "\n" << run.err;
            EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
            EXPECT_FALSE(fs::exists(file("a.exr")));
        }
    }
}

}  // namespace
}  // namespace sheen
