#include "light/illumination_cut.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "core/bounces.h"
#include "core/parallel.h"
#include "light/photon_tracer.h"
#include "light/ways_on.h"

namespace sheen {
namespace {

// The cut begins with nodes of this level, or, where more than the average arrives, of the next: 4
// to 8 thousand.
constexpr int kLevel = 12;
constexpr int kRounds = 4;
// Nodes are opened whose photons say less by more than this share of what they say.
constexpr float kDifference = 1.2f;
// Those of fewer photons say nothing sure of themselves.
constexpr size_t kFewest = 16;
// A node has a side: photons turned by more than this cosine lie on another. Where these are more
// than this share, it is opened.
constexpr float kTurned = 0.7f;
constexpr float kMixed = 0.2f;
// What lies higher over a node's plane, by this cosine, is of another surface.
constexpr float kHigh = 0.3f;
constexpr size_t kLeafNodes = 4;

}  // namespace

struct IlluminationCut::Range {
    size_t begin, end;
    bool open = false;

    size_t size() const { return end - begin; }
    size_t middle() const { return begin + size() / 2; }
};

namespace {

// Of a node, by its photons alone.
struct Sums {
    vec3 mean{0.0f};
    size_t center = 0;  // the photon nearest to it
    float longest = 0.0f;
    float density = 0.0f;  // of luminance, over the square of the longest side
    float other = 0.0f;    // share of photons on surfaces that face elsewhere
};

template <class Range>
Sums sumsOf(std::span<const Photon> all, const Range& range) {
    const std::span<const Photon> photons = all.subspan(range.begin, range.size());
    Sums sums;
    Bounds box;
    for (const Photon& photon : photons) {
        sums.mean += photon.position / static_cast<float>(photons.size());
        box.add(photon.position);
    }
    float nearest = kInfinity;
    for (size_t i = 0; i < photons.size(); ++i) {
        const vec3 way = photons[i].position - sums.mean;
        if (glm::dot(way, way) < nearest) {
            nearest = glm::dot(way, way);
            sums.center = range.begin + i;
        }
    }
    const vec3 extent = box.upper - box.lower;
    sums.longest = std::max({extent.x, extent.y, extent.z});
    const vec3& n_g = all[sums.center].n_g;
    size_t turned = 0;
    for (const Photon& photon : photons) {
        if (glm::dot(photon.n_g, n_g) > kTurned) {
            sums.density += luminance(photon.power);
        } else {
            ++turned;
        }
    }
    sums.density /= std::max(sums.longest * sums.longest, 1e-30f);
    sums.other = static_cast<float>(turned) / static_cast<float>(photons.size());
    return sums;
}

}  // namespace

IlluminationCut::Node IlluminationCut::nodeOf(const Tracer& tracer, const PhotonMap& map,
                                              const Range& range) const {
    const Sums sums = sumsOf(map.photons(), range);
    const Photon& center = map.photons()[sums.center];
    const SurfaceSide side{.position = center.position,
                           .n_g = center.n_g,
                           .toward_viewer = center.wi,
                           .offset = surfaceOffset(tracer.scene(), center.triangle, center.position,
                                                   center.n_g, 0.0f)};
    return {.position = center.position,
            .n_g = center.n_g,
            .reach = sums.longest,
            .irradiance = map.at(tracer, side, center.n_g, nullptr).irradiance,
            .approximate = sums.density};
}

IlluminationCut::IlluminationCut(const Tracer& tracer, const PhotonMap& map) {
    if (map.size() == 0) {
        return;
    }
    std::vector<Range> cut = {{0, map.size()}};
    // One level down, each range by its two halves where it is open and large enough. The photon
    // that parts them, which may lie anywhere between them, counts for neither.
    const auto descend = [&] {
        std::vector<Range> next;
        for (const Range& range : cut) {
            if (range.open && range.size() >= 2 * kFewest) {
                next.push_back({range.begin, range.middle()});
                next.push_back({range.middle() + 1, range.end});
            } else {
                next.push_back({range.begin, range.end});
            }
        }
        cut = std::move(next);
    };
    const auto forEach = [&cut](const auto& body) {
        parallelFor(
            static_cast<int>(cut.size()), [&](int i) { body(static_cast<size_t>(i)); }, 16);
    };
    for (int level = 0; level < kLevel; ++level) {
        forEach([&](size_t i) { cut[i].open = true; });
        descend();
    }
    std::vector<float> densities(cut.size());
    forEach([&](size_t i) { densities[i] = sumsOf(map.photons(), cut[i]).density; });
    double average = 0.0;
    for (const float density : densities) {
        average += density / static_cast<double>(cut.size());
    }
    forEach([&](size_t i) { cut[i].open = densities[i] > average; });
    descend();
    for (int round = 0; round < kRounds; ++round) {
        forEach([&](size_t i) {
            const Sums sums = sumsOf(map.photons(), cut[i]);
            cut[i].open = sums.other > kMixed;
            if (!cut[i].open && cut[i].size() >= 2 * kFewest) {
                const Node node = nodeOf(tracer, map, cut[i]);
                cut[i].open = std::abs(luminance(node.irradiance) - node.approximate) >
                              kDifference * node.approximate;
            }
        });
        descend();
    }
    nodes_.resize(cut.size());
    forEach([&](size_t i) { nodes_[i] = nodeOf(tracer, map, cut[i]); });
    std::erase_if(nodes_, [](const Node& node) { return !(node.reach > 0.0f); });
    if (!nodes_.empty()) {
        divide(0, nodes_.size(), 0);
    }
}

void IlluminationCut::divide(size_t begin, size_t end, size_t box) {
    if (boxes_.size() <= box) {
        boxes_.resize(box + 1);
    }
    Bounds bounds;
    for (size_t i = begin; i < end; ++i) {
        bounds.add(nodes_[i].position - nodes_[i].reach);
        bounds.add(nodes_[i].position + nodes_[i].reach);
    }
    boxes_[box] = bounds;
    if (end - begin > kLeafNodes) {
        const size_t middle = begin + (end - begin) / 2;
        divide(begin, middle, 2 * box + 1);
        divide(middle, end, 2 * box + 2);
    }
}

template <class F>
void IlluminationCut::around(const vec3& p, size_t begin, size_t end, size_t box,
                             const F& body) const {
    const Bounds& bounds = boxes_[box];
    if (!glm::all(glm::greaterThanEqual(p, bounds.lower)) ||
        !glm::all(glm::lessThanEqual(p, bounds.upper))) {
        return;
    }
    if (end - begin > kLeafNodes) {
        const size_t middle = begin + (end - begin) / 2;
        around(p, begin, middle, 2 * box + 1, body);
        around(p, middle, end, 2 * box + 2, body);
        return;
    }
    for (size_t i = begin; i < end; ++i) {
        body(nodes_[i]);
    }
}

std::optional<vec3> IlluminationCut::irradiance(const ElementSite& at) const {
    constexpr float kLeastWeight = 1e-3f;
    if (nodes_.empty()) {
        return std::nullopt;
    }
    const vec3& p = at.side.position;
    vec3 sum(0.0f);
    float weights = 0.0f;
    around(p, 0, nodes_.size(), 0, [&](const Node& node) {
        const vec3 way = p - node.position;
        const float distance2 = glm::dot(way, way);
        const float inside = 1.0f - distance2 / (node.reach * node.reach);
        const float high = std::abs(glm::dot(way, node.n_g));
        if (inside > 0.0f && high <= kHigh * std::sqrt(distance2) + at.side.offset) {
            const float weight = inside * std::max(glm::dot(node.n_g, at.normal), 0.0f);
            sum += weight * node.irradiance;
            weights += weight;
        }
    });
    return weights > kLeastWeight ? std::optional(sum / weights) : std::nullopt;
}

PhotonLight::PhotonLight(const Tracer& tracer, const SceneLights& lights, int count, int bounces)
    : bounces_(bounces) {
    // Photons farther off than this share of the scene tell nothing of a point.
    constexpr float kReach = 1.0f / 16.0f;
    const std::vector<Photon> photons =
        tracePhotons(tracer, lights, {.bounces = bounces - 1}, count);
    Bounds box;
    for (const Photon& photon : photons) {
        box.add(photon.position);
    }
    const int cuts = bounces == kAllBounces ? 1 : std::min(bounces - 1, WaysOn::kMost + 1);
    for (int followed = 0; followed < cuts; ++followed) {
        std::vector<Photon> few;
        std::copy_if(photons.begin(), photons.end(), std::back_inserter(few),
                     [&](const Photon& p) { return p.scattered < bounces - followed; });
        cuts_.emplace_back(tracer, PhotonMap(std::move(few), kReach * box.size()));
    }
}

std::optional<vec3> PhotonLight::irradiance(const ElementSite& at, int followed) const {
    if (bounces_ == kAllBounces) {
        return cuts_.front().irradiance(at);
    }
    const auto cut = static_cast<size_t>(followed);
    return cut < cuts_.size() ? cuts_[cut].irradiance(at) : vec3(0.0f);
}

size_t PhotonLight::size() const {
    size_t sum = 0;
    for (const IlluminationCut& cut : cuts_) {
        sum += cut.size();
    }
    return sum;
}

}  // namespace sheen
