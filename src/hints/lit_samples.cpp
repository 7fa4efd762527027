#include "hints/lit_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/directions.h"
#include "core/parallel.h"
#include "hints/even_directions.h"
#include "light/triangle_grid.h"

namespace sheen {
namespace {

// Terms of an evenly spread sequence in [0, 1)^2, of which any number may be taken. [Rob18]
vec2 spread(uint32_t i) {
    constexpr double kX = 0.7548776662466927, kY = 0.5698402909980532;
    const double x = 0.5 + kX * i, y = 0.5 + kY * i;
    return {static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y))};
}

// 0 to count - 1, such that terms of the sequence that follow each other are close: in Morton
// order.
std::vector<uint32_t> neighbourly(uint32_t count) {
    constexpr float kCells = 256.0f;
    std::vector<std::pair<uint32_t, uint32_t>> ordered;  // Morton code, number
    for (uint32_t i = 0; i < count; ++i) {
        const uvec2 cell = glm::min(uvec2(spread(i) * kCells), uvec2(255u));
        uint32_t code = 0;
        for (uint32_t bit = 0; bit < 8; ++bit) {
            code |= (cell.x >> bit & 1u) << (2 * bit) | (cell.y >> bit & 1u) << (2 * bit + 1);
        }
        ordered.emplace_back(code, i);
    }
    std::sort(ordered.begin(), ordered.end());
    std::vector<uint32_t> numbers;
    for (const auto& [code, number] : ordered) {
        numbers.push_back(number);
    }
    return numbers;
}

// From all directions within the cone about an axis whose cosine is at least `least`.
vec3 directionInCone(const vec3& axis, float least, const vec2& u) {
    const float z = 1.0f - u.x * (1.0f - least);
    const float r = std::sqrt(std::max(1.0f - z * z, 0.0f));
    const float phi = 2.0f * kPi * u.y;
    return tangentFrame(axis) * vec3(r * std::cos(phi), r * std::sin(phi), z);
}

// A ray from a light. What it meets receives `light`, a factor of the light there.
struct LightRay {
    vec3 origin, direction;
    // Of rays that spread from a point: the solid angle that each stands for. 0: they are parallel.
    float solid_angle = 0.0f;
    float area = 0.0f;  // of parallel rays, or of a lamp's: across the direction
    vec3 flux{0.0f};    // where it is known from the start, lm; else by `light`
    const PunctualLight* light = nullptr;
};

// Something that shines, its power, and how its sample `i` starts, that stands for one of `count`.
struct Source {
    double power;
    std::function<LightRay(uint32_t i, float count)> ray;
};

Source sourceOf(const PunctualLight& light, const vec3& center, float radius) {
    const double brightness = luminance(light.intensity);
    if (light.kind == shared::LIGHT_DIRECTIONAL) {
        const float area = kPi * radius * radius;
        return {brightness * area, [=](uint32_t i, float count) {
                    const vec2 u = spread(i);
                    const float r = radius * std::sqrt(u.x);
                    const float phi = 2.0f * kPi * u.y;
                    const vec3 across = vec3(r * std::cos(phi), r * std::sin(phi), -2.0f * radius);
                    const float each = area / count;
                    return LightRay{.origin = center + tangentFrame(light.direction) * across,
                                    .direction = light.direction,
                                    .area = each,
                                    .flux = light.intensity * each};
                }};
    }
    const float least = light.kind == shared::LIGHT_SPOT ? light.cos_outer : -1.0f;
    const float whole = 2.0f * kPi * (1.0f - least);
    return {brightness * whole, [=, &light](uint32_t i, float count) {
                return LightRay{.origin = light.position,
                                .direction = directionInCone(light.direction, least, spread(i)),
                                .solid_angle = whole / count,
                                .light = &light};
            }};
}

// All triangles that emit are one source.
class Lamps {
  public:
    explicit Lamps(const Tracer& tracer, const LampSampler& lamps) : scene_(tracer.scene()) {
        for (uint32_t triangle = 0; triangle < scene_.triangles.size(); ++triangle) {
            if (lamps.isLamp(triangle)) {
                const vec3 emission = meanEmission(scene_, triangle);
                const double area = TriangleEdges(scene_, triangle).area();
                area_ += area;
                power_ += 2.0 * kPi * area * luminance(emission);  // both sides shine
                lamps_.push_back({triangle, power_, emission});
            }
        }
    }
    double power() const { return power_; }
    LightRay ray(uint32_t i, float count) const {
        const double wanted = power_ * (i + 0.5) / count;
        const auto lamp = std::lower_bound(
            lamps_.begin(), lamps_.end() - 1, wanted,
            [](const Lamp& each, double power) { return each.power_to_here < power; });
        const TriangleEdges edges(scene_, lamp->triangle);
        const vec2 on = randomPlace(i, kOn);
        const vec2 uv = on.x + on.y < 1.0f ? on : 1.0f - on;
        const vec3 front = geometricNormal(scene_, static_cast<int>(lamp->triangle));
        const vec3 n_g = i % 2 == 0 ? front : -front;
        const vec3 direction = tangentFrame(n_g) * cosineDirection(randomPlace(i, kTo));
        const vec3 position = edges.at(uv);
        const float offset = surfaceOffset(scene_, lamp->triangle, position, n_g, 0.0f);
        const float brightness = luminance(lamp->emission);
        return {.origin = offSurface(position, n_g, direction, offset),
                .direction = direction,
                .solid_angle = 2.0f * kPi / count,
                .area = static_cast<float>(area_) / count,
                .flux = lamp->emission * static_cast<float>(power_ / brightness / count)};
    }

  private:
    static constexpr uint32_t kOn = 101, kTo = 102;  // which random numbers
    struct Lamp {
        uint32_t triangle;
        double power_to_here;  // of this one and those before
        vec3 emission;
    };
    const Scene& scene_;
    double power_ = 0.0;
    double area_ = 0.0;
    std::vector<Lamp> lamps_;
};

// A sample for what the ray met.
LitSample sampleOf(const Scene& scene, const LightRay& ray, const Hit& hit) {
    const SurfacePoint p =
        surfacePoint(scene, hit.triangle, hit.u, hit.v, -ray.direction, hit.distance);
    const float spread2 = ray.solid_angle * hit.distance * hit.distance;
    vec3 received = ray.flux;
    float light_distance = hit.distance;
    if (ray.light != nullptr) {
        received = shared::sampleLight(*ray.light, p.position).irradiance * spread2;
    } else if (ray.solid_angle == 0.0f) {
        light_distance = -1.0f;
    }
    constexpr float kLeastCosine = 0.2f;  // a piece seen along it is long, and no disc
    const float cosine = std::max(glm::dot(p.n_g, p.wo), kLeastCosine);
    const Scatterer surface = scattererAt(scene, p);
    return {.position = p.eye(scene),
            .n_g = p.n_g,
            .received = hit.weight * received,
            .group = 0,
            .wi = p.wo,
            .light_distance = light_distance,
            .surface = surface,
            .softening2 = (ray.area + spread2) / (kPi * cosine),
            .glossy = surface.brdf.f0 != vec3(0.0f) || surface.brdf.f90 != 0.0f};
}

// A source's rays. Where it gets few, each stands for what the source would get on average, so that
// of many weak sources those that get none are made up for.
void addRays(const std::vector<Source>& sources, int count, std::vector<LightRay>& rays) {
    constexpr double kEven = 1.0 / 64.0;  // of them, whatever the power
    constexpr double kMany = 8.0;
    double power = 0.0;
    for (const Source& source : sources) {
        power += source.power;
    }
    double sum = 0.0;
    uint32_t given = 0;
    for (size_t i = 0; i < sources.size() && power > 0.0; ++i) {
        const double expected = count * ((1.0 - kEven) * sources[i].power / power +
                                         kEven / static_cast<double>(sources.size()));
        sum += expected;
        // Those whose sum passes whole numbers get one.
        const auto to = static_cast<uint32_t>(std::llround(sum));
        const double each = expected < kMany ? expected : to - given;
        for (const uint32_t k : neighbourly(sources[i].power > 0.0 ? to - given : 0)) {
            rays.push_back(sources[i].ray(k, static_cast<float>(each)));
        }
        given = to;
    }
}

void addSamples(const Tracer& tracer, const std::vector<LightRay>& rays,
                std::vector<LitSample>& samples) {
    const size_t first = samples.size();
    std::vector<LitSample> found(rays.size());
    std::vector<uint8_t> any(rays.size(), 0);
    const auto packets = static_cast<int>((rays.size() + Tracer::kPacket - 1) / Tracer::kPacket);
    parallelFor(packets, [&](int packet) {
        const size_t from = static_cast<size_t>(packet) * Tracer::kPacket;
        const size_t count = std::min(rays.size() - from, size_t{Tracer::kPacket});
        std::array<vec3, Tracer::kPacket> origins, directions;
        std::array<Hit, Tracer::kPacket> hits;
        for (size_t k = 0; k < count; ++k) {
            origins[k] = rays[from + k].origin;
            directions[k] = rays[from + k].direction;
        }
        tracer.meet({.directions = {directions.data(), count}, .origins = {origins.data(), count}},
                    hits.data());
        for (size_t k = 0; k < count; ++k) {
            if (hits[k].found()) {
                LitSample s = sampleOf(tracer.scene(), rays[from + k], hits[k]);
                s.group = static_cast<uint32_t>(packet);
                found[from + k] = s;
                any[from + k] = finite(s.received) && s.received != vec3(0.0f) ? 1 : 0;
            }
        }
    });
    samples.resize(first + rays.size());
    size_t kept = first;
    for (size_t i = 0; i < rays.size(); ++i) {
        if (any[i] != 0) {
            samples[kept++] = found[i];
        }
    }
    samples.resize(kept);
}

}  // namespace

vec3 LitSample::toward(const vec3& wo, float d2, float width) const {
    if (!glossy) {
        return surface.brdf.diffuse * received / kPi;
    }
    Brdf seen = surface.brdf;
    const float across2 = kPi * softening2 + width * width;
    seen.alpha =
        shared::filteredAlpha(seen.alpha, across2 / (d2 + across2), std::sqrt(d2), light_distance);
    return shared::evalBrdf(seen, surface.n, wo, wi) * received;
}

SkySamples::SkySamples(const Environment& environment)
    : environment_(environment), sampler_(environment) {
    if (environment.texels.width * environment.texels.height == 1) {
        even_ = evenDirections(kCount);
    }
}

SkySamples::Sample SkySamples::at(int index, const mat3& rotation, const vec2& shift) const {
    constexpr float kShare = 1.0f / kCount;
    if (!even_.empty()) {
        const vec3 wi = rotation * even_[static_cast<size_t>(index)];
        return {wi, environment_.radiance(wi) * (4.0f * kPi * kShare)};
    }
    // By its brightness, whatever the normal.
    const vec2 u = glm::fract(spread(static_cast<uint32_t>(index)) + shift);
    const SkySampler::Sample s = sampler_.sample(vec3(0, 1, 0), u);
    return {s.wi, s.density > 0.0f ? s.radiance * (kShare / s.density) : vec3(0.0f)};
}

std::vector<LitSample> litSamples(const Tracer& tracer, const SceneLights& lights, int count) {
    const Scene& scene = tracer.scene();
    std::vector<LitSample> samples;
    if (scene.triangles.empty()) {
        return samples;
    }
    const vec3 center = scene.bounds.center();
    const float radius = 0.5f * scene.bounds.size();
    std::vector<Source> sources;
    for (const PunctualLight& light : scene.lights) {
        sources.push_back(sourceOf(light, center, radius));
    }
    const Lamps lamps(tracer, lights.lamps);
    if (lamps.power() > 0.0) {
        sources.push_back({lamps.power(), [&](uint32_t i, float n) { return lamps.ray(i, n); }});
    }
    std::vector<LightRay> rays;
    addRays(sources, count, rays);
    addSamples(tracer, rays, samples);
    return samples;
}

}  // namespace sheen
