// Photons: light that surfaces hand on from lights, lamps and the sky, as points where it arrives.
// They start where lights reach surfaces, as rays' hits are lit, and go on by chance.
// Based on: [Jen96], with photons aimed by what a first part of them found [PP98].
#pragma once

#include <vector>

#include "light/photon_map.h"
#include "light/scene_lights.h"
#include "light/seen_space.h"

namespace sheen {

/// Which photons are wanted.
struct PhotonPaths {
    bool caustics = false;  ///< of light that specular surfaces alone send to one that is not, or
                            ///< not only, specular; false: from all surfaces to all
    const SeenSpace* seen = nullptr;  ///< where they are kept; null: everywhere
    int bounces = 1;                  ///< so often they are scattered at the most
};

/// Of `count` photons that start, those that lie where they are wanted, once for each surface that
/// they meet: of light that is scattered once at least. The same for any number of threads. None
/// where nothing shines or nothing scatters.
std::vector<Photon> tracePhotons(const Tracer& tracer, const SceneLights& lights,
                                 const PhotonPaths& paths, int count);

}  // namespace sheen
