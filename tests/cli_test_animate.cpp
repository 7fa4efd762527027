// The program from outside: animate, and compare of sequences.
#include "cli_test_animate.h"

#include "image/exr.h"

namespace sheen {
namespace {

const char* const kSmall = "--size 16x12 --method reference --spp 4";

TEST_F(CliAnimate, WritesEveryFrame) {
    const Outcome run =
        call(fmt::format("animate scene.gltf --fps 2 -o out/f_%04d.exr {} --json -", kSmall));
    ASSERT_EQ(run.code, 0) << run.err;
    const Json json = Json::parse(run.out);
    EXPECT_EQ(json["first"], 0);
    EXPECT_EQ(json["last"], 4) << "2 s at 2 frames a second";
    EXPECT_EQ(json["kept"], 0);
    std::vector<std::string> changes;
    for (const Json& frame : json["frames"]) {
        changes.push_back(frame["changed"]);
        EXPECT_TRUE(fs::exists(file(frame["output"])));
    }
    EXPECT_EQ(changes, (std::vector<std::string>{"scene", "scene", "scene", "cameras", "cameras"}));
    EXPECT_EQ(json["frames"][3]["output"], "out/f_0003.exr");
}

TEST_F(CliAnimate, ContinuesWithTheSameBits) {
    const std::string options = "--fps 2 --size 16x12 --aa 1 --bounces 1 --method irradiance";
    ASSERT_EQ(call("animate scene.gltf -o whole/%04d.exr " + options).code, 0);
    ASSERT_EQ(call("animate scene.gltf -o parts/%04d.exr --frames 0..1 " + options).code, 0);
    const auto kept = fs::last_write_time(file("parts/0001.exr"));
    const Outcome rest = call("animate scene.gltf -o parts/%04d.exr --json - " + options);
    ASSERT_EQ(rest.code, 0) << rest.err;
    EXPECT_EQ(Json::parse(rest.out)["kept"], 2);
    EXPECT_EQ(fs::last_write_time(file("parts/0001.exr")), kept);
    for (const char* name : {"0000.exr", "0001.exr", "0002.exr", "0003.exr", "0004.exr"}) {
        EXPECT_TRUE(textOf(folder_ / "whole" / name) == textOf(folder_ / "parts" / name)) << name;
    }
}

TEST_F(CliAnimate, RecordsMayBeGatheredAheadOfImages) {
    const std::string options =
        "--fps 2 --size 16x12 --aa 1 --bounces 1 --lifespan 2 --temporal-gradients interpolated";
    ASSERT_EQ(call("animate scene.gltf -o a/%04d.exr " + options).code, 0);
    ASSERT_EQ(call("animate scene.gltf -o b/%04d.exr --threads 1 " + options).code, 0);
    for (const char* name : {"0000.exr", "0001.exr", "0002.exr", "0003.exr", "0004.exr"}) {
        EXPECT_TRUE(textOf(folder_ / "a" / name) == textOf(folder_ / "b" / name)) << name;
    }
    fs::remove(file("b/0003.exr"));
    const Outcome again = call("animate scene.gltf -o b/%04d.exr --json - " + options);
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_EQ(Json::parse(again.out)["kept"], 4);
    EXPECT_TRUE(fs::exists(file("b/0003.exr")));
}

TEST_F(CliAnimate, AStillSceneHasTheSameBitsInAllFrames) {
    writeScene([](Json& json) { json["animations"][0]["channels"].clear(); });
    const Outcome run =
        call("animate scene.gltf --frames 0..2 -o %d.exr --size 16x12 --aa 1 --json -");
    ASSERT_EQ(run.code, 0) << run.err;
    const Json json = Json::parse(run.out);
    EXPECT_EQ(json["frames"][1]["changed"], "nothing");
    EXPECT_EQ(json["frames"][2]["changed"], "nothing");
    EXPECT_TRUE(textOf(file("0.exr")) == textOf(file("1.exr")));
    EXPECT_TRUE(textOf(file("0.exr")) == textOf(file("2.exr")));
}

TEST_F(CliAnimate, FramesOfAPathTracerHaveNoiseOfTheirOwn) {
    writeScene([](Json& json) { json["animations"][0]["channels"].clear(); });
    ASSERT_EQ(call(fmt::format("animate scene.gltf --frames 0..1 -o %d.exr {}", kSmall)).code, 0);
    EXPECT_FALSE(textOf(file("0.exr")) == textOf(file("1.exr")));
    ASSERT_EQ(call(fmt::format("animate scene.gltf --frames 1..1 -o b%d.exr {}", kSmall)).code, 0);
    EXPECT_TRUE(textOf(file("1.exr")) == textOf(file("b1.exr")));
}

TEST_F(CliAnimate, DamagedFramesAreRenderedAgain) {
    const std::string command =
        fmt::format("animate scene.gltf --frames 0..1 -o %d.exr {} --json -", kSmall);
    ASSERT_EQ(call(command).code, 0);
    const std::string whole = textOf(file("1.exr"));
    std::ofstream(file("1.exr"), std::ios::binary) << whole.substr(0, whole.size() / 2);
    const Outcome again = call(command);
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_NE(again.err.find("1.exr: rendered again"), std::string::npos) << again.err;
    EXPECT_EQ(Json::parse(again.out)["kept"], 1);
    EXPECT_TRUE(textOf(file("1.exr")) == whole);
}

TEST_F(CliAnimate, FramesOfAnotherSequenceAreNotMixedIn) {
    const std::string command =
        fmt::format("animate scene.gltf --frames 0..1 -o %d.exr {}", kSmall);
    ASSERT_EQ(call(command).code, 0);
    expectError(command + " --fov 30", ExitCode::kUsage, "with other options");
    expectError(command + " --fps 12", ExitCode::kUsage, "with other options");
    writeScene([](Json& json) { json["nodes"][1]["name"] = "another"; });
    expectError(command, ExitCode::kUsage, "of another scene");
    fs::remove(file("sequence.json"));
    expectError(command, ExitCode::kUsage, "0.exr: is there");
    std::ofstream(file("sequence.json")) << "no json";
    expectError(command, ExitCode::kUsage, "sequence.json");
}

TEST_F(CliAnimate, PngsShareOneExposure) {
    // A lamp that grows brighter: with an exposure of their own all frames would look alike.
    const std::string command =
        fmt::format("animate scene.gltf --fps 2 --frames 0..2 -o %d.png --tone none {}", kSmall);
    ASSERT_EQ(call(command).code, 0);
    const Json sequence = Json::parse(textOf(file("sequence.json")));
    ASSERT_TRUE(sequence["exposure"].is_number());
    const std::string last = textOf(file("2.png"));
    fs::remove(file("2.png"));
    ASSERT_EQ(call(command).code, 0);
    EXPECT_TRUE(textOf(file("2.png")) == last);
    EXPECT_EQ(Json::parse(textOf(file("sequence.json"))), sequence);
}

TEST_F(CliAnimate, Errors) {
    expectError("animate scene.gltf", ExitCode::kUsage, "--output is required");
    for (const char* name :
         {"out.exr", "%x.exr", "%d%d.exr", "%4d.exr", "%00d.exr", "%d/f.exr", "%.exr"}) {
        expectError(fmt::format("animate scene.gltf -o {}", name), ExitCode::kUsage, name);
    }
    expectError("animate scene.gltf -o %d.gif", ExitCode::kUsage, ".exr or .png");
    for (const char* frames : {"5..2", "-1..2", "a..b", "1..", "..", "1.5..2", "0..9999999"}) {
        expectError(fmt::format("animate scene.gltf -o %d.exr --frames={}", frames),
                    ExitCode::kUsage, frames);
    }
    expectError("animate scene.gltf -o %d.exr --cache c", ExitCode::kUsage, "--cache");
    expectError("animate scene.gltf -o %d.exr --fps 0", ExitCode::kUsage, "--fps");
    expectError("animate scene.gltf -o %d.exr --animation dance", ExitCode::kUsage, "dance");
    expectError("animate scene.gltf -o %d.exr --temporal-accuracy 0.2", ExitCode::kUsage,
                "--temporal-accuracy: needs --lifespan");
    expectError("animate scene.gltf -o %d.exr --lifespan 4 --method reference", ExitCode::kUsage,
                "--lifespan");
    expectError("animate scene.gltf -o %d.exr --lifespan 4 --gather plane", ExitCode::kUsage,
                "--lifespan");
    expectError("animate scene.gltf -o %d.exr --temporal-gradients interpolated", ExitCode::kUsage,
                "--temporal-gradients: needs --lifespan");
    for (const char* limit : {"--target-error 0.1", "--time-limit 1"}) {
        expectError(fmt::format("animate scene.gltf -o %d.exr --lifespan 4 --temporal-gradients "
                                "interpolated {}",
                                limit),
                    ExitCode::kUsage, "interpolated: gathers records before");
    }
    for (const char* options : {"--lifespan 4", "--method reference", "--gather plane"}) {
        expectError(fmt::format("animate scene.gltf -o %d.exr --anchors {}", options),
                    ExitCode::kUsage, "--anchors: ");
    }
    expectError("animate scene.gltf -o %d.exr --anchors --temporal-accuracy 0.1", ExitCode::kUsage,
                "--temporal-accuracy: is of records with a lifespan");
    expectError("animate none.gltf -o %d.exr", ExitCode::kInput, "none.gltf");
    writeScene([](Json& json) { json["animations"][0]["samplers"][0]["input"] = 77; });
    expectError("animate scene.gltf -o %d.exr", ExitCode::kInput, "accessor 77");
    writeScene([](Json& json) { json.erase("animations"); });
    expectError("animate scene.gltf -o %d.exr", ExitCode::kUsage, "--frames A..B");
    std::ofstream(file("taken")) << "a file\n";
    expectError("animate scene.gltf --frames 0..1 -o taken/%d.exr", ExitCode::kEnvironment,
                "taken");
}

// ffmpeg is played by a script that notes its arguments and joins the frames.
class CliMovie : public CliAnimate {
  protected:
    void install(const std::string& script) const {
        fs::create_directories(base_.path() / "bin");
        const fs::path program = base_.path() / "bin" / "ffmpeg";
        std::ofstream(program) << script;
        fs::permissions(program, fs::perms::owner_all);
    }
    Outcome make() const {
        setenv("PATH", (base_.path() / "bin").c_str(), 1);
        const Outcome run = call(fmt::format("animate scene.gltf --fps 2 -o m.mp4 {}", kSmall));
        setenv("PATH", path_.c_str(), 1);
        return run;
    }
    const std::string path_ = std::getenv("PATH");
};

TEST_F(CliMovie, IsMadeOfTheFrames) {
    install(
        "#!/bin/sh\necho \"$@\" > arguments\nfor last; do :; done\n"
        "echo m.mp4.frames/*.png > \"$last\"\n");
    const Outcome run = make();
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(textOf(file("m.mp4")),
              "m.mp4.frames/000000.png m.mp4.frames/000001.png m.mp4.frames/000002.png "
              "m.mp4.frames/000003.png m.mp4.frames/000004.png\n");
    const std::string arguments = textOf(file("arguments"));
    for (const char* part : {"-framerate 2 ", "-start_number 0 ", "-i m.mp4.frames/%06d.png "}) {
        EXPECT_NE(arguments.find(part), std::string::npos) << arguments;
    }
    EXPECT_FALSE(fs::exists(file("m.mp4.frames"))) << "only the movie is left";
}

TEST_F(CliMovie, FramesStayWhereItFails) {
    install("#!/bin/sh\nexit 1\n");
    const Outcome run = make();
    EXPECT_EQ(run.code, 4) << run.err;
    EXPECT_NE(run.err.find("ffmpeg"), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(file("m.mp4")));
    EXPECT_TRUE(fs::exists(file("m.mp4.frames/000004.png")));
}

TEST_F(CliMovie, WithoutFfmpegIsOneLine) {
    const Outcome run = make();
    EXPECT_EQ(run.code, 4) << run.err;
    EXPECT_EQ(run.err.rfind("sheen: error: -o m.mp4: movies are made by ffmpeg, which is not", 0),
              0u)
        << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(fs::exists(file("m.mp4.frames")));
}

// Writes frame `number` of both sequences: the reference 2 everywhere, the test 2 + `error`.
void writeFramePair(const std::string& folder, int number, float error) {
    fs::create_directories(folder + "/a");
    fs::create_directories(folder + "/b");
    Frame frame;
    frame.primitive = Image<uint32_t>(4, 4, 0u);
    frame.direct = Image<vec3>(4, 4, vec3(1.0f));
    frame.indirect = Image<vec3>(4, 4, vec3(2.0f));
    frame.indirect_variance = Image<vec3>(4, 4, vec3(0.0f));
    writeExr(fmt::format("{}/b/{:02}.exr", folder, number), frame, ExrLayers::kBasic);
    frame.indirect = Image<vec3>(4, 4, vec3(2.0f + error));
    writeExr(fmt::format("{}/a/{:02}.exr", folder, number), frame, ExrLayers::kBasic);
}

TEST_F(CliTest, compareSequences) {
    for (int frame = 8; frame < 12; ++frame) {
        writeFramePair(folder_.string(), frame, frame % 2 == 0 ? 0.25f : -0.25f);
    }
    fs::remove(file("b/11.exr"));
    const std::string command = "compare --sequence a/%02d.exr b/%02d.exr";
    const Outcome run = call(command + " --json -");
    ASSERT_EQ(run.code, 0) << run.err;
    const Json json = Json::parse(run.out);
    ASSERT_EQ(json["frames"].size(), 3u);
    EXPECT_EQ(json["frames"][2]["frame"], 10);
    EXPECT_NEAR(json["frames"][0]["rel_rmse"].get<double>(), 0.125, 1e-6);
    EXPECT_EQ(json["flicker"]["pairs"], 2);
    EXPECT_NEAR(json["flicker"]["value"].get<double>(), 0.25, 1e-6);
    const Outcome text = call(command);
    EXPECT_NE(text.out.find("frame   10  rel_rmse 12.500%"), std::string::npos) << text.out;
    EXPECT_NE(text.out.find("flicker     25.000% over 2 pairs of frames\n"), std::string::npos)
        << text.out;
}

TEST_F(CliTest, compareSequencesErrors) {
    writeFramePair(folder_.string(), 0, 0.0f);
    expectError("compare --sequence a/00.exr b/00.exr", ExitCode::kUsage, "a/00.exr");
    expectError("compare --sequence a/%02d.exr b/%03d.exr", ExitCode::kInput, "no frame is there");
    expectError("compare --sequence none/%02d.exr b/%02d.exr", ExitCode::kInput, "none/");
    expectError("compare --sequence a/%02d.exr b/%02d.exr --heatmap h.png", ExitCode::kUsage,
                "--heatmap");
    const Outcome one = call("compare --sequence a/%02d.exr b/%02d.exr");
    EXPECT_EQ(one.code, 0) << one.err;
    EXPECT_NE(one.out.find("flicker     none"), std::string::npos) << one.out;
}

}  // namespace
}  // namespace sheen
