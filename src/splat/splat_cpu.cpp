#include <algorithm>

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

}  // namespace

SplatBuffer splatCpu(const Receivers& receivers, const RecordCache& cache,
                     const WeightParams& weight) {
    const Image<vec4> none(receivers.image.width, receivers.image.height);
    SplatBuffer result{none, none, none};
    const Nearby nearby(cache, weight);
    parallelFor(receivers.image.height, [&](int y) {
        for (int x = 0; x < receivers.image.width; ++x) {
            const size_t i = receivers.image.index(x, y);
            const int order = receivers.orders[i];
            const vec3& p = receivers.positions[i];
            const shared::ShVector lobe =
                order > shared::DIFFUSE_ORDER ? receivers.lobes.at(i, order) : shared::ShVector{};
            if (order == kNoOrder) {
                continue;
            }
            for (const size_t near : nearby.at(p)) {
                const Record& k = cache.records[near];
                if (!serves(k.order, order)) {
                    continue;
                }
                const float w = weightAt(receivers, i, k, weight);
                if (w <= 0.0f) {
                    continue;
                }
                result.irradiance.pixels[i] += vec4(w * irradianceBy(receivers, i, k), w);
                if (static_cast<int>(k.material) == receivers.materials[i]) {
                    result.missed.pixels[i] += vec4(w * shared::recordMissed(k), w);
                }
                if (order > shared::DIFFUSE_ORDER) {
                    const float* sh = &cache.sh[static_cast<size_t>(k.sh_first)];
                    result.specular.pixels[i] +=
                        vec4(w * convolveRecord(k, sh, lobe.c, order, p), 0.0f);
                }
            }
        }
    });
    return result;
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
