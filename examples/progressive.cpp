// Finer and finer images of a scene made of arrays, until the estimated error is small enough or
// the time is up: progressive OUT.png TARGET_ERROR SECONDS
#include <sheen/sheen.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace {

using Clock = std::chrono::steady_clock;

// Two walls and a floor as one mesh each, under a lamp and a light.
sheen::Scene corner() {
    sheen::Arrays scene;
    scene.materials = {{.name = "floor", .roughness = 0.4f},
                       {.name = "red", .base_color = {0.7f, 0.1f, 0.1f}},
                       {.name = "lamp", .emission = {8.0f, 8.0f, 8.0f}}};
    const std::vector<std::uint32_t> quad = {0, 1, 2, 0, 2, 3};
    scene.meshes = {
        {.name = "floor",
         .positions = {0, 0, 0, 0, 0, 2, 2, 0, 2, 2, 0, 0},
         .indices = quad,
         .material = 0},
        {.name = "left",
         .positions = {0, 0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2},
         .indices = quad,
         .material = 1},
        {.name = "back", .positions = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0}, .indices = quad},
        {.name = "lamp",
         .positions = {0.8f, 2, 0.8f, 1.2f, 2, 0.8f, 1.2f, 2, 1.2f, 0.8f, 2, 1.2f},
         .indices = quad,
         .material = 2}};
    scene.lights = {{.position = {1.6f, 1.6f, 1.6f}, .intensity = {1.0f, 0.9f, 0.7f}}};
    scene.cameras = {{.position = {3.4f, 1.8f, 3.4f}, .look_at = {0.8f, 0.8f, 0.8f}, .fov = 45.0f}};
    return sheen::Scene::fromArrays(scene);
}

void render(const char* output, double target, double seconds) {
    const Clock::time_point start = Clock::now();
    const auto elapsed = [start] {
        return std::chrono::duration<double>(Clock::now() - start).count();
    };
    // A frame that does not end in time is given up; what there is so far stands in the file.
    const sheen::Listener in_time{
        .progress = [&](const std::string&, double) { return elapsed() < seconds; }};
    const sheen::Session session(corner());
    session.keepRecords();  // each image begins with those of the one before
    for (double accuracy = 2.0; accuracy > 0.05; accuracy /= 2) {
        const sheen::Frame frame =
            session.render({{"width", 160}, {"height", 120}, {"aa", 1}, {"accuracy", accuracy}},
                           accuracy < 2.0 ? in_time : sheen::Listener{});
        frame.write(output);
        const double error = frame.figure("estimate_high");
        std::printf("accuracy %.3g: error at most %.1f%%, %.2f s\n", accuracy, 100 * error,
                    elapsed());
        if (error <= target) {
            return;
        }
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: progressive OUT.png TARGET_ERROR SECONDS\n");
        return 2;
    }
    try {
        render(argv[1], std::atof(argv[2]), std::atof(argv[3]));
    } catch (const sheen::Error& error) {
        if (error.kind() != sheen::ErrorKind::cancelled) {
            std::fprintf(stderr, "%s\n", error.what());
            return static_cast<int>(error.kind());
        }
        std::printf("the time is up\n");
    }
}
