// All lights of a scene but its sky, as they are asked from surfaces.
#pragma once

#include "light/lamps.h"
#include "light/many_lights.h"

namespace sheen {

/// Safe to use from many threads. The tracer must outlive it.
struct SceneLights {
    explicit SceneLights(const Tracer& tracer) : lamps(tracer), punctual(tracer.scene()) {}

    LampSampler lamps;
    ManyLights punctual;
};

}  // namespace sheen
