#include "render/black_frame.h"

#include <algorithm>

namespace sheen {
namespace {

bool isBlack(const Image<vec3>& layer) {
    return std::all_of(layer.pixels.begin(), layer.pixels.end(),
                       [](const vec3& pixel) { return pixel == vec3(0.0f); });
}

}  // namespace

std::string whyBlack(const Scene& scene, const Camera& camera, const Frame& frame) {
    if (scene.triangles.empty() || !isBlack(frame.direct) || !isBlack(frame.indirect) ||
        !isBlack(frame.emission) || !isBlack(frame.caustic)) {
        return {};
    }
    int seen = 0;
    int backs = 0;
    for (int y = 0; y < frame.height(); ++y) {
        for (int x = 0; x < frame.width(); ++x) {
            const uint32_t triangle = frame.primitive.at(x, y);
            if (triangle != kNoPrimitive) {
                const CameraRay ray = cameraRay(camera, frame.width(), frame.height(),
                                                static_cast<float>(x), static_cast<float>(y));
                const vec3 normal = geometricNormal(scene, static_cast<int>(triangle));
                ++seen;
                backs += glm::dot(normal, ray.direction) > 0.0f ? 1 : 0;
            }
        }
    }
    const std::string name = fmt::format("camera '{}'", camera.name);
    if (seen == 0) {
        return name +
               " sees no surface, the image is black: all lie behind or beside it; turn it round, "
               "or choose another by --camera";
    }
    constexpr double kNearlyAll = 0.99;
    const double pixels = static_cast<double>(frame.width()) * frame.height();
    if (seen >= kNearlyAll * pixels && backs >= kNearlyAll * seen) {
        return name +
               " is inside a solid, the image is black: it sees only backs of surfaces and no "
               "light on them; move it out, or choose another by --camera";
    }
    return name +
           " sees surfaces but no light on them, the image is black: no light reaches where it "
           "looks; add one there, or choose another by --camera";
}

}  // namespace sheen
