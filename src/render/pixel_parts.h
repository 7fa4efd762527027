// What the light of one pixel is made of: for whoever wants to know why it looks as it does.
#pragma once

#include <vector>

#include "record/record.h"
#include "render/session.h"

namespace sheen {

struct PixelParts {
    ivec2 pixel{0};     ///< of the whole image
    bool seen = false;  ///< whether there is a surface; else all that follows says nothing
    vec3 position{0.0f}, normal{0.0f};  ///< world space
    float roughness = 0.0f;             ///< perceptual
    int order = 0;                      ///< of the spherical harmonics that it asks for
    /// Radiance toward the camera, nits, if a frame shows it.
    vec3 direct{0.0f}, indirect{0.0f}, caustic{0.0f}, emission{0.0f};

    struct Serving {
        size_t record = 0;  ///< index in the cache
        float share = 0;    ///< of all weights
        float distance = 0;
        float reach = 0;
    };
    std::vector<Serving> records = {};  ///< the heaviest first

    // Of the heaviest record, radiance from its hemisphere as a disc: its normal in the middle, the
    // horizon on the edge, equal areas for equal solid angles.
    Image<vec3> hemisphere = {};      ///< by a ray a pixel; empty without records
    Image<vec3> reconstruction = {};  ///< by its spherical harmonics; empty where it has none
};

/// Of a pixel of the image that `params` describe, as records of `cache` serve it. `order`: that it
/// asks for; shared::DIFFUSE_ORDER: of irradiance. Usage error where the camera does not exist.
PixelParts partsOf(const SceneState& state, const RenderParams& params, const ivec2& pixel,
                   int order, const RecordCache& cache, const WeightParams& weight);

}  // namespace sheen
