#include "bake/bake_light.h"

#include <memory>
#include <vector>

#include "light/element_light.h"
#include "light/place_elements.h"

namespace sheen {

BakeLight::BakeLight(const Tracer& tracer, std::span<const ElementSite> from, int bounces)
    : lights(tracer), once(tracer, &lights, std::vector<Bounds>{}) {
    if (bounces > 1) {
        again.emplace(once,
                      std::make_unique<ElementLight>(once, placeElements(tracer, from), bounces),
                      std::vector<Bounds>{}, bounces);
    }
}

}  // namespace sheen
