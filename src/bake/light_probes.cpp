#include "bake/light_probes.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "bake/bake_light.h"
#include "bake/solids.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/timer.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// From where light will be looked for: some of the probes, up and down.
std::vector<ElementSite> someOf(std::span<const vec3> points) {
    constexpr size_t kSome = 512;
    std::vector<ElementSite> some;
    const size_t step = (points.size() + kSome - 1) / kSome;
    for (size_t i = 0; i < points.size(); i += step) {
        for (const float up : {1.0f, -1.0f}) {
            const vec3 n(0.0f, up, 0.0f);
            some.push_back(
                {.side = {.position = points[i], .n_g = n, .toward_viewer = n, .offset = 0.0f},
                 .normal = n});
        }
    }
    return some;
}

// Probes that lie in nothing solid.
struct FreePoints {
    std::vector<vec3> points;
    std::vector<size_t> of;  // which probe each is
};

// Also fills `solid`.
FreePoints freePoints(const Tracer& tracer, const HintLattice& lattice,
                      std::vector<uint8_t>& solid) {
    const Solids solids(tracer);
    solid.resize(static_cast<size_t>(lattice.count()));
    const auto place = [&](int i) { return lattice.middle(lattice.at(i)); };
    parallelFor(lattice.count(),
                [&](int i) { solid[static_cast<size_t>(i)] = solids.hold(place(i)) ? 1 : 0; });
    FreePoints free;
    for (int i = 0; i < lattice.count(); ++i) {
        if (solid[static_cast<size_t>(i)] == 0) {
            free.points.push_back(place(i));
            free.of.push_back(static_cast<size_t>(i));
        }
    }
    return free;
}

void add(const ShLight& light, ShLight& sum) {
    std::transform(sum.begin(), sum.end(), light.begin(), sum.begin(), std::plus<>());
}

void addGathered(Gatherer& gatherer, const FreePoints& free, bool quiet, LightProbes& probes) {
    constexpr size_t kTogether = 256;
    const std::span<const vec3> points(free.points);
    Progress progress("gathering at probes", static_cast<int64_t>(points.size()), quiet);
    for (size_t first = 0; first < points.size(); first += kTogether) {
        const size_t count = std::min(kTogether, points.size() - first);
        const std::vector<ShLight> found =
            gatherAround(gatherer, points.subspan(first, count), kLightProbeOrder);
        for (size_t k = 0; k < count; ++k) {
            add(found[k], probes.light[free.of[first + k]]);
        }
        progress.advance(static_cast<int64_t>(count));
    }
    probes.stats.records = static_cast<int>(2 * points.size());
}

void addDirect(const Tracer& tracer, const SceneLights& lights, const HintLattice& lattice,
               const FreePoints& free, LightProbes& probes) {
    const float radius = std::max(0.5f * std::min({lattice.cell.x, lattice.cell.y, lattice.cell.z}),
                                  std::numeric_limits<float>::min());
    parallelFor(static_cast<int>(free.points.size()), [&](int k) {
        const auto i = static_cast<size_t>(k);
        const vec3 up(0.0f, 1.0f, 0.0f);
        const SurfaceSide point = {
            .position = free.points[i], .n_g = up, .toward_viewer = up, .offset = 0.0f};
        add(directAround(tracer, lights, point, radius, kLightProbeOrder,
                         pcgHash(static_cast<uint32_t>(free.of[i]))),
            probes.light[free.of[i]]);
    });
}

// Those without light get the mean of their neighbours', layer by layer.
void fillSolid(const HintLattice& lattice, LightProbes& probes) {
    std::vector<uint8_t> known(probes.solid.size());
    std::transform(probes.solid.begin(), probes.solid.end(), known.begin(),
                   [](uint8_t solid) { return static_cast<uint8_t>(solid == 0); });
    for (bool any = true; any;) {
        any = false;
        const std::vector<uint8_t> before = known;
        for (int i = 0; i < lattice.count(); ++i) {
            const auto probe = static_cast<size_t>(i);
            if (before[probe] != 0) {
                continue;
            }
            ShLight sum(probes.light[probe].size(), vec3(0.0f));
            int count = 0;
            for (int side = 0; side < 6; ++side) {
                ivec3 at = lattice.at(i);
                at[side / 2] += side % 2 == 0 ? 1 : -1;
                if (glm::any(glm::lessThan(at, ivec3(0))) ||
                    glm::any(glm::greaterThanEqual(at, lattice.counts)) ||
                    before[static_cast<size_t>(lattice.index(at))] == 0) {
                    continue;
                }
                add(probes.light[static_cast<size_t>(lattice.index(at))], sum);
                ++count;
            }
            if (count > 0) {
                for (vec3& c : sum) {
                    c /= static_cast<float>(count);
                }
                probes.light[probe] = std::move(sum);
                known[probe] = 1;
                any = true;
            }
        }
    }
}

}  // namespace

HintLattice lightProbeLattice(const Bounds& box, const ivec3& counts) {
    const double all = double(counts.x) * counts.y * counts.z;
    if (!(all <= kMostLightProbes)) {
        throwUsage(
            "--probes: {} x {} x {} probes are more than {}; take fewer, or more space between "
            "them",
            counts.x, counts.y, counts.z, kMostLightProbes);
    }
    const vec3 origin = box.empty() ? vec3(0.0f) : box.lower;
    const vec3 size = box.empty() ? vec3(0.0f) : box.upper - box.lower;
    return {.origin = origin, .cell = size / vec3(counts), .counts = counts};
}

HintLattice lightProbeLattice(const Bounds& box, float spacing) {
    const vec3 size = box.empty() ? vec3(0.0f) : box.upper - box.lower;
    // As a number may be too great for an integer.
    const vec3 counts = glm::clamp(glm::ceil(size / spacing), 1.0f, 1e6f);
    return lightProbeLattice(box, ivec3(counts));
}

LightProbes bakeLightProbes(const Tracer& tracer, const HintLattice& lattice,
                            const BakeParams& params, const RankedJob& job) {
    LightProbes probes;
    const FreePoints free = freePoints(tracer, lattice, probes.solid);
    probes.free = static_cast<int>(free.points.size());
    const Timer made;
    const BakeLight light(tracer, someOf(free.points), params.bounces);
    probes.stats.seconds_lights = made.seconds();
    const std::unique_ptr<Gatherer> gatherer = light.gatherer(params, job);
    constexpr auto kSize = static_cast<size_t>(kLightProbeOrder * kLightProbeOrder);
    probes.light.assign(probes.solid.size(), ShLight(kSize, vec3(0.0f)));
    const Timer gather;
    addGathered(*gatherer, free, params.quiet, probes);
    probes.stats.seconds_gather = gather.seconds();
    if (!params.indirect_only) {
        const Timer direct;
        addDirect(tracer, light.lights, lattice, free, probes);
        probes.stats.seconds_direct = direct.seconds();
    }
    fillSolid(lattice, probes);
    return probes;
}

}  // namespace sheen
