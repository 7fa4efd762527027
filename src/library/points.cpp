#include "library/points.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "bake/points.h"

namespace sheen::library {
namespace {

constexpr size_t kMostPoints = 1 << 28;

std::vector<AskedPoint> askedPoints(const Scene& scene, const sheen_points& points) {
    if (points.count > 0 && (points.positions == nullptr || points.normals == nullptr)) {
        throwUsage("points: positions or normals are NULL");
    }
    if (points.count > kMostPoints) {
        throwUsage("points: {} are more than {}; ask for fewer at once", points.count, kMostPoints);
    }
    if (!(points.width > 0.0f) || !std::isfinite(points.width)) {
        throwUsage("points: their width is {}; it must be above 0", points.width);
    }
    std::vector<AskedPoint> asked(points.count);
    for (size_t i = 0; i < points.count; ++i) {
        const double* p = points.positions + 3 * i;
        const float* n = points.normals + 3 * i;
        const vec3 position(dvec3(p[0], p[1], p[2]) - scene.origin);
        const vec3 normal(n[0], n[1], n[2]);
        const float length = glm::length(normal);
        if (!finite(position) || !std::isfinite(length) || !(length > 0.0f)) {
            throwUsage("points: position or normal {} is not finite, or the normal zero", i);
        }
        asked[i] = {.position = position, .normal = normal / length, .width = points.width};
    }
    return asked;
}

void copyTo(float* to, const std::vector<vec3>& light, const std::vector<uint8_t>& found) {
    for (size_t i = 0; to != nullptr && i < light.size(); ++i) {
        const vec3 value = found[i] != 0 ? light[i] : vec3(std::numeric_limits<float>::quiet_NaN());
        std::memcpy(to + 3 * i, &value, sizeof(value));
    }
}

}  // namespace

void askPoints(const Scene& scene, const sheen_points& points, const Request& request,
               float* direct, float* indirect) {
    const std::vector<AskedPoint> asked = askedPoints(scene, points);
    BakeParams params{.bounces = request.options.params.bounces,
                      .indirect_only = direct == nullptr};
    if (request.app.get_option("--accuracy")->count() > 0) {
        params.accuracy = request.options.params.placement.accuracy;
    }
    const Tracer tracer(scene);
    const LightAtPoints light = lightAtPoints(tracer, asked, params);
    copyTo(direct, light.direct, light.found);
    copyTo(indirect, light.indirect, light.found);
    size_t lost = 0, first = 0;
    for (size_t i = light.found.size(); i-- > 0;) {
        lost += light.found[i] == 0 ? 1 : 0;
        first = light.found[i] == 0 ? i : first;
    }
    if (lost > 0) {
        warn(fmt::format(
            "points: {} of {} have no surface within their width, point {} is the first: NaN there",
            lost, asked.size(), first));
    }
}

}  // namespace sheen::library
