// make_scenes DIRECTORY [--moved SEED]: writes the scenes that come with Sheen; with --moved those
// that are measured, as NAME.movedSEED.glb, with their first camera and lights moved.
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "scenes/all_scenes.h"
#include "scenes/moved.h"

namespace sheen::scenes {
namespace {

// False, with a message, where the file cannot be written.
bool write(const Model& model, const std::filesystem::path& path) {
    const std::vector<uint8_t> bytes = encodeGlb(model);
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) {
        std::fprintf(stderr, "make_scenes: %s cannot be written\n", path.c_str());
        return false;
    }
    std::printf("%s: %zu bytes\n", path.c_str(), bytes.size());
    return true;
}

// A whole number from 1 on; 0 where the text is none.
uint32_t seedOf(const char* text) {
    uint32_t seed = 0;
    const char* end = text + std::strlen(text);
    const auto [rest, error] = std::from_chars(text, end, seed);
    return error == std::errc() && rest == end ? seed : 0;
}

int run(int argc, char** argv) {
    const bool is_moved = argc == 4 && std::strcmp(argv[2], "--moved") == 0;
    const uint32_t seed = is_moved ? seedOf(argv[3]) : 0;
    if (is_moved ? seed == 0 : argc != 2) {
        std::fprintf(stderr, "usage: make_scenes DIRECTORY [--moved SEED], SEED from 1 on\n");
        return 2;
    }
    for (const NamedScene& scene : allScenes()) {
        if (is_moved && !scene.measured) {
            continue;
        }
        std::filesystem::path path = std::filesystem::path(argv[1]) / scene.file_name;
        if (is_moved) {
            path.replace_extension("moved" + std::to_string(seed) + ".glb");
        }
        if (!write(is_moved ? moved(scene.make(), seed) : scene.make(), path)) {
            return 4;
        }
    }
    return 0;
}

}  // namespace
}  // namespace sheen::scenes

int main(int argc, char** argv) { return sheen::scenes::run(argc, argv); }
