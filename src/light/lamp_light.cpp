#include "light/lamp_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/directions.h"
#include "core/parallel.h"
#include "rays/jitter.h"
#include "scene/ggx_sampling.h"

namespace sheen {
namespace {

// A pixel's samples in turn: those after the first where the ones before disagree, here or in
// pixels around. Were only those looked at again that disagree by chance, what they say would be
// biased.
constexpr int kSamples[] = {16, 48, 192};
constexpr int kAround = 2;
constexpr float kDoubt = 0.02f;  // standard error over the mean from which on they disagree
// Open light that they miss, over all of it, from which on they may have missed a lamp.
constexpr float kMissed = 0.25f;

// Lobes wider than this are left to the directions toward lamps, others are followed too.
constexpr float kWideLobe = 0.35f;
// Where lamps fill more than this, steradians, as a luminous ceiling does, directions by the cosine
// are followed besides: the ones toward lamps do not know it.
constexpr float kLargeLamps = 0.6f;
// And where they fill more than this they hide each other, as in a room of glowing walls: what they
// bring without that is of no use.
constexpr float kEverywhere = kPi;
constexpr int kLookSamples = 8;  // that tell how much they fill

// Steps of the R3 sequence, whose points fill a cube evenly, however many there are [Rob18].
constexpr vec3 kSpread(0.8191725f, 0.6710436f, 0.5497005f);

// What a pixel's samples add up to.
struct Sum {
    vec3 light{0.0f};      // radiance, but for the share of `open` that arrives
    float squares = 0.0f;  // of its luminance
    // Where what lamps bring without shadows is known, samples tell which share of it arrives: what
    // they would bring, what they do, and by luminance these and `light` squared and multiplied.
    vec3 open{0.0f}, arriving{0.0f};
    float open2 = 0.0f, arriving2 = 0.0f, both = 0.0f, with_open = 0.0f, with_arriving = 0.0f;
    int count = 0;
    int hidden = 0;  // ways that were not free, to lamps within reach
    int free = 0;
};

// What that says.
struct Answer {
    vec3 light{0.0f};
    bool doubtful = false;  // more samples would tell more
};

class PixelLamps {
  public:
    PixelLamps(const Tracer& tracer, const LampSampler& lamps, const LitPoint& point,
               uint32_t pixel)
        : tracer_(tracer),
          lamps_(lamps),
          point_(point),
          start_(randomPlace(pixel, 0), randomPlace(pixel, 1).x),
          lobe_start_(randomPlace(pixel, 2)),
          frame_(tangentFrame(point.surface.n)),
          wo_(glm::transpose(frame_) * point.side.toward_viewer) {
        const Brdf& brdf = point.surface.brdf;
        lobe_ = brdf.alpha < kWideLobe && luminance(brdf.f0) + brdf.f90 > 0.0f && wo_.z > 0.0f;
        float angle = 0.0f;
        for (uint32_t i = 0; i < kLookSamples; ++i) {
            const vec3 u(randomPlace(pixel, 4 + 2 * i), randomPlace(pixel, 5 + 2 * i).x);
            const auto s = lamps.sample(point.side, point.surface.n, u);
            angle += s ? 1.0f / (s->density * kLookSamples) : 0.0f;
        }
        large_ = angle > kLargeLamps;
        known_ = lamps.plain() && angle < kEverywhere;
        if (known_) {
            open_ = lamps.irradiance(point.side, point.surface.n) * brdf.diffuse / kPi;
            large_ = large_ && brdf.f90 > 0.0f;  // else nothing is left to follow
        }
    }

    // Adds samples first to first + count of the pixel's sequence.
    void add(int first, int count, Sum& sum) const {
        for (int i = first; i < first + count; i += Tracer::kPacket) {
            vec3 light[Tracer::kPacket], open[Tracer::kPacket];
            vec3 shares[Tracer::kPacket];
            addTowardLamps(i, light, open, shares, sum);
            if (lobe_) {
                addFollowed(i, light, [this](const vec2& u) {
                    const vec3 h = sampleGgxVisibleNormal(wo_, point_.surface.brdf.alpha, u);
                    return 2.0f * glm::dot(wo_, h) * h - wo_;
                });
            }
            if (large_) {
                addFollowed(i, light, cosineDirection);
            }
            for (int k = 0; k < Tracer::kPacket; ++k) {
                const float plain = luminance(light[k]), all = luminance(open[k]);
                const float arriving = luminancePassing(shares[k], open[k]);
                sum.light += light[k];
                sum.squares += plain * plain;
                sum.open += open[k];
                sum.arriving += shares[k] * open[k];
                sum.open2 += all * all;
                sum.arriving2 += arriving * arriving;
                sum.both += arriving * all;
                sum.with_open += plain * all;
                sum.with_arriving += plain * arriving;
            }
            sum.count += Tracer::kPacket;
        }
    }

    // Of open light the samples' own, and of what they miss of it, or have too much, the share that
    // arrives of all: what is open is known exactly, and what is hidden adds nothing.
    Answer answer(const Sum& sum) const {
        const auto count = static_cast<float>(sum.count);
        const float open = luminance(sum.open);
        const float share = open > 0.0f ? luminance(sum.arriving) / open : 1.0f;
        const vec3 missed = open_ - sum.open / count;
        Answer result{.light = sum.light / count +
                               glm::max(sum.arriving / count + share * missed, vec3(0.0f))};
        const float squares = sum.squares + 2.0f * (sum.with_arriving - share * sum.with_open) +
                              sum.arriving2 - 2.0f * share * sum.both + share * share * sum.open2;
        const float plain = luminance(sum.light) / count;
        const float variance = std::max(squares / count - plain * plain, 0.0f);
        result.doubtful = (sum.hidden > 0 && sum.free > 0) ||
                          std::sqrt(variance / count) > kDoubt * luminance(result.light) ||
                          luminance(glm::abs(missed)) > kMissed * luminance(open_);
        return result;
    }

  private:
    // And what of it, at each sample, is a share of what is known to arrive where nothing hides it.
    void addTowardLamps(int first, vec3* light, vec3* open, vec3* shares, Sum& sum) const {
        Way ways[Tracer::kPacket];
        bool tells[Tracer::kPacket] = {};
        for (int k = 0; k < Tracer::kPacket; ++k) {
            const vec3 u = glm::fract(start_ + static_cast<float>(first + k) * kSpread);
            light[k] = open[k] = vec3(0.0f);
            const auto s = lamps_.sample(point_.side, point_.surface.n, u);
            if (!s) {
                continue;
            }
            const bool known = known_ && s->within_reach;
            light[k] = over(s->density + followed(s->wi), s->wi, known) * s->radiance;
            ways[k] = s->way;
            tells[k] = s->within_reach && s->way.length > 0.0f;
            if (known) {
                open[k] = diffuse(s->density, s->wi) * s->radiance;
            }
        }
        const Tracer::Shares passing = tracer_.passing(ways);
        for (size_t k = 0; k < Tracer::kPacket; ++k) {
            const bool arrives = passing[k] != vec3(0.0f);
            sum.hidden += tells[k] && !arrives ? 1 : 0;
            sum.free += tells[k] && arrives ? 1 : 0;
            light[k] = arrives ? passing[k] * light[k] : vec3(0.0f);
            shares[k] = passing[k];
        }
    }

    // Adds what lies in directions toward(u) of the normal's frame.
    template <class F>
    void addFollowed(int first, vec3* light, const F& toward) const {
        vec3 directions[Tracer::kPacket];
        int of[Tracer::kPacket];
        size_t count = 0;
        for (int k = 0; k < Tracer::kPacket; ++k) {
            const vec2 u = glm::fract(lobe_start_ + static_cast<float>(first + k) * vec2(kSpread));
            const vec3 wi = toward(u);
            const vec3 direction = glm::normalize(frame_ * wi);
            if (wi.z > 0.0f && glm::dot(direction, point_.side.n_g) > 0.0f) {
                of[count] = k;
                directions[count++] = direction;
            }
        }
        Hit hits[Tracer::kPacket];
        tracer_.meet({.origin = point_.side.start(), .directions = {directions, count}}, hits);
        for (size_t i = 0; i < count; ++i) {
            if (!hits[i].found() || !lamps_.isLamp(hits[i].triangle)) {
                continue;
            }
            const float density =
                followed(directions[i]) +
                lamps_.density(point_.side, point_.surface.n, hits[i], directions[i]);
            if (density > 0.0f) {
                const bool known = known_ && lamps_.withinReach(point_.side, hits[i]);
                light[of[i]] +=
                    over(density, directions[i], known) * hits[i].weight * lamps_.radiance(hits[i]);
            }
        }
    }

    // What is scattered of radiance from a direction, times its cosine, over a density. Of a lobe
    // that is followed by the lobe's own density, as its sampler weighs it: its values themselves
    // are rounded, the more the narrower it is.
    vec3 over(float density, const vec3& wi, bool without_diffuse) const {
        const Brdf& brdf = point_.surface.brdf;
        const float NoL = glm::dot(wi, point_.surface.n);
        if (!lobe_) {
            Scatterer surface = point_.surface;
            surface.brdf.diffuse = without_diffuse ? vec3(0.0f) : brdf.diffuse;
            return scattered(surface, point_.side.toward_viewer,
                             {.wi = wi, .distance = 0.0f, .irradiance = vec3(1.0f / density)});
        }
        const vec3 h = glm::normalize(wi + point_.side.toward_viewer);
        const vec3 fresnel =
            brdf.f0 + (vec3(brdf.f90) - brdf.f0) * shared::schlickWeight(glm::dot(wi, h));
        const float NoV = std::max(wo_.z, shared::MIN_COSINE);
        const vec3 along = fresnel * (visibleNormalWeight(NoV, NoL, brdf.alpha) * lobeDensity(wi));
        if (NoL <= 0.0f) {
            return vec3(0.0f);
        }
        return without_diffuse ? along / density : along / density + diffuse(density, wi);
    }
    vec3 diffuse(float density, const vec3& wi) const {
        return point_.surface.brdf.diffuse *
               (std::max(glm::dot(wi, point_.surface.n), 0.0f) / (kPi * density));
    }

    // The density of all directions that are followed.
    float followed(const vec3& wi) const {
        const float cosine = std::max(glm::dot(wi, point_.surface.n), 0.0f);
        return (lobe_ ? lobeDensity(wi) : 0.0f) + (large_ ? cosine / kPi : 0.0f);
    }

    // Of a direction mirrored at visible normals.
    float lobeDensity(const vec3& wi_world) const {
        const vec3 wi = glm::transpose(frame_) * wi_world;
        const vec3 sum = wi + wo_;
        const float length = glm::length(sum);
        if (wi.z <= 0.0f || length < 1e-6f) {
            return 0.0f;
        }
        const float alpha = point_.surface.brdf.alpha;
        const float NoV = std::max(wo_.z, shared::MIN_COSINE);
        return reflectedDensity(NoV, sum.z / length, alpha);
    }

    const Tracer& tracer_;
    const LampSampler& lamps_;
    const LitPoint& point_;
    vec3 start_;
    vec2 lobe_start_;
    mat3 frame_;
    vec3 wo_;             // in the frame
    vec3 open_{0.0f};     // scattered diffusely if nothing were in the way, where that is known
    bool lobe_ = false;   // followed
    bool large_ = false;  // lamps, so that the cosine is
    bool known_ = false;  // what they bring where nothing is in the way
};

}  // namespace

Image<vec3> lampLight(const Tracer& tracer, const LampSampler& lamps, int width, int height,
                      std::span<const uint32_t> rows_of,
                      const std::function<std::optional<LitPoint>(int x, int y)>& pointAt) {
    const bool image = rows_of.empty();
    const float share = image ? 1.0f : 1.0f / static_cast<float>(width);
    const int rows_around = image ? kAround : 0;
    Image<Sum> sums(width, height);
    Image<vec3> light(width, height);
    Image<uint8_t> doubtful(width, height);
    const auto addTo = [&](int x, int y, int first, int count) {
        if (const std::optional<LitPoint> point = pointAt(x, y)) {
            const uint32_t row = image ? static_cast<uint32_t>(y) : rows_of[static_cast<size_t>(y)];
            const PixelLamps pixel(tracer, lamps, *point,
                                   row * static_cast<uint32_t>(width) + static_cast<uint32_t>(x));
            pixel.add(first, count, sums.at(x, y));
            const Answer answer = pixel.answer(sums.at(x, y));
            light.at(x, y) = answer.light;
            doubtful.at(x, y) = answer.doubtful ? 1 : 0;
        }
    };
    const auto forEach = [&](const auto& body) {
        parallelFor(height, [&](int y) {
            for (int x = 0; x < width; ++x) {
                body(x, y);
            }
        });
    };
    Image<uint8_t> wanted(width, height, 1);
    int first = 0;
    for (const int samples : kSamples) {
        const int packets = static_cast<int>(share * static_cast<float>(samples / Tracer::kPacket));
        const int count = Tracer::kPacket * (first == 0 ? std::max(packets, 1) : packets);
        if (count == 0) {
            continue;
        }
        forEach([&](int x, int y) {
            if (wanted.at(x, y) != 0) {
                addTo(x, y, first, count);
            }
        });
        first += count;
        const Image<uint8_t> before = std::exchange(wanted, Image<uint8_t>(width, height));
        forEach([&](int x, int y) {
            for (int j = std::max(y - rows_around, 0); j <= std::min(y + rows_around, height - 1);
                 ++j) {
                for (int i = std::max(x - kAround, 0); i <= std::min(x + kAround, width - 1); ++i) {
                    wanted.at(x, y) |= before.at(x, y) != 0 && doubtful.at(i, j) != 0 ? 1 : 0;
                }
            }
        });
    }
    return light;
}

}  // namespace sheen
