#include "bake/texels.h"

#include <cmath>
#include <memory>

#include "image/frame.h"
#include "record/record.h"

namespace sheen {
namespace {

// What stands for the height of an image: the side of a cube of as much surface.
float extentOf(const Scene& scene) {
    double area2 = 0.0;
    for (const uvec3& t : scene.triangles) {
        const vec3& p = scene.positions[t.x];
        area2 += glm::length(glm::cross(scene.positions[t.y] - p, scene.positions[t.z] - p));
    }
    return static_cast<float>(std::sqrt(area2 / 12.0));
}

}  // namespace

Receivers unseenReceivers(int width, int height) {
    Receivers r;
    r.image = {.width = width, .height = height};
    const auto count = static_cast<size_t>(r.image.count());
    r.positions.resize(count);
    r.normals.resize(count);
    r.footprints.resize(count);
    r.triangles.assign(count, kNoPrimitive);
    r.materials.assign(count, kNoMaterial);
    r.outward.resize(count);
    r.orders.assign(count, static_cast<int8_t>(kNoOrder));
    r.by_rays.resize(count);
    r.irradiance_only = true;
    return r;
}

void putReceiver(Receivers& r, size_t i, const Scene& scene, uint32_t triangle,
                 const SurfaceSide& side, const vec3& normal, float footprint) {
    r.positions[i] = side.position;
    r.outward[i] = side.n_g;
    r.normals[i] = normal;
    r.footprints[i] = footprint;
    r.triangles[i] = triangle;
    r.materials[i] = static_cast<int>(scene.materials_of[triangle]);
    r.orders[i] = shared::DIFFUSE_ORDER;
}

void indexReceivers(Receivers& r, const Scene& scene) {
    std::vector<uint32_t> seen;
    for (uint32_t i = 0; i < r.positions.size(); ++i) {
        if (r.seen(i)) {
            seen.push_back(i);
        }
    }
    r.counts.seen = r.counts.diffuse = static_cast<int>(seen.size());
    r.extent = extentOf(scene);
    r.places = std::make_shared<PointIndex>(r.positions, std::move(seen));
}

}  // namespace sheen
