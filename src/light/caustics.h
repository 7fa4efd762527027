// Light that specular surfaces alone send from lights, lamps and the sky to surfaces that are not
// specular.
#pragma once

#include <vector>

#include "light/photon_tracer.h"

namespace sheen {

/// `count` photons that leave lights and meet specular surfaces, from 1 to `bounces` of them; those
/// that then lie in `seen` on a surface that is not, or not only, specular. The same for any number
/// of threads. None where nothing is specular or nothing shines.
std::vector<Photon> traceCaustics(const Tracer& tracer, const SceneLights& lights,
                                  const SeenSpace& seen, int count, int bounces);

}  // namespace sheen
