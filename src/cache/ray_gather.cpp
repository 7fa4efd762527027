#include "cache/ray_gather.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/timer.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// Rays are cast in the order of blocks of texels, which are seen in similar directions; a texel
// looked at closer gets as many more, a row and a column each.
constexpr int kBlockWidth = 4;
constexpr int kBlockHeight = RayCaster::kPacket / kBlockWidth;
constexpr int kMoreRays = kBlockWidth * kBlockHeight;

// A texel is looked at closer where its neighbours' light differs by more than this many times what
// a texel contributes on average.
constexpr float kContrast = 2.0f;

// A face of the hemisphere in world space.
struct WorldFace {
    vec3 right, up, forward;
    vec2 step;  // from texel to texel, in u and v

    WorldFace(const HemisphereFace& face, const mat3& frame)
        : right(frame * face.right),
          up(frame * face.up),
          forward(frame * face.forward),
          step(2.0f / vec2(face.width, face.height)) {}

    vec3 direction(int x, int y, const vec2& place) const {
        const vec2 uv = (vec2(x, y) + place) * step - 1.0f;
        return glm::normalize(forward + uv.x * right + uv.y * up);
    }
};

// Rays of a record, and the texels they are for. Directions below the surface, to where the shading
// normal's hemisphere may reach, are not cast: nothing comes from there.
struct TexelRays {
    vec3 n_g;
    std::vector<vec3> directions = {};
    std::vector<float> solid_angles = {};  // that the rays stand for
    std::vector<size_t> of = {};

    void add(const vec3& direction, float solid_angle, size_t texel) {
        if (glm::dot(direction, n_g) > 0.0f) {
            directions.push_back(direction);
            solid_angles.push_back(solid_angle);
            of.push_back(texel);
        }
    }
    std::vector<vec4> cast(const RayCaster& rays, const vec3& eye, const LightCells& cells) const {
        std::vector<vec4> seen(directions.size());
        rays.cast({.origin = eye, .directions = directions, .solid_angles = solid_angles},
                  seen.data(), &cells);
        return seen;
    }
};

// Which texels deserve more rays: those beside whose middle light changes. A texel is judged by its
// neighbours and never by its own ray: were it looked at closer because its ray met something
// bright, but not because it missed it, light would be lost.
std::vector<uint8_t> texelsToRefine(const Hemisphere& h, const std::vector<vec4>& texels) {
    const size_t count = texels.size();
    std::vector<float> light(count);
    float sum = 0.0f;
    for (size_t t = 0; t < count; ++t) {
        light[t] = (texels[t].x + texels[t].y + texels[t].z) * h.solid_angles[t];
        sum += light[t];
    }
    std::vector<float> least(count, kInfinity);
    std::vector<float> most(count, 0.0f);
    const auto heed = [&](uint32_t t, uint32_t neighbour) {
        least[t] = std::min(least[t], light[neighbour]);
        most[t] = std::max(most[t], light[neighbour]);
    };
    for (const HemisphereWall& wall : h.walls) {
        heed(wall.a, wall.b);
        heed(wall.b, wall.a);
    }
    const float tolerated = kContrast * sum / static_cast<float>(count);
    std::vector<uint8_t> refine(count);
    for (size_t t = 0; t < count; ++t) {
        refine[t] = most[t] - least[t] > tolerated ? 1 : 0;
    }
    return refine;
}

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
    const auto texelOf = [&h](const HemisphereFace& face, int x, int y) {
        return static_cast<size_t>((face.y + y) * h.width + face.x + x);
    };

    // One ray a texel.
    TexelRays first{.n_g = site.geometric_normal};
    for (const HemisphereFace& face : h.faces) {
        const WorldFace world(face, frame);
        for (int y0 = 0; y0 < face.height; y0 += kBlockHeight) {
            for (int x0 = 0; x0 < face.width; x0 += kBlockWidth) {
                for (int y = y0; y < std::min(y0 + kBlockHeight, face.height); ++y) {
                    for (int x = x0; x < std::min(x0 + kBlockWidth, face.width); ++x) {
                        const size_t t = texelOf(face, x, y);
                        const vec2 place = randomPlace(index, static_cast<uint32_t>(t));
                        first.add(world.direction(x, y, place), h.solid_angles[t], t);
                    }
                }
            }
        }
    }
    const std::vector<vec4> first_seen = first.cast(rays_, eye, cells_);
    for (size_t i = 0; i < first.of.size(); ++i) {
        texels[first.of[i]] = first_seen[i];
    }

    // Eight more where light changes from texel to texel.
    const std::vector<uint8_t> refine = texelsToRefine(h, texels);
    TexelRays more{.n_g = site.geometric_normal};
    for (const HemisphereFace& face : h.faces) {
        const WorldFace world(face, frame);
        for (int y = 0; y < face.height; ++y) {
            for (int x = 0; x < face.width; ++x) {
                const size_t t = texelOf(face, x, y);
                for (int k = 0; refine[t] != 0 && k < kMoreRays; ++k) {
                    const size_t ray = texels.size() + t * kMoreRays + static_cast<size_t>(k);
                    const vec2 place = (vec2(k % kBlockWidth, k / kBlockWidth) +
                                        randomPlace(index, static_cast<uint32_t>(ray))) /
                                       vec2(kBlockWidth, kBlockHeight);
                    more.add(world.direction(x, y, place), h.solid_angles[t] / kMoreRays, t);
                }
            }
        }
    }
    const std::vector<vec4> more_seen = more.cast(rays_, eye, cells_);
    // The mean of radiance, and of the distance's inverse, over all nine rays.
    const auto inverse = [](float distance) { return distance > 0.0f ? 1.0f / distance : 0.0f; };
    for (size_t t = 0; t < texels.size(); ++t) {
        texels[t].w = inverse(texels[t].w);
    }
    for (size_t i = 0; i < more.of.size(); ++i) {
        texels[more.of[i]] += vec4(vec3(more_seen[i]), inverse(more_seen[i].w));
    }
    for (size_t t = 0; t < texels.size(); ++t) {
        texels[t] *= refine[t] != 0 ? 1.0f / (1 + kMoreRays) : 1.0f;
        texels[t].w = inverse(texels[t].w);
    }
    return texels;
}

}  // namespace sheen
