// The program from outside: exit codes, one line for every error, files whole or absent.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "image/exr.h"
#include "test_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// A floor and a wall, each one triangle, lit by a point light, seen by a camera called "front".
// The buffer: six positions, then their normals; no indices, so that the text stays readable.
const char* const kScene = R"({
  "asset": {"version": "2.0"},
  "extensionsUsed": ["KHR_lights_punctual"],
  "extensions": {"KHR_lights_punctual": {"lights": [
    {"type": "point", "intensity": 20.0, "name": "lamp"}]}},
  "scene": 0,
  "scenes": [{"nodes": [0, 1, 2]}],
  "nodes": [
    {"mesh": 0},
    {"translation": [0.5, 1, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}},
    {"camera": 0, "name": "front", "translation": [0, 1, 4]}],
  "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}],
  "materials": [{"name": "plaster", "doubleSided": true,
    "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.6}}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "material": 0}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3",
    "min": [-4, 0, -4], "max": [4, 8, 4]},
    {"bufferView": 0, "byteOffset": 72, "componentType": 5126, "count": 6, "type": "VEC3"}],
  "bufferViews": [{"buffer": 0, "byteLength": 144}],
  "buffers": [{"uri": "scene.bin", "byteLength": 144}]
})";
constexpr float kVertices[] = {-4, 0, 4, 4, 0, 4, 0, 0, -4, -4, 0, -1, 4, 0, -1, 0, 8, -1,
                               0,  1, 0, 0, 1, 0, 0, 1, 0,  0,  0, 1,  0, 0, 1,  0, 0, 1};

struct Outcome {
    int code = 0;  ///< exit code, or minus the signal that ended the program
    std::string out;
    std::string err;
};

std::string textOf(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

class CliTest : public testing::Test {
  protected:
    void SetUp() override {
        fs::create_directories(folder_);
        std::ofstream(file("scene.gltf")) << kScene;
        std::ofstream(file("scene.bin"), std::ios::binary)
            .write(reinterpret_cast<const char*>(kVertices), sizeof(kVertices));
    }

    std::string file(const std::string& name) const { return (folder_ / name).string(); }

    // Runs the program in the test's folder; `arguments` is shell text.
    Outcome call(const std::string& arguments) const {
        const std::string command =
            fmt::format("cd '{}' && >'{}/out' 2>'{}/err' </dev/null '{}' {}", folder_.string(),
                        base_.path().string(), base_.path().string(), SHEEN_PROGRAM, arguments);
        const int status = std::system(command.c_str());
        Outcome run;
        run.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
        run.out = textOf(base_.path() / "out");
        run.err = textOf(base_.path() / "err");
        return run;
    }

    // The program must end with `code` and one error line holding `part`, and leave no new file.
    void expectError(const std::string& arguments, ExitCode code, const std::string& part) const {
        const std::vector<std::string> before = files();
        const Outcome run = call(arguments);
        EXPECT_EQ(run.code, static_cast<int>(code)) << arguments << "\n" << run.err;
        EXPECT_EQ(run.err.rfind("sheen: error: ", 0), 0u) << arguments << "\n" << run.err;
        EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
        EXPECT_NE(run.err.find(part), std::string::npos) << arguments << "\n" << run.err;
        EXPECT_EQ(run.out, "") << arguments;
        EXPECT_EQ(files(), before) << arguments;
    }

    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder_)) {
            names.push_back(entry.path().filename().string());
        }
        std::sort(names.begin(), names.end());
        return names;
    }

    TestFolder base_;
    fs::path folder_ = base_.path() / "work";
};

// Small enough to take milliseconds.
const char* const kReference = "render scene.gltf --method reference --size 16x12 --spp 32";

TEST_F(CliTest, versionAndHelp) {
    EXPECT_EQ(call("--version").code, 0);
    EXPECT_EQ(call("--version").out.rfind("sheen ", 0), 0u);
    for (const char* arguments :
         {"--help", "render --help", "compare -h", "info --help", "chart --help"}) {
        const Outcome run = call(arguments);
        EXPECT_EQ(run.code, 0) << arguments;
        EXPECT_NE(run.out.find("Usage: "), std::string::npos) << arguments;
        EXPECT_EQ(run.err, "") << arguments;
    }
}

TEST_F(CliTest, helpStatesDefaults) {
    const std::string help = call("render --help").out;
    for (const char* text : {"512x512", "=radiance", "=0.4", "=ray", "=256", "=basic"}) {
        EXPECT_NE(help.find(text), std::string::npos) << text;
    }
}

TEST_F(CliTest, wrongCommands) {
    expectError("", ExitCode::kUsage, "subcommand is required");
    expectError("paint scene.gltf", ExitCode::kUsage, "paint: no such subcommand");
    expectError("render", ExitCode::kUsage, "SCENE is required (see sheen render --help)");
    expectError("render scene.gltf --fast", ExitCode::kUsage, "not expected: --fast");
    expectError("render scene.gltf other.gltf", ExitCode::kUsage, "not expected: other.gltf");
    expectError("render scene.gltf --size 8x8 --size 9x9", ExitCode::kUsage, "--size");
    expectError("compare a.exr", ExitCode::kUsage, "REFERENCE is required");
}

TEST_F(CliTest, optionsOutOfRange) {
    for (const char* option : {"--size 0x8",
                               "--size 8",
                               "--size 8x",
                               "--size x8",
                               "--size 8x8x8",
                               "--size 16385x8",
                               "--size -8x8",
                               "--size 8x99999999999999999999",
                               "--accuracy 0",
                               "--accuracy 2.1",
                               "--accuracy nan",
                               "--accuracy inf",
                               "--accuracy 0.1x",
                               "--target-error 0",
                               "--target-error 0.6",
                               "--target-error nan",
                               "--target-error 1%",
                               "--sh-order 1",
                               "--sh-order 11",
                               "--sh-order best",
                               "--gather sphere",
                               "--gather-size 7",
                               "--gather-size 513",
                               "--gather-size 64.5",
                               "--gather-extent 0.5",
                               "--gather-extent 11",
                               "--method magic",
                               "--method octree --accuracy 0",
                               "--method octree --gather-size 7",
                               "--method denoised --spp 0",
                               "--method reference --spp 0",
                               "--method reference --spp 65537",
                               "--method reference --seed -1",
                               "--method reference --bounces 0",
                               "--threads -1",
                               "--threads 257",
                               "--layers some",
                               "--exposure bright -o a.png",
                               "--exposure nan -o a.png",
                               "--exposure 51 -o a.png",
                               "--accuracy"}) {
        const std::string text = option;
        const std::string name = text.substr(0, text.find(' '));
        expectError("render scene.gltf " + text, ExitCode::kUsage,
                    name == "--method" && text.find(" --") != std::string::npos ? "--" : name);
    }
}

TEST_F(CliTest, optionsTheMethodDoesNotSupport) {
    for (const char* option : {"--spp 16", "--seed 1", "--bounces 2"}) {
        expectError(fmt::format("render scene.gltf {}", option), ExitCode::kUsage, "radiance");
        expectError(fmt::format("render scene.gltf --method irradiance {}", option),
                    ExitCode::kUsage, "irradiance");
    }
    expectError("render scene.gltf --method irradiance --sh-order 4", ExitCode::kUsage,
                "--sh-order: not an option of --method irradiance");
    for (const char* method : {"reference", "denoised"}) {
        for (const char* option : {"--accuracy 0.1", "--target-error 0.02", "--sh-order 4",
                                   "--gather plane", "--gather-size 32", "--gather-extent 2"}) {
            expectError(fmt::format("render scene.gltf --method {} {}", method, option),
                        ExitCode::kUsage, fmt::format("not an option of --method {}", method));
        }
    }
    for (const char* option : {"--spp 16", "--seed 1", "--target-error 0.02", "--bounces 2",
                               "--sh-order 4", "--gather plane", "--gather-extent 2"}) {
        expectError(fmt::format("render scene.gltf --method octree {}", option), ExitCode::kUsage,
                    "--method octree");
    }
    expectError("render scene.gltf --target-error 0.02 --accuracy 0.1", ExitCode::kUsage,
                "--accuracy");
    for (const char* gather : {"hemicube", "ray"}) {
        expectError(fmt::format("render scene.gltf --gather {} --gather-extent 2", gather),
                    ExitCode::kUsage, fmt::format("not an option of --gather {}", gather));
    }
}

TEST_F(CliTest, optionsTheFileDoesNotSupport) {
    expectError("render scene.gltf -o a.exr --exposure 1", ExitCode::kUsage, "for PNG only");
    expectError("render scene.gltf -o a.png --layers all", ExitCode::kUsage, "for EXR only");
    expectError("render scene.gltf -o a.jpg", ExitCode::kUsage, "must end in .exr or .png");
    expectError("render scene.gltf -o a", ExitCode::kUsage, "must end in .exr or .png");
    expectError("render scene.gltf -o a.exr --json a.exr", ExitCode::kUsage, "image's name");
    expectError("compare a.exr b.exr --layer normal", ExitCode::kUsage, "--layer");
    expectError("compare a.exr b.exr --heatmap h.exr", ExitCode::kUsage, "must be a .png");
}

TEST_F(CliTest, badScenes) {
    std::ofstream(file("text.glb")) << "this is no scene\n";
    std::ofstream(file("empty.glb")) << "";
    fs::create_directory(file("folder.glb"));
    for (const char* command : {"render", "info"}) {
        for (const char* scene : {"none.glb", "text.glb", "empty.glb", "folder.glb"}) {
            expectError(fmt::format("{} {}", command, scene), ExitCode::kInput, scene);
        }
    }
}

TEST_F(CliTest, unknownCamera) {
    expectError(std::string(kReference) + " --camera side", ExitCode::kUsage, "--camera side");
    expectError(std::string(kReference) + " --camera 7", ExitCode::kUsage, "front");
}

TEST_F(CliTest, unwritableOutputIsFoundBeforeRendering) {
    // So many paths that a render could not end within the test's time limit.
    const std::string endless =
        "render scene.gltf --method reference --size 4096x4096 --spp 65536 ";
    fs::create_directory(file("folder.exr"));
    expectError(endless + "-o none/a.exr", ExitCode::kEnvironment, "none/a.exr: cannot write");
    expectError(endless + "-o folder.exr", ExitCode::kEnvironment, "is a directory");
    expectError(endless + "-o a.exr --json none/a.json", ExitCode::kEnvironment, "none/a.json");
    expectError("info scene.gltf --json none/a.json", ExitCode::kEnvironment, "none/a.json");
}

TEST_F(CliTest, fullStandardOutput) {
    const Outcome run = call("info scene.gltf --json - >/dev/full");
    EXPECT_EQ(run.code, 4) << run.err;
    EXPECT_NE(run.err.find("standard output"), std::string::npos);
    EXPECT_EQ(call("info scene.gltf >/dev/full").code, 4);
    EXPECT_EQ(call("--help >/dev/full").code, 4);
}

TEST_F(CliTest, nobodyReadsTheErrors) {
    EXPECT_EQ(call("info none.gltf 2>/dev/full").code, 3);
    EXPECT_EQ(call("info none.gltf 2>&-").code, 3);
    EXPECT_EQ(call("render 2>/dev/full").code, 2);
}

TEST_F(CliTest, numbersAreDecimal) {
    for (const char* option : {"--spp 010", "--seed 07", "--seed -1", "--threads 01"}) {
        expectError(std::string(kReference) + " " + option, ExitCode::kUsage, "is not a number");
    }
    EXPECT_EQ(call("render scene.gltf --size 8x8 --accuracy 0.5").code, 0);
}

TEST_F(CliTest, pathsArePrintedAsTraced) {
    const Outcome run = call("render scene.gltf --method reference --size 8x8 --spp 5 --json -");
    EXPECT_EQ(Json::parse(run.out)["spp"], 8);  // four replicates of two
}

TEST_F(CliTest, anEstimateOfNothingIsNone) {
    const Outcome run = call("render scene.gltf --size 1x1");
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("estimate  none"), std::string::npos) << run.out;
    EXPECT_TRUE(Json::parse(call("render scene.gltf --size 1x1 --json -").out)["estimated_rel_rmse"]
                    .is_null());
}

TEST_F(CliTest, compareNamesTheFile) {
    ASSERT_EQ(call("render scene.gltf --size 8x8 -o small.exr").code, 0);
    ASSERT_EQ(call("render scene.gltf --size 9x8 -o large.exr").code, 0);
    expectError("compare small.exr large.exr", ExitCode::kInput,
                "small.exr has 8x8 pixels, large.exr 9x8");
}

TEST_F(CliTest, renderNamesItsOutput) {
    const Outcome run = call(kReference);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("wrote     scene.exr (16x12, reference)"), std::string::npos) << run.out;
    const LoadedExr exr = readExr(file("scene.exr"));
    EXPECT_EQ(exr.width, 16);
    EXPECT_EQ(exr.height, 12);
    EXPECT_EQ(exr.colors.count("variance"), 1u);
    EXPECT_EQ(exr.colors.count("normal"), 0u);
    EXPECT_EQ(files(), (std::vector<std::string>{"scene.bin", "scene.exr", "scene.gltf"}));
}

TEST_F(CliTest, renderAllLayers) {
    EXPECT_EQ(call(std::string(kReference) + " --layers all --camera front -o a.exr").code, 0);
    EXPECT_EQ(readExr(file("a.exr")).colors.count("normal"), 1u);
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
    for (const char* key :
         {"method", "size", "threads", "records", "seconds", "pixels_uncovered", "nonfinite_pixels",
          "negative_pixels", "estimated_rel_rmse", "accuracy", "gather_size", "passes",
          "diffuse_share", "too_glossy_share", "sh_order", "gl_renderer", "mrays_per_second"}) {
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

TEST_F(CliTest, everyWayToGatherRenders) {
    const char* const cached = "render scene.gltf --size 24x16 --gather-size 16";
    for (const char* gather : {"ray", "hemicube", "border", "plane", "larsen"}) {
        SCOPED_TRACE(gather);
        const Outcome run = call(
            fmt::format("{} --gather {} -o {}.exr --json {}.json", cached, gather, gather, gather));
        ASSERT_EQ(run.code, 0) << run.err;
        const Json json = Json::parse(textOf(file(std::string(gather) + ".json")));
        EXPECT_EQ(json["method"], "radiance");
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
    // Left to itself the program gathers by rays, and the name decides which way it is.
    ASSERT_EQ(call(fmt::format("{} -o default.exr", cached)).code, 0);
    EXPECT_EQ(textOf(file("default.exr")), textOf(file("ray.exr")));
    EXPECT_NE(textOf(file("hemicube.exr")), textOf(file("ray.exr")));
    EXPECT_NE(textOf(file("hemicube.exr")), textOf(file("border.exr")));
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
    EXPECT_EQ(readExr(file("octree.exr")).colors.count("indirect_diffuse"), 1u);

    const Outcome denoised =
        call(fmt::format("{} --method denoised --spp 16 --bounces 2 -o denoised.exr", small));
    ASSERT_EQ(denoised.code, 0) << denoised.err;
    const Json traced = Json::parse(denoised.out);
    EXPECT_EQ(traced["records"], 0);
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
    EXPECT_NE(run.err.find("[3/3] scene, path tracer, spp 256"), std::string::npos) << run.err;
    EXPECT_NE(run.out.find("wrote     a/chart/chart.html"), std::string::npos) << run.out;
    for (const char* name : {"chart.html", "chart.csv", "chart.json"}) {
        EXPECT_TRUE(fs::exists(folder_ / "a/chart" / name)) << name;
    }
    const Json json = Json::parse(textOf(file("a/chart/chart.json")));
    EXPECT_EQ(json["scenes"][0]["points"].size(), 3u);
    const Outcome again = call(command);
    EXPECT_EQ(again.code, 0);
    EXPECT_EQ(again.err, "3 of 3 points were measured before\n");
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

}  // namespace
}  // namespace sheen
