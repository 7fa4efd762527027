#include "bake/bake_light.h"

#include <memory>
#include <utility>
#include <vector>

#include "gather/ray_gather.h"
#include "gather/shared_gather.h"
#include "light/element_light.h"
#include "light/place_elements.h"
#include "render/gather_road.h"

namespace sheen {

BakeLight::BakeLight(const Tracer& tracer, std::span<const ElementSite> from, int bounces)
    : lights(tracer), once(tracer, &lights, std::vector<Bounds>{}) {
    if (bounces > 1) {
        again.emplace(once,
                      std::make_unique<ElementLight>(once, placeElements(tracer, from), bounces),
                      std::vector<Bounds>{}, bounces);
    }
}

BakeLight::BakeLight(const Tracer& tracer, ByteReader in, int bounces)
    : lights(tracer), once(tracer, &lights, std::vector<Bounds>{}) {
    if (bounces > 1) {
        again.emplace(once, std::make_unique<ElementLight>(in), std::vector<Bounds>{}, bounces);
    }
}

std::string BakeLight::written() const {
    ByteWriter out;
    if (again) {
        again->writeKept(out);
    }
    return out.bytes();
}

std::unique_ptr<Gatherer> BakeLight::gatherer(float accuracy) const {
    return std::make_unique<RayGatherer>(
        outgoing(), HemisphereParams{.size = gatherSize(GatherRoad::kRays, accuracy)}, false,
        BelowHorizon::kNothing);
}

std::unique_ptr<Gatherer> BakeLight::gatherer(const BakeParams& params,
                                              const RankedJob& job) const {
    std::unique_ptr<Gatherer> by_all =
        gatherByAll(gatherer(params.accuracy), job, [this] { return written(); });
    return params.log != nullptr ? gatherByLog(std::move(by_all), *params.log) : std::move(by_all);
}

}  // namespace sheen
