#include "accuracy_sh.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "reference/sobol.h"

namespace sheen::bench {
namespace {

constexpr int kSphereSize = 64;  // texels along a side of the image's hemicube
constexpr int kRaysPerSide = 2;  // squared: rays a texel
constexpr int kChunk = 16;       // sites a task sums up
constexpr int kNoiseSites = 64;  // a scene, whose images are traced twice
constexpr float kLift = 0.1f;    // of the harmonic mean distance, at most half the way up

std::vector<float> greys(const std::vector<vec4>& texels) {
    std::vector<float> values;
    for (const vec4& t : texels) {
        values.push_back(grey(t));
    }
    return values;
}

// A site's images, its frame turned at random about the normal: pixels' azimuths are fixed in it.
class SiteImages {
  public:
    SiteImages(const Sphere& sphere, const BenchScene& scene, int index)
        : sphere_(sphere), scene_(scene), site_(scene.sites[static_cast<size_t>(index)]) {
        seed_ = hash32(static_cast<uint32_t>(index));
        const float angle = 2.0f * kPi * static_cast<float>(seed_ >> 8) * 0x1p-24f;
        const float c = std::cos(angle);
        const float s = std::sin(angle);
        frame_ = tangentFrame(site_.normal) * mat3(vec3(c, s, 0), vec3(-s, c, 0), vec3(0, 0, 1));
    }

    SphereImage onSurface(uint32_t salt) {
        const std::vector<vec4> texels =
            trace(site_.eye(), {.seed = hashCombine(seed_, salt), .above = site_.geometric_normal});
        double inverse = 0.0;
        for (size_t t = 0; t < texels.size(); ++t) {
            inverse += texels[t].w > 0.0f ? sphere_.upper().solid_angles[t] / texels[t].w : 0.0f;
        }
        mean_distance_ = inverse > 0.0 ? static_cast<float>(2.0 * kPi / inverse) : 0.0f;
        return {greys(texels), {}};
    }
    // After onSurface().
    SphereImage lifted() const {
        const vec3 eye = site_.eye();
        const vec3 up[] = {site_.geometric_normal};
        vec4 above;
        scene_.light.cast({.origin = eye, .directions = up}, &above);
        const float room = above.w > 0.0f ? 0.5f * above.w : kInfinity;
        const vec3 lifted = eye + std::min(kLift * mean_distance_, room) * up[0];
        return {greys(trace(lifted, {.seed = hashCombine(seed_, 2)})),
                greys(trace(
                    lifted,
                    {.seed = hashCombine(seed_, 3), .mirrored = true, .lowest = Sphere::kLowest}))};
    }

  private:
    std::vector<vec4> trace(const vec3& eye, TexelRays how) const {
        how.side = kRaysPerSide;
        how.random = true;
        return traceTexels(scene_.light, sphere_.upper(), frame_, eye, how).light;
    }

    const Sphere& sphere_;
    const BenchScene& scene_;
    const RecordSite& site_;
    uint32_t seed_;
    mat3 frame_{1.0f};
    float mean_distance_ = 0.0f;
};

void judge(const Sphere& sphere, const std::vector<Projection>& projections, Eye eye,
           const SphereImage& image, Sums& sums) {
    std::vector<float> truth(kPixels);
    const auto judged = [&](int pixel) {
        return eye == kLifted || sphere.pixels()[static_cast<size_t>(pixel)].tilt == 0;
    };
    for (int k = 0; k < kPixels; ++k) {
        if (judged(k)) {
            truth[static_cast<size_t>(k)] = sphere.outgoing(k, image);
            sums.truth[eye][k] += truth[static_cast<size_t>(k)];
        }
    }
    const Sphere::Moments moments = sphere.moments(image);
    for (size_t p = 0; p < projections.size(); ++p) {
        for (int order = kMinOrder; order <= shared::SH_MAX_ORDER; ++order) {
            const Coefficients c = sphere.project(projections[p], p, order, moments);
            for (int k = 0; k < kPixels; ++k) {
                if (judged(k)) {
                    const double e = dotProduct(c.c, sphere.lobe(projections[p], k).c,
                                                static_cast<size_t>(order * order)) -
                                     truth[static_cast<size_t>(k)];
                    sums.squares[eye][p][order - kMinOrder][k] += e * e;
                }
            }
            if (p == kProgramFit && eye == kOnSurface) {
                sums.negative[order - kMinOrder] += sphere.negative(order, c) ? 1 : 0;
                for (int k = 0; k < kPixels; k += kTilts) {
                    const float t = truth[static_cast<size_t>(k)];
                    const float e = dotProduct(c.c, sphere.lobe(projections[p], k).c,
                                               static_cast<size_t>(order * order)) -
                                    t;
                    sums.negative_light[order - kMinOrder][k / kTilts] += e + t < 0.0f ? 1 : 0;
                    sums.relative[order - kMinOrder][k / kTilts].push_back(std::abs(e) /
                                                                           std::max(t, 1e-20f));
                }
            }
        }
    }
    if (eye == kOnSurface) {
        const Coefficients c = sphere.project(projections[kEvenReflection], kEvenReflection,
                                              shared::SH_MAX_ORDER, moments);
        for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
            const auto size = static_cast<size_t>(2 * l + 1);
            sums.band_power[l] +=
                dotProduct(&c.c[l * l], &c.c[l * l], size) / static_cast<double>(size);
        }
    }
}

Sums judgeScene(const Sphere& sphere, const std::vector<Projection>& projections,
                const BenchScene& scene, int sites) {
    const int chunks = (sites + kChunk - 1) / kChunk;
    std::vector<std::unique_ptr<Sums>> parts(static_cast<size_t>(chunks));
    parallelFor(chunks, [&](int chunk) {
        auto sums = std::make_unique<Sums>();
        for (int i = chunk * kChunk; i < std::min((chunk + 1) * kChunk, sites); ++i) {
            SiteImages images(sphere, scene, i);
            const SphereImage image = images.onSurface(0);
            judge(sphere, projections, kOnSurface, image, *sums);
            judge(sphere, projections, kLifted, images.lifted(), *sums);
            ++sums->sites;
            if (i % std::max(1, sites / kNoiseSites) == 0) {
                const SphereImage again = images.onSurface(1);
                for (int k = 0; k < kPixels; k += kTilts) {
                    const double d = sphere.outgoing(k, image) - sphere.outgoing(k, again);
                    sums->noise[k] += 0.5 * d * d;
                }
                ++sums->noise_sites;
            }
        }
        parts[static_cast<size_t>(chunk)] = std::move(sums);
    });
    Sums& all = *parts.front();
    for (size_t i = 1; i < parts.size(); ++i) {
        all.add(*parts[i]);
    }
    return all;
}

}  // namespace

void studyProjection(const BenchScenes& scenes, int sites, const Output& output) {
    const std::vector<Projection> projections = allProjections();
    const Sphere sphere(kSphereSize);
    std::vector<Sums> sums;
    for (const auto& scene : scenes) {
        sums.push_back(judgeScene(sphere, projections, *scene, sites));
    }
    writeProjectionReport(projections, scenes, sums, output);
}

}  // namespace sheen::bench
