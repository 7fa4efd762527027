// Records of the cache: where light was gathered, and what was found there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math.h"
#include "scene/scene.h"

namespace sheen::shared {
using namespace glm;
#include "shared/record.glsl"
}  // namespace sheen::shared

namespace sheen {

using shared::Record;
using shared::WeightParams;
static_assert(sizeof(Record) == 10 * 16, "irradiance.frag takes a Record as ten vec4s");

/// Where the light that a record sees changes within a texel. `strength`: by how much, twice its
/// standard deviation there, in units of what a texel brings on average; as a hemisphere of the
/// usual size would see it.
struct Contrast {
    vec3 position{};
    float strength = 0;
};

/// The specular lobe of a surface seen from somewhere; f90 and f0 are 0 where there is none.
struct SpecularLobe {
    float alpha = 1;
    float f0 = 0;  ///< mean of the channels
    float f90 = 0;

    bool any() const { return f0 > 0.0f || f90 > 0.0f; }
};

/// A point where light is to be gathered.
struct RecordSite {
    vec3 position{};
    vec3 normal{};            ///< shading normal: the hemisphere's pole
    vec3 geometric_normal{};  ///< on the same side
    vec3 toward_viewer{};     ///< unit, to whoever sees the site; zero where no one does
    float offset = 0;         ///< surfaceOffset()
    /// Of its random numbers. From its place on the surface, never from what was gathered before:
    /// noise then stays where it is when the camera moves.
    uint32_t seed = 0;
    int order = shared::DIFFUSE_ORDER;
    SpecularLobe lobe = {};  ///< toward the viewer, where what it sees is wanted
    float reach = 0;         ///< that its record will most likely have, in pixels; 0: not known
    std::vector<Contrast> contrasts = {};  ///< what records nearby found: where to look closer
    bool first = false;                    ///< of the first grid: few have records nearby

    /// From where the site is looked out of.
    vec3 eye() const { return offSurface(position, geometric_normal, toward_viewer, offset); }
};

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

/// Bands that carry translation gradients, at most (docs/decisions.md).
constexpr int kShGradientOrder = 3;

inline ShLayout shLayout(int order) {
    return {.order = order, .gradient_order = order < kShGradientOrder ? order : kShGradientOrder};
}

/// What a gather found at a site, before any clamp of the radius.
struct GatheredRecord {
    Record record{};        ///< radius is the harmonic mean distance
    std::vector<float> sh;  ///< ShLayout; empty for a diffuse record
    /// Greatest second derivative, in magnitude, of the irradiance's luminance along the surface.
    float curvature = 0;
    /// The mean of the light that the site's lobe sees, by the texels themselves; of the site's
    /// lobe, if any.
    vec3 lobe_light{};
    float lobe_texels =
        0;  ///< so many texels count in that mean: (sum of weights)^2 / sum of squares
    std::vector<Contrast> contrasts = {};  ///< the strongest, for records to come
};

/// The cache: records and the coefficients they point into.
struct RecordCache {
    std::vector<Record> records;
    std::vector<float> sh;
};

/// Shortens gradients (`sh`: the record's coefficients, none of a diffuse one) so that within
/// `reach` a value changes by no more than `limit` times itself.
void boundGradients(Record& record, float* sh, float reach, float limit);

/// A tangent frame (tangent, bitangent, normal) that depends on the normal alone. [DBC17]
mat3 tangentFrame(const vec3& normal);
/// The same, turned about the normal by an angle from the tangent toward the bitangent.
mat3 tangentFrame(const vec3& normal, float angle);

/// A lobe [order * order] times a record's coefficients (`sh`, in ShLayout) extrapolated to p, RGB.
vec3 convolveRecord(const Record& k, const float* sh, const float* lobe, int order, const vec3& p);

}  // namespace sheen
