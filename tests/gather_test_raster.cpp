// Records gathered by the rasteriser: closed forms, the same light as by rays, and what their
// turned frames depend on.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "gather/raster_gather.h"
#include "gather/ray_gather.h"
#include "test_light.h"
#include "test_scenes.h"
#include "test_sites.h"
#include "test_stage.h"

namespace sheen {
namespace {

constexpr HemisphereParams kRasterHemicube = {.kind = HemisphereKind::kHemicube, .size = 32};
constexpr HemisphereParams kRasterKinds[] = {
    kRasterHemicube,
    {.kind = HemisphereKind::kBorder, .size = 48, .extent = 2.0f},
    {.kind = HemisphereKind::kPlane, .size = 48, .extent = 3.0f},
    {.kind = HemisphereKind::kLarsen, .size = 48, .extent = 3.0f}};

// Diffuse and glossy ones in turns.
std::vector<RecordSite> sitesInRoom(int count) {
    std::vector<RecordSite> sites = sitesInGlossyRoom(count);
    for (size_t i = 1; i < sites.size(); i += 2) {
        sites[i].order = 4;
    }
    return sites;
}

std::vector<GatheredRecord> gather(const Scene& scene, const std::vector<RecordSite>& sites,
                                   const HemisphereParams& params = kRasterHemicube,
                                   int workers = 2) {
    TestStage stage(scene, workers);
    RasterGatherer gatherer(stage.pool, stage.gpu, params);
    return gatherer.gather(sites);
}

TEST(RasterGatherer, TheSameBitsForAnyWorkers) {
    const Scene scene = glossyRoom();
    const std::vector<RecordSite> sites = sitesInRoom(70);
    const std::vector<GatheredRecord> one = gather(scene, sites, kRasterHemicube, 1);
    const std::vector<GatheredRecord> three = gather(scene, sites, kRasterHemicube, 3);
    for (size_t i = 0; i < sites.size(); ++i) {
        EXPECT_EQ(std::memcmp(&one[i].record, &three[i].record, sizeof(Record)), 0) << i;
        EXPECT_TRUE(one[i].sh == three[i].sh) << i;
    }
}

TEST(RasterGatherer, AFramesTurnFollowsFromTheSeedAlone) {
    const Scene scene = glossyRoom();
    std::vector<RecordSite> sites = sitesInRoom(24);
    const std::vector<GatheredRecord> first = gather(scene, sites);
    std::reverse(sites.begin(), sites.end());
    const std::vector<GatheredRecord> reversed = gather(scene, sites);
    int alike = 0;
    for (size_t i = 0; i < sites.size(); ++i) {
        const Record& a = first[i].record;
        const Record& b = reversed[sites.size() - 1 - i].record;
        EXPECT_EQ(a.tangent, b.tangent) << i;
        EXPECT_NEAR(glm::dot(a.tangent, a.normal), 0.0f, 1e-6f);
        EXPECT_NEAR(glm::length(a.tangent), 1.0f, 1e-6f);
        // Three normals in turn.
        if (i >= 3) {
            alike += glm::dot(a.tangent, first[i - 3].record.tangent) > 0.999f ? 1 : 0;
        }
    }
    EXPECT_LE(alike, 4);
}

// Walls that shine alike: whatever the turn, the same irradiance and no gradient.
TEST(RasterGatherer, AFurnaceWhateverTheTurn) {
    constexpr float kFurnaceError = 2e-3f;
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseParams(vec3(0), vec3(1, 2, 3))),
           true);
    const std::vector<RecordSite> sites = {siteAt({0.2f, -1, 0.3f}, {0, 1, 0}),
                                           siteAt({-1, 0.4f, -0.5f}, {1, 0, 0}, 4),
                                           siteAt({0.7f, 0.1f, -1}, {0, 0, 1})};
    for (const HemisphereParams& params : kRasterKinds) {
        const bool whole = params.kind != HemisphereKind::kPlane;
        for (const GatheredRecord& g : gather(scene, sites, params)) {
            const Record& r = g.record;
            const vec3 expected = kPi * vec3(1, 2, 3);
            for (int c = 0; c < 3; ++c) {
                if (whole) {
                    EXPECT_NEAR(r.irradiance[c], expected[c], kFurnaceError * expected[c]);
                } else {
                    EXPECT_LT(r.irradiance[c], expected[c]);
                }
            }
            EXPECT_LT(glm::length(r.translation_g), 1e-3f);
        }
    }
}

// The hemisphere of a tilted shading normal reaches below the surface, where all that can be seen
// is the lit surface itself.
TEST(RasterGatherer, NothingComesFromBelowTheGeometricSurface) {
    Scene scene;
    addQuad(scene, vec3(-5, 0, 5), vec3(10, 0, 0), vec3(0, 0, -10),
            addMaterial(scene, diffuseParams(vec3(0.8f))));
    scene.lights.push_back(pointLight(vec3(0, 3, 0), vec3(50)));
    for (int order : {0, 4}) {
        RecordSite site = siteAt({0.3f, 0, 0.2f}, glm::normalize(vec3(0.6f, 1, 0.2f)), order);
        site.geometric_normal = vec3(0, 1, 0);
        for (const HemisphereParams& params : kRasterKinds) {
            const GatheredRecord g = gather(scene, {site}, params).front();
            EXPECT_EQ(g.record.irradiance, vec3(0.0f));
            EXPECT_EQ(g.record.radius, kInfinity);
            EXPECT_EQ(g.curvature, 0.0f);
            for (float c : g.sh) {
                EXPECT_EQ(c, 0.0f);
            }
        }
        const LitByCells lit(scene);
        EXPECT_EQ(RayGatherer(lit.light, kRasterHemicube).gather({&site, 1})[0].record.irradiance,
                  vec3(0.0f));
    }
}

// Light, its rotation, and its translation, which goes by the planes that both know.
TEST(RasterGatherer, SeesWhatRaysSee) {
    // Of the irradiance, root mean square over the sites; at one of them a texel at the edge of a
    // shadow counts for more.
    constexpr double kIrradiance = 0.02, kRotation = 0.02, kTranslation = 0.12;
    const Scene scene = cornellRoom(diffuseParams(vec3(0.6f)), diffuseParams(vec3(0.5f)));
    std::vector<RecordSite> sites = sitesInRoom(24);
    for (RecordSite& site : sites) {
        site.order = shared::DIFFUSE_ORDER;
    }
    const LitByCells lit(scene);
    const HemisphereParams fine = {.kind = HemisphereKind::kHemicube, .size = 64};
    const std::vector<GatheredRecord> truth = RayGatherer(lit.light, fine).gather(sites);
    const std::vector<GatheredRecord> seen = gather(scene, sites, fine);
    double irradiance = 0.0, rotation = 0.0, translation = 0.0;
    for (size_t i = 0; i < sites.size(); ++i) {
        const Record& a = seen[i].record;
        const Record& b = truth[i].record;
        const double scale = b.irradiance.y;
        const auto square = [&](double difference) {
            return difference * difference / (scale * scale * static_cast<double>(sites.size()));
        };
        irradiance += square(a.irradiance.y - b.irradiance.y);
        rotation += square(glm::length(a.rotation_g - b.rotation_g));
        translation += square(glm::length(a.translation_g - b.translation_g));
    }
    EXPECT_LT(std::sqrt(irradiance), kIrradiance);
    EXPECT_LT(std::sqrt(rotation), kRotation);
    EXPECT_LT(std::sqrt(translation), kTranslation);
}

}  // namespace
}  // namespace sheen
