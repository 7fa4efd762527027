#include "bake/points.h"

#include <optional>

#include "bake/texels.h"
#include "core/parallel.h"

namespace sheen {
namespace {

// The surface that a point lies on: met by a ray from a little above it. From as near as meets one,
// so that what hangs over it does not count.
std::optional<SurfacePoint> surfaceOf(const Tracer& tracer, const AskedPoint& point) {
    constexpr float kNearest = 0x1p-10f;  // of its width
    const vec3 direction = -point.normal;
    for (float share = kNearest; share <= 1.0f; share *= 2.0f) {
        const float height = share * point.width;
        Hit hit;
        tracer.meet(
            {.origin = point.position + height * point.normal, .directions = {&direction, 1}},
            &hit);
        if (hit.found() && hit.distance <= 2.0f * height) {
            return surfacePoint(tracer.scene(), hit.triangle, hit.u, hit.v, point.normal,
                                hit.distance);
        }
    }
    return std::nullopt;
}

}  // namespace

LightAtPoints lightAtPoints(const Tracer& tracer, std::span<const AskedPoint> points,
                            const BakeParams& params) {
    constexpr int kGrain = 256;
    const Scene& scene = tracer.scene();
    const auto count = static_cast<int>(points.size());
    LightAtPoints light;
    light.direct.resize(points.size());
    light.indirect.resize(points.size());
    light.found.resize(points.size());
    // In rows, which are worked on side by side; the last one may end in nothing.
    constexpr int kRow = 64;
    Receivers receivers = unseenReceivers(kRow, (count + kRow - 1) / kRow);
    parallelFor(
        count,
        [&](int k) {
            const auto i = static_cast<size_t>(k);
            const std::optional<SurfacePoint> p = surfaceOf(tracer, points[i]);
            if (!p) {
                return;
            }
            const SurfaceSide side =
                sideToward(scene, p->triangle, p->position, p->position + points[i].width * p->n_g);
            const vec3 normal =
                normalsAt(scene, p->triangle, p->barycentric, side.n_g, side.toward_viewer).smooth;
            putReceiver(receivers, i, scene, p->triangle, side, normal, points[i].width);
            light.found[i] = 1;
        },
        kGrain);
    indexReceivers(receivers, scene);
    if (receivers.counts.seen == 0) {
        return light;
    }
    const Baked baked = gatherLight(tracer, receivers, params);
    light.stats = baked.stats;
    for (size_t i = 0; i < points.size(); ++i) {
        if (light.found[i] != 0) {
            light.indirect[i] = baked.frame.indirect.pixels[i];
            if (!params.indirect_only) {
                light.direct[i] = baked.frame.direct.pixels[i];
            }
        }
    }
    return light;
}

}  // namespace sheen
