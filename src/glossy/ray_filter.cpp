#include "glossy/ray_filter.h"

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "core/parallel.h"

namespace sheen {
namespace {

// A Gaussian window: its deviations in pixels and, in alpha, in the slope of the lobes' half
// vectors.
struct Window {
    float pixels;
    float slope;
};
constexpr float kAnySlope = 1e6f;
constexpr float kFarSlope = 100.0f;
// From the smoothest on. Before them the records alone, and these with the mean of what rays around
// see more; after them the pixel alone.
constexpr std::array<Window, 5> kWindows = {
    {{4.0f, kAnySlope}, {4.0f, 0.25f}, {2.0f, kAnySlope}, {4.0f, 0.125f}, {1.0f, kAnySlope}}};
constexpr size_t kFits = kWindows.size() + 3;
// Less smooth fits are taken where they err less by this: what both differ by may be noise.
constexpr float kBetter = 0.04f;
constexpr int kFar = 8;         // windows end here, in x and y
constexpr float kJudge = 6.0f;  // deviation of the window in which fits are judged
constexpr int kBlend = 2;       // pixels over which one fit passes into another
// Pixels take no part across a step of more footprints than this off the tangent plane.
constexpr float kOffPlane = 3.0f;
// Fits to fewer pixels are their mean.
constexpr float kLeastPixels = 4.0f;
// Of the mean square: below it a feature's variance is rounding.
constexpr float kLeastVariance = 1e-4f;
// Of a feature's variance: keeps features that vary alike apart.
constexpr float kRidge = 1e-3f;

// What a pixel's light is by each fit, and how far that is wrong.
struct Fits {
    std::array<vec3, kFits> light;
    std::array<float, kFits> error2;  // but for what all have in common
};

class Filter {
  public:
    Filter(const Receivers& receivers, const NoisyLight& light)
        : receivers_(receivers), light_(light) {
        const PixelGrid& image = receivers.image;
        index_ = Image<int>(image.width, image.height, -1);
        for (size_t i = 0; i < index_.pixels.size(); ++i) {
            if (receivers.by_rays[i] != 0) {
                index_.pixels[i] = static_cast<int>(pixels_.size());
                pixels_.emplace_back(i % static_cast<size_t>(image.width),
                                     i / static_cast<size_t>(image.width));
            }
        }
        fits_.resize(pixels_.size());
        chosen_.resize(pixels_.size());
    }

    Image<vec3> run() {
        forEach([&](size_t i) { fit(i); });
        forEach([&](size_t i) { chosen_[i] = choose(pixels_[i]); });
        Image<vec3> filtered(index_.width, index_.height);
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
        const size_t i = indexOf(own);
        const vec3& p = receivers_.positions[i];
        const vec3& n = receivers_.normals[i];
        const float step_height = kOffPlane * receivers_.footprints[i];
        for (int dy = -reach; dy <= reach; dy += step) {
            for (int dx = -reach; dx <= reach; dx += step) {
                const ivec2 at = own + ivec2(dx, dy);
                if (at.x < 0 || at.y < 0 || at.x >= index_.width || at.y >= index_.height ||
                    index_.at(at.x, at.y) < 0) {
                    continue;
                }
                const size_t k = indexOf(at);
                if (receivers_.materials[k] != receivers_.materials[i] ||
                    receivers_.isCorrected(k) != receivers_.isCorrected(i)) {
                    continue;
                }
                const vec3 offset = receivers_.positions[k] - p;
                if (std::abs(glm::dot(offset, n)) <= step_height && finiteAt(at)) {
                    visit(ivec2(dx, dy), at);
                }
            }
        }
    }
    size_t indexOf(const ivec2& at) const { return receivers_.image.index(at.x, at.y); }
    // What is no number, compose() counts at one pixel; none around is to suffer from it.
    bool finiteAt(const ivec2& at) const {
        const vec3 sum = light_.halves[0].at(at.x, at.y) + light_.halves[1].at(at.x, at.y);
        return std::isfinite(sum.x + sum.y + sum.z);
    }

    // By how many alpha the slope of the microfacet that would show, at `own`, what `at` mirrors
    // differs from the surface's. Half vectors' slopes have GGX's width alpha however narrow
    // grazing views make the lobe. What is mirrored lies at the distance found [Zhd21].
    float slope(const ivec2& own, const ivec2& at) const {
        const size_t i = indexOf(own);
        const size_t k = indexOf(at);
        const vec3& p = receivers_.positions[i];
        const vec3& n = receivers_.scatteringNormal(i);
        const vec3& q = receivers_.positions[k];
        const vec3 wo = receivers_.towardViewer(i);
        const vec3 mirrored =
            glm::reflect(glm::normalize(q - receivers_.viewer(k)), receivers_.scatteringNormal(k));
        const float nearness =
            std::max(light_.nearness.at(at.x, at.y), light_.nearness.at(own.x, own.y));
        const vec3 h = wo + glm::normalize(mirrored + (q - p) * nearness);
        const float NoH = std::max(glm::dot(h, n), 1e-6f);
        const float slope = glm::length(h - NoH * n) / (NoH * receivers_.alpha(i));
        return slope < kFarSlope ? slope : kFarSlope;  // also where it is no number
    }

    void fit(size_t i);
    size_t choose(const ivec2& own) const;
    vec3 blended(size_t i) const;

    const Receivers& receivers_;
    const NoisyLight& light_;
    Image<int> index_;  // into pixels_, -1: not by rays
    std::vector<ivec2> pixels_;
    std::vector<Fits> fits_;
    std::vector<size_t> chosen_;  // fit
};

struct Neighbour {
    vec3 features;  // x, y, guide, from those of the pixel that is fitted
    vec3 light[2];
    vec3 guide;
    float pixels2;  // distance, squared
    float slope;
    float weight = 0.0f;
};

// The least-squares fits of both lights by a constant and the features, at features of zero; left
// alone where no one is around. They are linear in the light: a mean, tilted.
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
    if (!(all > 0.0f)) {
        return;
    }
    mean /= all;
    // In units of the features' deviations, of which one may be that of a few pixels' rounding.
    const mat3 variance = square / all - glm::outerProduct(mean, mean);
    const float pixels = all * all / squares;
    vec3 scale(0.0f);
    mat3 correlation(0.0f);
    for (int k = 0; k < 3; ++k) {
        const bool varies = variance[k][k] > kLeastVariance * square[k][k] / all;
        scale[k] = varies && pixels > kLeastPixels ? 1.0f / std::sqrt(variance[k][k]) : 0.0f;
    }
    for (int k = 0; k < 3; ++k) {
        correlation[k] = scale * scale[k] * variance[k];
        correlation[k][k] = 1.0f + kRidge + 1.0f / pixels;
    }
    const vec3 tilt = -scale * (glm::inverse(correlation) * (scale * mean));
    fitted[0] = fitted[1] = vec3(0.0f);
    for (const Neighbour& n : around) {
        const float share = n.weight / all * (1.0f + glm::dot(tilt, n.features - mean));
        fitted[0] += share * n.light[0];
        fitted[1] += share * n.light[1];
    }
}

// The guide, and the mean of what both lights around are more than it.
void addMissed(std::span<const Neighbour> around, const vec3& guide, vec3* fitted) {
    float all = 0.0f;
    vec3 missed[2] = {};
    for (const Neighbour& n : around) {
        all += n.weight;
        missed[0] += n.weight * (n.light[0] - n.guide);
        missed[1] += n.weight * (n.light[1] - n.guide);
    }
    for (int half = 0; half < 2 && all > 0.0f; ++half) {
        fitted[half] = guide + missed[half] / all;
    }
}

void Filter::fit(size_t i) {
    const ivec2 own = pixels_[i];
    const vec3& guide = light_.guide.at(own.x, own.y);
    const vec3 seen[2] = {light_.halves[0].at(own.x, own.y), light_.halves[1].at(own.x, own.y)};
    std::array<Neighbour, (2 * kFar + 1) * (2 * kFar + 1)> all;
    size_t count = 0;
    forAlike(own, kFar, 1, [&](const ivec2& d, const ivec2& at) {
        all[count++] = {.features = vec3(d, luminance(light_.guide.at(at.x, at.y) - guide)),
                        .light = {light_.halves[0].at(at.x, at.y), light_.halves[1].at(at.x, at.y)},
                        .guide = light_.guide.at(at.x, at.y),
                        .pixels2 = static_cast<float>(d.x * d.x + d.y * d.y),
                        .slope = slope(own, at)};
    });
    const std::span<Neighbour> around(all.data(), count);
    Fits& fits = fits_[i];
    // Each half's fit against the other half: its error and the other's noise. Both together have
    // half of the noise.
    const auto keep = [&](size_t which, const vec3& first, const vec3& second) {
        const float a = luminance(first - seen[1]);
        const float b = luminance(second - seen[0]);
        const float apart = luminance(first - second);
        fits.error2[which] = 0.5f * (a * a + b * b) - 0.25f * apart * apart;
        fits.light[which] = 0.5f * (first + second);
    };
    keep(0, guide, guide);
    for (size_t w = 0; w < kWindows.size(); ++w) {
        for (Neighbour& n : around) {
            const float s = n.slope / kWindows[w].slope;
            const float p2 = n.pixels2 / (kWindows[w].pixels * kWindows[w].pixels);
            n.weight = std::exp(-0.5f * (s * s + p2));
        }
        vec3 fitted[2] = {seen[0], seen[1]};
        if (w == 0) {
            addMissed(around, guide, fitted);
            keep(1, fitted[0], fitted[1]);
        }
        fitAtZero(around, fitted);
        keep(w + 2, fitted[0], fitted[1]);
    }
    keep(kFits - 1, seen[0], seen[1]);
}

size_t Filter::choose(const ivec2& own) const {
    std::array<float, kFits> error2{};
    forAlike(own, kFar, 2, [&](const ivec2& d, const ivec2& at) {
        const Fits& fits = fits_[static_cast<size_t>(index_.at(at.x, at.y))];
        const auto square = static_cast<float>(d.x * d.x + d.y * d.y);
        const float weight = std::exp(-0.5f * square / (kJudge * kJudge));
        for (size_t f = 0; f < kFits; ++f) {
            error2[f] += weight * fits.error2[f];
        }
    });
    // Where there are no records' lobes, the fits that tell of these are none.
    const bool corrected = receivers_.isCorrected(indexOf(own));
    size_t best = !corrected ? 2 : error2[1] < error2[0] ? 1 : 0;
    for (size_t f = best + 1; f < kFits; ++f) {
        if (error2[f] < (corrected ? 1.0f - kBetter : 1.0f) * error2[best]) {
            best = f;
        }
    }
    return best;
}

vec3 Filter::blended(size_t i) const {
    const Fits& fits = fits_[i];
    vec3 light(0.0f);
    float all = 0.0f;
    forAlike(pixels_[i], kBlend, 1, [&](const ivec2&, const ivec2& at) {
        light += fits.light[chosen_[static_cast<size_t>(index_.at(at.x, at.y))]];
        all += 1.0f;
    });
    return all > 0.0f ? light / all : fits.light[kFits - 1];
}

}  // namespace

Image<vec3> filterLight(const Receivers& receivers, const NoisyLight& light) {
    return Filter(receivers, light).run();
}

}  // namespace sheen
