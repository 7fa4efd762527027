// What photons of caustics say of receivers, as a layer of the frame.
#pragma once

#include "light/photon_map.h"
#include "receivers/edges.h"

namespace sheen {

/// [receiver]; black where there is no surface.
struct CausticLight {
    std::vector<PhotonMap::Light> values;
};

/// What each receiver gets; lobes that are specular, and where irradiance alone is wanted, all,
/// scatter none of it.
CausticLight causticLight(const Tracer& tracer, const PhotonMap& photons,
                          const Receivers& receivers);

/// What pixels then send toward the viewer.
Image<vec3> causticLayer(const Receivers& receivers, const CausticLight& light);

/// Receivers and what they get.
struct CausticReceivers {
    const Receivers& receivers;
    const CausticLight& light;
};

/// Makes pixels with edges what their samples see on average.
void blendCaustics(const Edges& edges, const CausticReceivers& pixels,
                   const CausticReceivers& strays, Image<vec3>& layer);

}  // namespace sheen
