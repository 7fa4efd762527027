// Spherical harmonics on the CPU: the basis (shared with the shaders) and rotation.
#pragma once

#include <vector>

#include "core/math.h"

namespace sheen::shared {
using namespace glm;
#include "shared/sh.glsl"

inline const ShFactors kShFactors = shFactors();
/// The basis at a unit direction, bands 0..order-1; the rest of the vector is not written.
inline ShVector shBasis(const vec3& d, int order) { return shBasis(d, order, kShFactors); }
}  // namespace sheen::shared

namespace sheen {

/// Entries of a triangular table over l < SH_MAX_ORDER, 0 <= m <= l.
constexpr int kShTriangle = shared::SH_MAX_ORDER * (shared::SH_MAX_ORDER + 1) / 2;
constexpr int shTriangleIndex(int l, int m) { return l * (l + 1) / 2 + m; }

/// Rotates coefficients: if f has coefficients c, then apply() gives those of f(R^-1 d).
/// Each band's matrix comes from fixed directions w_i with known basis values: the rotated band
/// must take the value f(w_i) at R w_i, of twice as many directions as decide it.
class ShRotation {
  public:
    ShRotation(const mat3& rotation, int order);
    /// `in` and `out`: [order * order]; may not overlap.
    void apply(const float* in, float* out) const;

  private:
    int order_;
    std::vector<float> matrices_;  // band by band, row-major (2l+1)^2
};

/// Solves A X = B for a symmetric positive definite A [n][n], B [n][columns] in place, by Cholesky.
/// (GLM stops at 4 x 4.)
void solveSpd(int n, std::vector<double> a, std::vector<double>& b, int columns);

}  // namespace sheen
