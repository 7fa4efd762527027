// Light along rays: what a pixel sees, what lights send from a surface, what a ray meets that
// leaves one. The integrand of docs/reference.md, for the path tracer and for whatever else is
// judged beside it (baselines/).
#pragma once

#include <optional>
#include <vector>

#include "reference/lights.h"
#include "reference/sampling.h"

namespace sheen {

/// What was traced, and what had to be dropped.
struct Counters {
    int64_t rays = 0;
    int64_t nonfinite = 0;  ///< samples whose radiance was not finite
};

bool black(const vec3& v);

/// Radiance that leaves a surface toward its wo, and what of it the diffuse term scattered.
struct Scattered {
    vec3 all{0.0f};
    vec3 diffuse{0.0f};

    void add(const Scattered& other) {
        all += other.all;
        diffuse += other.diffuse;
    }
    /// What of it the lobe of a specular surface scattered (isSpecular()); none of other surfaces.
    vec3 specular(const Brdf& brdf) const { return isSpecular(brdf) ? all - diffuse : vec3(0.0f); }
};

/// Radiance, nits, that punctual lights send from the surface toward its wo: one shadow ray each.
vec3 directRadiance(const RayScene& rays, const Surface& s, Counters& counters);

/// The same for up to RayScene::kPacket surfaces near each other, cheaper; as many `radiance`.
void directRadiance(const RayScene& rays, std::span<const Surface> surfaces, vec3* radiance,
                    Counters& counters);

/// The same of one surface, and what of it the diffuse term scattered.
Scattered scatterPunctual(const RayScene& rays, const Surface& s, Counters& counters);

/// One estimate of what lamps and sky send from a surface consists of two halves, each weighed
/// against the other. Of a chosen light:
Scattered scatterChosen(const RayScene& rays, const Surface& s, const BrdfSampler& sampler,
                        const LightChoice& choice, Counters& counters);
/// And of a direction that the BRDF chose: what shines there; the caller multiplies by its weight.
/// The lamp whose triangle it hit, of surface q, seen from the point `from`; the sky where it met
/// none.
vec3 lampMet(const Lights& lights, const Surface& q, uint32_t triangle, const vec3& from,
             float brdf_pdf);
vec3 skyMet(const Lights& lights, const vec3& wi, float brdf_pdf);

/// The second half for lamps: traces the direction that the BRDF chooses by u in [0, 1)^2.
vec3 lampsByBrdf(const RayScene& rays, const Lights& lights, const Surface& s,
                 const BrdfSampler& sampler, const vec2& u, Counters& counters);

/// Both halves for lamps, by point `index` of the sequences of `seed`; and the same for the sky.
vec3 sampleLamps(const RayScene& rays, const Lights& lights, const Surface& s,
                 const BrdfSampler& sampler, uint32_t index, uint32_t seed, Counters& counters);
vec3 sampleSky(const RayScene& rays, const Lights& lights, const Surface& s,
               const BrdfSampler& sampler, uint32_t index, uint32_t seed, Counters& counters);

/// Whether light can come to a surface from there: not from below it, where the hemisphere of its
/// shading normal may reach.
inline bool opensToward(const Surface& s, const vec3& wi) { return glm::dot(s.n_g, wi) > 0.0f; }

/// What a path meets that leaves a surface in direction wi, toward which it must open to meet
/// anything.
RayHit nextHit(const RayScene& rays, const Surface& s, const vec3& wi, Counters& counters);

/// A frame that sees nothing: black layers of light and of the G-buffer, no variances.
Frame emptyFrame(int width, int height);

/// A part of what a camera's ray sees.
struct Sighting {
    vec3 share{1.0f};     ///< of the light that leaves it, what reaches the eye
    float chance = 1.0f;  ///< by which one of all parts is this one, chosen by chance
    std::optional<Surface> surface = {};
    uint32_t triangle = kNoPrimitive;
    vec3 emission{0.0f};  ///< nits: where there is no surface, of the sky if that is to show
};
/// All parts, from the eye on, of a ray through a place of an image of that size, in pixels from
/// the first one's centre. The last may be without a surface. Textures are those of the place, or
/// averaged over the pixel about it, as who looks at its middle alone should see them. Without
/// `facets` rough glass is seen through as if it were smooth.
enum class Textures { kOfPlace, kOfPixel };
std::vector<Sighting> look(const RayScene& rays, const Camera& camera, const ivec2& size,
                           const vec2& place, Textures textures, Counters& counters,
                           const std::optional<Facets>& facets = {});

/// Adds a part of what the middle of pixel (x, y) sees to `frame`: its share of emission and of
/// direct light by punctual lights.
void addLight(const RayScene& rays, const Sighting& part, int x, int y, Frame& frame,
              Counters& counters);
/// Makes a part with a surface what the layers of the G-buffer say of the pixel.
void setGBuffer(const Camera& camera, const Sighting& part, int x, int y, Frame& frame);

/// The nearest surface at the centre of pixel (x, y), if there is one, taken as one through which
/// nothing is seen; shown in `frame`.
std::optional<Surface> seePixel(const RayScene& rays, const Camera& camera, int x, int y,
                                Frame& frame, Counters& counters);

}  // namespace sheen
