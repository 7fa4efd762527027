// What works on images: start-up to the first G-buffer, G-buffers, placement, splatting beside the
// memory's bandwidth, composition, files.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <numeric>

#include "cache/estimate.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "image/exr.h"
#include "receivers/served.h"
#include "render/render.h"
#include "splat/splat.h"
#include "stages_setup.h"

namespace sheen::bench {
namespace {

using State = benchmark::State;

constexpr int kOrders[] = {0, 4, 6, 8, 10};
constexpr int kSplatRecords = 4096;

// From nothing to a G-buffer lit by shadow maps: contexts, upload, shaders compiled. Once: the
// second time in a process much is there already.
void startup(State& state, Setup& setup) {
    const Scene scene = setup.load(kCornell);
    for (auto _ : state) {
        GBuffer g = renderGBuffer(Tracer(scene), scene.cameras.front(), 512, 512);
        lightGBuffer(setup.pool(), setup.gpuScene(kCornell), g);
        benchmark::DoNotOptimize(g);
    }
}

void gbuffer(State& state, Setup& setup, const SceneChoice& choice) {
    const Scene scene = setup.load(choice);
    const Tracer tracer(scene);
    for (auto _ : state) {
        benchmark::DoNotOptimize(renderGBuffer(tracer, scene.cameras.front(), 512, 512));
    }
    state.counters["triangles"] = scene.triangleCount();
    state.counters["pixels_per_s"] =
        benchmark::Counter(512.0 * 512.0, benchmark::Counter::kIsIterationInvariantRate);
}

void place(State& state, Setup& setup, int order, int count) {
    const MadeUpRecords& records = setup.madeUpRecords(order, count);
    for (auto _ : state) {
        RecordField field;
        benchmark::DoNotOptimize(records.place(field));
    }
    const auto placed = static_cast<double>(records.placement.cache.records.size());
    state.counters["order"] = order;
    state.counters["records"] = placed;
    state.counters["records_per_s"] =
        benchmark::Counter(placed, benchmark::Counter::kIsIterationInvariantRate);
}

// Pixels of the quads that a pass of splatGpu() draws.
double shadedFragments(const Receivers& receivers, const RecordCache& cache,
                       const WeightParams& weight) {
    double area = 0.0;
    for (const Record& r : cache.records) {
        const PixelRect b = reachedBounds(receivers, r, weight);
        area += static_cast<double>(b.x1 - b.x0) * (b.y1 - b.y0);
    }
    return area;
}

// What all passes read and write for an accepted fragment: each the G-buffer and a sum, RGBA of
// 32-bit floats, and together the pixel's lobe.
double fragmentBytes(int order) {
    constexpr double kPass = 16.0 * (2 + 2);
    return order > shared::DIFFUSE_ORDER
               ? (1 + shared::lobeGroups(order)) * kPass + 2.0 * order * order
               : kPass;
}

// Splats all records, and one alone: what it takes is what any splat takes before its first
// fragment and after its last, in uploads, shaders and reading back.
void splat(State& state, Setup& setup, int order) {
    const MadeUpRecords& made = setup.madeUpRecords(order, kSplatRecords);
    const WeightParams weight = made.params.servingWeight();
    const RecordCache& all = made.placement.cache;
    RecordCache one = all;
    one.records.resize(1);
    const auto seconds = [&](const RecordCache& cache) {
        const Timer timer;
        benchmark::DoNotOptimize(splatGpu(setup.pool(), made.receivers, cache, weight));
        return timer.seconds();
    };
    seconds(one);  // shaders are compiled by their first draw
    double whole = 0.0, fixed = 0.0;
    for (auto _ : state) {
        const double s = seconds(all);
        state.SetIterationTime(s);
        whole += s;
        fixed += seconds(one);
    }
    const Image<float> served = countRecords(made.receivers, all, weight);
    const double accepted = std::accumulate(served.pixels.begin(), served.pixels.end(), 0.0);
    const auto times = static_cast<double>(state.iterations());
    state.counters["order"] = order;
    state.counters["records"] = static_cast<double>(all.records.size());
    state.counters["fixed_ms"] = 1e3 * fixed / times;
    state.counters["accepted_per_s"] = accepted * times / whole;
    state.counters["net_accepted_per_s"] = accepted * times / (whole - fixed);
    state.counters["accepted_share"] = accepted / shadedFragments(made.receivers, all, weight);
    state.counters["fragment_bytes"] = fragmentBytes(order);
}

// a = b + s c over arrays larger than caches: the memory's bandwidth, counted as in STREAM.
void triad(State& state, Setup&) {
    constexpr int kChunks = 256;
    constexpr size_t kChunk = size_t{1} << 17;
    std::vector<float> a(kChunks * kChunk), b(a.size(), 1.0f), c(a.size(), 2.0f);
    for (auto _ : state) {
        parallelFor(kChunks, [&](int chunk) {
            const size_t first = static_cast<size_t>(chunk) * kChunk;
            for (size_t i = first; i < first + kChunk; ++i) {
                a[i] = b[i] + 3.0f * c[i];
            }
        });
        benchmark::ClobberMemory();
    }
    state.counters["bytes_per_s"] =
        benchmark::Counter(3.0 * sizeof(float) * static_cast<double>(a.size()),
                           benchmark::Counter::kIsIterationInvariantRate);
}

void composeFrame(State& state, Setup& setup, int order, bool estimate) {
    const MadeUpRecords& made = setup.madeUpRecords(order, kSplatRecords);
    const WeightParams weight = made.params.servingWeight();
    const SplatBuffer sums = splatGpu(setup.pool(), made.receivers, made.placement.cache, weight);
    const Image<vec3> traced(made.receivers.image.width, made.receivers.image.height);
    Frame frame;
    compose(made.receivers, sums, traced, true, frame);
    for (auto _ : state) {
        if (estimate) {
            benchmark::DoNotOptimize(neighbourErrors(made.receivers, made.placement.cache,
                                                     made.field.pixels, weight, frame.indirect));
        } else {
            compose(made.receivers, sums, traced, true, frame);
        }
    }
    state.counters["order"] = order;
}

void writeFile(State& state, Setup& setup, ExrLayers layers) {
    RenderParams params;
    params.width = params.height = 512;
    params.bounces = 1;
    params.caustics = 0;
    params.placement.accuracy = 2.0f;  // sooner there
    params.all_layers = true;
    params.quiet = true;
    const Frame frame = renderFrame(setup.load(kGlossyCornell), params).frame;
    const std::filesystem::path file =
        std::filesystem::temp_directory_path() / fmt::format("sheen-stages-{}.exr", getpid());
    for (auto _ : state) {
        writeExr(file.string(), frame, layers);
    }
    state.counters["bytes"] = static_cast<double>(std::filesystem::file_size(file));
    std::filesystem::remove(file);
}

benchmark::internal::Benchmark* add(const std::string& name,
                                    const std::function<void(State&)>& body) {
    return benchmark::RegisterBenchmark(name.c_str(), body)->Unit(benchmark::kMillisecond);
}

}  // namespace

void registerStartup(Setup& setup) {
    add("startup", [&setup](State& state) { startup(state, setup); })->UseRealTime()->Iterations(1);
}

void registerImage(Setup& setup) {
    for (const SceneChoice& choice : {kBySize[0], kBySize[3], kBySize[4], kAtrium}) {
        add(fmt::format("gbuffer/{}", choice.name), [&setup, choice](State& state) {
            gbuffer(state, setup, choice);
        })->UseRealTime();
    }
    for (int order : {0, 6}) {
        for (int count : {1024, 4096, 16384}) {
            add(fmt::format("placement/{}/{}", order, count), [&setup, order, count](State& state) {
                place(state, setup, order, count);
            })->UseRealTime();
        }
    }
    add("triad", [&setup](State& state) { triad(state, setup); })->UseRealTime();
    for (int order : kOrders) {
        add(fmt::format("splat/{}", order), [&setup, order](State& state) {
            splat(state, setup, order);
        })->UseManualTime();
    }
    for (int order : {0, 6}) {
        add(fmt::format("compose/{}", order), [&setup, order](State& state) {
            composeFrame(state, setup, order, false);
        })->UseRealTime();
        add(fmt::format("estimate/{}", order), [&setup, order](State& state) {
            composeFrame(state, setup, order, true);
        })->UseRealTime();
    }
    add("exr/basic", [&setup](State& state) {
        writeFile(state, setup, ExrLayers::kBasic);
    })->UseRealTime();
    add("exr/all", [&setup](State& state) {
        writeFile(state, setup, ExrLayers::kAll);
    })->UseRealTime();
}

}  // namespace sheen::bench
