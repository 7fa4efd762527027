// A scene, and the light in it that rays see.
#pragma once

#include "light/scattered_once.h"

namespace sheen {

const vec3 kUp(0, 1, 0);

/// Light scattered once, every hit lit by itself.
struct LitScene {
    explicit LitScene(const Scene& scene) : tracer(scene), light(tracer) {}

    void cast(const Rays& rays, vec4* seen, vec3* planes = nullptr) const {
        light.cast(rays, seen, planes);
    }

    Tracer tracer;
    ScatteredOnce light;
};

/// The same, by cells.
struct LitByCells {
    explicit LitByCells(const Scene& scene) : tracer(scene), light(tracer, nullptr, {}) {}

    Tracer tracer;
    ScatteredOnce light;
};

}  // namespace sheen
