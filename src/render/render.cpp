#include "render/render.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "baselines/denoise.h"
#include "baselines/irradiance_cache.h"
#include "cache/classes.h"
#include "cache/direct_rays.h"
#include "cache/estimate.h"
#include "cache/placement.h"
#include "cache/probes.h"
#include "cache/raster_gather.h"
#include "cache/ray_gather.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "gl/objects.h"
#include "raster/gbuffer.h"
#include "raster/gpu_scene.h"
#include "splat/splat.h"

namespace sheen {
namespace {

void countPixels(RenderResult& result) {
    const Frame& frame = result.frame;
    const Image<vec3> seen = beauty(frame);
    for (size_t i = 0; i < seen.pixels.size(); ++i) {
        const vec3& pixel = seen.pixels[i];
        const bool finite =
            std::isfinite(pixel.x) && std::isfinite(pixel.y) && std::isfinite(pixel.z);
        result.stats.nonfinite_pixels += finite ? 0 : 1;
        result.stats.pixels_geometry += frame.primitive.pixels[i] == kNoPrimitive ? 0 : 1;
    }
}

// Fewer replicates stratify better: at 64 paths four have three quarters of the variance of
// sixteen, which know the variance better.
int replicatesFor(int spp) { return spp < 1024 ? 4 : 16; }

RenderResult renderByPaths(const Scene& scene, const RenderParams& params) {
    ReferenceResult traced = renderReference(scene, {.width = params.width,
                                                     .height = params.height,
                                                     .camera = findCamera(scene, params.camera),
                                                     .bounces = params.bounces,
                                                     .spp = params.spp,
                                                     .replicates = replicatesFor(params.spp),
                                                     .seed = params.seed,
                                                     .quiet = params.quiet});
    RenderResult result;
    result.stats.seconds.trace = traced.seconds;
    result.stats.mrays_per_second = traced.mrays_per_second;
    result.stats.spp = traced.spp;
    if (params.method == Method::kDenoised) {
        const Timer denoise_timer;
        denoise(traced);
        result.stats.seconds.denoise = denoise_timer.seconds();
    }
    result.frame = std::move(traced.frame);
    countPixels(result);
    return result;
}

RenderResult renderByOctree(const Scene& scene, const RenderParams& params) {
    IrradianceCacheResult cached =
        renderIrradianceCache(scene, {.width = params.width,
                                      .height = params.height,
                                      .camera = findCamera(scene, params.camera),
                                      .accuracy = params.placement.accuracy,
                                      .rings = params.gather.size,
                                      .quiet = params.quiet});
    RenderResult result;
    result.frame = std::move(cached.frame);
    result.stats.records = cached.records;
    result.stats.pixels_uncovered = cached.uncovered;
    result.stats.seconds.gbuffer = cached.see;
    result.stats.seconds.placement = cached.place;
    result.stats.seconds.gather = cached.gather;
    result.stats.seconds.splat = cached.interpolate;
    countPixels(result);
    return result;
}

std::vector<MaterialOrder> nameOrders(const Scene& scene, const std::vector<int>& orders) {
    std::vector<MaterialOrder> named;
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        named.push_back({scene.materials[i].name, orders[i]});
    }
    return named;
}

// The software rasteriser keeps what it last drew to, deleted or not, until it draws elsewhere.
void dropTargets() {
    const gl::Texture texel = gl::makeTexture2d(GL_RGBA32F, 1, 1);
    const GLuint name = texel.name();
    const gl::Framebuffer target = gl::makeFramebuffer({&name, 1}, 0);
    const float black[4] = {};
    gl::glClearNamedFramebufferfv(target.name(), GL_COLOR, 0, black);
    gl::glFinish();
}

// What does not depend on the records.
struct Stage {
    gl::WorkerPool pool;
    GpuScene gpu;
    GBuffer gbuffer;
    PixelClasses classes;
    PixelLobes lobes;
    std::optional<RayCaster> rays;
    std::optional<LightCells> cells;
    Image<SpecularSeen> specular;  // what pixels see by rays of their own

    Stage(const Scene& scene, const RenderParams& params, StageSeconds& seconds);
    ~Stage() {
        pool.release([this](int worker) {
            if (worker == 0) {
                gpu = {};
            }
        });
    }
};

// scene -> rays -> G-buffer -> classes -> rays where the cache cannot follow. Direct light comes
// from rays where records use rays, else from shadow maps.
Stage::Stage(const Scene& scene, const RenderParams& params, StageSeconds& seconds)
    // Only the raster gather draws with more than one context.
    : pool(params.gather_road == GatherRoad::kRays ? 1 : threadCount(), threadCount()) {
    const bool by_rays = params.gather_road == GatherRoad::kRays;
    const Timer rays_timer;
    rays.emplace(scene);
    seconds.gather = rays_timer.seconds();

    const Timer gbuffer_timer;
    gbuffer = renderGBuffer(*rays, findCamera(scene, params.camera), params.width, params.height);
    classes = classifyPixels(scene, gbuffer, params.sh_order, params.method == Method::kIrradiance);
    lobes = buildLobes(gbuffer, classes);
    checkSplat(pool, lobes);
    seconds.gbuffer = gbuffer_timer.seconds();

    const Timer shadow_timer;
    const std::vector<Bounds> near = nearBoxes(scene, gbuffer);
    if (by_rays) {
        gbuffer.direct = traceDirect(*rays, gbuffer);
    } else {
        pool.runOnFirst([&] { gpu = uploadScene(scene); });
        renderShadowMaps(pool, scene, gpu, near);
        lightGBuffer(pool, gpu, gbuffer);
    }
    seconds.shadow = shadow_timer.seconds();

    const Timer gather_timer;
    cells.emplace(*rays, near);
    if (classes.anyByRays()) {
        specular = traceSpecular(*rays, &*cells, gbuffer, classes, params.specular);
    }
    seconds.gather += gather_timer.seconds();
}

// A gatherer of either kind, for as long as a pass lasts.
class PassGatherer {
  public:
    PassGatherer(Stage& stage, const RenderParams& params, const HemisphereParams& hemisphere) {
        if (params.gather_road == GatherRoad::kRays) {
            rays_.emplace(*stage.rays, *stage.cells, hemisphere);
        } else {
            raster_.emplace(stage.pool, stage.gpu, hemisphere);
        }
    }
    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) {
        return rays_ ? rays_->gather(sites) : raster_->gather(sites);
    }
    GatherSeconds seconds() const { return rays_ ? rays_->seconds() : raster_->seconds(); }

  private:
    std::optional<RayGatherer> rays_;
    std::optional<RasterGatherer> raster_;
};

// How wrong the image is: by the records, and by probes, which cast rays whatever road the records
// took. Probes cost a twentieth of the records, up to what is enough.
ErrorEstimate judge(const Scene& scene, const RenderParams& params, const Stage& stage,
                    const Placement& placement, const WeightParams& weight,
                    const HemisphereParams& hemisphere, const Image<vec3>& indirect) {
    constexpr uint32_t kOtherRays = 1u << 30u;  // than those of any record
    constexpr size_t kRecordsPerProbe = 40;
    constexpr size_t kFewest = 32;
    constexpr size_t kEnough = 400;
    const NeighbourErrors errors =
        neighbourErrors(stage.gbuffer, stage.classes, stage.lobes, placement, weight, indirect);
    const size_t records = placement.cache.records.size();
    std::vector<Probe> probes =
        chooseProbes(errors, stage.classes, indirect,
                     static_cast<int>(std::clamp(records / kRecordsPerProbe, kFewest, kEnough)));
    HemisphereParams seen = hemisphere;
    seen.kind = HemisphereKind::kHemicube;
    if (params.gather_road != GatherRoad::kRays) {
        seen.size = gatherSize(GatherRoad::kRays, params.placement.accuracy);
    }
    RayGatherer gatherer(*stage.rays, *stage.cells, seen, kOtherRays);
    gatherProbes(
        scene, stage.gbuffer, stage.classes, placement,
        [&](std::span<const RecordSite> sites) { return gatherer.gather(sites); }, *stage.rays,
        *stage.cells, params.specular, probes);
    return estimateError(errors, probes, stage.gbuffer, stage.classes, indirect);
}

// Along a crease each pixel gets a record of its own, however coarse the others are, until records
// there reach farther than one pixel.
float leastReach(float accuracy) {
    return std::max(PlacementParams{}.min_pixels, std::sqrt(accuracy));
}

// placement, which gathers and projects -> splat -> compose.
void renderPass(const Scene& scene, const RenderParams& params, float accuracy, Stage& stage,
                RenderResult& result) {
    StageSeconds& seconds = result.stats.seconds;
    const bool irradiance_only = params.method == Method::kIrradiance;
    PlacementParams how = params.placement;
    how.accuracy = accuracy;
    if (how.min_pixels == 0.0f) {
        how.min_pixels = leastReach(accuracy);
    }
    HemisphereParams hemisphere = params.gather;
    if (hemisphere.size == 0) {
        hemisphere.size = gatherSize(params.gather_road, accuracy, hemisphere.kind);
    }
    if (hemisphere.extent == 0.0f) {
        hemisphere.extent = gatherExtent(hemisphere.kind);
    }

    PassGatherer gatherer(stage, params, hemisphere);
    const Timer timer;
    const Placement placement = placeRecords(
        scene, stage.gbuffer, stage.classes, stage.lobes, how,
        [&](std::span<const RecordSite> sites) { return gatherer.gather(sites); }, params.quiet);
    const GatherSeconds gathered = gatherer.seconds();
    seconds.gather += gathered.see;
    seconds.project += gathered.project;
    seconds.placement += timer.seconds() - gathered.see - gathered.project;

    const Timer splat_timer;
    SplatBuffer splat = splatGpu(stage.pool, stage.gbuffer, stage.classes, stage.lobes,
                                 placement.cache, how.servingWeight());
    stage.pool.runOnFirst(dropTargets);
    seconds.splat += splat_timer.seconds();

    const Timer compose_timer;
    Image<vec3> specular;  // of pixels that rays see; none in many scenes
    if (!stage.specular.pixels.empty()) {
        specular =
            reflectSpecular(stage.gbuffer, stage.classes, stage.specular,
                            cachedSpecular(stage.gbuffer, stage.classes, stage.lobes, splat));
    }
    const ComposeCounts counts =
        compose(stage.gbuffer, stage.classes, stage.lobes, splat, specular,
                {.irradiance_only = irradiance_only, .geometry = params.all_layers}, result.frame);
    splat = {};
    specular = {};
    const ErrorEstimate estimate =
        judge(scene, params, stage, placement, how.servingWeight(), hemisphere,
              irradiance_only ? result.frame.indirect_diffuse : result.frame.indirect);
    if (params.all_layers) {
        result.frame.records =
            countRecords(stage.gbuffer, stage.classes, placement.cache, how.servingWeight());
    }
    seconds.compose += compose_timer.seconds();

    RenderStats& stats = result.stats;
    stats.records = static_cast<int>(placement.cache.records.size());
    stats.estimated_rel_rmse = estimate.rel_rmse;
    stats.estimate_low = estimate.low;
    stats.estimate_high = estimate.high;
    stats.accuracy = accuracy;
    stats.gather_size = hemisphere.size;
    stats.passes += 1;
    stats.pixels_uncovered = placement.uncovered;
    stats.nonfinite_pixels = counts.nonfinite;
    stats.negative_pixels = counts.negative;
}

// Renders at finer and finer accuracies, until the estimate is at most the target or falls no more.
void renderToTarget(const Scene& scene, const RenderParams& params, Stage& stage,
                    RenderResult& result) {
    constexpr float kFirst = 1.0f;
    // The error falls like this power of the accuracy, until what records do not cause is left:
    // from the first pass on its power is then small (docs/decisions.md).
    constexpr double kUsualPower = 0.7;
    constexpr double kLeastPower = 0.25;
    constexpr double kStep = 1.0 / 3.0;  // three times as long: half of that was spent on the way
    constexpr double kMargin = 0.85;     // a pass that just misses is lost
    double first_estimate = 0.0;
    for (float accuracy = kFirst;;) {
        renderPass(scene, params, accuracy, stage, result);
        const double estimate = result.stats.estimate_high;
        first_estimate = accuracy == kFirst ? estimate : first_estimate;
        const bool falls = accuracy == kFirst ||
                           estimate < first_estimate * std::pow(accuracy / kFirst, kLeastPower);
        if (!(estimate > params.target_error) || accuracy <= kFinestAccuracy || !falls) {
            return;
        }
        const double factor = std::pow(kMargin * params.target_error / estimate, 1.0 / kUsualPower);
        accuracy =
            std::max(accuracy * static_cast<float>(std::max(factor, kStep)), kFinestAccuracy);
    }
}

RenderResult renderByCache(const Scene& scene, const RenderParams& params) {
    RenderResult result;
    RenderStats& stats = result.stats;
    Stage stage(scene, params, stats.seconds);
    if (params.target_error > 0.0) {
        renderToTarget(scene, params, stage, result);
    } else {
        renderPass(scene, params, params.placement.accuracy, stage, result);
    }
    countPixels(result);
    stats.gl_renderer = stage.pool.renderer();
    const double geometry = std::max(stage.classes.geometry, 1);
    stats.diffuse_share = stage.classes.diffuse / geometry;
    stats.corrected_share = stage.classes.corrected / geometry;
    stats.too_glossy_share = stage.classes.too_glossy / geometry;
    stats.sh_order = nameOrders(scene, stage.classes.material_orders);
    return result;
}

// Bytes that a pixel takes, at the most (docs/stability.md).
uint64_t bytesPerPixel(const Scene& scene, const RenderParams& params) {
    constexpr uint64_t kByPaths = 230;
    constexpr uint64_t kByRecords = 330;
    constexpr uint64_t kByRays = 320;        // what rays saw and how it is filtered
    constexpr uint64_t kPerCoefficient = 4;  // of a lobe, here and as OpenGL has it
    if (params.method != Method::kRadiance && params.method != Method::kIrradiance) {
        return kByPaths;
    }
    std::vector<bool> used(scene.materials.size(), false);
    for (const uint32_t material : scene.materials_of) {
        used[material] = true;
    }
    int order = 0;
    for (size_t i = 0; i < used.size() && params.method == Method::kRadiance; ++i) {
        if (used[i]) {
            order = std::max(order, materialOrder(scene, scene.materials[i], params.sh_order));
        }
    }
    return kByRecords + (order > shared::DIFFUSE_ORDER ? kByRays : 0) +
           kPerCoefficient * static_cast<uint64_t>(order * order);
}

void checkRenderMemory(const Scene& scene, const RenderParams& params) {
    constexpr uint64_t kProgram = uint64_t{128} << 20;
    constexpr uint64_t kPerTriangle = 650;
    const uint64_t pixels =
        static_cast<uint64_t>(params.width) * static_cast<uint64_t>(params.height);
    checkMemory({.bytes = kProgram + bytesPerPixel(scene, params) * pixels +
                          kPerTriangle * scene.triangles.size(),
                 .threads = threadCount()},
                fmt::format("an image of {}x{} pixels of {} triangles", params.width, params.height,
                            scene.triangles.size()),
                "choose a smaller --size, or fewer --threads below an address limit");
}

RenderResult renderByMethod(const Scene& scene, const RenderParams& params) {
    switch (params.method) {
        case Method::kReference:
        case Method::kDenoised:
            return renderByPaths(scene, params);
        case Method::kOctree:
            return renderByOctree(scene, params);
        case Method::kRadiance:
        case Method::kIrradiance:
            return renderByCache(scene, params);
    }
    throw std::logic_error("unknown method");
}

}  // namespace

RenderResult renderFrame(const Scene& scene, const RenderParams& params) {
    checkRenderMemory(scene, params);
    RenderResult result = renderByMethod(scene, params);
    // Users know the file's coordinates alone.
    for (size_t i = 0; i < result.frame.position.pixels.size(); ++i) {
        if (result.frame.primitive.pixels[i] != kNoPrimitive) {
            vec3& position = result.frame.position.pixels[i];
            position = vec3(scene.inFile(position));
        }
    }
    return result;
}

}  // namespace sheen
