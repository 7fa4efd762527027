// From the texels of a hemisphere to a record.
#include "gather/integrate.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "scene/shared.h"
#include "sh/projection.h"
#include "sh/sh.h"

namespace sheen {
namespace {

// One over the distance of what the wall between two texels lies on: so fast the wall moves when
// the record does. [WH92] takes the nearer texel's, which is right where one surface hides another.
// Often none does. A record at the foot of a wall sees the floor in one texel from an inch away, in
// the next from the far end of the room, and what light changes from the one to the other changes
// on the way, far from the record: by the nearer distance its gradient would have no bound.
// - Both texels see one plane: light that changes evenly along it does so at the mean of 1 / r on
//   the way from r_a to r_b, ln(r_b / r_a) / (r_b - r_a).
// - Each sees a plane that is behind the other's where the other is seen: the two meet in an inner
//   corner, and the wall is that corner.
float wallParallax(const Hemisphere& h, const HemisphereWall& wall, std::span<const vec3> planes,
                   std::span<const float> inverse_distance) {
    constexpr float kSamePlane = 0.02f;  // inverse distances agree so well, relative
    const float nearer = std::max(inverse_distance[wall.a], inverse_distance[wall.b]);
    const auto unknown = [&](uint32_t texel) {
        return planes[texel] == vec3(0.0f) && inverse_distance[texel] > 0.0f;
    };
    if (nearer == 0.0f || planes.empty() || unknown(wall.a) || unknown(wall.b)) {
        return nearer;
    }
    const auto plane = [&](uint32_t of, uint32_t along) {
        return glm::dot(planes[of], h.directions[along]);
    };
    const float a = plane(wall.a, wall.a);
    const float b = plane(wall.b, wall.b);
    const float a_along_b = plane(wall.a, wall.b);
    const float before_b = a - plane(wall.b, wall.a);
    const float before_a = b - a_along_b;
    float parallax = nearer;
    if (a > 0.0f && b > 0.0f && std::abs(before_b) + std::abs(before_a) <= kSamePlane * (a + b)) {
        // Where a and b are alike, the geometric mean is as good, and 0 / 0 far.
        const float ratio = a / b;
        parallax =
            std::abs(ratio - 1.0f) < 0.1f ? std::sqrt(a * b) : a * std::log(ratio) / (ratio - 1.0f);
    } else if (before_b > 0.0f && before_a > 0.0f) {
        parallax = glm::mix(a, a_along_b, before_b / (before_b + before_a));
    }
    // A ray at a grazing angle may tell of a plane whose horizon lies before the texel's middle:
    // then the distances say more.
    return parallax >= 0.0f && parallax <= nearer ? parallax : nearer;
}

// Translation gradients: when the record moves, solid angle passes between neighbouring texels
// across their common wall, at the rate of its parallax. The exchanged radiance is
// added half to each texel, as the change of its radiance times solid angle:
// [axis][channel][texel]. `cosine_gradient`: the same with the cosine, summed: the irradiance's
// gradient. [WH92] `cosine_hessian`: the irradiance's second derivatives xx, xy, yy, the texels'
// light painted on what they see. [SJJ12]
struct TranslationGradient {
    vec3 cosine_gradient[2] = {};
    vec3 cosine_hessian{};  // of luminance
    std::vector<float> exchanged[2][3];
};

TranslationGradient translationGradient(const Hemisphere& h, const SeenTexels& seen,
                                        std::span<const float> inverse_distance, bool per_texel) {
    const std::vector<vec4>& texels = seen.light;
    TranslationGradient g;
    if (per_texel) {
        for (auto& axis : g.exchanged) {
            for (auto& channel : axis) {
                channel.assign(texels.size(), 0.0f);
            }
        }
    }
    std::vector<float> parallaxes;
    parallaxes.reserve(h.walls.size());
    std::vector<float> corner_q(static_cast<size_t>(h.corners));
    for (const HemisphereWall& wall : h.walls) {
        parallaxes.push_back(wallParallax(h, wall, seen.planes, inverse_distance));
        for (uint32_t corner : wall.corners) {
            corner_q[corner] = std::max(corner_q[corner], parallaxes.back());
        }
    }
    for (size_t i = 0; i < h.walls.size(); ++i) {
        const HemisphereWall& wall = h.walls[i];
        const vec3 step = vec3(texels[wall.a]) - vec3(texels[wall.b]);
        const vec3 change = -parallaxes[i] * step;
        g.cosine_gradient[0] += change * wall.cosine_motion.x;
        g.cosine_gradient[1] += change * wall.cosine_motion.y;
        const float q0 = corner_q[wall.corners[0]];
        const float q1 = corner_q[wall.corners[1]];
        g.cosine_hessian +=
            luminance(step) * (q0 * q0 * wall.cosine_bend[0] + q0 * q1 * wall.cosine_bend[1] +
                               q1 * q1 * wall.cosine_bend[2]);
        if (!per_texel) {
            continue;
        }
        for (int axis = 0; axis < 2; ++axis) {
            const float half_motion = 0.5f * wall.motion[axis];
            for (int channel = 0; channel < 3; ++channel) {
                const float value = half_motion * change[channel];
                g.exchanged[axis][channel][wall.a] += value;
                g.exchanged[axis][channel][wall.b] += value;
            }
        }
    }
    return g;
}

// The eigenvalue of the symmetric matrix xx, xy, yy that is greatest in magnitude.
float greatestCurvature(const vec3& m) {
    const float mean = 0.5f * (m.x + m.z);
    return std::abs(mean) + std::hypot(0.5f * (m.x - m.z), m.y);
}

std::vector<float> projectSh(const Hemisphere& h, std::span<const vec4> texels,
                             const TranslationGradient& gradient, const ShProjection& projection,
                             int order, const mat3& world_from_local) {
    const ShLayout layout = shLayout(order);
    const auto count = static_cast<size_t>(h.texelCount());
    const ShRotation rotation(world_from_local, order);
    const ShRotation gradient_rotation(world_from_local, layout.gradient_order);
    std::vector<float> sh(static_cast<size_t>(layout.size()));
    std::vector<float> local(static_cast<size_t>(layout.coefficients()));
    std::vector<float> plane(count);
    const auto project = [&](std::span<const float> matrix, int coefficients,
                             const ShRotation& turn, float* out) {
        for (int k = 0; k < coefficients; ++k) {
            local[static_cast<size_t>(k)] =
                dotProduct(&matrix[static_cast<size_t>(k) * count], plane.data(), count);
        }
        turn.apply(local.data(), out);
    };
    for (int channel = 0; channel < 3; ++channel) {
        for (size_t t = 0; t < count; ++t) {
            plane[t] = texels[t][channel];
        }
        project(projection.value, layout.coefficients(), rotation,
                &sh[static_cast<size_t>(channel * layout.coefficients())]);
    }
    // What a texel exchanged is radiance times solid angle; the matrix expects radiance.
    for (int axis = 0; axis < 2; ++axis) {
        for (int channel = 0; channel < 3; ++channel) {
            for (size_t t = 0; t < count; ++t) {
                plane[t] = gradient.exchanged[axis][channel][t] / h.solid_angles[t];
            }
            project(projection.gradient, layout.gradientCoefficients(), gradient_rotation,
                    &sh[static_cast<size_t>(layout.gradientFirst(axis) +
                                            channel * layout.gradientCoefficients())]);
        }
    }
    return sh;
}

}  // namespace

void ProjectionMatrices::prepare(const Hemisphere& hemisphere, std::span<const RecordSite> sites) {
    for (const RecordSite& site : sites) {
        for (int order : {site.order, shLayout(site.order).gradient_order}) {
            std::vector<float>& matrix = of_[static_cast<size_t>(order)];
            if (order > shared::DIFFUSE_ORDER && matrix.empty()) {
                matrix = below_ == BelowHorizon::kContinued
                             ? projectionMatrix(hemisphere, {.order = order})
                             : integralMatrix(hemisphere, order);
            }
        }
    }
}

void seeThroughLobe(const Hemisphere& h, std::span<const vec4> texels, const RecordSite& site,
                    const mat3& frame, GatheredRecord& result) {
    const SpecularLobe& lobe = site.lobe;
    result.toward_viewer = site.toward_viewer;
    result.lobe_texels = 0.0f;
    if (!lobe.any()) {
        return;
    }
    const vec3 wo = site.toward_viewer * frame;
    if (h.params.kind != HemisphereKind::kHemicube && h.params.kind != HemisphereKind::kBorder) {
        return;
    }
    const float NoV = std::max(wo.z, shared::MIN_COSINE);
    vec3 light(0.0f);
    float sum = 0.0f;
    float squares = 0.0f;
    for (size_t t = 0; t < texels.size(); ++t) {
        const vec3& wi = h.directions[t];
        const vec2 f =
            shared::specularLobe(lobe.alpha, vec3(0.0f, 0.0f, 1.0f), {wo.x, wo.y, NoV}, wi);
        const float weight = (lobe.f0 + (lobe.f90 - lobe.f0) * f.y) * f.x * h.cosines[t];
        light += weight * vec3(texels[t]);
        sum += weight;
        squares += weight * weight;
    }
    if (sum > 0.0f) {
        result.lobe_light = light / sum;
        result.lobe_texels = sum * sum / squares;
    }
}

GatheredRecord integrateHemisphere(const Hemisphere& h, const SeenTexels& seen,
                                   const ShProjection& projection, const RecordSite& site) {
    const std::vector<vec4>& texels = seen.light;
    SHEEN_CHECK_EQ(texels.size(), static_cast<size_t>(h.texelCount()));
    SHEEN_CHECK(seen.planes.empty() || seen.planes.size() == texels.size());
    const mat3 frame = tangentFrame(site.normal, seen.turn);
    const size_t count = texels.size();
    std::vector<float> inverse_distance(count);
    vec3 irradiance(0.0f);
    vec3 moment_x(0.0f);
    vec3 moment_y(0.0f);
    float inverse_sum = 0.0f;
    float solid_angle_sum = 0.0f;
    for (size_t t = 0; t < count; ++t) {
        const vec3 radiance(texels[t]);
        inverse_distance[t] = texels[t].w > 0.0f ? 1.0f / texels[t].w : 0.0f;
        irradiance += h.cosines[t] * radiance;
        moment_x += h.moments[t].x * radiance;
        moment_y += h.moments[t].y * radiance;
        inverse_sum += h.solid_angles[t] * inverse_distance[t];
        solid_angle_sum += h.solid_angles[t];
    }
    const bool glossy = site.order > shared::DIFFUSE_ORDER;
    const TranslationGradient gradient = translationGradient(h, seen, inverse_distance, glossy);

    GatheredRecord result;
    Record& r = result.record;
    r.position = site.position;
    r.normal = site.normal;
    r.order = site.order;
    r.tangent = frame[0];
    r.radius = inverse_sum > 0.0f ? solid_angle_sum / inverse_sum : kInfinity;
    r.irradiance = irradiance;
    vec3* rotation[] = {&r.rotation_r, &r.rotation_g, &r.rotation_b};
    vec3* translation[] = {&r.translation_r, &r.translation_g, &r.translation_b};
    for (int c = 0; c < 3; ++c) {
        *rotation[c] = frame[0] * moment_x[c] + frame[1] * moment_y[c];
        *translation[c] =
            frame[0] * gradient.cosine_gradient[0][c] + frame[1] * gradient.cosine_gradient[1][c];
    }
    result.curvature = greatestCurvature(gradient.cosine_hessian);
    seeThroughLobe(h, texels, site, frame, result);
    if (glossy) {
        result.sh = projectSh(h, texels, gradient, projection, site.order, frame);
    }
    return result;
}

}  // namespace sheen
