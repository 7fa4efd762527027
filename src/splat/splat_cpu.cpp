#include <algorithm>
#include <span>
#include <vector>

#include "cache/record_tree.h"
#include "core/parallel.h"
#include "receivers/served.h"
#include "splat/splat.h"

namespace sheen {

namespace {

// Which records may reach a place, in order.
class Nearby {
  public:
    Nearby(const RecordCache& cache, const WeightParams& weight) : tree_(boundsOf(cache)) {
        for (const Record& k : cache.records) {
            tree_.insert(k.position, weight.accuracy * k.radius);
        }
    }
    std::vector<size_t> at(const vec3& p) const {
        std::vector<size_t> found;
        const auto reaches = [](float distance2, float reach) {
            return distance2 <= reach * reach;
        };
        tree_.visit(p, reaches, [&](uint32_t k) { found.push_back(k); });
        std::sort(found.begin(), found.end());
        return found;
    }

  private:
    static Bounds boundsOf(const RecordCache& cache) {
        Bounds bounds;
        for (const Record& k : cache.records) {
            bounds.add(k.position);
        }
        return bounds;
    }

    RecordTree tree_;
};

// A record that serves a receiver.
struct Serving {
    const Record& record;
    float weight;
};

bool any(size_t) { return true; }

// Calls body(i, records), in their order, for each receiver with a surface that is wanted(i), many
// at once.
template <class F, class Wanted = bool (*)(size_t)>
void forReceivers(const Receivers& receivers, const RecordCache& cache, const WeightParams& weight,
                  const F& body, const Wanted& wanted = any) {
    const Nearby nearby(cache, weight);
    parallelFor(receivers.image.height, [&](int y) {
        std::vector<Serving> serving;
        for (int x = 0; x < receivers.image.width; ++x) {
            const size_t i = receivers.image.index(x, y);
            if (receivers.orders[i] == kNoOrder || !wanted(i)) {
                continue;
            }
            serving.clear();
            for (const size_t near : nearby.at(receivers.positions[i])) {
                const Record& k = cache.records[near];
                const float w =
                    serves(k.order, receivers.orders[i]) ? weightAt(receivers, i, k, weight) : 0.0f;
                if (w > 0.0f) {
                    serving.push_back({k, w});
                }
            }
            body(i, serving);
        }
    });
}

}  // namespace

namespace {

// What the records say at one receiver.
struct Sums {
    vec4 irradiance{0.0f}, specular{0.0f}, missed{0.0f};
};

Sums sumsAt(const Receivers& receivers, const RecordCache& cache, size_t i,
            std::span<const Serving> serving) {
    const int order = receivers.orders[i];
    const bool reflects = order > shared::DIFFUSE_ORDER && !receivers.irradiance_only;
    const shared::ShVector lobe = reflects ? receivers.lobes.at(i, order) : shared::ShVector{};
    Sums sums;
    for (const auto& [k, w] : serving) {
        sums.irradiance += vec4(w * irradianceBy(receivers, i, k), w);
        if (static_cast<int>(k.material) == receivers.materials[i]) {
            sums.missed += vec4(w * shared::recordMissed(k), w);
        }
        if (reflects) {
            const float* sh = &cache.sh[static_cast<size_t>(k.sh_first)];
            sums.specular +=
                vec4(w * convolveRecord(k, sh, lobe.c, order, receivers.positions[i]), 0.0f);
        }
    }
    return sums;
}

void put(const vec4& sum, size_t i, Image<vec4>& image) {
    if (!image.pixels.empty()) {
        image.pixels[i] = sum;
    }
}

void putAll(const Sums& sums, size_t i, SplatBuffer& splat) {
    put(sums.irradiance, i, splat.irradiance);
    put(sums.specular, i, splat.specular);
    put(sums.missed, i, splat.missed);
}

}  // namespace

SplatBuffer splatCpu(const Receivers& receivers, const RecordCache& cache,
                     const WeightParams& weight) {
    const Image<vec4> none(receivers.image.width, receivers.image.height);
    SplatBuffer result{none, none, none};
    forReceivers(receivers, cache, weight, [&](size_t i, std::span<const Serving> serving) {
        putAll(sumsAt(receivers, cache, i, serving), i, result);
    });
    return result;
}

void splatBent(const Receivers& receivers, const RecordCache& cache, const WeightParams& weight,
               SplatBuffer& splat) {
    if (receivers.eyes.empty()) {
        return;
    }
    const auto bent = [&](size_t i) { return receivers.isBent(i); };
    forReceivers(
        receivers, cache, weight,
        [&](size_t i, std::span<const Serving> serving) {
            putAll(sumsAt(receivers, cache, i, serving), i, splat);
        },
        bent);
}

std::vector<Image<vec3>> splatSh(const Receivers& receivers, const RecordCache& cache,
                                 const WeightParams& weight, int order) {
    const auto size = static_cast<size_t>(order * order);
    std::vector<Image<vec3>> sums(size, Image<vec3>(receivers.image.width, receivers.image.height));
    forReceivers(receivers, cache, weight, [&](size_t i, std::span<const Serving> serving) {
        float weights = 0.0f;
        for (const Serving& s : serving) {
            weights += s.weight;
        }
        std::vector<float> one(size, 0.0f);
        for (const auto& [k, w] : serving) {
            const float* sh = &cache.sh[static_cast<size_t>(k.sh_first)];
            for (size_t c = 0; c < size; ++c) {
                one[c] = 1.0f;
                sums[c].pixels[i] +=
                    w / weights * convolveRecord(k, sh, one.data(), order, receivers.positions[i]);
                one[c] = 0.0f;
            }
        }
    });
    return sums;
}

SplatBuffer splatLightmaps(const Scene& scene, const Receivers& receivers) {
    SplatBuffer splat;
    splat.irradiance = Image<vec4>(receivers.image.width, receivers.image.height);
    parallelFor(receivers.image.height, [&](int y) {
        for (size_t i = receivers.image.index(0, y); i < receivers.image.index(0, y + 1); ++i) {
            if (!receivers.seen(i)) {
                continue;
            }
            const uint32_t triangle = receivers.triangles[i];
            const bool lit = !scene.materials[scene.materials_of[triangle]].unlit;
            splat.irradiance.pixels[i] =
                vec4(lit ? lightmapAt(scene, triangle,
                                      barycentricOf(scene, triangle, receivers.positions[i]))
                         : vec3(0.0f),
                     1.0f);
        }
    });
    return splat;
}

Image<float> countRecords(const Receivers& receivers, const RecordCache& cache,
                          const WeightParams& weight) {
    Image<float> counts(receivers.image.width, receivers.image.height);
    for (const Record& k : cache.records) {
        forServed(receivers, k, weight, [&](size_t i, float) { counts.pixels[i] += 1.0f; });
    }
    return counts;
}

}  // namespace sheen
