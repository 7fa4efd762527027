#include "accuracy_raster.h"

#include <fmt/format.h>

#include "accuracy_gather.h"
#include "accuracy_truth.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "gather/raster_gather.h"
#include "raster/gpu_scene.h"

namespace sheen::bench {
namespace {

// One way to see a hemisphere; `published`: its error in the chapter, Sibenik cathedral.
struct Way {
    std::string name;
    HemisphereParams params;
    std::string published;
    std::vector<float> irradiance = {};  // grey, [scene][site]
    double milliseconds = 0;             // a record, over all scenes
};

std::vector<Way> allWays() {
    using Kind = HemisphereKind;
    return {{"plane", {Kind::kPlane, 64, 2.0f}, "18.1%"},
            {"larsen", {Kind::kLarsen, 64, 2.0f}, "10.4%"},
            {"border", {Kind::kBorder, 64, 2.0f}, "5.8%"},
            {"plane", {Kind::kPlane, 64, 3.0f}, ""},
            {"larsen", {Kind::kLarsen, 64, 3.0f}, ""},
            {"border", {Kind::kBorder, 64, 3.0f}, ""},
            {"hemicube", {Kind::kHemicube, 32, 1.0f}, ""},
            {"hemicube", {Kind::kHemicube, 38, 1.0f}, ""}};
}

// A scene on the GPU, lit; freed where it was made.
class GpuStage {
  public:
    GpuStage(gl::WorkerPool& pool, const Scene& scene) : pool_(pool) {
        pool_.runOnFirst([&] { gpu = uploadScene(scene); });
        renderShadowMaps(pool_, scene, gpu);
    }
    ~GpuStage() {
        pool_.release([this](int worker) {
            if (worker == 0) {
                gpu = {};
            }
        });
    }
    GpuStage(const GpuStage&) = delete;
    GpuStage& operator=(const GpuStage&) = delete;

  private:
    gl::WorkerPool& pool_;

  public:
    GpuScene gpu;
};

void gatherWays(const BenchScenes& scenes, int sites, std::vector<Way>& ways) {
    gl::WorkerPool pool(threadCount());
    for (const auto& scene : scenes) {
        const std::span<const RecordSite> of_scene(scene->sites.data(), static_cast<size_t>(sites));
        const GpuStage stage(pool, scene->scene);
        for (Way& way : ways) {
            RasterGatherer gatherer(pool, stage.gpu, way.params);
            gatherer.gather(of_scene.first(1));  // shaders are compiled by their first draw
            const Timer timer;
            for (const GatheredRecord& g : gatherer.gather(of_scene)) {
                way.irradiance.push_back(grey(g.record.irradiance));
            }
            way.milliseconds +=
                1e3 * timer.seconds() / (sites * static_cast<double>(scenes.size()));
        }
    }
}

}  // namespace

void studyRaster(const BenchScenes& scenes, int sites, const Output& output) {
    std::vector<Way> ways = allWays();
    gatherWays(scenes, sites, ways);
    const hemispheres::Truth truth = hemispheres::traceTruth(scenes, sites, 1);

    std::vector<std::string> head = {"hemisphere", "h", "texels", "published", "rasterised"};
    for (const auto& scene : scenes) {
        head.push_back(scene->name);
    }
    head.insert(head.end(), {"bias", "point by point", "ms a record"});
    Table table(head);
    std::string csv = "kind,extent,size,irradiance,bias\n";
    const auto count = static_cast<size_t>(sites);
    std::vector<double> noises;
    for (const Way& way : ways) {
        std::vector<double> by_scene, points;
        double bias = 0.0;
        noises.clear();
        for (size_t first = 0; first < way.irradiance.size(); first += count) {
            const Errors e =
                errorsOf({&way.irradiance[first], count}, {&truth.values.of[0][first], count},
                         {&truth.variance.of[0][first], count});
            by_scene.push_back(e.rel_rmse);
            points.push_back(e.point_rms);
            noises.push_back(e.noise);
            bias += e.bias / static_cast<double>(scenes.size());
        }
        const bool cube = way.params.kind == HemisphereKind::kHemicube;
        std::vector<std::string> cells = {
            way.name, cube ? "" : fmt::format("{}", way.params.extent),
            std::to_string(way.params.size), way.published, percent(rms(by_scene))};
        for (double error : by_scene) {
            cells.push_back(percent(error));
        }
        cells.push_back(fmt::format("{:+.1f}%", 100.0 * bias));
        cells.push_back(percent(rms(points)));
        cells.push_back(fmt::format("{:.2f}", way.milliseconds));
        table.add(cells);
        csv += fmt::format("{},{},{},{},{}\n", way.name, way.params.extent, way.params.size,
                           rms(by_scene), bias);
    }
    output.write("raster.csv", csv);
    output.write("raster.md",
                 fmt::format("{}\n{} points a scene. Noise of the truth, already taken "
                             "off: {}.\n",
                             table.text(), sites, percent(rms(noises))));
}

}  // namespace sheen::bench
