#include "gather/anchors.h"

#include <algorithm>
#include <cmath>

#include "core/hash.h"
#include "core/parallel.h"
#include "rays/surface_point.h"

namespace sheen {
namespace {

// A cell's edge over the width of what the ray that asks stands for, before it is rounded to a
// power of two.
constexpr float kCell = 0.5f;
constexpr float kSameNormal = 0.95f;
// Within this factor of what another point reflects its light tells of a point's.
constexpr float kMostTint = 4.0f;
// Of a lobe's alpha: rays that come from directions closer together see the same of it.
constexpr float kSameLobe = 0.5f;

// Whether a triangle's vertices have different colours.
bool colored(const Scene& scene, uint32_t triangle) {
    const uvec3& t = scene.triangles[triangle];
    return !scene.colors.empty() &&
           !(scene.colors[t.x] == scene.colors[t.y] && scene.colors[t.x] == scene.colors[t.z] &&
             scene.colors[t.x] == vec4(1.0f));
}

// The cell of space around a point whose edge is about as wanted: a hash of its place and size.
uint64_t cellOf(const vec3& p, float wanted) {
    const float level = std::floor(std::log2(std::max(wanted, 1e-30f)) + 0.5f);
    const float edge = std::exp2(level);
    // Surfaces often lie at round numbers, where cells should not meet.
    const vec3 place = p / edge + vec3(0.3711f, 0.6173f, 0.4519f);
    const vec3 corner = glm::clamp(glm::floor(place), vec3(-2e9f), vec3(2e9f));
    uint64_t hash = 0;
    for (const float number : {level, corner.x, corner.y, corner.z}) {
        hash = splitMix(hash + static_cast<uint64_t>(static_cast<int64_t>(number)));
    }
    return hash;
}

}  // namespace

void Anchors::beginFrame(const Scene& scene, std::vector<uint8_t> moves,
                         std::span<const vec3> before, size_t rays) {
    movers_ = Movers(scene, std::move(moves), before);
    for (size_t k = 0; k < places_.size(); ++k) {
        if (movers_.moves(places_[k].hit.triangle)) {
            stands_[k] = 0;
        }
    }
    before_ = size();
    lit_ = 0;
    change_ = movers_.any();
    rays_ = rays;
}

bool Anchors::claim(size_t rays) {
    if (rays_ + rays > kMostRays) {
        return false;
    }
    rays_ += rays;
    return true;
}

Anchors::Surface Anchors::surfaceOf(const Scene& scene, const Met& met) {
    const Hit& hit = met.hit;
    const SurfacePoint p = surfacePoint(scene, hit.triangle, hit.u, hit.v, -met.direction,
                                        hit.distance, met.solid_angle);
    Surface surface{.point = {p.position, p.n_g}, .toward = p.wo};
    surface.material = scene.materials_of[hit.triangle];
    const Material& material = scene.materials[surface.material];
    const bool lambertian = isLambertian(material);
    // Of what is not textured the direction alone makes a difference, which lobes' does.
    const bool varies = material.textured() || colored(scene, hit.triangle);
    if (!lambertian || varies) {
        const Scatterer scatterer = scattererAt(scene, p);
        surface.color = scatterer.brdf.diffuse + scatterer.brdf.f0;
        surface.alpha = lambertian ? 0.0f : scatterer.brdf.alpha;
    }
    if (!varies) {
        surface.color = vec3(1.0f);
    }
    if (material.emits()) {
        surface.emission = emissionAt(scene, hit.triangle, vec3(1.0f - hit.u - hit.v, hit.u, hit.v),
                                      met.solid_angle * hit.distance * hit.distance);
    }
    surface.cell = cellOf(p.position, kCell * hit.distance * std::sqrt(met.solid_angle));
    return surface;
}

// By what a point reflects more than an anchor; none where the one does not tell of the other.
std::optional<vec3> Anchors::tintOf(const Surface& anchor, const Surface& met) {
    if (anchor.material != met.material || anchor.emission != met.emission ||
        glm::dot(anchor.point.normal, met.point.normal) < kSameNormal) {
        return std::nullopt;
    }
    if (met.alpha > 0.0f && glm::distance(anchor.toward, met.toward) > kSameLobe * met.alpha) {
        return std::nullopt;
    }
    vec3 tint(1.0f);
    for (int c = 0; c < 3; ++c) {
        if (met.color[c] == anchor.color[c]) {
            continue;
        }
        if (met.emission != vec3(0.0f)) {
            return std::nullopt;  // which a tint would change
        }
        tint[c] = met.color[c] / anchor.color[c];
        if (!(tint[c] <= kMostTint && tint[c] * kMostTint >= 1.0f)) {
            return std::nullopt;
        }
    }
    return tint;
}

std::optional<Anchors::Link> Anchors::findFor(const Surface& surface, const vec3& weight) const {
    const auto first = first_of_.find(surface.cell);
    for (uint32_t k = first == first_of_.end() ? kNone : first->second; k != kNone; k = next_[k]) {
        if (stands_[k] == 0) {
            continue;
        }
        if (const auto tint = tintOf(surfaces_[k], surface)) {
            return Link{k, *tint * weight};
        }
    }
    return std::nullopt;
}

std::optional<Anchors::Link> Anchors::find(const Scene& scene, const Met& met) const {
    return findFor(surfaceOf(scene, met), met.hit.weight);
}

std::optional<Anchors::Link> Anchors::findOrAdd(const Scene& scene, const Met& met) {
    const Surface surface = surfaceOf(scene, met);
    if (const auto found = findFor(surface, met.hit.weight)) {
        return found;
    }
    if (size() >= kMost) {
        return std::nullopt;
    }
    const auto added = static_cast<uint32_t>(size());
    places_.push_back(met);
    places_.back().hit.weight = vec3(1.0f);
    surfaces_.push_back(surface);
    stands_.push_back(1);
    light_.emplace_back(0.0f);
    insert(added);
    return Link{added, met.hit.weight};
}

// At the end of its cell's, so that those found before still are.
void Anchors::insert(uint32_t anchor) {
    next_.push_back(kNone);
    uint32_t* last = &first_of_.try_emplace(surfaces_[anchor].cell, kNone).first->second;
    while (*last != kNone) {
        last = &next_[*last];
    }
    *last = anchor;
}

void Anchors::lightBy(const OutgoingLight& light, bool without_caustics) {
    constexpr size_t kTogether = OutgoingLight::kTogether / 4;
    const size_t first = lit_;
    const size_t chunks = (size() - first + kTogether - 1) / kTogether;
    std::vector<uint8_t> changed(chunks);
    parallelFor(static_cast<int>(chunks), [&](int chunk) {
        const size_t begin = first + static_cast<size_t>(chunk) * kTogether;
        const size_t end = std::min(begin + kTogether, size());
        std::vector<vec3> origins, directions;
        std::vector<float> solid_angles;
        std::vector<Hit> hits;
        for (size_t k = begin; k < end; ++k) {
            origins.push_back(places_[k].origin);
            directions.push_back(places_[k].direction);
            solid_angles.push_back(places_[k].solid_angle);
            hits.push_back(stands_[k] != 0 ? places_[k].hit : Hit{});
        }
        std::vector<vec3> found(hits.size());
        light.radiance({.directions = directions,
                        .solid_angles = solid_angles,
                        .origins = origins,
                        .without_caustics = without_caustics},
                       hits, found.data());
        for (size_t k = begin; k < end; ++k) {
            const vec3& now = found[k - begin];
            if (now != light_[k] && k < before_) {
                changed[static_cast<size_t>(chunk)] = 1;
            }
            light_[k] = now;
        }
    });
    change_ = change_ || std::find(changed.begin(), changed.end(), 1) != changed.end();
    lit_ = size();
}

std::vector<uint32_t> Anchors::keepOnly(std::span<const uint8_t> used) {
    std::vector<uint32_t> becomes(size(), kNone);
    uint32_t kept = 0;
    size_t lit = 0, before = 0;
    for (size_t k = 0; k < used.size(); ++k) {
        if (used[k] == 0 || stands_[k] == 0) {
            continue;
        }
        becomes[k] = kept;
        places_[kept] = places_[k];
        surfaces_[kept] = surfaces_[k];
        stands_[kept] = stands_[k];
        light_[kept] = light_[k];
        lit += k < lit_ ? 1 : 0;
        before += k < before_ ? 1 : 0;
        ++kept;
    }
    places_.resize(kept);
    surfaces_.resize(kept);
    stands_.resize(kept);
    light_.resize(kept);
    lit_ = lit;
    before_ = before;
    next_.clear();
    first_of_.clear();
    for (uint32_t k = 0; k < kept; ++k) {
        insert(k);
    }
    return becomes;
}

}  // namespace sheen
