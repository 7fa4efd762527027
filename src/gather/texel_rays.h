// The rays of a record: one through each texel of its hemisphere, at a random place within it, and
// more through some.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gather/face_directions.h"
#include "light/outgoing.h"

namespace sheen {

/// Rays of a record, and the texels they are for. Directions below the surface, to where the
/// shading normal's hemisphere may reach, are not cast: nothing comes from there.
struct TexelRays {
    vec3 n_g{0.0f};
    std::vector<vec3> directions = {};
    std::vector<float> solid_angles = {};  ///< that the rays stand for
    std::vector<size_t> of = {};           ///< texels
    std::vector<uint8_t> numbers = {};     ///< of the rays of its texel: 0 is the first
    std::vector<uint8_t> sets = {};

    void reserve(size_t count);
    void add(const vec3& direction, float solid_angle, size_t texel, int number, size_t set);
    /// What they see, as OutgoingLight::cast() has it. `hits`, `planes`: unless null, too.
    std::vector<vec4> cast(const OutgoingLight& light, const vec3& eye, bool without_caustics,
                           vec3* planes = nullptr, Hit* hits = nullptr) const;
};

/// Axes of the hemisphere's faces in the space of `frame`, a record's.
std::vector<FaceDirections> directionsOfFaces(const Hemisphere& h, const mat3& frame);

/// Where ray `number` of a texel goes, as seed and texel alone decide.
vec3 texelRay(const Hemisphere& h, std::span<const FaceDirections> faces, size_t texel, int number,
              uint32_t seed);

/// The first ray of each texel.
TexelRays raysThroughTexels(const Hemisphere& h, std::span<const FaceDirections> faces,
                            const vec3& n_g, uint32_t seed);

/// What a texel's light counts for: irradiance weighs it by its cosine, lobes anywhere.
std::span<const float> weightsFor(const Hemisphere& h, int order);

/// Light of texels, over their average.
std::vector<float> relativeLight(std::span<const vec4> texels, std::span<const float> weights);

/// By how much light changes across each texel, judged by its neighbours and, but for its share of
/// the average, never by its own ray: were it looked at closer because its ray met something
/// bright, but not because it missed it, light would be lost.
std::vector<float> contrastsOfNeighbours(const Hemisphere& h, std::span<const float> light);

/// From so much contrast on a texel is looked at closer.
constexpr float kLeastContrast = 2.0f;

/// [texel]: so many rays go through it besides the first.
std::vector<uint8_t> raysMore(std::span<const float> contrasts);

/// The others, [texel] so many.
TexelRays raysWhereLightChanges(const Hemisphere& h, std::span<const FaceDirections> faces,
                                const vec3& n_g, uint32_t seed, std::span<const uint8_t> more);

/// Makes texels, of one ray each, the means of radiance and of the distance's inverse over all
/// rays, of which there are `more`; those of them that were cast are `of` these texels.
void addRays(std::span<const size_t> of, std::span<const vec4> seen, std::span<const uint8_t> more,
             std::span<vec4> texels);

}  // namespace sheen
