#include "cache/ray_filter.h"

#include <array>
#include <cmath>
#include <vector>

#include "core/parallel.h"

namespace sheen {
namespace {

constexpr float kAnySlope = 1e6f;
struct Window {
    float pixels;
    float slope;  // in alpha
};
// Deviations of the Gaussian windows, in pixels; 0: the pixel alone.
constexpr std::array<Window, 7> kWindows = {
    Window{0.0f, 0.0f}, {0.0f, 1.0f},   {1.0f, kAnySlope}, {2.0f, kAnySlope},
    {4.0f, kAnySlope},  {4.0f, 0.125f}, {4.0f, 0.25f}};
constexpr int kFar = 8;         // the widest one ends here, and looks at every second pixel
constexpr float kJudge = 4.0f;  // deviation of the window in which widths are judged
constexpr int kBlend = 2;       // pixels over which one width passes into another
// Pixels take no part across a step of more footprints than this off the tangent plane.
constexpr float kOffPlane = 3.0f;
// Of a feature's variance: keeps fits to few pixels from following their noise.
constexpr float kLeastPixels = 4.0f;
constexpr float kRidge = 1e-3f;

float gaussian(const ivec2& d, float deviation) {
    return std::exp(-0.5f * static_cast<float>(d.x * d.x + d.y * d.y) / (deviation * deviation));
}

// Two fits, to the halves of the rays, at each width.
struct Fits {
    std::array<std::array<vec3, kWindows.size()>, 2> light;
    std::array<float, kWindows.size()> error2;  // of each width, but for what all have in common
};

class Filter {
  public:
    Filter(const GBuffer& gbuffer, const PixelClasses& classes, const NoisyLight& light)
        : gbuffer_(gbuffer), classes_(classes), light_(light) {
        index_ = Image<int>(gbuffer.width, gbuffer.height, -1);
        for (size_t i = 0; i < index_.pixels.size(); ++i) {
            if (classes.by_rays.pixels[i] != 0) {
                index_.pixels[i] = static_cast<int>(pixels_.size());
                pixels_.emplace_back(i % static_cast<size_t>(gbuffer.width),
                                     i / static_cast<size_t>(gbuffer.width));
            }
        }
        fits_.resize(pixels_.size());
        chosen_.resize(pixels_.size());
    }

    Image<vec3> run() {
        forEach([&](size_t i) { fit(i); });
        forEach([&](size_t i) { chosen_[i] = choose(pixels_[i]); });
        Image<vec3> filtered(gbuffer_.width, gbuffer_.height);
        forEach([&](size_t i) { filtered.at(pixels_[i].x, pixels_[i].y) = blended(i); });
        return filtered;
    }

  private:
    template <class F>
    void forEach(const F& body) const {
        constexpr int kGrain = 256;
        parallelFor(
            static_cast<int>(pixels_.size()), [&](int i) { body(static_cast<size_t>(i)); }, kGrain);
    }

    // Calls visit(offset, place) for the pixels that take part around one, of every `step`-th.
    template <class F>
    void forAlike(const ivec2& own, int reach, int step, const F& visit) const {
        const vec3 p(gbuffer_.position.at(own.x, own.y));
        const vec3 n(gbuffer_.normal.at(own.x, own.y));
        const float step_height =
            kOffPlane * gbuffer_.pixel_angle * gbuffer_.position.at(own.x, own.y).w;
        for (int dy = -reach; dy <= reach; dy += step) {
            for (int dx = -reach; dx <= reach; dx += step) {
                const ivec2 at = own + ivec2(dx, dy);
                if (at.x < 0 || at.y < 0 || at.x >= gbuffer_.width || at.y >= gbuffer_.height ||
                    index_.at(at.x, at.y) < 0 ||
                    classes_.materials.at(at.x, at.y) != classes_.materials.at(own.x, own.y) ||
                    classes_.isCorrected(at.x, at.y) != classes_.isCorrected(own.x, own.y)) {
                    continue;
                }
                const vec3 offset = vec3(gbuffer_.position.at(at.x, at.y)) - p;
                if (std::abs(glm::dot(offset, n)) <= step_height && finiteAt(at)) {
                    visit(ivec2(dx, dy), at);
                }
            }
        }
    }
    // What is no number, compose() counts at one pixel; none around is to suffer from it.
    bool finiteAt(const ivec2& at) const {
        const vec3 sum = light_.halves[0].at(at.x, at.y) + light_.halves[1].at(at.x, at.y);
        return std::isfinite(sum.x + sum.y + sum.z);
    }

    // By how many alpha the slope of the microfacet that would show, at `own`, what `at` mirrors
    // differs from the surface's. Half vectors' slopes have GGX's width alpha however narrow
    // grazing views make the lobe. What is mirrored lies at the distance found [Zhd21].
    float slope(const ivec2& own, const ivec2& at) const {
        const vec3 p(gbuffer_.position.at(own.x, own.y));
        const vec4 normal = gbuffer_.normal.at(own.x, own.y);
        const vec3 n(normal);
        const vec3 q(gbuffer_.position.at(at.x, at.y));
        const vec3 wo = glm::normalize(gbuffer_.view.origin - p);
        const vec3 mirrored = glm::reflect(glm::normalize(q - gbuffer_.view.origin),
                                           vec3(gbuffer_.normal.at(at.x, at.y)));
        const float nearness =
            std::max(light_.nearness.at(at.x, at.y), light_.nearness.at(own.x, own.y));
        const vec3 h = wo + glm::normalize(mirrored + (q - p) * nearness);
        const float NoH = std::max(glm::dot(h, n), 1e-6f);
        const float slope = glm::length(h - NoH * n) / (NoH * shared::alphaFromRoughness(normal.w));
        return slope < kAnySlope ? slope : 10.0f;
    }

    void fit(size_t i);
    size_t choose(const ivec2& own) const;
    vec3 blended(size_t i) const;

    const GBuffer& gbuffer_;
    const PixelClasses& classes_;
    const NoisyLight& light_;
    Image<int> index_;  // into pixels_, -1: not by rays
    std::vector<ivec2> pixels_;
    std::vector<Fits> fits_;
    std::vector<size_t> chosen_;  // width
};

struct Neighbour {
    vec3 features;  // x, y, guide, from those of the pixel that is fitted
    vec3 light[2];
    float weight;
};

// The least-squares fit of light by a constant and the features, at features of zero. It is linear
// in the light: the weights of a mean, tilted.
void fitAtZero(std::span<const Neighbour> around, vec3* fitted) {
    float all = 0.0f;
    float squares = 0.0f;
    vec3 mean(0.0f);
    mat3 square(0.0f);
    for (const Neighbour& n : around) {
        all += n.weight;
        squares += n.weight * n.weight;
        mean += n.weight * n.features;
        square += glm::outerProduct(n.weight * n.features, n.features);
    }
    mean /= all;
    // In units of the features' deviations, of which one may be that of a few pixels' rounding.
    const mat3 variance = square / all - glm::outerProduct(mean, mean);
    vec3 scale(0.0f);
    for (int k = 0; k < 3; ++k) {
        scale[k] = all * all > kLeastPixels * squares && variance[k][k] > 1e-4f * square[k][k] / all
                       ? 1.0f / std::sqrt(variance[k][k])
                       : 0.0f;
    }
    mat3 correlation(0.0f);
    for (int k = 0; k < 3; ++k) {
        correlation[k] = scale * scale[k] * variance[k];
        static const float K = getenv("KK") ? atof(getenv("KK")) : 1.0f;
        correlation[k][k] = 1.0f + kRidge + K * squares / (all * all);
    }
    const vec3 tilt = -scale * (glm::inverse(correlation) * (scale * mean));
    fitted[0] = fitted[1] = vec3(0.0f);
    for (const Neighbour& n : around) {
        const float share = n.weight / all * (1.0f + glm::dot(tilt, n.features - mean));
        fitted[0] += share * n.light[0];
        fitted[1] += share * n.light[1];
    }
}

void Filter::fit(size_t i) {
    const ivec2 own = pixels_[i];
    Fits& fits = fits_[i];
    const vec3 seen[2] = {light_.halves[0].at(own.x, own.y), light_.halves[1].at(own.x, own.y)};
    const float guide = luminance(light_.guide.at(own.x, own.y));
    std::vector<Neighbour> around;
    std::vector<vec2> offsets;  // slope, weight by pixels
    forAlike(own, kFar, 1, [&](const ivec2& d, const ivec2& at) {
        around.push_back(
            {.features = vec3(d, luminance(light_.guide.at(at.x, at.y)) - guide),
             .light = {light_.halves[0].at(at.x, at.y), light_.halves[1].at(at.x, at.y)},
             .weight = 0.0f});
        offsets.emplace_back(slope(own, at), static_cast<float>(d.x * d.x + d.y * d.y));
    });
    for (size_t w = 0; w < kWindows.size(); ++w) {
        vec3 fitted[2] = {seen[0], seen[1]};
        if (w == 0) {
            fitted[0] = fitted[1] = light_.guide.at(own.x, own.y);
        }
        if (w > 1 && !around.empty()) {
            for (size_t k = 0; k < around.size(); ++k) {
                const float s = offsets[k].x / kWindows[w].slope;
                around[k].weight = std::exp(
                    -0.5f * (s * s + offsets[k].y / (kWindows[w].pixels * kWindows[w].pixels)));
            }
            fitAtZero(around, fitted);
        }
        // Each half's fit against the other half: its error and the other's noise. Both together
        // have half of the noise.
        const float a = luminance(fitted[0] - seen[1]);
        const float b = luminance(fitted[1] - seen[0]);
        const float both = luminance(fitted[0] - fitted[1]);
        fits.error2[w] = 0.5f * (a * a + b * b) - 0.25f * both * both;
        fits.light[0][w] = fitted[0];
        fits.light[1][w] = fitted[1];
    }
}

size_t Filter::choose(const ivec2& own) const {
    if (getenv("FW"))
        return static_cast<size_t>(atoi(getenv("FW")));
    std::array<float, kWindows.size()> error2{};
    forAlike(own, kFar, 2, [&](const ivec2& d, const ivec2& at) {
        const Fits& fits = fits_[static_cast<size_t>(index_.at(at.x, at.y))];
        const float weight = gaussian(d, kJudge);
        for (size_t w = 0; w < kWindows.size(); ++w) {
            error2[w] += weight * fits.error2[w];
        }
    });
    return static_cast<size_t>(std::min_element(error2.begin(), error2.end()) - error2.begin());
}

vec3 Filter::blended(size_t i) const {
    std::array<float, kWindows.size()> weights{};
    float all = 0.0f;
    forAlike(pixels_[i], kBlend, 1, [&](const ivec2&, const ivec2& at) {
        weights[chosen_[static_cast<size_t>(index_.at(at.x, at.y))]] += 1.0f;
        all += 1.0f;
    });
    const Fits& fits = fits_[i];
    vec3 light(0.0f);
    for (size_t w = 0; w < kWindows.size(); ++w) {
        if (weights[w] > 0.0f) {
            light += weights[w] / all * 0.5f * (fits.light[0][w] + fits.light[1][w]);
        }
    }
    return all > 0.0f ? light : 0.5f * (fits.light[0][0] + fits.light[1][0]);
}

}  // namespace

Image<vec3> filterLight(const GBuffer& gbuffer, const PixelClasses& classes,
                        const NoisyLight& light) {
    return Filter(gbuffer, classes, light).run();
}

}  // namespace sheen
