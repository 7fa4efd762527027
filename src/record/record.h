// Records of the cache: where light was gathered, what was found there, and what that says of
// places around it.
#pragma once

#include <vector>

#include "core/directions.h"
#include "core/math.h"

namespace sheen::shared {
using namespace glm;
#include "shared/record.glsl"
}  // namespace sheen::shared

namespace sheen {

using shared::Record;
using shared::WeightParams;
static_assert(sizeof(Record) == 10 * 16, "irradiance.frag takes a Record as ten vec4s");

/// SH coefficients of one record, world space: radiance, and its change along the record's tangent
/// and bitangent in the first `gradient_order` bands.
/// Layout [channel][coefficient] of value, then tangent, then bitangent gradient.
struct ShLayout {
    int order = 0;
    int gradient_order = 0;

    int coefficients() const { return order * order; }
    int gradientCoefficients() const { return gradient_order * gradient_order; }
    int size() const { return 3 * coefficients() + 6 * gradientCoefficients(); }
    int gradientFirst(int axis) const {
        return 3 * coefficients() + 3 * axis * gradientCoefficients();
    }
};

/// Bands that carry translation gradients, at most (docs/decisions/gather.md).
constexpr int kShGradientOrder = 3;

inline ShLayout shLayout(int order) {
    return {.order = order, .gradient_order = order < kShGradientOrder ? order : kShGradientOrder};
}

/// The cache: records and the coefficients they point into.
struct RecordCache {
    std::vector<Record> records;
    std::vector<float> sh;
};

/// Shortens gradients (`sh`: the record's coefficients, none of a diffuse one) so that within
/// `reach` a value changes by no more than `limit` times itself.
void boundGradients(Record& record, float* sh, float reach, float limit);

/// The tangent frame of a normal, turned about it by an angle from the tangent toward the
/// bitangent.
mat3 tangentFrame(const vec3& normal, float angle);

/// A lobe [order * order] times a record's coefficients (`sh`, in ShLayout) extrapolated to p, RGB.
vec3 convolveRecord(const Record& k, const float* sh, const float* lobe, int order, const vec3& p);

}  // namespace sheen
