#include "bake/solids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "bake/charts.h"
#include "core/directions.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

constexpr int kRays = 2 * Tracer::kPacket;

// Numbers of connected surfaces, [triangle].
std::vector<uint32_t> partsOf(const Scene& scene, const std::vector<uint32_t>& places,
                              uint32_t& count) {
    std::vector<uint32_t> root(scene.positions.size());
    for (uint32_t i = 0; i < root.size(); ++i) {
        root[i] = i;
    }
    const auto find = [&](uint32_t i) {
        while (root[i] != i) {
            i = root[i] = root[root[i]];
        }
        return i;
    };
    for (const uvec3& t : scene.triangles) {
        root[find(places[t.y])] = find(places[t.x]);
        root[find(places[t.z])] = find(places[t.x]);
    }
    constexpr uint32_t kNone = ~0u;
    std::vector<uint32_t> number(root.size(), kNone);
    std::vector<uint32_t> parts;
    for (const uvec3& t : scene.triangles) {
        uint32_t& own = number[find(places[t.x])];
        own = own == kNone ? count++ : own;
        parts.push_back(own);
    }
    return parts;
}

// By rays from a point in all directions.
std::array<Hit, kRays> metAround(const Tracer& tracer, const vec3& from) {
    std::array<vec3, kRays> directions;
    for (uint32_t i = 0; i < kRays; ++i) {
        const vec2 u = randomPlace(i, 0);
        const float z = 2.0f * u.x - 1.0f, r = std::sqrt(1.0f - z * z), phi = 2.0f * kPi * u.y;
        directions[i] = {r * std::cos(phi), r * std::sin(phi), z};
    }
    std::array<Hit, kRays> hits;
    tracer.meet({.origin = from, .directions = directions}, hits.data());
    return hits;
}

}  // namespace

// Closed where each edge is passed once in both directions; outward where there is a volume then.
std::vector<bool> Solids::closedParts(const std::vector<uint32_t>& places) const {
    const Scene& scene = tracer_.scene();
    std::map<std::pair<uint32_t, uint32_t>, int> passed;
    std::vector<double> volumes(parts_);
    const dvec3 middle(scene.bounds.center());
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        const uvec3& t = scene.triangles[i];
        for (int c = 0; c < 3; ++c) {
            ++passed[{places[t[c]], places[t[(c + 1) % 3]]}];
        }
        const dvec3 a = dvec3(scene.positions[t.x]) - middle;
        const dvec3 b = dvec3(scene.positions[t.y]) - middle;
        const dvec3 c = dvec3(scene.positions[t.z]) - middle;
        volumes[part_of_[i]] += glm::dot(a, glm::cross(b, c));
    }
    std::vector<bool> closed(parts_);
    for (size_t i = 0; i < parts_; ++i) {
        closed[i] = volumes[i] > 0.0;
    }
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        const uvec3& t = scene.triangles[i];
        for (int c = 0; c < 3; ++c) {
            const uint32_t from = places[t[c]], to = places[t[(c + 1) % 3]];
            const auto back = passed.find({to, from});
            if (passed.at({from, to}) != 1 || back == passed.end() || back->second != 1) {
                closed[part_of_[i]] = false;
            }
        }
    }
    return closed;
}

Solids::Solids(const Tracer& tracer) : tracer_(tracer) {
    const Scene& scene = tracer.scene();
    const std::vector<uint32_t> places = placesOf(scene);
    part_of_ = partsOf(scene, places, parts_);
    const std::vector<bool> closed = closedParts(places);
    std::vector<vec3> stands;
    for (const PunctualLight& light : scene.lights) {
        if (light.kind != shared::LIGHT_DIRECTIONAL) {
            stands.push_back(light.position);
        }
    }
    for (const Camera& camera : scene.cameras) {
        stands.emplace_back(camera.world_from_camera[3]);
    }
    room_.resize(parts_);
    for (const vec3& p : stands) {
        if (const std::optional<uint32_t> part = metFromWithin(p)) {
            room_[*part] = true;
        }
    }
    solid_.resize(scene.triangles.size());
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        const uint32_t part = part_of_[i];
        solid_[i] =
            !room_[part] && (closed[part] || scene.materials[scene.materials_of[i]].single_sided);
    }
}

// The part that most rays from a point meet from behind, if there is one.
std::optional<uint32_t> Solids::metFromWithin(const vec3& from) const {
    const std::array<Hit, kRays> hits = metAround(tracer_, from);
    for (const Hit& hit : hits) {
        if (!hit.found() || !hit.back) {
            continue;
        }
        const uint32_t part = part_of_[hit.triangle];
        const auto met = std::count_if(hits.begin(), hits.end(), [&](const Hit& other) {
            return other.found() && other.back && part_of_[other.triangle] == part;
        });
        if (2 * met > kRays) {
            return part;
        }
    }
    return std::nullopt;
}

bool Solids::enclose(std::span<const Hit> hits) const {
    size_t within = 0, behind_one = 0;
    const uint32_t one = !hits.empty() && hits[0].found() ? part_of_[hits[0].triangle] : 0;
    for (const Hit& hit : hits) {
        if (hit.found() && hit.back) {
            const uint32_t part = part_of_[hit.triangle];
            within += solid_[hit.triangle] ? 1 : 0;
            behind_one += part == one && !room_[part] ? 1 : 0;
        }
    }
    return 2 * within > hits.size() || (!hits.empty() && behind_one == hits.size());
}

bool Solids::hold(const vec3& p) const { return enclose(metAround(tracer_, p)); }

bool Solids::bury(const SurfaceSide& p, const vec3& normal) const {
    std::array<vec3, kRays> directions;
    size_t count = 0;
    const mat3 frame = tangentFrame(normal);
    for (uint32_t i = 0; i < kRays; ++i) {
        const vec3 direction = glm::normalize(frame * cosineDirection(randomPlace(i, 1)));
        if (glm::dot(direction, p.n_g) > 0.0f) {
            directions[count++] = direction;
        }
    }
    std::array<Hit, kRays> hits;
    tracer_.meet({.origin = p.start(), .directions = {directions.data(), count}}, hits.data());
    return enclose({hits.data(), count});
}

}  // namespace sheen
