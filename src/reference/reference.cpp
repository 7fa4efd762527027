#include "reference/reference.h"

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

// One sample of the indirect radiance, and of its diffuse part.
struct Indirect {
    vec3 all{0.0f};
    vec3 diffuse{0.0f};
};

// Where a pixel's paths start: the point they leave and how they leave it.
struct Start {
    const Surface& p;
    BrdfSampler sampler;
    Guide guide;
};

Indirect samplePath(const RayScene& rays, const Start& start, int bounces, uint32_t index,
                    uint32_t seed, Counters& counters) {
    const Surface& p = start.p;
    const GuidedPoint guided = start.guide.warp(owenSobol(index, seed));
    const DirectionSample first = sampleBrdf(start.sampler, p.brdf, p.n, p.wo, guided.u);
    if (bounces == 0 || black(first.weight)) {
        return {};
    }
    RayHit hit = nextHit(rays, p, first.wi, counters);
    vec3 wi = first.wi;
    vec3 throughput(1.0f);
    vec3 radiance(0.0f);
    for (int bounce = 1; hit.found(); ++bounce) {
        const Surface q = rays.surfaceAt(hit, -wi);
        radiance += throughput * (q.emission + directRadiance(rays, q, counters));
        if (bounce == bounces) {
            break;
        }

        // Continue the path from q.
        const BrdfSampler sampler(q.brdf, q.specular_albedo, q.n, q.wo);
        const vec2 u = owenSobol(index, hashCombine(seed, static_cast<uint32_t>(bounce)));
        const DirectionSample next = sampleBrdf(sampler, q.brdf, q.n, q.wo, u);
        if (black(next.weight)) {
            break;
        }
        throughput *= next.weight;
        wi = next.wi;
        hit = nextHit(rays, q, wi, counters);
    }
    radiance *= guided.weight;
    return {.all = first.weight * radiance, .diffuse = first.diffuse * radiance};
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

struct Context {
    const RayScene& rays;
    const ReferenceParams& params;
    int samples_per_replicate;
    int guide_size;  // cells along a side; 0: no guide
};

// A guide from one path a cell: an aligned block of 4^k Sobol points has one in each.
Guide learnGuide(const Context& context, const Start& start, uint32_t seed, Counters& counters) {
    const int size = context.guide_size;
    std::vector<float> contributions(static_cast<size_t>(size) * static_cast<size_t>(size));
    for (uint32_t i = 0; i < contributions.size(); ++i) {
        const vec2 u = owenSobol(i, seed);
        const Indirect sample =
            samplePath(context.rays, start, context.params.bounces, i, seed, counters);
        const float sum = sample.all.x + sample.all.y + sample.all.z;
        const auto column = static_cast<size_t>(u.x * static_cast<float>(size));
        const auto row = static_cast<size_t>(u.y * static_cast<float>(size));
        contributions[row * static_cast<size_t>(size) + column] = std::isfinite(sum) ? sum : 0.0f;
    }
    return Guide(size, contributions);
}

void estimateIndirect(const Context& context, const Surface& p, int x, int y, Frame& frame,
                      Counters& counters) {
    const ReferenceParams& params = context.params;
    Start start{.p = p, .sampler = {p.brdf, p.specular_albedo, p.n, p.wo}, .guide = {}};
    const uint32_t pixel_seed = hashCombine(
        hashCombine(hash32(params.seed), static_cast<uint32_t>(x)), static_cast<uint32_t>(y));
    if (context.guide_size > 0) {
        start.guide = learnGuide(context, start, hashCombine(pixel_seed, kGuideSeed), counters);
    }
    Replicates all, diffuse;
    for (int replicate = 0; replicate < params.replicates; ++replicate) {
        const uint32_t seed = hashCombine(pixel_seed, static_cast<uint32_t>(replicate));
        dvec3 all_sum(0.0), diffuse_sum(0.0);
        for (int i = 0; i < context.samples_per_replicate; ++i) {
            const Indirect sample = samplePath(context.rays, start, params.bounces,
                                               static_cast<uint32_t>(i), seed, counters);
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
    frame.indirect.at(x, y) = vec3(all.mean);
    frame.indirect_variance.at(x, y) = all.varianceOfMean();
    frame.indirect_diffuse.at(x, y) = vec3(diffuse.mean);
    frame.indirect_diffuse_variance.at(x, y) = diffuse.varianceOfMean();
}

void renderPixel(const Context& context, int x, int y, ReferenceResult& result,
                 Counters& counters) {
    const std::optional<Surface> p =
        seePixel(context.rays, context.params.camera, x, y, result.frame, counters);
    if (p) {
        result.specular_albedo.at(x, y) = p->specular_albedo;
        estimateIndirect(context, *p, x, y, result.frame, counters);
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
    const Context context{
        .rays = rays,
        .params = params,
        .samples_per_replicate = (params.spp + params.replicates - 1) / params.replicates,
        .guide_size = guideSize(params)};

    ReferenceResult result;
    result.spp = context.samples_per_replicate * params.replicates;
    result.frame = emptyFrame(params.width, params.height);
    for (Image<vec3>* layer :
         {&result.frame.indirect_variance, &result.frame.indirect_diffuse_variance,
          &result.frame.direct_variance, &result.specular_albedo}) {
        *layer = Image<vec3>(params.width, params.height, vec3(0.0f));
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
