// Gathering by rays and by the rasteriser, beside what Embree takes for 1,024 rays a record and
// their shadow rays; what both need beforehand; and projection.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <string_view>

#include "accuracy_gather.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "gather/raster_gather.h"
#include "render/render.h"
#include "sh/projection.h"
#include "stages_setup.h"

namespace sheen::bench {
namespace {

const int kRaySize = gatherSize(GatherRoad::kRays, PlacementParams{}.accuracy);
const int kRasterSize = gatherSize(GatherRoad::kRaster, PlacementParams{}.accuracy);
constexpr int kYardstickRings = 18;  // 1,026 rays

// Gathers batch after batch, and each batch by the yardstick too, so that both meet the same
// conditions.
template <class G>
void measureGather(benchmark::State& state, const GatherScene& s, G& gatherer, int texels) {
    const std::span<const RecordSite> sites(s.scene.sites);
    gatherer.gather(sites.first(kBatch));  // shaders are compiled by their first draw
    const GatherSeconds before = gatherer.seconds();
    double own = 0.0, yardstick = 0.0;
    const WardStrata strata(kYardstickRings);
    int64_t yardstick_rays = 0;
    size_t first = 0;
    for (auto _ : state) {
        const std::span<const RecordSite> batch = sites.subspan(first, kBatch);
        first = (first + kBatch) % sites.size();
        const Timer own_timer;
        benchmark::DoNotOptimize(gatherer.gather(batch));
        const double seconds = own_timer.seconds();
        state.SetIterationTime(seconds);
        own += seconds;
        const Timer yardstick_timer;
        const YardstickRecords found = gatherByYardstick(s.yardstick, batch, strata);
        yardstick += yardstick_timer.seconds();
        benchmark::DoNotOptimize(found.irradiance.data());
        yardstick_rays += found.rays;
    }
    const auto records = static_cast<double>(state.iterations()) * kBatch;
    state.counters["triangles"] = s.scene.scene.triangleCount();
    state.counters["texels"] = texels;
    state.counters["record_ms"] = 1e3 * own / records;
    state.counters["project_ms"] = 1e3 * (gatherer.seconds().project - before.project) / records;
    state.counters["records_per_s"] = records / own;
    state.counters["texels_per_s"] = records * texels / own;
    state.counters["embree_ms"] = 1e3 * yardstick / records;
    state.counters["embree_rays_per_s"] = static_cast<double>(yardstick_rays) / yardstick;
    state.counters["ratio"] = own / yardstick;
}

void gatherByRays(benchmark::State& state, Setup& setup, const SceneChoice& choice, int size) {
    const GatherScene& s = setup.gatherScene(choice);
    const HemisphereParams params = {.size = size};
    RayGatherer gatherer(s.light, params);
    measureGather(state, s, gatherer, makeHemisphere(params).texelCount());
}

void gatherByRaster(benchmark::State& state, Setup& setup, const SceneChoice& choice,
                    const HemisphereParams& params) {
    const GatherScene& s = setup.gatherScene(choice);
    RasterGatherer gatherer(setup.pool(), setup.gpuScene(choice), params);
    measureGather(state, s, gatherer, makeHemisphere(params).texelCount());
}

// integrateHemisphere() of what a few records of the Cornell box see.
void project(benchmark::State& state, Setup& setup, int order) {
    const GatherScene& s = setup.gatherScene(kCornell);
    const Hemisphere hemisphere = makeHemisphere({.size = kRaySize});
    std::vector<RecordSite> sites(s.scene.sites.begin(), s.scene.sites.begin() + kBatch);
    std::vector<SeenTexels> texels;
    for (RecordSite& site : sites) {
        site.order = order;
        texels.push_back(
            traceTexels(s.scene.light, hemisphere, tangentFrame(site.normal), site.eye(), {}));
    }
    ProjectionMatrices matrices;
    matrices.prepare(hemisphere, sites);
    double seconds = 0.0;
    for (auto _ : state) {
        const Timer timer;
        parallelFor(static_cast<int>(sites.size()), [&](int index) {
            const auto i = static_cast<size_t>(index);
            benchmark::DoNotOptimize(
                integrateHemisphere(hemisphere, texels[i], matrices.of(order), sites[i]));
        });
        state.SetIterationTime(timer.seconds());
        seconds += timer.seconds();
    }
    const auto records = static_cast<double>(state.iterations()) * kBatch;
    state.counters["order"] = order;
    state.counters["texels"] = hemisphere.texelCount();
    state.counters["record_ms"] = 1e3 * seconds / records;
    state.counters["products_per_s"] =  // of a matrix entry and a texel
        records * shLayout(order).size() * hemisphere.texelCount() / seconds;
}

// What is made of a scene before anything is gathered.
template <class Make>
void measureBuild(benchmark::State& state, const Scene& scene, const Make& make) {
    for (auto _ : state) {
        make();
    }
    state.counters["triangles"] = scene.triangleCount();
}

void registerBuild(Setup& setup, const SceneChoice& choice) {
    using State = benchmark::State;
    const auto add = [&](const char* part, const auto& body) {
        benchmark::RegisterBenchmark(fmt::format("build/{}/{}", part, choice.name).c_str(), body)
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
    };
    add("embree", [&setup, choice](State& state) {
        const Scene& scene = setup.gatherScene(choice).scene.scene;
        measureBuild(state, scene, [&] { const Tracer tracer(scene); });
    });
    add("cells", [&setup, choice](State& state) {
        const BenchScene& s = setup.gatherScene(choice).scene;
        measureBuild(state, s.scene, [&] { const LightCells cells(s.tracer, s.scene.lights, {}); });
    });
    add("levels", [&setup, choice](State& state) {
        const Scene& scene = setup.gatherScene(choice).scene.scene;
        measureBuild(state, scene, [&] {
            setup.pool().runOnFirst([&] { const GpuScene gpu = uploadScene(scene); });
        });
    });
}

}  // namespace

void registerGather(Setup& setup) {
    const auto add = [](const std::string& name, const auto& body) {
        benchmark::RegisterBenchmark(name.c_str(), body)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
    };
    const auto addRays = [&](const SceneChoice& choice, int size) {
        add(fmt::format("rays/{}/{}", choice.name, size),
            [&setup, choice, size](benchmark::State& state) {
                gatherByRays(state, setup, choice, size);
            });
    };
    const auto addRaster = [&](const SceneChoice& choice, const char* kind,
                               const HemisphereParams& params) {
        add(fmt::format("raster/{}/{}_{}", choice.name, kind, params.size),
            [&setup, choice, params](benchmark::State& state) {
                gatherByRaster(state, setup, choice, params);
            });
    };
    for (int order : {0, 4, 6, 8, 10}) {
        add(fmt::format("project/{}", order),
            [&setup, order](benchmark::State& state) { project(state, setup, order); });
    }
    std::vector<SceneChoice> choices(std::begin(kBySize), std::end(kBySize));
    choices.push_back(kStatue);
    choices.push_back(kAtrium);
    for (const SceneChoice& choice : choices) {
        const std::string_view name = choice.name;
        const bool all_sizes = name == kCornell.name || name == kAtrium.name;
        for (int size : {kRaySize, 32, 64, 128}) {
            if (size == kRaySize || all_sizes) {
                addRays(choice, size);
            }
        }
        for (int size : {32, kRasterSize, 64, 128}) {
            if (size == kRasterSize || all_sizes) {
                addRaster(choice, "hemicube", {.kind = HemisphereKind::kHemicube, .size = size});
            }
        }
        for (int size : {32, 64, 128}) {
            if (size == 64 || all_sizes) {
                addRaster(choice, "border", {.kind = HemisphereKind::kBorder, .size = size});
            }
        }
        registerBuild(setup, choice);
    }
}

}  // namespace sheen::bench
