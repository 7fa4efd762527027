#include "light/illumination_cut.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "core/bounces.h"
#include "core/directions.h"
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
constexpr size_t kFewest = 8;
// A node has a side: where more than this share of its photons lie on another surface, it is
// opened.
constexpr float kMixed = 0.2f;

}  // namespace

struct IlluminationCut::Node {
    ElementSite site;  // it reaches as far as its photons' box is long
    Elements::Ways free;
    vec3 irradiance;    // by density
    float approximate;  // luminance of the same by the node's photons alone
    float other;        // share of these that lie on surfaces which face elsewhere
};

struct IlluminationCut::Range {
    size_t begin, end;
    bool open = false;
    std::optional<Node> node = {};  // once it has been asked for

    size_t size() const { return end - begin; }
    size_t middle() const { return begin + size() / 2; }
    std::span<const Photon> of(const PhotonMap& map) const {
        return map.photons().subspan(begin, size());
    }
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

Sums sumsOf(std::span<const Photon> photons) {
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
            sums.center = i;
        }
    }
    const vec3 extent = box.upper - box.lower;
    sums.longest = std::max({extent.x, extent.y, extent.z});
    const vec3& n_g = photons[sums.center].n_g;
    size_t turned = 0;
    for (const Photon& photon : photons) {
        if (glm::dot(photon.n_g, n_g) > kOneSurfaceCosine) {
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
                                              const Range& range) {
    const Sums sums = sumsOf(range.of(map));
    const Photon& center = range.of(map)[sums.center];
    const SurfaceSide side{.position = center.position,
                           .n_g = center.n_g,
                           .toward_viewer = center.wi,
                           .offset = surfaceOffset(tracer.scene(), center.triangle, center.position,
                                                   center.n_g, 0.0f)};
    Node node{
        .site = {.side = side, .normal = center.n_g, .spacing = sums.longest / Elements::kReach},
        .free = {},
        .irradiance = map.at(tracer, side, center.n_g, nullptr).irradiance,
        .approximate = sums.density,
        .other = sums.other};
    const WaysAlong ways(tracer, side);
    const mat3 frame = tangentFrame(center.n_g);
    for (size_t s = 0; s < WaysAlong::kCount; ++s) {
        node.free[Elements::sector(frame, ways.directions[s])] = ways.lengths[s];
    }
    return node;
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
                next.push_back(range);
                next.back().open = false;
            }
        }
        cut = std::move(next);
    };
    const auto forEach = [&cut](const auto& body) {
        parallelFor(
            static_cast<int>(cut.size()), [&](int i) { body(static_cast<size_t>(i)); }, 16);
    };
    for (int level = 0; level < kLevel; ++level) {
        for (Range& range : cut) {
            range.open = true;
        }
        descend();
    }
    std::vector<float> densities(cut.size());
    forEach([&](size_t i) { densities[i] = sumsOf(cut[i].of(map)).density; });
    double average = 0.0;
    for (const float density : densities) {
        average += density / static_cast<double>(cut.size());
    }
    for (size_t i = 0; i < cut.size(); ++i) {
        cut[i].open = densities[i] > average;
    }
    descend();
    const auto ask = [&](Range& range) {
        if (!range.node) {
            range.node = nodeOf(tracer, map, range);
            range.open = range.node->other > kMixed ||
                         std::abs(luminance(range.node->irradiance) - range.node->approximate) >
                             kDifference * range.node->approximate;
        }
    };
    for (int round = 0; round < kRounds; ++round) {
        forEach([&](size_t i) { ask(cut[i]); });
        descend();
    }
    forEach([&](size_t i) { ask(cut[i]); });
    for (const Range& range : cut) {
        if (range.node->site.spacing > 0.0f) {
            elements_.add(range.node->site);
            elements_.know(elements_.size() - 1, range.node->free, range.node->site.spacing);
            irradiances_.push_back(range.node->irradiance);
        }
    }
}

IlluminationCut::IlluminationCut(ByteReader& in)
    : elements_(in), irradiances_(in.get<std::vector<vec3>>()) {}

void IlluminationCut::write(ByteWriter& out) const {
    elements_.write(out);
    out.put(irradiances_);
}

std::optional<vec3> IlluminationCut::irradiance(const ElementSite& at) const {
    constexpr float kLeastWeight = 1e-3f;
    const vec3& p = at.side.position;
    vec3 sum(0.0f);
    float weights = 0.0f;
    elements_.around(p, at.normal, [&](size_t i, float) {
        const ElementSite& node = elements_.site(i);
        const vec3 way = p - node.side.position;
        const float reach = Elements::kReach * node.spacing;
        const float weight = (1.0f - glm::dot(way, way) / (reach * reach)) *
                             std::max(glm::dot(node.normal, at.normal), 0.0f);
        sum += weight * irradiances_[i];
        weights += weight;
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

PhotonLight::PhotonLight(ByteReader& in) : bounces_(in.get<int>()) {
    const auto cuts = in.get<uint64_t>();
    for (uint64_t i = 0; i < cuts; ++i) {
        cuts_.emplace_back(in);
    }
}

void PhotonLight::write(ByteWriter& out) const {
    out.put(bounces_);
    out.put(uint64_t{cuts_.size()});
    for (const IlluminationCut& cut : cuts_) {
        cut.write(out);
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
