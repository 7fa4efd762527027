// make_scenes DIRECTORY: writes the scenes that come with Sheen.
#include <cstdio>
#include <fstream>

#include "scenes/all_scenes.h"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_scenes DIRECTORY\n");
        return 2;
    }
    for (const sheen::scenes::NamedScene& scene : sheen::scenes::allScenes()) {
        const std::string path = std::string(argv[1]) + "/" + scene.file_name;
        const std::vector<uint8_t> bytes = sheen::scenes::encodeGlb(scene.make());
        std::ofstream out(path, std::ios::binary);
        out.write(reinterpret_cast<const char*>(bytes.data()),
                  static_cast<std::streamsize>(bytes.size()));
        out.close();
        if (!out) {
            std::fprintf(stderr, "make_scenes: %s cannot be written\n", path.c_str());
            return 4;
        }
        std::printf("%s: %zu bytes\n", path.c_str(), bytes.size());
    }
    return 0;
}
