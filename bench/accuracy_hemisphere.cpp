#include "accuracy_hemisphere.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "accuracy_gather.h"
#include "accuracy_truth.h"
#include "core/parallel.h"
#include "sh/brdf_sh.h"

namespace sheen::bench {
using namespace hemispheres;

namespace {

constexpr char kProductWay[] = "gather";

// Weights of a layout's texels: cosine, and the lobe at each view and azimuth.
struct Kernels {
    std::vector<float> irradiance;
    std::vector<float> lobes[kViews][kAzimuths];
};

Kernels makeKernels(const Hemisphere& h) {
    const auto count = static_cast<size_t>(h.texelCount());
    const bool whole =
        h.params.kind == HemisphereKind::kBorder || h.params.kind == HemisphereKind::kHemicube;
    Kernels k;
    k.irradiance = h.cosines;
    std::vector<std::vector<FootprintSample>> footprints;
    for (int t = 0; t < h.texelCount(); ++t) {
        footprints.push_back(footprint(h, t));
        float covered = 0.0f;
        for (const FootprintSample& s : footprints.back()) {
            covered += s.solid_angle;
        }
        for (FootprintSample& s : footprints.back()) {
            s.solid_angle *= h.solid_angles[static_cast<size_t>(t)] / covered;  // kLarsen: more
        }
    }
    for (int view = 0; view < kViews; ++view) {
        const float albedo = lobeAlbedo(viewer(view, 0));
        for (int azimuth = 0; azimuth < kAzimuths; ++azimuth) {
            const vec3 wo = viewer(view, azimuth);
            std::vector<float>& lobe = k.lobes[view][azimuth];
            lobe.resize(count);
            double sum = 0.0;
            for (size_t t = 0; t < count; ++t) {
                for (const FootprintSample& s : footprints[t]) {
                    lobe[t] += s.solid_angle * metalLobe(kAlpha, vec3(0, 0, 1), wo, s.direction);
                }
                sum += lobe[t];
            }
            // A hemisphere without gaps reproduces constant light, whatever its quadrature.
            for (float& value : lobe) {
                value *= whole ? static_cast<float>(albedo / sum) : 1.0f;
            }
        }
    }
    return k;
}

// One way to see a hemisphere; `weighed_as`: what the same texels are made of.
struct Layout {
    HemisphereParams params;
    TexelRays rays;
    std::string way;
    std::vector<HemisphereKind> weighed_as;
};

Layout planeLayout(int size, float extent) {
    return {{HemisphereKind::kPlane, size, extent},
            {},
            "middles",
            {HemisphereKind::kPlane, HemisphereKind::kLarsen, HemisphereKind::kBorder}};
}

Layout cubeLayout(int size, const TexelRays& rays, const std::string& name) {
    return {{HemisphereKind::kHemicube, size, 1.0f}, rays, name, {HemisphereKind::kHemicube}};
}

std::vector<Layout> sizeLayouts() {
    std::vector<Layout> layouts;
    for (float extent : {1.5f, 2.0f, 3.0f, 4.0f, 5.0f}) {
        for (int size : {16, 32, 64}) {
            layouts.push_back(planeLayout(size, extent));
        }
    }
    layouts.push_back(planeLayout(128, 3.0f));
    for (int size : {16, 24, 32, 48, 64, 128}) {
        layouts.push_back(cubeLayout(size, {}, "middles"));
    }
    for (int size : {16, 24, 32, 48, 64}) {
        layouts.push_back(cubeLayout(size, {.random = true}, "random"));
    }
    for (int size : {16, 32}) {
        layouts.push_back(cubeLayout(size, {.side = 2}, "4 middles"));
        layouts.push_back(cubeLayout(size, {.side = 2, .random = true}, "4 random"));
    }
    layouts.push_back(cubeLayout(16, {.side = 4, .random = true}, "16 random"));
    return layouts;
}

std::string kindName(HemisphereKind kind) {
    switch (kind) {
        case HemisphereKind::kPlane:
            return "plane";
        case HemisphereKind::kLarsen:
            return "larsen";
        case HemisphereKind::kBorder:
            return "border";
        case HemisphereKind::kHemicube:
            return "hemicube";
    }
    return "";
}

// One row of the tables.
struct Row {
    std::string kind, way;
    float extent = 0.0f;
    int size = 0;
    int rays = 0;
    Values values;
};

void traceLayout(const BenchScenes& scenes, int sites, const Layout& layout,
                 std::vector<Row>& rows) {
    const auto all = scenes.size() * static_cast<size_t>(sites);
    const Hemisphere seen_by = makeHemisphere(layout.params);
    std::vector<Kernels> kernels;
    const size_t first = rows.size();
    for (HemisphereKind kind : layout.weighed_as) {
        HemisphereParams params = layout.params;
        params.kind = kind;
        kernels.push_back(makeKernels(makeHemisphere(params)));
        rows.push_back({.kind = kindName(kind),
                        .way = layout.way,
                        .extent = layout.params.extent,
                        .size = layout.params.size,
                        .rays = seen_by.texelCount() * layout.rays.side * layout.rays.side,
                        .values = Values(all)});
    }
    parallelFor(static_cast<int>(all), [&](int index) {
        const BenchScene& scene = *scenes[static_cast<size_t>(index / sites)];
        const RecordSite& site = scene.sites[static_cast<size_t>(index % sites)];
        TexelRays how = layout.rays;
        how.seed = static_cast<uint32_t>(index);
        how.above = site.geometric_normal;
        const std::vector<vec4> texels =
            traceTexels(scene.light, seen_by, tangentFrame(site.normal), site.eye(), how).light;
        std::vector<float> light(texels.size());
        std::transform(texels.begin(), texels.end(), light.begin(),
                       [](const vec4& t) { return grey(t); });
        for (size_t k = 0; k < kernels.size(); ++k) {
            Values& values = rows[first + k].values;
            const auto i = static_cast<size_t>(index);
            values.of[0][i] = dotProduct(kernels[k].irradiance.data(), light.data(), light.size());
            for (int view = 0; view < kViews; ++view) {
                values.of[1 + view][i] = dotProduct(kernels[k].lobes[view][azimuthOf(index)].data(),
                                                    light.data(), light.size());
            }
        }
    });
}

// The product's gather, its extra rays included: of records that come after others, since all
// points are gathered twice, and the second time know what their neighbours found the first time.
// It hands out no texels: its lobes go through spherical harmonics of order 10.
void traceProduct(const BenchScenes& scenes, int sites, int size, std::vector<Row>& rows) {
    constexpr int kOrder = shared::SH_MAX_ORDER;
    const auto all = scenes.size() * static_cast<size_t>(sites);
    const HemisphereParams params{HemisphereKind::kHemicube, size, 1.0f};
    rows.push_back({.kind = "hemicube",
                    .way = kProductWay,
                    .extent = 1.0f,
                    .size = size,
                    .rays = 0,
                    .values = Values(all)});
    Values& values = rows.back().values;
    const BrdfRotator rotator(kOrder);
    int64_t rays = 0;
    for (size_t s = 0; s < scenes.size(); ++s) {
        const Tracer& tracer = scenes[s]->tracer;
        const ScatteredOnce light(tracer, nullptr, {});
        RayGatherer gatherer(light, params);
        std::vector<RecordSite> of_scene(scenes[s]->sites.begin(),
                                         scenes[s]->sites.begin() + sites);
        for (RecordSite& site : of_scene) {
            site.order = kOrder;
        }
        tellContrasts(gatherer, of_scene);
        const int64_t rays_before = gatherer.rays();
        const std::vector<GatheredRecord> records = gatherInBatches(gatherer, of_scene);
        rays += gatherer.rays() - rays_before;
        for (size_t r = 0; r < records.size(); ++r) {
            const size_t i = s * static_cast<size_t>(sites) + r;
            const mat3 frame = tangentFrame(of_scene[r].normal);
            values.of[0][i] = grey(records[r].record.irradiance);
            for (int view = 0; view < kViews; ++view) {
                const vec3 wo = viewer(view, azimuthOf(static_cast<int>(i)));
                float lobe[kOrder * kOrder];
                rotator.rotate(brdfSh(wo.z, std::sqrt(kAlpha)), kMetalF0, 1.0f, frame[2],
                               frame * wo, lobe);
                values.of[1 + view][i] = grey(convolveRecord(
                    records[r].record, records[r].sh.data(), lobe, kOrder, of_scene[r].position));
            }
        }
    }
    rows.back().rays = static_cast<int>(rays / static_cast<int64_t>(all));
}

// Over scenes: the root mean square of their errors.
struct RowErrors {
    double rel_rmse[kQuantities] = {};
    double noise[kQuantities] = {};
    double point_rms = 0;
    double bias = 0;
    std::vector<double> irradiance_by_scene;
};

RowErrors errorsOfRow(const Row& row, const Truth& truth, size_t scenes, int sites) {
    RowErrors result;
    std::vector<double> points;
    for (int q = 0; q < kQuantities; ++q) {
        std::vector<double> by_scene, noises;
        for (size_t s = 0; s < scenes; ++s) {
            const size_t first = s * static_cast<size_t>(sites);
            const auto count = static_cast<size_t>(sites);
            const Errors e =
                errorsOf({&row.values.of[q][first], count}, {&truth.values.of[q][first], count},
                         {&truth.variance.of[q][first], count});
            by_scene.push_back(e.rel_rmse);
            noises.push_back(e.noise);
            if (q == 0) {
                points.push_back(e.point_rms);
                result.bias += e.bias / static_cast<double>(scenes);
            }
        }
        result.rel_rmse[q] = rms(by_scene);
        result.noise[q] = rms(noises);
        if (q == 0) {
            result.irradiance_by_scene = by_scene;
        }
    }
    result.point_rms = rms(points);
    return result;
}

void study(const BenchScenes& scenes, int sites, const std::vector<Layout>& layouts,
           const std::vector<int>& product_sizes, const std::string& name, const Output& output) {
    std::vector<Row> rows;
    const Truth truth = traceTruth(scenes, sites);
    for (const Layout& layout : layouts) {
        traceLayout(scenes, sites, layout, rows);
    }
    for (int size : product_sizes) {
        traceProduct(scenes, sites, size, rows);
    }

    std::string csv = "kind,way,extent,size,rays,irradiance,lobe45,lobe75,lobe85\n";
    std::vector<std::string> head = {"hemisphere",    "h",         "texels", "rays",
                                     "rays a record", "irradiance"};
    for (const auto& scene : scenes) {
        head.push_back(scene->name);
    }
    for (const char* column : {"bias", "point by point", "lobe 45", "lobe 75", "lobe 85"}) {
        head.emplace_back(column);
    }
    Table table(head);
    RowErrors e;
    for (const Row& row : rows) {
        e = errorsOfRow(row, truth, scenes.size(), sites);
        csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", row.kind, row.way, row.extent, row.size,
                           row.rays, e.rel_rmse[0], e.rel_rmse[1], e.rel_rmse[2], e.rel_rmse[3]);
        const bool cube = row.kind == "hemicube";
        std::vector<std::string> cells = {row.kind,
                                          cube ? "" : fmt::format("{}", row.extent),
                                          std::to_string(row.size),
                                          row.way,
                                          std::to_string(row.rays),
                                          percent(e.rel_rmse[0])};
        for (double v : e.irradiance_by_scene) {
            cells.push_back(percent(v));
        }
        cells.push_back(fmt::format("{:+.1f}%", 100.0 * e.bias));
        cells.push_back(percent(e.point_rms));
        for (int view = 0; view < kViews; ++view) {
            cells.push_back(percent(e.rel_rmse[1 + view]));
        }
        table.add(cells);
    }
    output.write(name + ".csv", csv);
    output.write(name + ".md",
                 fmt::format("{}\n{} points a scene. Noise of the truth, already taken off: "
                             "irradiance {}, lobe at 45 degrees {}, at 75 {}, at 85 {}.\n",
                             table.text(), sites, percent(e.noise[0]), percent(e.noise[1]),
                             percent(e.noise[2]), percent(e.noise[3])));
}

}  // namespace

void studyHemispheres(const BenchScenes& scenes, int sites, const Output& output) {
    study(scenes, sites,
          {planeLayout(64, 2.0f), planeLayout(64, 3.0f), cubeLayout(32, {}, "middles"),
           cubeLayout(32, {.random = true}, "random")},
          {20, 38}, "hemispheres", output);
}

void studyHemisphereSizes(const BenchScenes& scenes, int sites, const Output& output) {
    study(scenes, sites, sizeLayouts(), {12, 16, 20, 24, 32, 40}, "hemisphere_sizes", output);
}

}  // namespace sheen::bench
