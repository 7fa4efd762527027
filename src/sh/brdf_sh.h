// Spherical harmonics of the BRDF's specular lobe times the cosine, seen from one direction: what a
// record's coefficients are multiplied with. The table is made when the project is built
// (make_brdf_sh.cpp): bands 0-9 in the view-aligned frame (z the normal, the viewer in the xz
// plane, x > 0), where an isotropic lobe mirrors in y and only m >= 0 is needed.
#pragma once

#include <vector>

#include "core/math.h"
#include "sh/sh.h"

namespace sheen {

/// The lobe split by Schlick's Fresnel, F0 * a + F90 * b; entry l (l + 1) / 2 + m. Entry 0 times
/// sqrt(4 pi) is the directional albedo.
struct BrdfShSample {
    float a[kShTriangle];
    float b[kShTriangle];
};

/// The table at a view cosine and perceptual roughness, bilinear.
BrdfShSample brdfSh(float NoV, float roughness);

/// Rotates lobes into world space without a rotation matrix: a band of a function that mirrors in
/// the plane of incidence is a sum of zonal harmonics about directions in that plane, and turning
/// the function is turning those directions. Based on: [NSF12].
class BrdfRotator {
  public:
    /// For lobes of `order` bands, 1..SH_MAX_ORDER.
    explicit BrdfRotator(int order);

    /// World-space coefficients [l (l + 1) + m] of the lobe F0 * a + F90 * b with scalar F0 and
    /// F90, on a surface with normal n seen from wo (unit, world space).
    void rotate(const BrdfShSample& lobe, float f0, float f90, const vec3& n, const vec3& wo,
                float* coefficients) const;

  private:
    int order_;
    std::vector<vec2> axes_;      // (sine, cosine) of the zonal directions from the normal
    std::vector<float> weights_;  // [l][m][direction]
};

/// Relative error, through a lobe, of light whose band l has amplitude 1 / (l + 1) (see
/// lightAmplitude in brdf_sh.cpp): predicted RMS over the lobe's own response to constant light.
struct LobePrediction {
    float truncated[shared::SH_MAX_ORDER + 1];  ///< [n]: bands n and above left out
    float as_diffuse;  ///< the lobe replaced by a cosine of the same albedo
};
LobePrediction predictLobeError(float NoV, float roughness);

}  // namespace sheen
