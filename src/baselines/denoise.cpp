#include "baselines/denoise.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace sheen {
namespace {

// Below this a channel's albedo says nothing of the light that met it.
constexpr float kLeastAlbedo = 1e-3f;
// Pixels less alike than exp(-12) do not touch each other at all.
constexpr float kUnlike = 12.0f;
// The B3 spline, 5 taps. [DSHL10]
constexpr float kSpline[] = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f};

// One layer on its way through the levels: light over albedo.
struct Level {
    Image<vec3> light;
    Image<vec3> variance;
};

// Pixels of one row at a time, of all rows.
template <class Body>
void forEachPixel(const Frame& guide, const Body& body) {
    parallelFor(guide.height(), [&](int y) {
        for (int x = 0; x < guide.width(); ++x) {
            if (guide.primitive.at(x, y) != kNoPrimitive) {
                body(x, y);
            }
        }
    });
}

// Of the luminance, as if its channels erred alike: they do, seeing the same samples.
float luminanceDeviation(const vec3& variance) {
    return luminance(glm::sqrt(glm::max(variance, vec3(0.0f))));
}

// How unlike the surfaces of two pixels are: their weight is exp(-this).
float unlikeness(const Frame& guide, ivec2 p, ivec2 q, const AtrousParams& params) {
    const vec3 &n_p = guide.normal.at(p.x, p.y), &n_q = guide.normal.at(q.x, q.y);
    const vec3 d = guide.position.at(q.x, q.y) - guide.position.at(p.x, p.y);
    const float off_plane = std::max(std::abs(glm::dot(d, n_p)), std::abs(glm::dot(d, n_q)));
    const float distance = glm::length(d);
    const float sine = distance > 0.0f ? off_plane / distance : 0.0f;
    const float rougher = guide.roughness.at(p.x, p.y) - guide.roughness.at(q.x, q.y);
    const float tilt = sine / params.plane;
    return (1.0f - glm::dot(n_p, n_q)) / params.normal + tilt * tilt +
           std::abs(rougher) / params.roughness;
}

// Mean of the deviation over 3 x 3 pixels of similar surfaces: a variance from few replicates is
// noisy itself. [SKWKLBHL17, eq. 5]
Image<float> smoothDeviation(const Image<vec3>& variance, const Frame& guide, int step) {
    Image<float> result(guide.width(), guide.height());
    forEachPixel(guide, [&](int x, int y) {
        float sum = 0.0f, weights = 0.0f;
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const int qx = x + dx * step, qy = y + dy * step;
                if (qx < 0 || qy < 0 || qx >= guide.width() || qy >= guide.height() ||
                    guide.primitive.at(qx, qy) == kNoPrimitive) {
                    continue;
                }
                const float weight = (dx == 0 ? 2.0f : 1.0f) * (dy == 0 ? 2.0f : 1.0f);
                const float deviation = luminanceDeviation(variance.at(qx, qy));
                sum += weight * deviation * deviation;
                weights += weight;
            }
        }
        result.at(x, y) = std::sqrt(sum / weights);
    });
    return result;
}

// difference / scale, also where the scale is 0.
float inScales(float difference, float scale) {
    if (scale > 0.0f) {
        return difference / scale;
    }
    return difference > 0.0f ? kInfinity : 0.0f;
}

Level filterLevel(const Level& level, const Image<vec3>& albedo, const Frame& guide, int step,
                  const AtrousParams& params) {
    Level result = level;
    const Image<float> deviation = smoothDeviation(level.variance, guide, step);
    forEachPixel(guide, [&](int x, int y) {
        if (glm::all(glm::lessThanEqual(albedo.at(x, y), vec3(kLeastAlbedo)))) {
            return;
        }
        const float here = luminance(level.light.at(x, y));
        vec3 light(0.0f), variance(0.0f), weights(0.0f);
        for (int dy = -2; dy <= 2; ++dy) {
            for (int dx = -2; dx <= 2; ++dx) {
                const int qx = x + dx * step, qy = y + dy * step;
                if (qx < 0 || qy < 0 || qx >= guide.width() || qy >= guide.height() ||
                    guide.primitive.at(qx, qy) == kNoPrimitive) {
                    continue;
                }
                float weight = kSpline[std::abs(dx)] * kSpline[std::abs(dy)];
                if (dx != 0 || dy != 0) {
                    const float there = luminance(level.light.at(qx, qy));
                    const float scale =
                        params.luminance * (deviation.at(x, y) + deviation.at(qx, qy));
                    const float unlike = unlikeness(guide, ivec2(x, y), ivec2(qx, qy), params) +
                                         inScales(std::abs(here - there), scale);
                    if (unlike > kUnlike) {
                        continue;
                    }
                    weight *= std::exp(-unlike);
                }
                // A black channel of an albedo knows nothing of the light.
                const vec3 known =
                    vec3(glm::greaterThan(albedo.at(qx, qy), vec3(kLeastAlbedo))) * weight;
                light += known * (level.light.at(qx, qy) - level.light.at(x, y));
                variance += known * known * level.variance.at(qx, qy);
                weights += known;
            }
        }
        for (int c = 0; c < 3; ++c) {
            if (weights[c] > 0.0f) {
                result.light.at(x, y)[c] += light[c] / weights[c];
                result.variance.at(x, y)[c] = variance[c] / (weights[c] * weights[c]);
            }
        }
    });
    return result;
}

}  // namespace

Image<vec3> filterAtrous(const Image<vec3>& color, const Image<vec3>& variance,
                         const Image<vec3>& albedo, const Frame& guide,
                         const AtrousParams& params) {
    Level level{.light = Image<vec3>(guide.width(), guide.height()),
                .variance = Image<vec3>(guide.width(), guide.height())};
    forEachPixel(guide, [&](int x, int y) {
        const vec3 divisor = glm::max(albedo.at(x, y), vec3(kLeastAlbedo));
        level.light.at(x, y) = color.at(x, y) / divisor;
        level.variance.at(x, y) = variance.at(x, y) / (divisor * divisor);
    });
    for (int i = 0; i < params.levels; ++i) {
        level = filterLevel(level, albedo, guide, 1 << i, params);
    }
    Image<vec3> result = color;
    forEachPixel(guide, [&](int x, int y) {
        for (int c = 0; c < 3; ++c) {
            const float factor = albedo.at(x, y)[c];
            if (factor > kLeastAlbedo) {
                result.at(x, y)[c] = level.light.at(x, y)[c] * factor;
            }
        }
    });
    return result;
}

void denoise(ReferenceResult& traced) {
    Frame& frame = traced.frame;
    // Both parts see the same samples, so the whole's variance is at least the sum of theirs.
    Image<vec3> specular = frame.indirect, specular_variance = frame.indirect_variance;
    for (size_t i = 0; i < specular.pixels.size(); ++i) {
        specular.pixels[i] -= frame.indirect_diffuse.pixels[i];
        specular_variance.pixels[i] = glm::max(
            specular_variance.pixels[i] - frame.indirect_diffuse_variance.pixels[i], vec3(0.0f));
    }
    frame.indirect_diffuse =
        filterAtrous(frame.indirect_diffuse, frame.indirect_diffuse_variance, frame.albedo, frame);
    specular = filterAtrous(specular, specular_variance, traced.specular_albedo, frame);
    for (size_t i = 0; i < specular.pixels.size(); ++i) {
        frame.indirect.pixels[i] = frame.indirect_diffuse.pixels[i] + specular.pixels[i];
    }
    frame.indirect_variance = frame.indirect_diffuse_variance = frame.direct_variance = {};
}

}  // namespace sheen
