#include "light/caustics.h"

namespace sheen {

std::vector<Photon> traceCaustics(const Tracer& tracer, const SceneLights& lights,
                                  const SeenSpace& seen, int count, int bounces) {
    return tracePhotons(tracer, lights, {.caustics = true, .seen = &seen, .bounces = bounces},
                        count);
}

}  // namespace sheen
