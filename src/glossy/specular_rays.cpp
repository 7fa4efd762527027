// Each pixel sees its lobe by rays of its own; what they saw is then filtered. Where there are
// records, they are a control variate: rays say how much more there is.
#include "glossy/specular_rays.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "glossy/ray_filter.h"
#include "rays/jitter.h"
#include "scene/brdf_albedo.h"
#include "scene/ggx_sampling.h"

namespace sheen {
namespace {

// A row of samples is a packet of rays.
constexpr int kRowSamples = Tracer::kPacket;
constexpr uint32_t kMostSamples = 1u << 16u;  // of a pixel, more than there are
constexpr int kAreaRows = 8;                  // of one of which the whole area counts, at the least

// Where rays of a pixel leave, and what mirrors them there.
struct LobeStart {
    vec3 eye, n_g, n, wo;
};

LobeStart middleOf(const Scene& scene, const Receivers& receivers, size_t i) {
    const SurfaceSide side = receivers.sideAt(scene, i);
    return {side.start(), side.n_g, receivers.scatteringNormal(i), receivers.towardViewer(i)};
}

// At a place of the pixel that is the row's own, where the camera sees the middle's surface there:
// so what mirrors show has smooth edges.
LobeStart placeInPixel(const OutgoingLight& light, const Receivers& receivers, size_t i,
                       const LobeStart& middle, int row, int rows) {
    constexpr float kGolden = 0.6180340f;  // places by the golden ratio are evenly spread
    constexpr float kOffPlane = 1.0f;      // footprints
    const Scene& scene = light.scene();
    const PixelGrid& image = receivers.image;
    const auto width = static_cast<size_t>(image.width);
    const vec2 u((static_cast<float>(row) + 0.5f) / static_cast<float>(rows),
                 glm::fract((static_cast<float>(row) + 0.5f) * kGolden));
    const vec2 place = (vec2(i % width, i / width) + u) / vec2(image.width, image.height);
    const vec3 way = glm::normalize(shared::viewDirection(image.view, 2.0f * place - 1.0f));
    const Sight sight = light.tracer().seeAlone(image.view.origin, way);
    for (int veil = 0; veil <= sight.veil_count; ++veil) {
        const Sight::Part part = sight.part(veil);
        const Hit& hit = part.hit;
        if (!hit.found() ||
            static_cast<int>(scene.materials_of[hit.triangle]) != receivers.materials[i]) {
            continue;
        }
        const SurfacePoint p =
            surfacePoint(scene, hit.triangle, hit.u, hit.v, -part.direction, hit.distance);
        const ShadingNormals n = normalsAt(scene, p.triangle, p.barycentric, p.n_g, p.wo);
        const float height =
            0.5f * glm::dot(p.position - receivers.positions[i], n.smooth + receivers.normals[i]);
        if (std::abs(height) <= kOffPlane * receivers.footprints[i]) {
            return {p.eye(scene), p.n_g, receivers.are_coats ? n.coat : n.mapped, p.wo};
        }
    }
    return middle;
}

// A row of samples of a pixel: where in the lobe, and of which half the first one is.
struct Row {
    vec2 u[kRowSamples];
    int half;
};

// Adds what they see. `sharing`: so many rays there are of the lobe; each stands for its part of
// it.
void castRow(const OutgoingLight& light, const Receivers& receivers, size_t i,
             const LobeStart& from, const Row& row, float sharing, bool without_caustics,
             SpecularSeen& result) {
    const mat3 frame = tangentFrame(from.n);
    const vec3 wo_local = glm::transpose(frame) * from.wo;
    vec3 directions[kRowSamples];
    vec3 weights[kRowSamples];
    uint8_t halves[kRowSamples];
    float solid_angles[kRowSamples];
    vec4 seen[kRowSamples];
    size_t count = 0;
    for (int k = 0; k < kRowSamples; ++k) {
        const auto along =
            sampleLobe(wo_local, receivers.alpha(i), receivers.f0[i], receivers.f90[i], row.u[k]);
        if (!along) {
            continue;
        }
        const int half = (row.half + k) % 2;
        result.weight[half] += along->weight;
        const vec3 direction = glm::normalize(frame * along->wi);
        if (glm::dot(direction, from.n_g) > 0.0f) {
            directions[count] = direction;
            solid_angles[count] = std::min(1.0f / (sharing * along->density), kPi);
            halves[count] = static_cast<uint8_t>(half);
            weights[count++] = along->weight;
        }
    }
    light.cast({.origin = from.eye,
                .directions = {directions, count},
                .solid_angles = {solid_angles, count},
                .sets = {halves, count},
                .without_caustics = without_caustics},
               seen);
    for (size_t k = 0; k < count; ++k) {
        result.light[halves[k]] += weights[k] * vec3(seen[k]);
        result.nearness += seen[k].w > 0.0f ? 1.0f / seen[k].w : 0.0f;
    }
}

// What a pixel sees by this share of the usual rays, when `sharing` pixels share them. A ray sees
// highlights as wide as the cone it stands for: where that is counted too wide, mirrored highlights
// are blurred. Rays are weighted by the estimator of visible normals, F G2 / G1, whose mean is the
// lobe's albedo.
SpecularSeen see(const OutgoingLight& light, const Receivers& receivers, size_t i, float rays_share,
                 float sharing, const SpecularParams& params, uint32_t sample = 0) {
    const LobeStart middle = middleOf(light.scene(), receivers, i);
    const bool area = params.pixel_area && receivers.isTooGlossy(i);  // wider lobes hide edges
    const float wanted = rays_share * std::min(params.rays_per_alpha * receivers.alpha(i),
                                               static_cast<float>(params.max_rays));
    const int rows =
        std::max(static_cast<int>(std::ceil(wanted / kRowSamples)), area ? kAreaRows : 1);
    const auto all = static_cast<float>(rows * kRowSamples);
    // The halves are the fields of a chessboard of strata, which is which by chance: each is right
    // on average, and both together are as evenly spread as one set of rays.
    const int first = randomPlace(static_cast<uint32_t>(i), ~sample).x < 0.5f ? 1 : 0;
    const bool without_caustics = params.caustics_apart && receivers.alpha(i) >= kSpecularAlpha;
    SpecularSeen result;
    for (int r = 0; r < rows; ++r) {
        Row row{.u = {}, .half = r + first};
        for (int k = 0; k < kRowSamples; ++k) {
            const vec2 place =
                randomPlace(static_cast<uint32_t>(i),
                            kMostSamples * sample + static_cast<uint32_t>(r * kRowSamples + k));
            row.u[k] = (vec2(r, k) + place) / vec2(rows, kRowSamples);
        }
        const LobeStart from = area ? placeInPixel(light, receivers, i, middle, r, rows) : middle;
        castRow(light, receivers, i, from, row, all * sharing, without_caustics, result);
    }
    const vec3 scale = 2.0f / (all * glm::max(receivers.specularAlbedo(i), vec3(1e-12f)));
    result.nearness /= all;
    for (int k = 0; k < 2; ++k) {
        result.light[k] *= scale;
        result.weight[k] *= scale;
    }
    return result;
}

// Calls body(i) for the pixels gathered by rays.
template <class F>
void forEachByRays(const Receivers& receivers, const F& body) {
    const PixelGrid& image = receivers.image;
    parallelFor(image.height, [&](int y) {
        for (size_t i = image.index(0, y); i < image.index(0, y + 1); ++i) {
            if (receivers.by_rays[i] != 0) {
                body(i);
            }
        }
    });
}

}  // namespace

Image<SpecularSeen> traceSpecular(const OutgoingLight& light, const Receivers& receivers,
                                  const SpecularParams& params) {
    // As many pixels as a Gaussian counts for: 4 pi times its variance.
    const float sharing = std::max(4.0f * kPi * params.window * params.window, 1.0f);
    Image<SpecularSeen> seen(receivers.image.width, receivers.image.height);
    forEachByRays(receivers, [&](size_t i) {
        if (!receivers.isCorrected(i)) {
            seen.pixels[i] = see(light, receivers, i, 1.0f, 1.0f, params);
            return;
        }
        // Their noise shows by the lobe's share of what a pixel reflects: so do their rays [Ney34].
        const float specular = luminance(receivers.specularAlbedo(i));
        const float all = specular + luminance(receivers.diffuse[i]);
        const float share = specular / std::max(all, 1e-12f);
        seen.pixels[i] = see(light, receivers, i, share, sharing, params);
    });
    return seen;
}

vec3 seeAgain(const OutgoingLight& light, const Receivers& receivers, size_t pixel, float share,
              int sample, const SpecularParams& params) {
    const SpecularSeen seen =
        see(light, receivers, pixel, share, 1.0f, params, static_cast<uint32_t>(sample + 1));
    return (seen.light[0] + seen.light[1]) /
           glm::max(seen.weight[0] + seen.weight[1], vec3(1e-12f));
}

Image<vec3> reflectSpecular(const Receivers& receivers, const Image<SpecularSeen>& seen,
                            const Image<vec3>& cached, bool neighbours) {
    Image<vec3> specular(receivers.image.width, receivers.image.height);
    NoisyLight light{.halves = {specular, specular},
                     .guide = specular,
                     .nearness = Image<float>(specular.width, specular.height)};
    forEachByRays(receivers, [&](size_t i) {
        const vec3 albedo = receivers.specularAlbedo(i);
        specular.pixels[i] = albedo;
        const bool corrected = receivers.isCorrected(i);
        const vec3 said =
            corrected ? cached.pixels[i] / glm::max(albedo, vec3(1e-12f)) : vec3(0.0f);
        light.guide.pixels[i] = said;
        const SpecularSeen& s = seen.pixels[i];
        light.nearness.pixels[i] = s.nearness;
        for (int half = 0; half < 2; ++half) {
            light.halves[half].pixels[i] =
                corrected ? said + s.light[half] - said * s.weight[half]
                          : s.light[half] / glm::max(s.weight[half], vec3(1e-12f));
        }
    });
    const Image<vec3> filtered = neighbours ? filterLight(receivers, light) : Image<vec3>();
    forEachByRays(receivers, [&](size_t i) {
        specular.pixels[i] *= neighbours
                                  ? filtered.pixels[i]
                                  : 0.5f * (light.halves[0].pixels[i] + light.halves[1].pixels[i]);
    });
    return specular;
}

}  // namespace sheen
