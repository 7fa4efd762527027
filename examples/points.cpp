// How much light falls on the ground, along a line through the scene's middle: points SCENE.glb
#include <sheen/sheen.h>

#include <cstdio>

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: points SCENE.glb\n");
        return 2;
    }
    try {
        const sheen::Scene scene = sheen::Scene::load(argv[1]);
        double lower[3], upper[3];
        if (!scene.bounds(lower, upper)) {
            std::fprintf(stderr, "the scene has no geometry\n");
            return 2;
        }
        const int count = 16;
        sheen::Points line;
        line.width = static_cast<float>((upper[0] - lower[0]) / count);
        for (int i = 0; i < count; ++i) {
            const double x = lower[0] + (i + 0.5) * line.width;
            line.positions.insert(line.positions.end(), {x, lower[1], 0.5 * (lower[2] + upper[2])});
            line.normals.insert(line.normals.end(), {0, 1, 0});
        }
        const sheen::Irradiance light = sheen::irradiance(scene, line, {{"accuracy", 1.0}});
        for (std::size_t i = 0; i < line.positions.size(); i += 3) {
            std::printf("x %6.3f: green light %.3g lux direct, %.3g indirect\n", line.positions[i],
                        light.direct[i + 1], light.indirect[i + 1]);
        }
    } catch (const sheen::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return static_cast<int>(error.kind());
    }
}
