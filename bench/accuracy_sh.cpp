#include "accuracy_sh.h"

#include <algorithm>

#include "core/parallel.h"
#include "reference/sobol.h"
#include "sh/projection.h"

namespace sheen::bench {
namespace {

constexpr int kSphereSize = 64;   // texels along a side of the image's hemicube
constexpr int kRaysPerSide = 2;   // squared: rays a texel
constexpr int kChunk = 16;        // sites a task sums up
constexpr int kNoiseSites = 64;   // a scene, whose images are traced twice
constexpr int kRingHeights = 16;  // directions that are looked at for negative light
constexpr int kRingAzimuths = 40;
constexpr int kCount = shared::SH_MAX_COEFFICIENTS;

struct Coefficients {
    float c[kCount] = {};

    void add(const shared::ShVector& y, float weight) {
        for (int k = 0; k < kCount; ++k) {
            c[k] += weight * y.c[k];
        }
    }
};

shared::ShVector basis(const vec3& d) { return shared::shBasis(d, shared::SH_MAX_ORDER); }

vec3 viewer(int view) {
    const float theta = glm::radians(kViewDegrees[view]);
    return {std::sin(theta), 0.0f, std::cos(theta)};
}

// What of a radiance image, by texels, gives the true outgoing light of each lobe, and what gives
// its coefficients.
class Sphere {
  public:
    Sphere() : upper_(makeHemisphere({HemisphereKind::kHemicube, kSphereSize, 1.0f})) {
        std::vector<std::vector<FootprintSample>> footprints;
        for (int t = 0; t < upper_.texelCount(); ++t) {
            footprints.push_back(footprint(upper_, t));
        }
        integrateBasis(footprints);
        integrateLobes(footprints);
        for (int order = kMinOrder; order <= shared::SH_MAX_ORDER; ++order) {
            program_[order - kMinOrder] = projectionMatrix(upper_, {.order = order});
        }
        for (int i = 0; i < kRingHeights; ++i) {
            const float z = (static_cast<float>(i) + 0.5f) / kRingHeights;
            const float s = std::sqrt(std::max(0.0f, 1.0f - z * z));
            for (int j = 0; j < kRingAzimuths; ++j) {
                const float phi = 2.0f * kPi * static_cast<float>(j) / kRingAzimuths;
                directions_.emplace_back().add(basis({s * std::cos(phi), s * std::sin(phi), z}),
                                               1.0f);
            }
        }
    }

    const Hemisphere& upper() const { return upper_; }

    float outgoing(int lobe, const std::vector<float>& image) const {
        return dotProduct(&lobes_[static_cast<size_t>(lobe) * image.size()], image.data(),
                          image.size());
    }
    // By the program's fit.
    Coefficients project(int order, const std::vector<float>& image) const {
        return times(program_[order - kMinOrder], order * order, image);
    }
    // Of the image and its mirror image below the horizon.
    Coefficients mirrored(const std::vector<float>& image) const {
        Coefficients c = times(basis_, kCount, image);
        for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
            for (int m = -l; m <= l; ++m) {
                c.c[shared::shIndex(l, m)] *= (l + m) % 2 != 0 ? 0.0f : 2.0f;
            }
        }
        return c;
    }
    float convolved(int lobe, int order, const Coefficients& c) const {
        return dotProduct(c.c, lobe_sh_[lobe].c, static_cast<size_t>(order * order));
    }
    // Whether a fit is negative in some direction of the hemisphere.
    bool negative(int order, const Coefficients& c) const {
        return std::any_of(directions_.begin(), directions_.end(), [&](const Coefficients& y) {
            return dotProduct(y.c, c.c, static_cast<size_t>(order * order)) < 0.0f;
        });
    }

  private:
    using Footprints = std::vector<std::vector<FootprintSample>>;

    static Coefficients times(const std::vector<float>& matrix, int rows,
                              const std::vector<float>& image) {
        Coefficients c;
        for (size_t k = 0; k < static_cast<size_t>(rows); ++k) {
            c.c[k] = dotProduct(&matrix[k * image.size()], image.data(), image.size());
        }
        return c;
    }

    void integrateBasis(const Footprints& footprints) {
        const size_t texels = footprints.size();
        basis_.resize(kCount * texels);
        parallelFor(upper_.texelCount(), [&](int texel) {
            const auto t = static_cast<size_t>(texel);
            Coefficients y;
            for (const FootprintSample& s : footprints[t]) {
                y.add(basis(s.direction), s.solid_angle);
            }
            for (size_t k = 0; k < kCount; ++k) {
                basis_[k * texels + t] = y.c[k];
            }
        });
    }

    void integrateLobes(const Footprints& footprints) {
        const size_t texels = footprints.size();
        lobes_.resize(kLobes * texels);
        parallelFor(kLobes, [&](int lobe) {
            const float alpha = kAlphas[lobe / kViewCount];
            const vec3 wo = viewer(lobe % kViewCount);
            for (size_t t = 0; t < texels; ++t) {
                for (const FootprintSample& s : footprints[t]) {
                    const float value =
                        s.solid_angle * metalLobe(alpha, vec3(0, 0, 1), wo, s.direction);
                    lobes_[static_cast<size_t>(lobe) * texels + t] += value;
                    lobe_sh_[lobe].add(basis(s.direction), value);
                }
            }
        });
    }

    Hemisphere upper_;
    std::vector<float> basis_;             // [coefficient][texel]
    std::vector<float> program_[kOrders];  // likewise
    std::vector<float> lobes_;             // [lobe][texel]
    Coefficients lobe_sh_[kLobes];
    std::vector<Coefficients> directions_;  // the basis where negative() looks
};

// Grey radiance that a site sees, its frame turned at random about the normal: views' azimuths are
// fixed in it.
std::vector<float> imageOf(const Sphere& sphere, const BenchScene& scene, int index,
                           uint32_t salt) {
    const RecordSite& site = scene.sites[static_cast<size_t>(index)];
    const uint32_t seed = hash32(static_cast<uint32_t>(index));
    const float angle = 2.0f * kPi * static_cast<float>(seed >> 8) * 0x1p-24f;
    const float c = std::cos(angle);
    const float s = std::sin(angle);
    const mat3 frame =
        tangentFrame(site.normal) * mat3(vec3(c, s, 0), vec3(-s, c, 0), vec3(0, 0, 1));
    std::vector<float> values;
    for (const vec4& t : traceTexels(scene.light, sphere.upper(), frame, site.eye(),
                                     {.side = kRaysPerSide,
                                     .random = true,
                                     .seed = hashCombine(seed, salt),
                                     .above = site.geometric_normal})
                             .light) {
        values.push_back(grey(t));
    }
    return values;
}

void judge(const Sphere& sphere, const std::vector<float>& image, Sums& sums) {
    float truth[kLobes];
    for (int lobe = 0; lobe < kLobes; ++lobe) {
        truth[lobe] = sphere.outgoing(lobe, image);
        sums.truth[lobe] += truth[lobe];
    }
    for (int order = kMinOrder; order <= shared::SH_MAX_ORDER; ++order) {
        const int n = order - kMinOrder;
        const Coefficients c = sphere.project(order, image);
        sums.negative[n] += sphere.negative(order, c) ? 1 : 0;
        for (int lobe = 0; lobe < kLobes; ++lobe) {
            const double e = sphere.convolved(lobe, order, c) - truth[lobe];
            sums.squares[n][lobe] += e * e;
            sums.negative_light[n][lobe] += e + truth[lobe] < 0.0 ? 1 : 0;
            sums.relative[n][lobe].push_back(static_cast<float>(std::abs(e)) /
                                             std::max(truth[lobe], 1e-20f));
        }
    }
    const Coefficients c = sphere.mirrored(image);
    for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
        const auto size = static_cast<size_t>(2 * l + 1);
        sums.band_power[l] +=
            dotProduct(&c.c[l * l], &c.c[l * l], size) / static_cast<double>(size);
    }
}

Sums judgeScene(const Sphere& sphere, const BenchScene& scene, int sites) {
    const int chunks = (sites + kChunk - 1) / kChunk;
    std::vector<Sums> parts(static_cast<size_t>(chunks));
    parallelFor(chunks, [&](int chunk) {
        Sums& sums = parts[static_cast<size_t>(chunk)];
        for (int i = chunk * kChunk; i < std::min((chunk + 1) * kChunk, sites); ++i) {
            const std::vector<float> image = imageOf(sphere, scene, i, 0);
            judge(sphere, image, sums);
            ++sums.sites;
            if (i % std::max(1, sites / kNoiseSites) == 0) {
                const std::vector<float> again = imageOf(sphere, scene, i, 1);
                for (int lobe = 0; lobe < kLobes; ++lobe) {
                    const double d = sphere.outgoing(lobe, image) - sphere.outgoing(lobe, again);
                    sums.noise[lobe] += 0.5 * d * d;
                }
                ++sums.noise_sites;
            }
        }
    });
    for (size_t i = 1; i < parts.size(); ++i) {
        parts.front().add(parts[i]);
    }
    return std::move(parts.front());
}

}  // namespace

void Sums::add(const Sums& other) {
    for (int n = 0; n < kOrders; ++n) {
        for (int k = 0; k < kLobes; ++k) {
            squares[n][k] += other.squares[n][k];
            negative_light[n][k] += other.negative_light[n][k];
            relative[n][k].insert(relative[n][k].end(), other.relative[n][k].begin(),
                                  other.relative[n][k].end());
        }
        negative[n] += other.negative[n];
    }
    for (int k = 0; k < kLobes; ++k) {
        truth[k] += other.truth[k];
        noise[k] += other.noise[k];
    }
    for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
        band_power[l] += other.band_power[l];
    }
    noise_sites += other.noise_sites;
    sites += other.sites;
}

void studyProjection(const BenchScenes& scenes, int sites, const Output& output) {
    const Sphere sphere;
    std::vector<Sums> sums;
    for (const auto& scene : scenes) {
        sums.push_back(judgeScene(sphere, *scene, sites));
    }
    writeProjectionReport(scenes, sums, output);
}

}  // namespace sheen::bench
