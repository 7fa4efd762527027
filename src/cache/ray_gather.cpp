#include "cache/ray_gather.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/timer.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// Texels whose rays are cast together: a block is seen in similar directions.
constexpr int kBlockWidth = 4;
constexpr int kBlockHeight = RayCaster::kPacket / kBlockWidth;

}  // namespace

std::vector<GatheredRecord> RayGatherer::gather(std::span<const RecordSite> sites) {
    projections_.prepare(hemisphere_, sites);
    const auto count = static_cast<int>(sites.size());
    std::vector<std::vector<vec4>> texels(sites.size());
    const Timer see_timer;
    parallelFor(count, [&](int index) {
        const auto i = static_cast<size_t>(index);
        texels[i] = see(sites[i], gathered_ + static_cast<uint32_t>(index));
    });
    seconds_.see += see_timer.seconds();
    const Timer project_timer;
    std::vector<GatheredRecord> results(sites.size());
    parallelFor(count, [&](int index) {
        const auto i = static_cast<size_t>(index);
        results[i] =
            integrateHemisphere(hemisphere_, texels[i], projections_.of(sites[i].order), sites[i]);
    });
    seconds_.project += project_timer.seconds();
    gathered_ += static_cast<uint32_t>(count);
    return results;
}

// Rays through the middles of texels would all miss, or all meet, a thin thing that lies along a
// row of them, and a record's neighbours would err the same way. Random places make that noise,
// which differs from record to record, so that interpolation averages it.
std::vector<vec4> RayGatherer::see(const RecordSite& site, uint32_t index) const {
    const Hemisphere& h = hemisphere_;
    const mat3 frame = tangentFrame(site.normal);
    const vec3 eye = rays_.origin(site.position, site.geometric_normal, site.toward_viewer);
    std::vector<vec4> texels(static_cast<size_t>(h.texelCount()));
    for (const HemisphereFace& face : h.faces) {
        const vec3 right = frame * face.right;
        const vec3 up = frame * face.up;
        const vec3 forward = frame * face.forward;
        const vec2 step = 2.0f / vec2(face.width, face.height);
        for (int y0 = 0; y0 < face.height; y0 += kBlockHeight) {
            for (int x0 = 0; x0 < face.width; x0 += kBlockWidth) {
                vec3 directions[RayCaster::kPacket];
                vec4 seen[RayCaster::kPacket];
                size_t of[RayCaster::kPacket];
                size_t rays = 0;
                for (int y = y0; y < std::min(y0 + kBlockHeight, face.height); ++y) {
                    for (int x = x0; x < std::min(x0 + kBlockWidth, face.width); ++x) {
                        const auto texel = static_cast<size_t>((face.y + y) * h.width + face.x + x);
                        const vec2 place = randomPlace(index, static_cast<uint32_t>(texel));
                        const vec2 uv = (vec2(x, y) + place) * step - 1.0f;
                        const vec3 direction = glm::normalize(forward + uv.x * right + uv.y * up);
                        // The shading normal's hemisphere may reach below the surface.
                        if (glm::dot(direction, site.geometric_normal) > 0.0f) {
                            directions[rays] = direction;
                            of[rays++] = texel;
                        }
                    }
                }
                rays_.cast(eye, {directions, rays}, seen);
                for (size_t k = 0; k < rays; ++k) {
                    texels[of[k]] = seen[k];
                }
            }
        }
    }
    return texels;
}

}  // namespace sheen
