#include "gather/movers.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sheen {
namespace {

// Triangles are halved so often by where they lie: cones around the parts are narrower than one
// around all.
constexpr int kHalvings = 4;

vec3 middleOf(const Scene& scene, uint32_t triangle) {
    const uvec3& t = scene.triangles[triangle];
    return (scene.positions[t.x] + scene.positions[t.y] + scene.positions[t.z]) / 3.0f;
}

Bounds boundsOf(const Scene& scene, std::span<const uint32_t> triangles) {
    Bounds bounds;
    for (const uint32_t triangle : triangles) {
        const uvec3& t = scene.triangles[triangle];
        for (int corner = 0; corner < 3; ++corner) {
            bounds.add(scene.positions[t[corner]]);
        }
    }
    return bounds;
}

// Calls visit(part) for parts that lie close together.
template <class F>
void forEachPart(const Scene& scene, std::span<uint32_t> triangles, int halvings, const F& visit) {
    if (halvings == 0 || triangles.size() < 2) {
        visit(triangles);
        return;
    }
    const Bounds bounds = boundsOf(scene, triangles);
    const vec3 size = bounds.upper - bounds.lower;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const size_t half = triangles.size() / 2;
    std::nth_element(triangles.begin(), triangles.begin() + static_cast<ptrdiff_t>(half),
                     triangles.end(), [&](uint32_t a, uint32_t b) {
                         const float at_a = middleOf(scene, a)[axis];
                         const float at_b = middleOf(scene, b)[axis];
                         return at_a != at_b ? at_a < at_b : a < b;
                     });
    forEachPart(scene, triangles.first(half), halvings - 1, visit);
    forEachPart(scene, triangles.subspan(half), halvings - 1, visit);
}

}  // namespace

Movers::Movers(const Scene& scene, std::vector<uint8_t> moves, std::span<const vec3> before)
    : moves_(std::move(moves)) {
    auto moving = std::make_unique<Scene>();
    const auto add = [&](size_t triangle, std::span<const vec3> positions) {
        const auto base = static_cast<uint32_t>(moving->positions.size());
        for (int corner = 0; corner < 3; ++corner) {
            moving->positions.push_back(positions[scene.triangles[triangle][corner]]);
        }
        moving->triangles.emplace_back(base, base + 1, base + 2);
    };
    for (size_t i = 0; i < moves_.size(); ++i) {
        if (moves_[i] != 0) {
            add(i, scene.positions);
            if (!before.empty()) {
                add(i, before);
            }
        }
    }
    if (moving->triangles.empty()) {
        return;
    }
    std::vector<uint32_t> all(moving->triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    forEachPart(*moving, all, kHalvings, [&](std::span<const uint32_t> part) {
        const Bounds bounds = boundsOf(*moving, part);
        balls_.push_back({bounds.center(), 0.5f * bounds.size()});
    });
    scene_ = std::move(moving);
    tracer_ = std::make_unique<Tracer>(*scene_);
}

std::vector<uint32_t> Movers::texelsToward(const Hemisphere& h, const vec3& eye,
                                           const vec3& normal) const {
    const mat3 local = glm::transpose(tangentFrame(normal, 0.0f));
    // From the middle of a texel to its corner, at most.
    const float corner = std::sqrt(2.0f) / static_cast<float>(h.params.size);
    std::vector<vec4> cones;  // axis, cosine
    for (const Ball& ball : balls_) {
        const vec3 way = ball.center - eye;
        const float distance = glm::length(way);
        const float angle = distance > ball.radius ? std::asin(ball.radius / distance) : kPi;
        if (angle + corner >= kPi) {
            cones.assign(1, vec4(0.0f, 0.0f, 1.0f, -2.0f));
            break;
        }
        cones.emplace_back(local * (way / distance), std::cos(angle + corner));
    }
    std::vector<uint32_t> texels;
    for (size_t t = 0; t < h.directions.size(); ++t) {
        const vec3& d = h.directions[t];
        if (std::any_of(cones.begin(), cones.end(),
                        [&](const vec4& cone) { return glm::dot(vec3(cone), d) >= cone.w; })) {
            texels.push_back(static_cast<uint32_t>(t));
        }
    }
    return texels;
}

std::vector<uint8_t> Movers::hide(const vec3& eye, std::span<const vec3> directions,
                                  std::span<const float> distances) const {
    std::vector<Hit> hits(directions.size());
    tracer_->meet({.origin = eye, .directions = directions}, hits.data());
    std::vector<uint8_t> hidden(directions.size());
    for (size_t i = 0; i < hits.size(); ++i) {
        hidden[i] = hits[i].distance < distances[i] ? 1 : 0;
    }
    return hidden;
}

}  // namespace sheen
