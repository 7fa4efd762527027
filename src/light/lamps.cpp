#include "light/lamps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/directions.h"
#include "core/parallel.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// Triangles that fill more of what a point sees are sampled evenly over the angle they fill, others
// over their area: there rounding would decide.
constexpr float kSmallestAngle = 3e-3f;
// A way ends this fraction short of its lamp.
constexpr float kWayShare = 1.0f - 1e-5f;
// What leaves a side of a lamp meets other surfaces at some distance: from the inside of a bulb, or
// against a wall, soon. Beyond so many times the farthest of what a few rays met it is seldom seen.
constexpr float kReach = 4.0f;
constexpr int kReachPackets = 16;

// More lamps' light is not added up without shadows.
constexpr size_t kMostPlain = 1024;

// Whether all points of a surface emit as much.
bool shinesAlike(const Material& material) {
    const bool textured =
        material.unlit || std::any_of(material.textures.begin(), material.textures.end(),
                                      [](const TextureUse& use) { return use.used(); });
    return !textured && !material.lightPasses();
}

// What a spherical triangle's corners, as seen from a point, span. [VOS83]
float solidAngle(const vec3& a, const vec3& b, const vec3& c) {
    const float numerator = std::abs(glm::dot(a, glm::cross(b, c)));
    const float denominator = 1.0f + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a);
    return 2.0f * std::atan2(numerator, denominator);
}

// An angle of a spherical triangle: at a, between the arcs to b and to c.
double angleAt(const dvec3& a, const dvec3& b, const dvec3& c) {
    const dvec3 to_b = glm::cross(a, b), to_c = glm::cross(a, c);
    return std::atan2(glm::length(glm::cross(to_b, to_c)), glm::dot(to_b, to_c));
}

// The integral of the cosine to a unit normal over what a triangle fills of the half space above,
// by its corners as seen from a point; `volume`: its area times the height of its plane. [Arv95]
double projectedAngle(const std::array<dvec3, 3>& corners, const dvec3& n, double volume) {
    // So small, or so far, that it is a point.
    constexpr double kPoint = 1.0 / 1024.0;
    const dvec3 middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    const double distance2 = glm::dot(middle, middle);
    double size2 = 0.0, low = kInfinity, high = -kInfinity;
    for (const dvec3& corner : corners) {
        size2 = std::max(size2, glm::dot(corner - middle, corner - middle));
        low = std::min(low, glm::dot(corner, n));
        high = std::max(high, glm::dot(corner, n));
    }
    if (high <= 0.0) {
        return 0.0;
    }
    if (low > 0.0 && size2 < kPoint * distance2) {
        return volume * glm::dot(middle, n) / (distance2 * distance2);
    }
    // What is below the horizon is cut off.
    std::array<dvec3, 4> kept;
    size_t count = 0;
    for (size_t i = 0; i < 3; ++i) {
        const dvec3 &from = corners[i], &to = corners[(i + 1) % 3];
        const double above = glm::dot(from, n), next = glm::dot(to, n);
        if (above >= 0.0) {
            kept[count++] = from;
        }
        if ((above > 0.0 && next < 0.0) || (above < 0.0 && next > 0.0)) {
            kept[count++] = glm::mix(from, to, above / (above - next));
        }
    }
    double sum = 0.0;
    for (size_t i = 0; i < count; ++i) {
        const dvec3& a = kept[i];
        const dvec3& b = kept[(i + 1) % count];
        const dvec3 across = glm::cross(a, b);
        const double length = glm::length(across);
        if (length > 0.0) {
            sum += std::atan2(length, glm::dot(a, b)) * glm::dot(across, n) / length;
        }
    }
    return 0.5 * std::abs(sum);
}

// A direction evenly spread over a spherical triangle. [Arv95]
vec3 sampleSpherical(const vec3& a_, const vec3& b_, const vec3& c_, const vec2& u) {
    const dvec3 a(a_), b(b_), c(c_);
    const double alpha = angleAt(a, b, c);
    const double area = alpha + angleAt(b, c, a) + angleAt(c, a, b) - std::numbers::pi;
    const double part = double{u.x} * area;
    const double s = std::sin(part - alpha), t = std::cos(part - alpha);
    const double cos_alpha = std::cos(alpha), sin_alpha = std::sin(alpha);
    const double cos_c = glm::dot(a, b);
    const double k = t - cos_alpha, m = s + sin_alpha * cos_c;
    const double down = (m * s + k * t) * sin_alpha;
    const double q = ((m * t - k * s) * cos_alpha - m) / (std::abs(down) > 0.0 ? down : 1e-300);
    const double cos_b = glm::clamp(q, -1.0, 1.0);
    const dvec3 toward_c = c - glm::dot(c, a) * a;
    const dvec3 moved = cos_b * a + std::sqrt(1.0 - cos_b * cos_b) * glm::normalize(toward_c);
    const double z = 1.0 - double{u.y} * (1.0 - glm::dot(moved, b));
    const dvec3 toward_moved = moved - glm::dot(moved, b) * b;
    const double length = glm::length(toward_moved);
    return vec3(
        length > 0.0 ? z * b + std::sqrt(std::max(1.0 - z * z, 0.0)) * (toward_moved / length) : b);
}

}  // namespace

struct LampSampler::Corners {
    vec3 p0, e1, e2;
    vec3 n;  // unit, by winding
    float area;

    // Where a ray meets the plane: barycentric coordinates of the second and third corner.
    vec2 meet(const vec3& origin, const vec3& direction) const {
        const vec3 p = glm::cross(direction, e2);
        const float scale = 1.0f / glm::dot(e1, p);
        const vec3 from = origin - p0;
        const vec2 uv(glm::dot(from, p) * scale, glm::dot(direction, glm::cross(from, e1)) * scale);
        const vec2 inside = glm::max(uv, vec2(0.0f));
        return inside / std::max(inside.x + inside.y, 1.0f);
    }
    vec3 at(const vec2& uv) const { return p0 + uv.x * e1 + uv.y * e2; }
};

LampSampler::Corners LampSampler::corners(uint32_t triangle) const {
    const uvec3& t = scene_.triangles[triangle];
    Corners c;
    c.p0 = scene_.positions[t.x];
    c.e1 = scene_.positions[t.y] - c.p0;
    c.e2 = scene_.positions[t.z] - c.p0;
    const vec3 across = glm::cross(c.e1, c.e2);
    c.area = 0.5f * glm::length(across);
    c.n = glm::normalize(across);
    return c;
}

// What a few rays meet that leave the middle of a triangle on the side of a unit normal: how far
// away at most.
float LampSampler::farthest(const Tracer& tracer, uint32_t triangle, const vec3& n) const {
    const Corners c = corners(triangle);
    const vec3 middle = c.at(vec2(1.0f / 3.0f));
    const float size = std::max(glm::length(c.e1), glm::length(c.e2));
    const SurfaceSide side{.position = middle,
                           .n_g = n,
                           .toward_viewer = vec3(0.0f),
                           .offset = surfaceOffset(scene_, triangle, middle, n, size)};
    const mat3 frame = tangentFrame(n);
    float distance = 0.0f;
    for (int packet = 0; packet < kReachPackets; ++packet) {
        vec3 directions[Tracer::kPacket];
        Hit hits[Tracer::kPacket];
        for (int k = 0; k < Tracer::kPacket; ++k) {
            const auto ray = static_cast<uint32_t>(packet * Tracer::kPacket + k);
            directions[k] = frame * cosineDirection(randomPlace(triangle, ray));
        }
        tracer.meet({.origin = side.start(), .directions = directions}, hits);
        for (const Hit& hit : hits) {
            distance = std::max(distance, hit.distance);
        }
    }
    return distance;
}

LampSampler::LampSampler(const Tracer& tracer) : scene_(tracer.scene()) {
    const auto count = static_cast<uint32_t>(scene_.triangleCount());
    for (uint32_t t = 0; t < count; ++t) {
        if (!scene_.lamps_baked && scene_.materials[scene_.materials_of[t]].emits() &&
            luminance(meanEmission(scene_, t)) > 0.0f) {
            first_.resize(count, kNone);
            first_[t] = static_cast<uint32_t>(2 * triangles_.size());
            triangles_.push_back(t);
        }
    }
    std::vector<LightBounds> entries(2 * triangles_.size());
    reaches_.resize(entries.size());
    parallelFor(static_cast<int>(entries.size()), [&](int i) {
        const auto entry = static_cast<size_t>(i);
        const uint32_t triangle = triangles_[entry / 2];
        const Corners c = corners(triangle);
        LightBounds& bounds = entries[entry];
        for (const vec2& uv : {vec2(0, 0), vec2(1, 0), vec2(0, 1)}) {
            bounds.box.add(c.at(uv));
        }
        const vec3 n = entry % 2 == 0 ? c.n : -c.n;
        bounds.intensity =
            Intensity::byCosine(n, c.area * luminance(meanEmission(scene_, triangle)));
        bounds.reach = reaches_[entry] = kReach * farthest(tracer, triangle, n);
    });
    tree_ = LightTree(entries);
    plain_ = triangles_.size() <= kMostPlain;
    for (const uint32_t t : triangles_) {
        emissions_.push_back(meanEmission(scene_, t));
        plain_ = plain_ && shinesAlike(scene_.materials[scene_.materials_of[t]]);
    }
}

bool LampSampler::reaches(size_t entry, const Corners& c, const vec3& p) const {
    const vec3 way = c.at(vec2(1.0f / 3.0f)) - p;
    return glm::dot(way, way) <= reaches_[entry] * reaches_[entry];
}

bool LampSampler::withinReach(const SurfaceSide& surface, const Hit& hit) const {
    return reaches(entryOf(hit.triangle) + (hit.back ? 1 : 0), corners(hit.triangle),
                   surface.start());
}

vec3 LampSampler::irradiance(const SurfaceSide& surface, const vec3& n) const {
    const vec3 start = surface.start();
    vec3 sum(0.0f);
    for (size_t i = 0; i < triangles_.size(); ++i) {
        const Corners c = corners(triangles_[i]);
        const float height = glm::dot(start - c.p0, c.n);
        const size_t entry = 2 * i + (height < 0.0f ? 1 : 0);
        if (!(c.area > 0.0f) || !reaches(entry, c, start)) {
            continue;
        }
        const dvec3 p0 = dvec3(c.p0) - dvec3(start);
        const double angle = projectedAngle({p0, p0 + dvec3(c.e1), p0 + dvec3(c.e2)}, dvec3(n),
                                            double{c.area} * std::abs(height));
        sum += emissions_[i] * static_cast<float>(angle);
    }
    return sum;
}

std::optional<LampSampler::Sample> LampSampler::sample(const SurfaceSide& surface, const vec3& n,
                                                       const vec3& u) const {
    const vec3 start = surface.start();
    const std::optional<LightTree::Choice> choice = tree_.choose(start, n, u.x);
    if (!choice) {
        return std::nullopt;
    }
    const uint32_t triangle = triangles_[choice->light / 2];
    const Corners c = corners(triangle);
    const vec3 side = choice->light % 2 == 0 ? c.n : -c.n;
    if (glm::dot(start - c.p0, side) <= 0.0f) {
        return std::nullopt;
    }
    const vec3 to[3] = {glm::normalize(c.p0 - start), glm::normalize(c.p0 + c.e1 - start),
                        glm::normalize(c.p0 + c.e2 - start)};
    const float angle = solidAngle(to[0], to[1], to[2]);
    vec2 uv;
    if (angle > kSmallestAngle) {
        uv = c.meet(start, sampleSpherical(to[0], to[1], to[2], vec2(u.y, u.z)));
    } else {
        const float root = std::sqrt(u.y);
        uv = vec2(1.0f - root, u.z * root);
    }
    const vec3 position = c.at(uv);
    const vec3 way = position - start;
    const float distance = glm::length(way);
    Sample s{.wi = way / distance,
             .distance = distance,
             .radiance = {},
             .density = 0,
             .way = {},
             .within_reach = true};
    const float cosine = -glm::dot(s.wi, side);
    if (!(cosine > 0.0f) || glm::dot(s.wi, n) <= 0.0f) {
        return std::nullopt;
    }
    s.density = choice->probability *
                (angle > kSmallestAngle ? 1.0f / angle : distance * distance / (c.area * cosine));
    const vec3 barycentric(1.0f - uv.x - uv.y, uv);
    s.radiance =
        coverageAt(scene_, triangle, barycentric) * emissionAt(scene_, triangle, barycentric);
    // It ends off the lamp's surface, as it starts off the other.
    const vec3 end = position + surfaceOffset(scene_, triangle, position, side, distance) * side;
    if (glm::dot(s.wi, surface.n_g) > 0.0f) {
        const float length = glm::length(end - start);
        s.way = {.start = start, .direction = (end - start) / length, .length = length * kWayShare};
    }
    s.within_reach = reaches(choice->light, c, start);
    return s;
}

float LampSampler::density(const SurfaceSide& surface, const vec3& n, const Hit& hit,
                           const vec3& direction) const {
    const vec3 start = surface.start();
    const uint32_t entry = entryOf(hit.triangle) + (hit.back ? 1 : 0);
    const float probability = tree_.probability(start, n, entry);
    if (probability == 0.0f) {
        return 0.0f;
    }
    const Corners c = corners(hit.triangle);
    const float angle =
        solidAngle(glm::normalize(c.p0 - start), glm::normalize(c.p0 + c.e1 - start),
                   glm::normalize(c.p0 + c.e2 - start));
    const float cosine = std::abs(glm::dot(direction, c.n));
    return probability * (angle > kSmallestAngle
                              ? 1.0f / angle
                              : hit.distance * hit.distance / (c.area * std::max(cosine, 1e-6f)));
}

vec3 LampSampler::radiance(const Hit& hit) const {
    return emissionAt(scene_, hit.triangle, vec3(1.0f - hit.u - hit.v, hit.u, hit.v));
}

}  // namespace sheen
