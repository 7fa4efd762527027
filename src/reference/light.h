// Light along rays: what a pixel sees, what punctual lights send from a surface, what a ray meets
// that leaves one. The integrand of docs/reference.md, for the path tracer and for whatever else is
// judged beside it (baselines/).
#pragma once

#include <optional>

#include "reference/ray_scene.h"

namespace sheen {

/// What was traced, and what had to be dropped.
struct Counters {
    int64_t rays = 0;
    int64_t nonfinite = 0;  ///< samples whose radiance was not finite
};

bool finite(const vec3& v);
bool black(const vec3& v);

/// Radiance, nits, that punctual lights send from the surface toward its wo: one shadow ray each.
vec3 directRadiance(const RayScene& rays, const Surface& s, Counters& counters);

/// The same for up to RayScene::kPacket surfaces near each other, cheaper; as many `radiance`.
void directRadiance(const RayScene& rays, std::span<const Surface> surfaces, vec3* radiance,
                    Counters& counters);

/// What a path meets that leaves a surface in direction wi. The hemisphere of a shading normal
/// reaches below the geometric surface, from where no light comes.
RayHit nextHit(const RayScene& rays, const Surface& s, const vec3& wi, Counters& counters);

/// A frame that sees nothing: black layers of light and of the G-buffer, no variances.
Frame emptyFrame(int width, int height);

/// The surface at the centre of pixel (x, y), if there is one; sets the pixel's direct light,
/// emission and G-buffer in `frame`.
std::optional<Surface> seePixel(const RayScene& rays, const Camera& camera, int x, int y,
                                Frame& frame, Counters& counters);

}  // namespace sheen
