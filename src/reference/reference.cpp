#include "reference/reference.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "reference/guide.h"
#include "reference/light.h"
#include "reference/sampling.h"
#include "reference/sobol.h"

namespace sheen {
namespace {

using glm::dvec3;

// Of the guide's paths; those of replicates are their index.
constexpr uint32_t kGuideSeed = 0xffffffffu;

// Sizes of the guide's grid. Measured on glossy interiors, variance times CPU time: 16 x 16 from
// 1.4 to 3 times better than 8 x 8 at 256 paths; 8 x 8 at 64 paths no better than none.
constexpr int kSmallestGuide = 16;
constexpr int kLargestGuide = 64;

// Of the directions toward lamps and sky chosen at a path's vertices, and of direct light.
constexpr uint32_t kLampSeed = 0x6c616d70u;
constexpr uint32_t kSkySeed = 0x736b7900u;
constexpr uint32_t kDirectSeed = 0x64697265u;

// Of the places in a pixel that paths see, where they see all of it.
constexpr uint32_t kPlaceSeed = 0x706c6163u;
constexpr uint32_t kPartSeed = 0x70617274u;

// Of all bounces these are always followed; then a path goes on with the chance that is the
// brightest of what its channels have left, but never surely, so that it ends in white rooms too.
constexpr int kSureBounces = 3;
constexpr float kLikeliest = 0.95f;
constexpr uint32_t kRouletteSeed = 0x726f756cu;

// Where a path starts: the point it leaves and how it leaves it.
struct Start {
    Surface p;
    BrdfSampler sampler;

    explicit Start(const Surface& surface)
        : p(surface),
          sampler(surface.brdf, surface.specular_albedo, surface.n, surface.wo, surface.coat) {}
};

struct Context {
    const RayScene& rays;
    const Lights& lights;
    const ReferenceParams& params;
    int samples_per_replicate;
    int guide_size;  // cells along a side; 0: no guide
    // Of the image that the frame may be a part of: a place there is the same digits.
    Camera whole_camera;
    ivec2 whole_size;
};

// What a path of a pixel starts from.
struct PathStart {
    std::optional<Start> start;  // none where no surface is seen
    // Of all that is seen there.
    vec3 emission{0.0f};
    float coverage = 0.0f;
};

// Where a pixel's paths start: all on one of the surfaces that its middle sees, or each at a place
// of its own in the pixel's area, on one of those that are seen there.
class Pixel {
  public:
    Pixel(const Context& context, int x, int y)
        : context_(context),
          x_(x),
          y_(y),
          in_whole_(ivec2(x, y) + context.params.camera.window.first),
          seed_(hashCombine(
              hashCombine(hash32(context_.params.seed), static_cast<uint32_t>(in_whole_.x)),
              static_cast<uint32_t>(in_whole_.y))) {}

    // On a surface that the middle sees, other paths than before: what they bring counts by its
    // share.
    void startFrom(const Surface& surface, float share) {
        if (on_.start) {
            seed_ = hash32(seed_);
        }
        on_.start.emplace(surface);
        share_ = share;
    }

    int x() const { return x_; }
    int y() const { return y_; }
    uint32_t seed() const { return seed_; }
    float share() const { return share_; }
    PathStart start(uint32_t index, uint32_t seed, Counters& counters) const {
        const ReferenceParams& params = context_.params;
        if (!params.pixel_area) {
            return on_;
        }
        const vec2 place = owenSobol(index, hashCombine(seed, kPlaceSeed)) - 0.5f;
        float u = owenSobol(index, hashCombine(seed, kPartSeed)).x;
        PathStart from{.start = {}, .coverage = 1.0f};
        // One of the surfaces, by its share of the light.
        for (const Sighting& part : look(context_.rays, context_.whole_camera, context_.whole_size,
                                         vec2(in_whole_) + place, Textures::kOfPlace, counters)) {
            from.emission += part.share * part.emission;
            if (!part.surface) {
                from.coverage = 1.0f - part.share;
                break;
            }
            if (u >= 0.0f && u < part.share) {
                from.start.emplace(*part.surface);
            }
            u -= part.share;
        }
        return from;
    }

  private:
    const Context& context_;
    int x_, y_;
    ivec2 in_whole_;  // of the image that the frame may be a part of
    uint32_t seed_;
    float share_ = 1.0f;
    PathStart on_;
};

// What lights of all kinds send from a path's vertex, but for the half of lamps and sky that the
// path's next ray finds.
vec3 lightAtVertex(const Context& context, const Surface& q, const BrdfSampler& sampler,
                   uint32_t index, uint32_t seed, Counters& counters) {
    const RayScene& rays = context.rays;
    const Lights& lights = context.lights;
    vec3 radiance = directRadiance(rays, q, counters);
    if (!lights.lamps.empty()) {
        const LightChoice lamp =
            lights.lamps.choose(q.rayOrigin(), owenSobol(index, hashCombine(seed, kLampSeed)));
        radiance += scatterChosen(rays, q, sampler, lamp, counters).all;
    }
    if (!lights.sky.empty()) {
        const LightChoice sky =
            lights.sky.choose(q.rayOrigin(), owenSobol(index, hashCombine(seed, kSkySeed)));
        radiance += scatterChosen(rays, q, sampler, sky, counters).all;
    }
    return radiance;
}

// Radiance that a path brings to its start from where it goes by `first`. Lamps that the first ray
// meets are direct light and do not count.
vec3 followPath(const Context& context, const Surface& start, const DirectionSample& first,
                uint32_t index, uint32_t seed, Counters& counters) {
    const RayScene& rays = context.rays;
    const int bounces = context.params.bounces;
    Surface from = start;
    vec3 wi = first.wi;
    float pdf = first.pdf;
    vec3 throughput(1.0f);
    vec3 radiance(0.0f);
    for (int bounce = 1; opensToward(from, wi); ++bounce) {
        const RayHit hit = nextHit(rays, from, wi, counters);
        if (!hit.found()) {
            radiance += throughput * skyMet(context.lights, wi, pdf);
            break;
        }
        const Surface q = rays.surfaceAt(hit, -wi);
        if (bounce > 1) {
            radiance +=
                throughput * lampMet(context.lights, q, hit.triangle, from.rayOrigin(), pdf);
        }
        if (bounce > bounces) {
            break;
        }
        const BrdfSampler sampler(q.brdf, q.specular_albedo, q.n, q.wo, q.coat);
        const uint32_t bounce_seed = hashCombine(seed, static_cast<uint32_t>(bounce));
        radiance += throughput * lightAtVertex(context, q, sampler, index, bounce_seed, counters);
        // The last vertex needs one more ray where that may find a lamp or the sky.
        if (bounce == bounces && context.lights.empty()) {
            break;
        }

        // Continue the path from q.
        const DirectionSample next =
            sampleBrdf(sampler, q.brdf, q.n, q.wo, owenSobol(index, bounce_seed));
        if (black(next.weight)) {
            break;
        }
        throughput *= next.weight;
        if (bounces == kAllBounces && bounce > kSureBounces) {
            const float chance =
                std::min(std::max({throughput.x, throughput.y, throughput.z}), kLikeliest);
            // So that a path of no number ends too.
            if (!(owenSobol(index, hashCombine(bounce_seed, kRouletteSeed)).x < chance)) {
                break;
            }
            throughput /= chance;
        }
        wi = next.wi;
        pdf = next.pdf;
        from = q;
    }
    return radiance;
}

// One sample of the indirect light that arrives in directions chosen by the BRDF.
Scattered samplePath(const Context& context, const Start& start, const Guide& guide, uint32_t index,
                     uint32_t seed, Counters& counters) {
    const Surface& p = start.p;
    const GuidedPoint guided = guide.warp(owenSobol(index, seed));
    const DirectionSample first = sampleBrdf(start.sampler, p.brdf, p.n, p.wo, guided.u);
    if (context.params.bounces == 0 || black(first.weight)) {
        return {};
    }
    vec3 radiance = followPath(context, p, first, index, seed, counters);
    radiance *= guided.weight;
    return {.all = first.weight * radiance, .diffuse = first.diffuse * radiance};
}

// And of what of the sky's light the other half of the estimate brings: by directions toward it.
// (Weights of both halves are those of plain BRDF samples: they add up to one whatever the guide.)
Scattered sampleSkyFromStart(const Context& context, const Start& start, uint32_t index,
                             uint32_t seed, Counters& counters) {
    if (context.params.bounces == 0 || context.lights.sky.empty()) {
        return {};
    }
    const LightChoice choice = context.lights.sky.choose(
        start.p.rayOrigin(), owenSobol(index, hashCombine(seed, kSkySeed)));
    return scatterChosen(context.rays, start.p, start.sampler, choice, counters);
}

// Mean and variance of the mean of independent, equally good estimates.
struct Replicates {
    int count = 0;
    dvec3 mean{0.0};
    dvec3 squares{0.0};  // sum of squared deviations from the mean [Wel62]

    void add(const dvec3& value) {
        ++count;
        const dvec3 delta = value - mean;
        mean += delta / static_cast<double>(count);
        squares += delta * (value - mean);
    }
    vec3 varianceOfMean() const {
        return vec3(squares / (static_cast<double>(count) * (count - 1)));
    }
};

// A guide from one sample a cell, sample(index, u) its radiance: an aligned block of 4^k Sobol
// points has one in each.
template <class Sample>
Guide learnGuide(int size, uint32_t seed, const Sample& sample) {
    if (size == 0) {
        return {};
    }
    std::vector<float> contributions(static_cast<size_t>(size) * static_cast<size_t>(size));
    for (uint32_t i = 0; i < contributions.size(); ++i) {
        const vec2 u = owenSobol(i, seed);
        const vec3 radiance = sample(i, u);
        const float sum = radiance.x + radiance.y + radiance.z;
        const auto column = static_cast<size_t>(u.x * static_cast<float>(size));
        const auto row = static_cast<size_t>(u.y * static_cast<float>(size));
        contributions[row * static_cast<size_t>(size) + column] = std::isfinite(sum) ? sum : 0.0f;
    }
    return Guide(size, contributions);
}

void estimateIndirect(const Context& context, const Pixel& pixel, Frame& frame,
                      Counters& counters) {
    const ReferenceParams& params = context.params;
    const uint32_t guide_seed = hashCombine(pixel.seed(), kGuideSeed);
    const Guide guide = learnGuide(context.guide_size, guide_seed, [&](uint32_t i, const vec2&) {
        const PathStart from = pixel.start(i, guide_seed, counters);
        return from.start ? samplePath(context, *from.start, {}, i, guide_seed, counters).all
                          : vec3(0.0f);
    });
    Replicates all, diffuse;
    for (int replicate = 0; replicate < params.replicates; ++replicate) {
        const uint32_t seed = hashCombine(pixel.seed(), static_cast<uint32_t>(replicate));
        dvec3 all_sum(0.0), diffuse_sum(0.0);
        for (int i = 0; i < context.samples_per_replicate; ++i) {
            const auto index = static_cast<uint32_t>(i);
            const PathStart from = pixel.start(index, seed, counters);
            if (!from.start) {
                continue;
            }
            Scattered sample = samplePath(context, *from.start, guide, index, seed, counters);
            sample.add(sampleSkyFromStart(context, *from.start, index, seed, counters));
            if (!finite(sample.all) || !finite(sample.diffuse)) {
                ++counters.nonfinite;
                continue;
            }
            all_sum += dvec3(sample.all);
            diffuse_sum += dvec3(sample.diffuse);
        }
        const double samples = context.samples_per_replicate;
        all.add(all_sum / samples);
        diffuse.add(diffuse_sum / samples);
    }
    const float share = pixel.share();
    frame.indirect.at(pixel.x(), pixel.y()) += share * vec3(all.mean);
    frame.indirect_variance.at(pixel.x(), pixel.y()) += share * share * all.varianceOfMean();
    frame.indirect_diffuse.at(pixel.x(), pixel.y()) += share * vec3(diffuse.mean);
    frame.indirect_diffuse_variance.at(pixel.x(), pixel.y()) +=
        share * share * diffuse.varianceOfMean();
}

// A guide of where on the lamps the light of a pixel comes from: not from their backs, nor from
// those that are far off or hidden.
Guide learnLamps(const Context& context, const Pixel& pixel, uint32_t seed, Counters& counters) {
    if (context.lights.lamps.empty()) {
        return {};
    }
    return learnGuide(context.guide_size, seed, [&](uint32_t i, const vec2& u) {
        const std::optional<Start> start = pixel.start(i, seed, counters).start;
        if (!start) {
            return vec3(0.0f);
        }
        const LightChoice lamp = context.lights.lamps.choose(start->p.rayOrigin(), u);
        return scatterChosen(context.rays, start->p, start->sampler, lamp, counters).all;
    });
}

// One sample of the light that lamps send to a path's start, and of punctual lights' where that is
// not known.
vec3 sampleDirect(const Context& context, const Start& start, const Guide& guide, uint32_t index,
                  uint32_t seed, Counters& counters) {
    const Lamps& lamps = context.lights.lamps;
    vec3 sample(0.0f);
    if (context.params.pixel_area) {
        sample += directRadiance(context.rays, start.p, counters);
    }
    if (!lamps.empty()) {
        const GuidedPoint guided = guide.warp(owenSobol(index, hashCombine(seed, kLampSeed)));
        const LightChoice lamp = lamps.choose(start.p.rayOrigin(), guided.u);
        sample += guided.weight *
                      scatterChosen(context.rays, start.p, start.sampler, lamp, counters).all +
                  lampsByBrdf(context.rays, context.lights, start.p, start.sampler,
                              owenSobol(index, seed), counters);
    }
    return sample;
}

// Adds the lamps' light to that of punctual lights, which at a pixel's middle has no variance; of
// its area, adds both, and what is emitted there and how much of it is covered.
void estimateDirect(const Context& context, const Pixel& pixel, Frame& frame, Counters& counters) {
    const uint32_t direct_seed = hashCombine(pixel.seed(), kDirectSeed);
    const Guide guide = learnLamps(context, pixel, hashCombine(direct_seed, kGuideSeed), counters);
    Replicates direct;
    dvec3 emission(0.0);
    double covered = 0.0;
    for (int replicate = 0; replicate < context.params.replicates; ++replicate) {
        const uint32_t seed = hashCombine(direct_seed, static_cast<uint32_t>(replicate));
        dvec3 sum(0.0);
        for (int i = 0; i < context.samples_per_replicate; ++i) {
            const auto index = static_cast<uint32_t>(i);
            const PathStart from = pixel.start(index, seed, counters);
            emission += dvec3(from.emission);
            covered += from.coverage;
            if (!from.start) {
                continue;
            }
            const vec3 sample = sampleDirect(context, *from.start, guide, index, seed, counters);
            if (finite(sample)) {
                sum += dvec3(sample);
            } else {
                ++counters.nonfinite;
            }
        }
        direct.add(sum / static_cast<double>(context.samples_per_replicate));
    }
    const float share = pixel.share();
    frame.direct.at(pixel.x(), pixel.y()) += share * vec3(direct.mean);
    frame.direct_variance.at(pixel.x(), pixel.y()) += share * share * direct.varianceOfMean();
    if (context.params.pixel_area) {
        const double all = context.samples_per_replicate * context.params.replicates;
        frame.emission.at(pixel.x(), pixel.y()) = vec3(emission / all);
        frame.coverage.at(pixel.x(), pixel.y()) = static_cast<float>(covered / all);
    }
}

void renderPixel(const Context& context, int x, int y, ReferenceResult& result,
                 Counters& counters) {
    const ReferenceParams& params = context.params;
    Pixel pixel(context, x, y);
    const auto estimate = [&] {
        if (!context.lights.lamps.empty() || params.pixel_area) {
            estimateDirect(context, pixel, result.frame, counters);
        }
        estimateIndirect(context, pixel, result.frame, counters);
    };
    const std::vector<Sighting> parts =
        look(context.rays, params.camera, {params.width, params.height}, vec2(x, y),
             Textures::kOfPixel, counters);
    // What lies behind panes or, where that is nothing, the nearest of them.
    const Sighting& shown = parts.back().surface ? parts.back() : parts.front();
    if (shown.surface) {
        setGBuffer(params.camera, shown, x, y, result.frame);
        result.specular_albedo.at(x, y) =
            shown.surface->specular_albedo +
            (shown.surface->coat ? shown.surface->coat->albedo : 0.0f);
    }
    if (params.pixel_area) {
        estimate();
        return;
    }
    for (const Sighting& part : parts) {
        addLight(context.rays, part, x, y, result.frame, counters);
        if (part.surface) {
            pixel.startFrom(*part.surface, part.share);
            estimate();
        } else if (!result.frame.coverage.empty()) {
            result.frame.coverage.at(x, y) = 1.0f - part.share;
        }
    }
}

void checkParams(const ReferenceParams& params) {
    if (params.width < 1 || params.height < 1) {
        throwUsage("image size {}x{}: both must be at least 1", params.width, params.height);
    }
    if (params.spp < 1) {
        throwUsage("--spp {}: must be at least 1", params.spp);
    }
    if (params.bounces < 0) {
        throwUsage("--bounces {}: must not be negative", params.bounces);
    }
    SHEEN_CHECK(params.replicates >= 2);
}

// The largest grid that is taught by at most as many paths as make the estimate.
int guideSize(const ReferenceParams& params) {
    int size = 0;
    for (int next = kSmallestGuide; next <= kLargestGuide; next *= 2) {
        if (next * next <= params.spp) {
            size = next;
        }
    }
    return params.bounces > 0 ? size : 0;
}

}  // namespace

ReferenceResult renderReference(const Scene& scene, const ReferenceParams& params) {
    checkParams(params);
    const Timer timer;
    const RayScene rays(scene);
    const Lights lights(scene);
    Camera whole_camera = params.camera;
    whole_camera.window = {};
    const Context context{
        .rays = rays,
        .lights = lights,
        .params = params,
        .samples_per_replicate = (params.spp + params.replicates - 1) / params.replicates,
        .guide_size = guideSize(params),
        .whole_camera = whole_camera,
        .whole_size = params.camera.wholeSize({params.width, params.height})};

    ReferenceResult result;
    result.spp = context.samples_per_replicate * params.replicates;
    result.frame = emptyFrame(params.width, params.height);
    for (Image<vec3>* layer :
         {&result.frame.indirect_variance, &result.frame.indirect_diffuse_variance,
          &result.frame.direct_variance, &result.specular_albedo}) {
        *layer = Image<vec3>(params.width, params.height, vec3(0.0f));
    }
    if (params.pixel_area || std::any_of(scene.materials.begin(), scene.materials.end(),
                                         [](const Material& m) { return m.blended; })) {
        result.frame.coverage = Image<float>(params.width, params.height, 1.0f);
    }
    std::atomic<int64_t> ray_count{0};
    std::atomic<int64_t> nonfinite{0};
    Progress progress("path tracing", params.height, params.quiet);
    parallelFor(params.height, [&](int y) {
        Counters counters;
        for (int x = 0; x < params.width; ++x) {
            renderPixel(context, x, y, result, counters);
        }
        ray_count += counters.rays;
        nonfinite += counters.nonfinite;
        progress.advance();
    });

    result.rays = ray_count;
    result.nonfinite_samples = nonfinite;
    result.seconds = timer.seconds();
    result.mrays_per_second = 1e-6 * static_cast<double>(result.rays) / result.seconds;
    if (result.nonfinite_samples > 0) {
        warn(fmt::format("path tracing dropped {} samples that were not finite",
                         result.nonfinite_samples));
    }
    return result;
}

}  // namespace sheen
