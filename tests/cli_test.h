// A folder with a small scene, and the program run in it as from a shell.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "core/error.h"
#include "test_folder.h"

namespace sheen {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// A floor and a wall, each one triangle, lit by a point light, seen by a camera called "front".
// The buffer: six positions, then their normals; no indices, so that the text stays readable.
inline const char* const kScene = R"({
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
    std::string err;  ///< but for lines of progress
};

/// How many lines of progress there are is the machine's affair.
inline std::string withoutProgress(const std::string& err) {
    return std::regex_replace(err, std::regex("[^\n]* [0-9]+% \\([0-9]+ s left\\)\n"), "");
}

inline std::string textOf(const fs::path& path) {
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
        return callShell(fmt::format("'{}' {}", SHEEN_PROGRAM, arguments));
    }

    Outcome callShell(const std::string& command) const {
        const std::string whole =
            fmt::format("cd '{}' && >'{}/out' 2>'{}/err' </dev/null {}", folder_.string(),
                        base_.path().string(), base_.path().string(), command);
        const int status = std::system(whole.c_str());
        Outcome run;
        run.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
        run.out = textOf(base_.path() / "out");
        run.err = withoutProgress(textOf(base_.path() / "err"));
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
inline const char* const kReference = "render scene.gltf --method reference --size 16x12 --spp 32";

}  // namespace sheen
