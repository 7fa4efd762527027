// What records miss of the light that their pixels' lobes see, and the filter of rays.
#include <gtest/gtest.h>

#include <cmath>

#include "gather/integrate.h"
#include "glossy/ray_filter.h"
#include "scene/shared.h"
#include "test_placement.h"

namespace sheen {
namespace {

// A site on a floor, seen at an angle.
RecordSite siteWithLobe(float alpha, const vec3& toward_viewer) {
    return {.normal = vec3(0, 0, 1),
            .geometric_normal = vec3(0, 0, 1),
            .toward_viewer = glm::normalize(toward_viewer),
            .lobe = {.alpha = alpha, .f0 = 0.04f, .f90 = 1.0f}};
}

// What it sees where light comes from as far as `lit` says so.
GatheredRecord look(const RecordSite& site, const std::function<float(const vec3&)>& lit) {
    const Hemisphere h = makeHemisphere({.size = 48});
    const mat3 frame = tangentFrame(site.normal);
    SeenTexels seen;
    for (const vec3& direction : h.directions) {
        seen.light.emplace_back(vec3(lit(frame * direction)), 1.0f);
    }
    return integrateHemisphere(h, seen, {}, site);
}

TEST(LobeLight, ConstantLightIsSeenExactly) {
    for (float alpha : {0.1f, 0.5f, 1.0f}) {
        const GatheredRecord g =
            look(siteWithLobe(alpha, {2, 0, 1}), [](const vec3&) { return 3.0f; });
        EXPECT_NEAR(g.lobe_light.x, 3.0f, 1e-4f) << alpha;
        EXPECT_GT(g.lobe_texels, 1.0f);
    }
}

// Light from one half of the hemisphere, against the lobe's integral by a fine grid of directions.
TEST(LobeLight, IsTheLobesMean) {
    constexpr float kTexels = 0.01f;
    for (float alpha : {0.3f, 0.64f, 1.0f}) {
        const RecordSite site = siteWithLobe(alpha, {1, 0.3f, 0.5f});
        const vec3 aside = glm::normalize(vec3(-0.8f, 0.5f, 0.3f));
        const auto lit = [&](const vec3& d) { return glm::dot(d, aside) > 0.4f ? 1.0f : 0.2f; };
        double light = 0.0;
        double all = 0.0;
        constexpr int kSteps = 600;
        for (int i = 0; i < kSteps; ++i) {
            for (int j = 0; j < kSteps; ++j) {
                const float z = (static_cast<float>(i) + 0.5f) / kSteps;
                const float phi = 2.0f * kPi * (static_cast<float>(j) + 0.5f) / kSteps;
                const float r = std::sqrt(1.0f - z * z);
                const vec3 wi(r * std::cos(phi), r * std::sin(phi), z);
                const vec2 f = shared::specularLobe(alpha, site.normal, site.toward_viewer, wi);
                const double weight = (0.04 + 0.96 * static_cast<double>(f.y)) *
                                      static_cast<double>(f.x) * static_cast<double>(z);
                light += weight * static_cast<double>(lit(wi));
                all += weight;
            }
        }
        EXPECT_NEAR(look(site, lit).lobe_light.x, light / all, kTexels) << alpha;
    }
}

TEST(LobeLight, NoLobeNoLight) {
    RecordSite site = siteWithLobe(0.5f, {1, 0, 1});
    site.lobe = {};
    EXPECT_EQ(look(site, [](const vec3&) { return 1.0f; }).lobe_texels, 0.0f);
}

// What a record misses is the lobe's light less what it says of it, and belongs to its material.
TEST(Placement, RecordsKeepWhatTheyMiss) {
    Stage stage = makeStage(0, 0);
    stage.receivers.f0.assign(kWidth * kHeight, vec3(0.04f));
    stage.receivers.diffuse.assign(kWidth * kHeight, vec3(0.1f));
    stage.receivers.f90.assign(kWidth * kHeight, 1.0f);
    for (int x = kWidth / 2; x < kWidth; ++x) {
        for (int y = 0; y < kHeight; ++y) {
            stage.receivers.materials[stage.receivers.image.index(x, y)] = 7;
        }
    }
    RecordField field;
    const Placement placement = place(
        stage, {},
        [](const RecordSite& site, GatheredRecord& g) {
            EXPECT_TRUE(site.lobe.any());
            g.lobe_light = vec3(2.0f);
            g.lobe_texels = 100.0f;
        },
        &field);
    ASSERT_GT(placement.cache.records.size(), 1u);
    for (size_t k = 0; k < placement.cache.records.size(); ++k) {
        const Record& r = placement.cache.records[k];
        EXPECT_NEAR(r.missed_r, 2.0f - r.irradiance.x / kPi, 1e-5f);
        EXPECT_EQ(static_cast<int>(r.material), field.pixels[k] % kWidth < kWidth / 2 ? 0 : 7);
    }
}

// A floor all of whose pixels have rays, whose light is `truth` with noise.
struct Noisy {
    Stage stage = makeStage(10, 10);
    NoisyLight light;
    Image<vec3> truth{kWidth, kHeight};

    Noisy(const std::function<float(int, int)>& light_at, float noise) {
        for (size_t i = 0; i < kWidth * kHeight; ++i) {
            stage.receivers.by_rays[i] = stage.receivers.seen(i) ? 1 : 0;
        }
        light = {.halves = {truth, truth},
                 .guide = truth,
                 .nearness = Image<float>(kWidth, kHeight, 0.0f)};
        Random random(3);
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
                truth.at(x, y) = vec3(light_at(x, y));
                for (Image<vec3>& half : light.halves) {
                    half.at(x, y) = truth.at(x, y) + vec3(random.uniform(-noise, noise));
                }
            }
        }
    }
    // Root mean square over the pixels with rays.
    double error(const Image<vec3>& image) const {
        double squares = 0.0;
        int count = 0;
        for (size_t i = 0; i < truth.pixels.size(); ++i) {
            if (stage.receivers.by_rays[i] != 0) {
                squares += std::pow(image.pixels[i].x - truth.pixels[i].x, 2);
                ++count;
            }
        }
        return std::sqrt(squares / count);
    }
    Image<vec3> filtered() const { return filterLight(stage.receivers, light); }
};

TEST(FilterLight, TakesNoiseOffSmoothLight) {
    const Noisy noisy([](int x, int y) { return 1.0f + 0.02f * static_cast<float>(x + y); }, 0.5f);
    EXPECT_LT(noisy.error(noisy.filtered()), 0.15 * noisy.error(noisy.light.halves[0]));
}

TEST(FilterLight, KeepsWhatHasNoNoise) {
    const Noisy sharp([](int x, int y) { return (x / 3 + y / 3) % 2 == 0 ? 1.0f : 5.0f; }, 0.0f);
    EXPECT_LT(sharp.error(sharp.filtered()), 1e-4);
}

// The guide has the light's pattern at half its strength, too fine for any window.
TEST(FilterLight, FollowsTheGuideAsFarAsTheLightDoes) {
    Noisy noisy([](int x, int y) { return (x * 7 + y * 13) % 5 < 2 ? 1.0f : 3.0f; }, 1.0f);
    const double unguided = noisy.error(noisy.filtered());
    for (size_t i = 0; i < noisy.truth.pixels.size(); ++i) {
        noisy.light.guide.pixels[i] = 0.5f * noisy.truth.pixels[i];
    }
    EXPECT_LT(noisy.error(noisy.filtered()), 0.3 * unguided);
}

// A guide that has nothing to do with the light, as where a truncated lobe rings, does no harm.
TEST(FilterLight, AGuideThatMisleadsIsNotFollowed) {
    Noisy noisy([](int, int) { return 2.0f; }, 0.5f);
    Random random(5);
    for (vec3& g : noisy.light.guide.pixels) {
        g = vec3(random.uniform(-4.0f, 8.0f));
    }
    EXPECT_LT(noisy.error(noisy.filtered()), 0.3 * noisy.error(noisy.light.halves[0]));
}

}  // namespace
}  // namespace sheen
