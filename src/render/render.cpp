#include "render/render.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "baselines/denoise.h"
#include "baselines/irradiance_cache.h"
#include "cache/classes.h"
#include "cache/estimate.h"
#include "cache/placement.h"
#include "cache/raster_gather.h"
#include "cache/ray_gather.h"
#include "cache/specular_rays.h"
#include "core/parallel.h"
#include "core/timer.h"
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
                                      .accuracy = params.octree_accuracy,
                                      .rings = params.octree_rings,
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

// Places records with a gatherer of either kind, and says how long each part took.
template <class G>
Placement placeWith(G& gatherer, const Scene& scene, const GBuffer& gbuffer,
                    const PixelClasses& classes, const PixelLobes& lobes,
                    const RenderParams& params, StageSeconds& seconds) {
    const Timer timer;
    Placement placement = placeRecords(
        scene, gbuffer, classes, lobes, params.placement,
        [&](std::span<const RecordSite> sites) { return gatherer.gather(sites); }, params.quiet);
    seconds.gather += gatherer.seconds().see;
    seconds.project += gatherer.seconds().project;
    seconds.placement += timer.seconds() - gatherer.seconds().see - gatherer.seconds().project;
    return placement;
}

// scene -> raster (shadow maps, G-buffer) -> classes -> rays where the cache cannot follow ->
// placement, which gathers and projects -> splat -> compose.
RenderResult renderByCache(const Scene& scene, const RenderParams& params) {
    const bool irradiance_only = params.method == Method::kIrradiance;
    const Camera& camera = findCamera(scene, params.camera);
    RenderResult result;
    StageSeconds& seconds = result.stats.seconds;

    const bool by_rays = params.gather_road == GatherRoad::kRays;

    // Only the raster gather draws with more than one context.
    gl::WorkerPool pool(by_rays ? 1 : threadCount());
    result.stats.gl_renderer = pool.renderer();

    Timer shadow_timer;
    GpuScene gpu;
    pool.runOnFirst([&] { gpu = uploadScene(scene); });
    renderShadowMaps(pool, scene, gpu);
    seconds.shadow = shadow_timer.seconds();

    Timer gbuffer_timer;
    const GBuffer gbuffer = renderGBuffer(pool, scene, gpu, camera, params.width, params.height);
    const PixelClasses classes = classifyPixels(scene, gbuffer, params.sh_order, irradiance_only);
    const PixelLobes lobes = buildLobes(gbuffer, classes);
    seconds.gbuffer = gbuffer_timer.seconds();

    Placement placement;
    Image<vec3> traced(params.width, params.height);
    Timer gather_timer;
    std::optional<RayCaster> rays;
    if (by_rays || classes.too_glossy > 0) {
        rays.emplace(scene);
    }
    if (classes.too_glossy > 0) {
        traced = gatherSpecular(*rays, scene, gbuffer, classes);
    }
    if (by_rays) {
        RayGatherer gatherer(*rays, params.gather);
        seconds.gather = gather_timer.seconds();
        placement = placeWith(gatherer, scene, gbuffer, classes, lobes, params, seconds);
    } else {
        lightSurfaces(pool, gpu);
        RasterGatherer gatherer(pool, scene, gpu, params.gather);
        seconds.gather = gather_timer.seconds();
        placement = placeWith(gatherer, scene, gbuffer, classes, lobes, params, seconds);
    }

    Timer splat_timer;
    const SplatBuffer splat =
        splatGpu(pool, gbuffer, classes, lobes, placement.cache, params.placement.servingWeight());
    seconds.splat = splat_timer.seconds();

    Timer compose_timer;
    const ComposeCounts counts =
        compose(gbuffer, classes, lobes, splat, traced, irradiance_only, result.frame);
    result.stats.estimated_rel_rmse =
        estimateRelRmse(gbuffer, classes, lobes, placement, params.placement.servingWeight(),
                        irradiance_only ? result.frame.indirect_diffuse : result.frame.indirect);
    if (params.all_layers) {
        result.frame.records =
            countRecords(gbuffer, classes, placement.cache, params.placement.servingWeight());
    }
    pool.runOnFirst([&] { gpu = {}; });
    countPixels(result);
    seconds.compose = compose_timer.seconds();

    RenderStats& stats = result.stats;
    stats.records = static_cast<int>(placement.cache.records.size());
    stats.pixels_uncovered = placement.uncovered;
    stats.nonfinite_pixels += counts.nonfinite;
    stats.negative_pixels = counts.negative;
    const double geometry = std::max(classes.geometry, 1);
    stats.diffuse_share = classes.diffuse / geometry;
    stats.too_glossy_share = classes.too_glossy / geometry;
    stats.sh_order = nameOrders(scene, classes.material_orders);
    return result;
}

}  // namespace

RenderResult renderFrame(const Scene& scene, const RenderParams& params) {
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

}  // namespace sheen
