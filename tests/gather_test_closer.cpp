// Records gathered by rays: where they look closer, and highlights smaller than a texel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gather/ray_gather.h"
#include "test_light.h"
#include "test_scenes.h"
#include "test_sites.h"

namespace sheen {
namespace {

constexpr HemisphereParams kSmallHemicube = {.kind = HemisphereKind::kHemicube, .size = 24};

// ---- Where to look closer -----------------------------------------------------------------------

// A dark room with a lamp in its ceiling, a third as wide as a texel of a record on the floor.
constexpr float kTexelWidth = 4.0f / 24.0f;
bool nearLamp(const vec3& p) {  // in its texel or in the next one
    return p.y > 0.9f && std::abs(p.x) < 2.0f * kTexelWidth && std::abs(p.z) < 2.0f * kTexelWidth;
}
Scene roomWithSmallLamp(float half = 0.027f) {
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseParams(vec3(0.5f))), true);
    addQuad(scene, vec3(-half, 0.999f, -half), vec3(2 * half, 0, 0), vec3(0, 0, 2 * half),
            addMaterial(scene, diffuseParams(vec3(0.5f), vec3(1000.0f))));
    return scene;
}

TEST(RayGatherer, LooksCloserWhereRecordsNearbySawLightChange) {
    const Scene scene = roomWithSmallLamp();
    const LitByCells lit(scene);
    constexpr int kRecords = 400;
    for (int order : {shared::DIFFUSE_ORDER, 4}) {
        // A record that met the lamp says where it is.
        std::vector<Contrast> found;
        for (const GatheredRecord& g :
             RayGatherer(lit.light, kSmallHemicube)
                 .gather(repeated(100, siteAt(vec3(0.1f, -1, 0), vec3(0, 1, 0), order)))) {
            for (const Contrast& c : g.contrasts) {
                EXPECT_TRUE(nearLamp(c.position)) << c.position.x << " " << c.position.z;
                EXPECT_GE(c.strength, 2.0f);
            }
            found.insert(found.end(), g.contrasts.begin(), g.contrasts.end());
        }
        ASSERT_FALSE(found.empty());
        // Its neighbours then err less, and by chance alone.
        struct Statistics {
            double mean = 0, error = 0;
        };
        const auto gatherWith = [&](const std::vector<Contrast>& contrasts) {
            std::vector<RecordSite> sites =
                repeated(kRecords, siteAt(vec3(0), vec3(0, 1, 0), order));
            for (RecordSite& site : sites) {
                site.contrasts = contrasts;
            }
            double sum = 0.0, squares = 0.0;
            for (const GatheredRecord& g : RayGatherer(lit.light, kSmallHemicube).gather(sites)) {
                sum += g.record.irradiance.y;
                squares += g.record.irradiance.y * g.record.irradiance.y;
            }
            const double mean = sum / kRecords;
            return Statistics{mean, std::sqrt((squares / kRecords - mean * mean) / kRecords)};
        };
        const Statistics alone = gatherWith({});
        const Statistics told = gatherWith(found);
        EXPECT_LT(told.error, alone.error / 4.0);
        EXPECT_NEAR(told.mean, alone.mean, 3.0 * std::hypot(told.error, alone.error));
    }
}

TEST(RayGatherer, TheFirstRecordsLookTwice) {
    const Scene scene = roomWithSmallLamp();
    const LitByCells lit(scene);
    constexpr int kRecords = 2000;
    std::vector<RecordSite> sites = repeated(kRecords, siteAt(vec3(0), vec3(0, 1, 0)));
    double means[2], deviations[2];
    for (int first = 0; first < 2; ++first) {
        for (RecordSite& site : sites) {
            site.first = first != 0;
        }
        double sum = 0.0, squares = 0.0;
        for (const GatheredRecord& g : RayGatherer(lit.light, kSmallHemicube).gather(sites)) {
            sum += g.record.irradiance.y;
            squares += g.record.irradiance.y * g.record.irradiance.y;
        }
        means[first] = sum / kRecords;
        deviations[first] = std::sqrt(squares / kRecords - means[first] * means[first]);
    }
    EXPECT_LT(deviations[1], deviations[0]);
    EXPECT_NEAR(means[1], means[0],
                3.0 * std::hypot(deviations[0], deviations[1]) / std::sqrt(kRecords));
}

TEST(RayGatherer, LightTooFaintToCompareIsKept) {
    // Radiance whose sum over the hemisphere has no finite inverse.
    Scene scene;
    constexpr float kFaint = 1e-37f;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseParams(vec3(0.5f), vec3(kFaint))),
           true);
    const LitByCells lit(scene);
    const RecordSite site = siteAt(vec3(0.1f, -1, 0.2f), vec3(0, 1, 0));
    const std::vector<GatheredRecord> g = RayGatherer(lit.light, kSmallHemicube).gather({&site, 1});
    EXPECT_NEAR(g[0].record.irradiance.y, kPi * kFaint, 1e-2f * kPi * kFaint);
    EXPECT_TRUE(g[0].contrasts.empty());
}

TEST(RayGatherer, ContrastsOfSmallHemispheresSayWhatThoseOfLargeOnesDo) {
    // A lamp smaller than their texels, which records nearby have told of.
    const Scene scene = roomWithSmallLamp(0.015f);
    const LitByCells lit(scene);
    double strengths[2];
    for (int far = 0; far < 2; ++far) {
        Random random(1);
        std::vector<RecordSite> sites;
        for (int i = 0; i < 400; ++i) {
            const vec3 p = random.point(-0.3f, 0.3f);
            sites.push_back(siteAt(vec3(p.x, 0, p.z), vec3(0, 1, 0)));
            sites.back().reach = far ? 60.0f : 1.0f;
            sites.back().contrasts = {{vec3(0, 0.999f, 0), 90.0f}};
        }
        double sum = 0.0;
        for (const GatheredRecord& g : RayGatherer(lit.light, kSmallHemicube).gather(sites)) {
            float strongest = 0.0f;
            for (const Contrast& c : g.contrasts) {
                strongest = std::max(strongest, c.strength);
            }
            sum += strongest;
        }
        strengths[far] = sum / static_cast<double>(sites.size());
    }
    EXPECT_NEAR(strengths[0] / strengths[1], 1.0, 0.3);
}

TEST(RayGatherer, ContrastsTakeRaysAsTheSideOfTheHemisphere) {
    // Nothing here varies of itself.
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseParams(vec3(0.5f), vec3(1))), true);
    const LitByCells lit(scene);
    constexpr float kStrength = 12.0f;
    for (float reach : {0.0f, 1.0f, 60.0f}) {
        RecordSite site = siteAt(vec3(0.01f, -1, 0.02f), vec3(0, 1, 0));
        site.reach = reach;
        int64_t cast[2];
        for (int told = 0; told < 2; ++told) {
            if (told != 0) {
                site.contrasts = {{vec3(0.1f, 1, 0.1f), kStrength}};
            }
            RayGatherer gatherer(lit.light, kSmallHemicube);
            gatherer.gather({&site, 1});
            cast[told] = gatherer.rays();
        }
        const float scale = static_cast<float>(sideForReach(24, reach)) / 24.0f;
        EXPECT_EQ(cast[1] - cast[0], 4 * static_cast<int>(scale * kStrength)) << reach;
    }
}

// ---- Highlights smaller than a texel ------------------------------------------------------------

// A mirror above the site and one light. What arrives is what the light's image behind the mirror
// would send.
TEST(RayGatherer, AMirrorsHighlightIsNeitherMissedNorABlotch) {
    // A record sees the highlight through about one texel: the sum of a few rays, whose lobe has
    // long tails. Unfiltered, one in a thousand records saw it, a thousand times too bright.
    constexpr double kLeast = 0.4, kMost = 2.0, kMeanError = 0.1;
    constexpr int kRecords = 300;
    constexpr float kCeiling = 1.0f;
    for (float roughness : {0.0f, 0.05f, 0.15f}) {
        for (const PunctualLight& light : {pointLight(vec3(0.3f, 0.4f, 0.2f), vec3(1)),
                                           pointLight(vec3(-0.8f, 0.9f, 0.4f), vec3(1)),
                                           directionalLight(vec3(0.3f, 1.0f, 0.1f), vec3(1))}) {
            Scene scene;
            addQuad(scene, vec3(-6, kCeiling, -6), vec3(12, 0, 0), vec3(0, 0, 12),
                    addMaterial(scene, glossyParams(vec3(1.0f), 1.0f, roughness)));
            scene.lights.push_back(light);
            PunctualLight image = light;
            image.position.y = 2.0f * kCeiling - light.position.y;
            image.direction.y = -light.direction.y;
            const LightSample l = shared::sampleLight(image, vec3(0));
            const double expected = l.irradiance.x * l.wi.y;
            const LitByCells lit(scene);
            const std::vector<RecordSite> sites =
                repeated(kRecords, siteAt(vec3(0), vec3(0, 1, 0)));
            double sum = 0.0, least = kInfinity, most = 0.0;
            for (const GatheredRecord& g : RayGatherer(lit.light, kSmallHemicube).gather(sites)) {
                const double e = g.record.irradiance.x;
                sum += e;
                least = std::min(least, e);
                most = std::max(most, e);
            }
            SCOPED_TRACE(testing::Message() << "roughness " << roughness << " light at "
                                            << light.position.y << " kind " << light.kind);
            EXPECT_NEAR(sum / kRecords, expected, kMeanError * expected);
            EXPECT_GT(least, kLeast * expected);
            EXPECT_LT(most, kMost * expected);
        }
    }
}

}  // namespace
}  // namespace sheen
