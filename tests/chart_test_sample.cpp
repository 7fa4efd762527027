#include "chart_test_sample.h"

#include <limits>

#include "image/png.h"

namespace sheen {

const char* const kHostileName =
    "</script><script>document.title=\"hacked\"//<!-- 'r\xc3\xb6\xc3\xb6m', \"1\"\n{{data}}\xff";

namespace {

std::string flatPng(uint8_t red, uint8_t green) {
    return pngBytes(Image<Rgb8>(8, 8, Rgb8{red, green, 40}));
}

ChartPoint makePoint(const std::string& method, const std::string& setting, double seconds,
                     double error) {
    ChartPoint point;
    point.method = method;
    point.setting = setting;
    point.file = "points/" + method + ".exr";
    Measurement& m = point.measured;
    m.host = {.version = "1.2.3", .build = "0123456789abcdef", .cpu = "A CPU", .threads = 2};
    for (const double s : {seconds, 1.1 * seconds, 0.9 * seconds}) {
        m.runs.push_back({s, {{"load", 0.1 * s}, {"gather", 0.6 * s}, {"other", 0.3 * s}}});
    }
    m.records = method == "reference" ? 0 : 100;
    m.gl_renderer = method == "reference" ? "" : "A renderer";
    Comparison& e = point.errors;
    e.rel_rmse = error;
    e.rel_mse = error * error;
    e.bias = -0.1 * error;
    e.median = 0.5 * error;
    e.p99 = 5 * error;
    e.max = 20 * error;
    e.tile_max = 4 * error;
    e.noise_share = 0.1;
    e.excluded = 1;
    e.compared = 63;
    e.judged = true;
    const auto shade = static_cast<uint8_t>(20 * seconds);
    point.image_png = flatPng(shade, 200);
    point.heatmap_png = flatPng(shade, 90);
    return point;
}

std::vector<SweepMethod> sampleMethods() {
    return chooseMethods({"radiance", "irradiance", "reference"}, 1);
}

ChartScene makeScene(const std::string& name) {
    ChartScene scene;
    scene.name = name;
    scene.file = name + ".glb";
    scene.camera = "front";
    scene.reference_file = "references/a.exr";
    scene.reference_seconds = 60;
    scene.noise_rel_rmse = 0.02;
    scene.reference_png = flatPng(0, 0);
    for (const SweepMethod& method : sampleMethods()) {
        const double slower = 1 + static_cast<double>(scene.points.size());
        scene.points.push_back(makePoint(method.name, "fine 1", 0.5 * slower, 0.3 * slower));
        scene.points.push_back(makePoint(method.name, "fine 2", 0.4 * slower, 0.2 * slower));
        scene.points.push_back(makePoint(method.name, "fine 3", 1.1 * slower, 0.05 * slower));
        scene.points[scene.points.size() - 3].measured.cold_seconds = slower;
    }
    return scene;
}

}  // namespace

Chart sampleChart() {
    Chart chart;
    chart.host = {.version = "1.2.3", .build = "0123456789abcdef", .cpu = "A CPU", .threads = 2};
    chart.width = chart.height = 8;
    chart.reference_spp = 64;
    chart.repeats = 3;
    chart.methods = sampleMethods();
    chart.scenes = {makeScene("room"), makeScene(kHostileName)};
    std::vector<ChartPoint>& points = chart.scenes[1].points;
    points[0].errors.judged = false;
    points[1].errors.rel_rmse = 0;
    points[2].errors.rel_rmse = std::numeric_limits<double>::infinity();
    chart.sequences = Sequences{.measured = "By hand.",
                                .points = {{"kite", "anew", 0.02, 0.03, 0.001, 4.0},
                                           {"kite", "temporal", 0.02, 0.0005, 0.001, 1.0},
                                           {kHostileName, "anew", 0.5, 0.25, 0.001, 2.0}}};
    chart.bakes = Bakes{.measured = "Baked by hand.",
                        .points = {{"cornell", "records", "accuracy 1.2", 0.02, true, 0.06, 3.0},
                                   {"cornell", "records", "accuracy 0.4", 0.01, true, 0.13, 5.0},
                                   {"cornell", "paths", "spp 16", 0.08, false, 0.0, 2.0},
                                   {kHostileName, "paths", "spp 16", 0.5, true, 0.0, 2.5}}};
    return chart;
}

}  // namespace sheen
