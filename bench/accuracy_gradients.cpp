#include "accuracy_gradients.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "gather/integrate.h"
#include "reference/sobol.h"
#include "sh/brdf_sh.h"
#include "sh/projection.h"

namespace sheen::bench {
namespace gradients {
namespace {

// integrateHemisphere() keeps gradients of the first bands of the matrix it is given: a matrix of
// other rows yields theirs.
class GradientRows {
  public:
    GradientRows(const Hemisphere& hemisphere, int order, int count) : hemisphere_(hemisphere) {
        const std::vector<float> all = projectionMatrix(hemisphere, {.order = order});
        const auto texels = static_cast<size_t>(hemisphere.texelCount());
        for (int first = 0; first < count; first += kHeld) {
            const int start = std::max(0, std::min(first, count - kHeld));
            std::vector<float> rows(kHeld * texels);
            std::copy_n(&all[static_cast<size_t>(start) * texels],
                        static_cast<size_t>(std::min(kHeld, count - start)) * texels, rows.begin());
            matrices_.push_back(std::move(rows));
            firsts_.push_back(start);
        }
        count_ = count;
    }

    // Along both axes, [count]; and irradiance's.
    void gradient(const SeenTexels& texels, float* const c[2], float* const e[2]) const {
        // In the local frame: its normal is z and its tangents are x and y.
        const RecordSite site{.normal = vec3(0, 0, 1), .order = kShGradientOrder};
        const ShLayout layout = shLayout(kShGradientOrder);
        for (size_t i = 0; i < matrices_.size(); ++i) {
            const GatheredRecord r = integrateHemisphere(
                hemisphere_, texels, {.value = matrices_[i], .gradient = matrices_[i]}, site);
            for (int axis = 0; axis < 2; ++axis) {
                *e[axis] = grey(vec3(r.record.translation_r[axis], r.record.translation_g[axis],
                                     r.record.translation_b[axis]));
                for (int k = 0; k < std::min(kHeld, count_ - firsts_[i]); ++k) {
                    float sum = 0.0f;
                    for (int channel = 0; channel < 3; ++channel) {
                        sum += r.sh[layout.gradientFirst(axis) + channel * kHeld + k] / 3.0f;
                    }
                    c[axis][firsts_[i] + k] = sum;
                }
            }
        }
    }

  private:
    static constexpr int kHeld = kShGradientOrder * kShGradientOrder;
    const Hemisphere& hemisphere_;
    std::vector<std::vector<float>> matrices_;
    std::vector<int> firsts_;  // coefficient in each matrix's first row
    int count_ = 0;
};

struct LayoutTools {
    std::unique_ptr<Hemisphere> hemisphere;
    std::vector<GradientRows> rows;  // the first bands of order 10, then fits of order 1, 2, ...

    LayoutTools(const HemisphereParams& params, bool own)
        : hemisphere(std::make_unique<Hemisphere>(makeHemisphere(params))) {
        rows.emplace_back(*hemisphere, kOrder, kJudged);
        for (int n = 1; own && n <= kBands; ++n) {
            rows.emplace_back(*hemisphere, n, n * n);
        }
    }

    Gradient gradient(const SeenTexels& texels) const {
        Gradient g;
        float* const e[] = {&g[0].irradiance, &g[1].irradiance};
        for (size_t n = 0; n < rows.size(); ++n) {
            float* const c[] = {n == 0 ? g[0].c.data() : g[0].own[n].data(),
                                n == 0 ? g[1].c.data() : g[1].own[n].data()};
            rows[n].gradient(texels, c, e);
        }
        return g;
    }
};

// What every site is judged with.
struct Tools {
    Hemisphere fine = makeHemisphere({HemisphereKind::kHemicube, 64, 1.0f});
    std::vector<float> fine_matrix = projectionMatrix(fine, {.order = kOrder});
    std::vector<float> own_matrices[kBands + 1];
    std::vector<LayoutTools> layouts;
    std::vector<std::array<float, kCount>> lobes;

    Tools() {
        for (size_t i = 0; i < kLayoutCount; ++i) {
            layouts.emplace_back(kLayouts[i].params, i == kProgramLayout);
        }
        for (int n = 1; n <= kBands; ++n) {
            own_matrices[n] = projectionMatrix(fine, {.order = n});
        }
        const BrdfRotator rotator(kOrder);
        for (float degrees : kViewDegrees) {
            for (int azimuth = 0; azimuth < kAzimuths; ++azimuth) {
                const float theta = glm::radians(degrees);
                const float phi = 0.5f * kPi * static_cast<float>(azimuth) + 0.3f;
                const vec3 wo(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                              std::cos(theta));
                rotator.rotate(brdfSh(wo.z, std::sqrt(kAlpha)), kMetalF0, 1.0f, vec3(0, 0, 1), wo,
                               lobes.emplace_back().data());
            }
        }
    }

    Light light(const SeenTexels& texels) const {
        std::vector<float> greys(texels.light.size());
        std::transform(texels.light.begin(), texels.light.end(), greys.begin(),
                       [](const vec4& t) { return grey(t); });
        Light l;
        l.irradiance = dotProduct(fine.cosines.data(), greys.data(), greys.size());
        for (size_t k = 0; k < kCount; ++k) {
            l.c[k] = dotProduct(&fine_matrix[k * greys.size()], greys.data(), greys.size());
        }
        for (size_t n = 1; n <= kBands; ++n) {
            for (size_t k = 0; k < n * n; ++k) {
                l.own[n][k] =
                    dotProduct(&own_matrices[n][k * greys.size()], greys.data(), greys.size());
            }
        }
        return l;
    }
};

class SiteJudge {
  public:
    SiteJudge(const Tools& tools, const BenchScene& scene, int index)
        : tools_(tools),
          scene_(scene),
          site_(scene.sites[static_cast<size_t>(index)]),
          frame_(tangentFrame(site_.normal)),
          seed_(hash32(static_cast<uint32_t>(index) + 77u)) {}

    // Nothing where the point cannot be moved along its plane, or is dark.
    std::optional<Judgement> judge() const {
        if (glm::dot(site_.normal, site_.geometric_normal) < kFlat) {
            return {};
        }
        Judgement j;
        const SeenTexels here = trace(tools_.fine, vec2(0.0f), 2, true, 0);
        const float R = distances(here.light, j.kind);
        const Light light = tools_.light(here);
        if (!(R < kInfinity) || light.irradiance <= 0.0f) {
            return {};
        }
        for (int way = 0; way < 4; ++way) {
            if (freeWay(axis(way)) < 1.5f * kStep * R) {
                return {};
            }
        }
        const float scale = 1.0f / light.irradiance;
        j.truth = differences(R, scale, j.half_difference);
        for (size_t i = 0; i < kLayoutCount; ++i) {
            const LayoutTools& layout = tools_.layouts[i];
            SeenTexels texels = trace(*layout.hemisphere, vec2(0.0f), 1, kLayouts[i].random, 1);
            if (!kLayouts[i].planes) {
                texels.planes.clear();
            }
            j.program[i] = layout.gradient(texels);
            for (Light& along : j.program[i]) {
                along = mix(R * scale, along, 0.0f, along);
            }
        }
        for (int way = 0; way < 4; ++way) {
            if (freeWay(axis(way)) > 1.2f * kMove * R) {
                const Light there =
                    tools_.light(trace(tools_.fine, kMove * R * axis(way), 2, true, 2));
                j.moved.push_back(predict(light, there, j, axis(way), scale));
            }
        }
        return j;
    }

  private:
    static vec2 axis(int way) {
        return way % 2 == 0 ? vec2(way == 0 ? 1 : -1, 0) : vec2(0, way == 1 ? 1 : -1);
    }
    // a light + b other.
    static Light mix(float a, const Light& light, float b, const Light& other) {
        Light sum;
        sum.irradiance = a * light.irradiance + b * other.irradiance;
        for (size_t k = 0; k < kCount; ++k) {
            sum.c[k] = a * light.c[k] + b * other.c[k];
        }
        for (size_t n = 1; n <= kBands; ++n) {
            for (size_t k = 0; k < n * n; ++k) {
                sum.own[n][k] = a * light.own[n][k] + b * other.own[n][k];
            }
        }
        return sum;
    }

    SeenTexels trace(const Hemisphere& h, const vec2& move, int side, bool random,
                     uint32_t salt) const {
        const vec3 eye = site_.eye() + frame_[0] * move.x + frame_[1] * move.y;
        return traceTexels(scene_.light, h, frame_, eye,
                           {.side = side,
                            .random = random,
                            .seed = hashCombine(seed_, salt),
                            .above = site_.geometric_normal});
    }
    float freeWay(const vec2& way) const {
        const vec3 direction[] = {frame_[0] * way.x + frame_[1] * way.y};
        vec4 seen;
        scene_.light.cast({.origin = site_.eye(), .directions = direction}, &seen);
        return seen.w > 0.0f ? seen.w : kInfinity;
    }

    // Harmonic mean distance; what kind of place this is.
    float distances(const std::vector<vec4>& texels, Class& kind) const {
        const Hemisphere& h = tools_.fine;
        double inverse = 0.0;
        float nearest = kInfinity;
        for (size_t t = 0; t < texels.size(); ++t) {
            if (texels[t].w > 0.0f) {
                inverse += h.solid_angles[t] / texels[t].w;
                nearest = std::min(nearest, texels[t].w);
            }
        }
        const float R = inverse > 0.0 ? static_cast<float>(2.0 * kPi / inverse) : kInfinity;
        float edges = 0.0f;
        for (const HemisphereWall& wall : h.walls) {
            const auto distance = [&](uint32_t t) {
                return texels[t].w > 0.0f ? texels[t].w : kInfinity;
            };
            const float a = std::min(distance(wall.a), distance(wall.b));
            const float b = std::max(distance(wall.a), distance(wall.b));
            edges += a < R && b > kDepthStep * a ? glm::length(wall.motion) : 0.0f;
        }
        kind = nearest > kNear * R ? kOpen : edges > kEdge ? kOccluder : kCorner;
        return R;
    }

    // The same rays from two points, whose light differs only by where they start.
    Gradient differences(float R, float scale, Gradient& half_difference) const {
        Gradient mean;
        for (int a = 0; a < 2; ++a) {
            Light estimates[2];
            for (int e = 0; e < 2; ++e) {
                const auto salt = static_cast<uint32_t>(10 + e);
                const Light ahead =
                    tools_.light(trace(tools_.fine, kStep * R * axis(a), kStepRays, true, salt));
                const Light behind =
                    tools_.light(trace(tools_.fine, -kStep * R * axis(a), kStepRays, true, salt));
                const float rate = scale / (2.0f * kStep);
                estimates[e] = mix(rate, ahead, -rate, behind);
            }
            mean[static_cast<size_t>(a)] = mix(0.5f, estimates[0], 0.5f, estimates[1]);
            half_difference[static_cast<size_t>(a)] = mix(0.5f, estimates[0], -0.5f, estimates[1]);
        }
        return mean;
    }

    Judgement::Moved predict(const Light& here, const Light& there, const Judgement& j,
                             const vec2& way, float scale) const {
        Judgement::Moved moved{};
        for (int lobe = 0; lobe < kLobes; ++lobe) {
            const float* b = tools_.lobes[static_cast<size_t>(lobe)].data();
            const float still = scale * dotProduct(b, here.c.data(), kCount);
            moved.truth[lobe] = scale * dotProduct(b, there.c.data(), kCount);
            for (int n = 0; n <= kBands; ++n) {
                const auto change = [&](const Gradient& g, bool own) {
                    float sum = 0.0f;
                    for (size_t a = 0; a < 2; ++a) {
                        const float* c = own ? g[a].own[n].data() : g[a].c.data();
                        sum += kMove * way[static_cast<int>(a)] *
                               dotProduct(b, c, static_cast<size_t>(n * n));
                    }
                    return sum;
                };
                const Gradient& program = j.program[kProgramLayout];
                moved.predicted[kFirstBands][n][lobe] = still + change(program, false);
                moved.predicted[kOwnFit][n][lobe] = still + change(program, true);
                moved.predicted[kTrueFirstBands][n][lobe] = still + change(j.truth, false);
                moved.predicted[kTrueOwnFit][n][lobe] = still + change(j.truth, true);
            }
        }
        return moved;
    }

    const Tools& tools_;
    const BenchScene& scene_;
    const RecordSite& site_;
    mat3 frame_;
    uint32_t seed_;
};

}  // namespace
}  // namespace gradients

void studyGradients(const BenchScenes& scenes, int sites, const Output& output) {
    using namespace gradients;
    const Tools tools;
    const auto all = scenes.size() * static_cast<size_t>(sites);
    std::vector<std::optional<Judgement>> found(all);
    parallelFor(static_cast<int>(all), [&](int index) {
        const BenchScene& scene = *scenes[static_cast<size_t>(index / sites)];
        found[static_cast<size_t>(index)] = SiteJudge(tools, scene, index % sites).judge();
    });
    std::vector<Judgement> judgements;
    for (size_t i = 0; i < all; ++i) {
        if (found[i]) {
            found[i]->scene = i / static_cast<size_t>(sites);
            judgements.push_back(std::move(*found[i]));
        }
    }
    report(judgements, scenes, output);
}

}  // namespace sheen::bench
