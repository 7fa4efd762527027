#include "light/photon_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/directions.h"

namespace sheen {
namespace {

// So many photons are asked at the most, over the power 2/3 of their number: both the area that
// they lie on and their noise then go to zero as there are more [KD13].
constexpr double kMost = 0.3;
// And at least one of so many of these.
constexpr size_t kLadder = 16;
constexpr size_t kLeast = 8;
// Estimates that differ by more standard deviations than this do so for a reason.
constexpr float kDeviations = 2.5f;
// Photons that lie higher over the tangent plane, by this cosine, are of another surface.
constexpr float kHigh = 0.3f;
// Shading normals make at most so much more of light that grazes a triangle.
constexpr float kMostByNormal = 4.0f;

// A photon counts by 1 - d^2 / r^2, over its integral [Sil86].
float kernel(float distance2, float radius2) {
    if (!(radius2 > std::numeric_limits<float>::min())) {
        return 0.0f;  // they lie where the point does
    }
    return 2.0f / (kPi * radius2) * std::max(1.0f - distance2 / radius2, 0.0f);
}

}  // namespace

WaysAlong::WaysAlong(const Tracer& tracer, const SurfaceSide& point) {
    const mat3 frame = tangentFrame(point.n_g);
    Hit hits[kCount];
    for (size_t s = 0; s < kCount; ++s) {
        const float angle = 2.0f * kPi * (static_cast<float>(s) + 0.5f) / kCount;
        directions[s] = frame * vec3(std::cos(angle), std::sin(angle), 0.0f);
    }
    tracer.meet({.origin = point.start(), .directions = directions}, hits);
    for (size_t s = 0; s < kCount; ++s) {
        lengths[s] = hits[s].distance;
        if (hits[s].found()) {
            const vec3 n_g = geometricNormal(tracer.scene(), static_cast<int>(hits[s].triangle));
            if (glm::dot(hits[s].back ? -n_g : n_g, point.n_g) > kOneSurfaceCosine) {
                lengths[s] = kInfinity;
            }
        }
    }
}

PhotonMap::PhotonMap(std::vector<Photon> photons, float reach)
    : photons_(std::move(photons)), axes_(photons_.size()), reach_(reach) {
    const double root = std::cbrt(static_cast<double>(photons_.size()));
    most_ = std::max(static_cast<size_t>(kMost * root * root), kLeast * kLadder);
    fewest_ = most_ / kLadder;
    divide(0, photons_.size());
}

void PhotonMap::divide(size_t begin, size_t end) {
    if (end - begin < 2) {
        return;
    }
    Bounds box;
    for (size_t i = begin; i < end; ++i) {
        box.add(photons_[i].position);
    }
    const vec3 extent = box.upper - box.lower;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0
                     : extent.y >= extent.z                       ? 1
                                                                  : 2;
    const size_t middle = begin + (end - begin) / 2;
    const auto at = [&](size_t i) { return photons_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [axis](const Photon& a, const Photon& b) {
        return a.position[axis] < b.position[axis];
    });
    axes_[middle] = static_cast<uint8_t>(axis);
    divide(begin, middle);
    divide(middle + 1, end);
}

// Keeps in a heap, the farthest on top, the nearest of a range, one more than are asked at the
// most.
void PhotonMap::find(const SurfaceSide& point, size_t begin, size_t end,
                     std::vector<Near>& heap) const {
    if (begin == end) {
        return;
    }
    const size_t middle = begin + (end - begin) / 2;
    const Photon& photon = photons_[middle];
    const vec3 way = photon.position - point.position;
    const float distance2 = glm::dot(way, way);
    const float height = glm::dot(way, point.n_g);
    const Near near{distance2, static_cast<uint32_t>(middle)};
    const bool full = heap.size() == most_ + 1;
    if (distance2 < reach_ * reach_ && (!full || near < heap.front()) &&
        glm::dot(photon.n_g, point.n_g) > kOneSurfaceCosine &&
        std::abs(height) <= kHigh * std::sqrt(distance2) + point.offset) {
        if (full) {
            std::pop_heap(heap.begin(), heap.end());
            heap.pop_back();
        }
        heap.push_back(near);
        std::push_heap(heap.begin(), heap.end());
    }
    const float across = -way[axes_[middle]];  // of the point, from the parting plane
    const auto search = [&](bool lower) {
        lower ? find(point, begin, middle, heap) : find(point, middle + 1, end, heap);
    };
    search(across < 0.0f);
    const float limit = heap.size() == most_ + 1 ? heap.front().distance2 : reach_ * reach_;
    if (across * across <= limit) {
        search(!(across < 0.0f));
    }
}

// The largest disc about a point whose light is, but for noise, that of the smaller ones.
PhotonMap::Disc PhotonMap::choose(std::span<const Near> near) const {
    Disc chosen;
    float lower = 0.0f;
    float upper = kInfinity;
    for (size_t count = fewest_; chosen.count < near.size(); count *= 2) {
        Disc disc{.count = std::min(count, most_), .radius2 = reach_ * reach_};
        if (disc.count < near.size()) {
            disc.radius2 = near[disc.count].distance2;
        } else {
            disc.count = near.size();
        }
        float sum = 0.0f;
        float variance = 0.0f;
        for (size_t i = 0; i < disc.count; ++i) {
            const float light =
                luminance(photons_[near[i].photon].power) * kernel(near[i].distance2, disc.radius2);
            sum += light;
            variance += light * light;
        }
        const float deviation = kDeviations * std::sqrt(variance);
        lower = std::max(lower, sum - deviation);
        upper = std::min(upper, sum + deviation);
        if (chosen.count > 0 && lower > upper) {
            break;
        }
        chosen = disc;
        if (count >= most_) {
            break;
        }
    }
    return chosen;
}

// What share of the kernel lies before the walls around.
float PhotonMap::open(const Tracer& tracer, const SurfaceSide& point, float radius) const {
    float sum = 0.0f;
    for (const float length : WaysAlong(tracer, point).lengths) {
        const float t = std::min(length / radius, 1.0f);
        sum += t * t * (2.0f - t * t) / WaysAlong::kCount;
    }
    return sum;
}

PhotonMap::Light PhotonMap::at(const Tracer& tracer, const SurfaceSide& point, const vec3& n,
                               const Brdf* lobe) const {
    std::vector<Near> near;
    near.reserve(most_ + 1);
    find(point, 0, photons_.size(), near);
    std::sort_heap(near.begin(), near.end());
    const Disc disc = choose(near);
    Light light;
    for (size_t i = 0; i < disc.count; ++i) {
        const Photon& photon = photons_[near[i].photon];
        const float NoL = glm::dot(n, photon.wi);
        if (NoL <= 0.0f) {
            continue;
        }
        // Photons are as dense as the light that a triangle gets; its shading normal gets another.
        const float by_normal =
            std::min(NoL / std::max(glm::dot(photon.n_g, photon.wi), 1e-6f), kMostByNormal);
        const vec3 irradiance = kernel(near[i].distance2, disc.radius2) * by_normal * photon.power;
        light.irradiance += irradiance;
        if (lobe != nullptr) {
            light.reflected +=
                irradiance * shared::evalSpecular(*lobe, n, point.toward_viewer, photon.wi);
        }
    }
    if (disc.count > 0) {
        // Never less than a corner of a room leaves.
        constexpr float kLeastOpen = 0.2f;
        const float scale =
            1.0f / std::max(open(tracer, point, std::sqrt(disc.radius2)), kLeastOpen);
        light.irradiance *= scale;
        light.reflected *= scale;
    }
    return light;
}

}  // namespace sheen
