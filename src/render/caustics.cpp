#include "render/caustics.h"

#include "core/parallel.h"

namespace sheen {

CausticLight causticLight(const Tracer& tracer, const PhotonMap& photons,
                          const Receivers& receivers) {
    constexpr int kGrain = 64;
    CausticLight light{.values = std::vector<PhotonMap::Light>(receivers.positions.size())};
    parallelFor(
        receivers.count(),
        [&](int receiver) {
            const auto i = static_cast<size_t>(receiver);
            if (!receivers.seen(i)) {
                return;
            }
            const Brdf lobe{.diffuse = vec3(0.0f),
                            .alpha = receivers.alpha(i),
                            .f0 = receivers.f0[i],
                            .f90 = receivers.f90[i]};
            const bool scatters = !isSpecular(lobe) && !receivers.irradiance_only;
            if (receivers.diffuse[i] != vec3(0.0f) || scatters) {
                light.values[i] =
                    photons.at(tracer, receivers.sideAt(tracer.scene(), i),
                               receivers.scatteringNormal(i), scatters ? &lobe : nullptr);
            }
        },
        kGrain);
    return light;
}

Image<vec3> causticLayer(const Receivers& receivers, const CausticLight& light) {
    Image<vec3> layer(receivers.image.width, receivers.image.height);
    for (size_t i = 0; i < layer.pixels.size(); ++i) {
        const PhotonMap::Light& at = light.values[i];
        layer.pixels[i] = receivers.diffuse[i] / kPi * at.irradiance + at.reflected;
    }
    return layer;
}

void blendCaustics(const Edges& edges, const CausticReceivers& pixels,
                   const CausticReceivers& strays, Image<vec3>& layer) {
    for (size_t k = 0; k < edges.pixels.size(); ++k) {
        vec3 sent(0.0f);
        for (size_t s = edges.pixels[k].first_share; s < edges.endOfShares(k); ++s) {
            const EdgeShare& share = edges.shares[s];
            const bool stray = share.receiver >= edges.first_stray;
            const CausticReceivers& lit = stray ? strays : pixels;
            const auto i = static_cast<size_t>(share.receiver - (stray ? edges.first_stray : 0));
            const PhotonMap::Light& at = lit.light.values[i];
            sent += share.diffuse / kPi * at.irradiance +
                    share.specular * at.reflected /
                        glm::max(lit.receivers.specularAlbedo(i), vec3(1e-12f));
        }
        layer.pixels[edges.pixels[k].pixel] = sent;
    }
}

}  // namespace sheen
