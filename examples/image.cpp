// A glTF scene to an image: image SCENE.glb OUT.exr|OUT.png
#include <sheen/sheen.h>

#include <cstdio>

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: image SCENE.glb OUT.exr|OUT.png\n");
        return 2;
    }
    try {
        const sheen::Session session(sheen::Scene::load(argv[1]));
        const sheen::Frame frame = session.render({{"size", "96x96"}, {"accuracy", 1.0}});
        frame.write(argv[2]);
        std::printf("error about %.1f%%\n", 100 * frame.figure("estimated_rel_rmse"));
    } catch (const sheen::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return static_cast<int>(error.kind());
    }
}
