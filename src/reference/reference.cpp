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
#include "reference/paths.h"
#include "reference/replicates.h"
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

// Of direct light.
constexpr uint32_t kDirectSeed = 0x64697265u;

// Of the places in a pixel that paths see, where they see all of it.
constexpr uint32_t kPlaceSeed = 0x706c6163u;
constexpr uint32_t kPartSeed = 0x70617274u;
// Of rough glass that they see through.
constexpr uint32_t kFacetSeed = 0x66616365u;

// What a path of a pixel starts from.
struct PathStart {
    std::optional<Start> start;  // none where no surface is seen
    vec3 weight{1.0f};           // what its light counts
    // Of all that is seen there.
    vec3 emission{0.0f};
    float coverage = 0.0f;
};

// Where a pixel's paths start: all on one of the surfaces that its middle sees, or each at a place
// of its own in the pixel's area, on one of those that are seen there.
class Pixel {
  public:
    Pixel(const PathContext& context, int x, int y)
        : context_(context),
          x_(x),
          y_(y),
          in_whole_(ivec2(x, y) + context.params.camera.window.first),
          seed_(hashCombine(
              hashCombine(hash32(context_.params.seed), static_cast<uint32_t>(in_whole_.x)),
              static_cast<uint32_t>(in_whole_.y))) {}

    // On a surface that the middle sees, other paths than before: what they bring counts by its
    // share.
    void startFrom(const Surface& surface, const vec3& share) {
        if (on_.start) {
            seed_ = hash32(seed_);
        }
        on_.start.emplace(surface);
        share_ = share;
    }

    int x() const { return x_; }
    int y() const { return y_; }
    uint32_t seed() const { return seed_; }
    const vec3& share() const { return share_; }
    PathStart start(uint32_t index, uint32_t seed, Counters& counters) const {
        const ReferenceParams& params = context_.params;
        if (!params.pixel_area) {
            return on_;
        }
        const vec2 place = owenSobol(index, hashCombine(seed, kPlaceSeed)) - 0.5f;
        float u = owenSobol(index, hashCombine(seed, kPartSeed)).x;
        PathStart from{.start = {}, .coverage = 1.0f};
        // One of the surfaces, by chance.
        for (const Sighting& part : look(context_.rays, context_.whole_camera, context_.whole_size,
                                         vec2(in_whole_) + place, Textures::kOfPlace, counters,
                                         Facets{index, hashCombine(seed, kFacetSeed)})) {
            from.emission += part.share * part.emission;
            if (!part.surface) {
                from.coverage = 1.0f - passingShare(part.share);
                break;
            }
            if (u >= 0.0f && u < part.chance) {
                from.start.emplace(*part.surface);
                from.weight = part.share / part.chance;
            }
            u -= part.chance;
        }
        return from;
    }

  private:
    const PathContext& context_;
    int x_, y_;
    ivec2 in_whole_;  // of the image that the frame may be a part of
    uint32_t seed_;
    vec3 share_{1.0f};
    PathStart on_;
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

void estimateIndirect(const PathContext& context, const Pixel& pixel, Frame& frame,
                      Counters& counters) {
    const ReferenceParams& params = context.params;
    const uint32_t guide_seed = hashCombine(pixel.seed(), kGuideSeed);
    const Guide guide = learnGuide(context.guide_size, guide_seed, [&](uint32_t i, const vec2&) {
        const PathStart from = pixel.start(i, guide_seed, counters);
        if (!from.start) {
            return vec3(0.0f);
        }
        const PathSample path = samplePath(context, *from.start, {}, i, guide_seed, counters);
        return from.weight * (path.indirect.all + path.caustic);
    });
    Replicates all, diffuse, caustic, global;
    for (int replicate = 0; replicate < params.replicates; ++replicate) {
        const uint32_t seed = hashCombine(pixel.seed(), static_cast<uint32_t>(replicate));
        dvec3 all_sum(0.0), diffuse_sum(0.0), caustic_sum(0.0);
        for (int i = 0; i < context.samples_per_replicate; ++i) {
            const auto index = static_cast<uint32_t>(i);
            const PathStart from = pixel.start(index, seed, counters);
            if (!from.start) {
                continue;
            }
            PathSample sample = samplePath(context, *from.start, guide, index, seed, counters);
            sample.indirect.add(sampleSkyFromStart(context, *from.start, index, seed, counters));
            if (!sample.isFinite()) {
                ++counters.nonfinite;
                continue;
            }
            all_sum += dvec3(from.weight * sample.indirect.all);
            diffuse_sum += dvec3(from.weight * sample.indirect.diffuse);
            caustic_sum += dvec3(from.weight * sample.caustic);
        }
        const double samples = context.samples_per_replicate;
        all.add(all_sum / samples);
        diffuse.add(diffuse_sum / samples);
        caustic.add(caustic_sum / samples);
        global.add((all_sum + caustic_sum) / samples);
    }
    const vec3 share = pixel.share();
    frame.indirect.at(pixel.x(), pixel.y()) += share * vec3(all.mean);
    frame.indirect_variance.at(pixel.x(), pixel.y()) += share * share * all.varianceOfMean();
    frame.indirect_diffuse.at(pixel.x(), pixel.y()) += share * vec3(diffuse.mean);
    frame.indirect_diffuse_variance.at(pixel.x(), pixel.y()) +=
        share * share * diffuse.varianceOfMean();
    if (!frame.caustic.empty()) {
        frame.caustic.at(pixel.x(), pixel.y()) += share * vec3(caustic.mean);
        frame.caustic_variance.at(pixel.x(), pixel.y()) += share * share * caustic.varianceOfMean();
        frame.global_variance.at(pixel.x(), pixel.y()) += share * share * global.varianceOfMean();
    }
}

// A guide of where on the lamps the light of a pixel comes from: not from their backs, nor from
// those that are far off or hidden.
Guide learnLamps(const PathContext& context, const Pixel& pixel, uint32_t seed,
                 Counters& counters) {
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
vec3 sampleDirect(const PathContext& context, const Start& start, const Guide& guide,
                  uint32_t index, uint32_t seed, Counters& counters) {
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
void estimateDirect(const PathContext& context, const Pixel& pixel, Frame& frame,
                    Counters& counters) {
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
            const vec3 sample =
                from.weight * sampleDirect(context, *from.start, guide, index, seed, counters);
            if (finite(sample)) {
                sum += dvec3(sample);
            } else {
                ++counters.nonfinite;
            }
        }
        direct.add(sum / static_cast<double>(context.samples_per_replicate));
    }
    const vec3 share = pixel.share();
    frame.direct.at(pixel.x(), pixel.y()) += share * vec3(direct.mean);
    frame.direct_variance.at(pixel.x(), pixel.y()) += share * share * direct.varianceOfMean();
    if (context.params.pixel_area) {
        const double all = context.samples_per_replicate * context.params.replicates;
        frame.emission.at(pixel.x(), pixel.y()) = vec3(emission / all);
        frame.coverage.at(pixel.x(), pixel.y()) = static_cast<float>(covered / all);
    }
}

void renderPixel(const PathContext& context, int x, int y, ReferenceResult& result,
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
            result.frame.coverage.at(x, y) = 1.0f - passingShare(part.share);
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

void renderSurface(const PathContext& context, const Surface& surface, int x, int y,
                   ReferenceResult& result, Counters& counters) {
    Pixel pixel(context, x, y);
    pixel.startFrom(surface, vec3(1.0f));
    result.frame.direct.at(x, y) = directRadiance(context.rays, surface, counters);
    if (!context.lights.lamps.empty()) {
        estimateDirect(context, pixel, result.frame, counters);
    }
    estimateIndirect(context, pixel, result.frame, counters);
}

// Renders each place of the image by render(context, x, y, result, counters).
template <class Render>
ReferenceResult renderPlaces(const Scene& scene, const ReferenceParams& params,
                             const Render& render) {
    checkParams(params);
    const Timer timer;
    const RayScene rays(scene);
    const Lights lights(scene);
    ReferenceParams apart = params;
    apart.caustics_apart = params.caustics_apart && anySpecular(scene);
    Camera whole_camera = params.camera;
    whole_camera.window = {};
    const PathContext context{
        .rays = rays,
        .lights = lights,
        .params = apart,
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
    if (apart.caustics_apart) {
        for (Image<vec3>* layer : {&result.frame.caustic, &result.frame.caustic_variance,
                                   &result.frame.global_variance}) {
            *layer = Image<vec3>(params.width, params.height, vec3(0.0f));
        }
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
            render(context, x, y, result, counters);
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

}  // namespace

ReferenceResult renderReference(const Scene& scene, const ReferenceParams& params) {
    return renderPlaces(scene, params, renderPixel);
}

ReferenceResult renderReferenceOf(const Scene& scene, const ReferenceParams& params,
                                  const SurfaceOf& surface_of) {
    SHEEN_CHECK(!params.pixel_area);
    const auto render = [&](const PathContext& context, int x, int y, ReferenceResult& result,
                            Counters& counters) {
        if (const std::optional<Surface> surface = surface_of(x, y)) {
            renderSurface(context, *surface, x, y, result, counters);
        }
    };
    return renderPlaces(scene, params, render);
}

}  // namespace sheen
