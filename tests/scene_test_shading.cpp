// Closed forms of the functions shared with the shaders: BRDF and its albedo table, lights, texture
// taps.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "scene/brdf_albedo.h"
#include "scene/layers.h"
#include "scene/scene.h"
#include "test_scenes.h"

namespace sheen {
namespace {

const vec3 kUp(0.0f, 0.0f, 1.0f);

vec3 direction(float mu, float phi) {
    const float s = std::sqrt(1.0f - mu * mu);
    return {s * std::cos(phi), s * std::sin(phi), mu};
}

// (A, B) of the specular lobe by the midpoint rule over half vectors, in double. With
// tan^2 = alpha^2 u / (1 - u) the measure D cos dw of half vectors is uniform in (u, phi), and
// dw_i = 4 (wo.h) dw_h. Shares no sampling with the table.
glm::dvec2 albedoByQuadrature(double mu, double alpha) {
    constexpr int kU = 800;
    constexpr int kPhi = 256;
    const glm::dvec3 wo(std::sqrt(1.0 - mu * mu), 0.0, mu);
    glm::dvec2 sum(0.0);
    for (int i = 0; i < kU; ++i) {
        // Squared spacing at the far end: at grazing views few and far normals matter.
        const double v = (i + 0.5) / kU;
        const double u = 1.0 - (1.0 - v) * (1.0 - v);
        const double weight = 2.0 * (1.0 - v) / kU;
        const double tan2 = alpha * alpha * u / (1.0 - u);
        const double NoH = 1.0 / std::sqrt(1.0 + tan2);
        const double sin_h = std::sqrt(1.0 - NoH * NoH);
        for (int j = 0; j < kPhi; ++j) {
            const double phi = std::numbers::pi * (j + 0.5) / kPhi;
            const glm::dvec3 h(sin_h * std::cos(phi), sin_h * std::sin(phi), NoH);
            const double VoH = glm::dot(wo, h);
            const double NoL = 2.0 * VoH * NoH - mu;
            if (VoH <= 0.0 || NoL <= 0.0) {
                continue;
            }
            const double a2 = alpha * alpha;
            const double visibility = 0.5 / (NoL * std::sqrt(mu * mu * (1.0 - a2) + a2) +
                                             mu * std::sqrt(NoL * NoL * (1.0 - a2) + a2));
            const double f = visibility * NoL * 4.0 * VoH / NoH * weight / kPhi;
            const double schlick = std::pow(1.0 - VoH, 5.0);
            sum += glm::dvec2(f * (1.0 - schlick), f * schlick);
        }
    }
    return sum;
}

TEST(Brdf, SpecularPartIsReciprocal) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0.02f, 1.0f);
    for (int i = 0; i < 1000; ++i) {
        Brdf brdf{};
        brdf.alpha = uniform(random);
        brdf.f0 = vec3(uniform(random), uniform(random), uniform(random));
        brdf.f90 = uniform(random);
        const vec3 wo = direction(uniform(random), 6.0f * uniform(random));
        const vec3 wi = direction(uniform(random), 6.0f * uniform(random));
        const vec3 there = shared::evalSpecular(brdf, kUp, wo, wi);
        const vec3 back = shared::evalSpecular(brdf, kUp, wi, wo);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(there[c], back[c], 1e-4f * there[c]);
        }
    }
}

TEST(Brdf, AlbedoTableAgreesWithQuadrature) {
    // Half a percent of a lobe that reflects all: the promise the diffuse part rests on.
    constexpr double kTolerance = 0.005;
    for (int y = 3; y < shared::ALBEDO_TABLE_ROUGHNESS; y += 4) {
        for (int x = 9; x < shared::ALBEDO_TABLE_MU; x += 9) {
            const vec2 params = shared::albedoTableParams(x, y);
            const glm::dvec2 expected =
                albedoByQuadrature(params.x, shared::alphaFromRoughness(params.y));
            const vec2 table = brdfAlbedo(params.x, params.y);
            EXPECT_NEAR(table.x, expected.x, kTolerance * (expected.x + expected.y))
                << "NoV " << params.x << " roughness " << params.y;
            EXPECT_NEAR(table.y, expected.y, kTolerance * (expected.x + expected.y))
                << "NoV " << params.x << " roughness " << params.y;
        }
    }
}

TEST(Brdf, AlbedoTableInterpolatesWithinHalfAPercent) {
    constexpr double kTolerance = 0.005;
    for (double root = 0.0; root < 1.0; root += 0.061) {
        const double roughness = root * root;
        for (double mu = 0.01; mu < 1.0; mu *= 1.21) {
            const glm::dvec2 expected =
                albedoByQuadrature(mu, shared::alphaFromRoughness(static_cast<float>(roughness)));
            const vec2 table = brdfAlbedo(static_cast<float>(mu), static_cast<float>(roughness));
            const double whole = expected.x + expected.y;
            EXPECT_NEAR(table.x + table.y, whole, kTolerance * whole)
                << "NoV " << mu << " roughness " << roughness;
            EXPECT_NEAR(0.04 * table.x + table.y, 0.04 * expected.x + expected.y,
                        kTolerance * whole);
        }
    }
}

TEST(Brdf, WhiteFurnaceNeverGainsEnergy) {
    for (float roughness = 0.0f; roughness <= 1.0f; roughness += 0.01f) {
        for (float mu = 0.0f; mu <= 1.0f; mu += 0.01f) {
            const vec2 ab = brdfAlbedo(mu, roughness);
            EXPECT_LE(ab.x + ab.y, 1.0001f) << "NoV " << mu << " roughness " << roughness;
            EXPECT_GE(ab.x, 0.0f);
            EXPECT_GE(ab.y, 0.0f);
        }
    }
}

// Light that microfacets scatter more than once is not lost, whatever the view and the roughness.
TEST(Brdf, WhiteSurfacesReflectAllOfTheLight) {
    constexpr double kError = 0.01;
    MaterialParams params = glossyParams(vec3(1.0f), 1.0f, 0.0f);
    for (const float roughness : {0.03f, 0.2f, 0.5f, 0.8f, 1.0f}) {
        params.roughness = roughness;
        for (const float mu : {0.05f, 0.2f, 0.6f, 1.0f}) {
            const glm::dvec2 once = albedoByQuadrature(mu, shared::alphaFromRoughness(roughness));
            for (const float metallic : {0.0f, 1.0f}) {
                params.metallic = metallic;
                const Brdf brdf = shared::makeBrdf(params, mu, brdfAlbedo(mu, roughness));
                EXPECT_NEAR(brdf.diffuse.x + brdf.f0.x * once.x + brdf.f90 * once.y, 1.0, kError)
                    << "NoV " << mu << " roughness " << roughness << " metallic " << metallic;
            }
        }
    }
}

// Layers take from the surface what they reflect: white ones on white lose and gain nothing.
TEST(Layers, WhiteOnWhiteReflectsAllOfTheLight) {
    const MaterialParams white = glossyParams(vec3(1.0f), 0.0f, 0.7f);
    for (const float NoV : {0.05f, 0.4f, 1.0f}) {
        const vec2 ab = brdfAlbedo(NoV, white.roughness);
        const Brdf below = shared::makeBrdf(white, NoV, ab);
        for (const Layers& layers :
             {Layers{.coat = 1.0f, .coat_roughness = 0.2f},
              Layers{.coat = 0.5f, .coat_roughness = 0.9f},
              Layers{.fibre_color = vec3(1.0f), .fibre_roughness = 0.4f},
              Layers{.coat = 1.0f, .fibre_color = vec3(1.0f), .fibre_roughness = 1.0f}}) {
            const Brdf brdf = underLayers(below, layers, NoV, NoV);
            const Brdf coat = coatBrdf(layers);
            const vec2 of_coat = brdfAlbedo(NoV, layers.coat_roughness);
            EXPECT_NEAR(brdf.diffuse.x + brdf.f0.x * ab.x + brdf.f90 * ab.y +
                            coat.f0.x * of_coat.x + coat.f90 * of_coat.y,
                        1.0f, 1e-5f)
                << "NoV " << NoV;
        }
    }
}

// By the trapezium rule over half vectors' cosines at NoV = 1, where h lies halfway to wi.
TEST(Layers, FibresReflectWhatTheirDistributionSays) {
    for (const float roughness : {0.25f, 0.5f, 1.0f}) {
        constexpr int kSteps = 20000;
        const double power = 1.0 / (double{roughness} * roughness);
        double sum = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            const double theta = 0.5 * std::numbers::pi * (i + 0.5) / kSteps;
            const double distribution =
                (2.0 + power) * std::pow(std::sin(0.5 * theta), power) / (2.0 * std::numbers::pi);
            sum += distribution / 4.0 * std::cos(theta) * std::sin(theta);  // V = 1/4 at NoV = 1
        }
        const double expected = 2.0 * std::numbers::pi * sum * 0.5 * std::numbers::pi / kSteps;
        EXPECT_NEAR(fibreAlbedo(1.0f, roughness), expected, 0.02 * expected + 1e-4) << roughness;
    }
    EXPECT_GT(fibreAlbedo(0.05f, 0.5f), 3.0f * fibreAlbedo(1.0f, 0.5f)) << "they shine at the rim";
}

// What meets a coloured surface again is coloured again.
TEST(Brdf, RoughGoldIsNoPalerThanSmoothGoldAndReflectsLess) {
    const vec3 gold(1.0f, 0.7f, 0.2f);
    const MaterialParams params = glossyParams(gold, 1.0f, 1.0f);
    const vec2 ab = brdfAlbedo(0.7f, params.roughness);
    const Brdf brdf = shared::makeBrdf(params, 0.7f, ab);
    const vec3 albedo = brdf.f0 * ab.x + vec3(brdf.f90 * ab.y);
    EXPECT_LE(albedo.x, 1.0f);
    EXPECT_LT(albedo.y, gold.y);
    EXPECT_LT(albedo.z, gold.z);
    EXPECT_GT(albedo.z, 0.4f * gold.z) << "what is scattered once, at the least";
}

TEST(Brdf, SmoothMirrorReflectsAllByFresnel) {
    for (const float mu : {0.2f, 0.5f, 0.9f}) {
        const vec2 ab = brdfAlbedo(mu, 0.0f);
        EXPECT_NEAR(ab.x + ab.y, 1.0f, 0.002f);
        EXPECT_NEAR(ab.y, shared::schlickWeight(mu), 0.005f) << "VoH is NoV on a mirror";
    }
}

TEST(Brdf, WhiteDiffuseBaseUnderALobeReflectsEverythingTheLobeLeaves) {
    MaterialParams params = glossyParams(vec3(1.0f), 0.0f, 0.6f);
    const vec2 ab = brdfAlbedo(0.7f, params.roughness);
    const Brdf brdf = shared::makeBrdf(params, 0.7f, ab);
    EXPECT_NEAR(brdf.diffuse.x + brdf.f0.x * ab.x + brdf.f90 * ab.y, 1.0f, 1e-6f);
    params.specular = 0.0f;
    const Brdf diffuse = shared::makeBrdf(params, 0.7f, ab);
    EXPECT_EQ(diffuse.diffuse, vec3(1.0f));
    EXPECT_EQ(shared::evalSpecular(diffuse, kUp, direction(0.5f, 0), direction(0.5f, 3)), vec3(0));
    params.metallic = 1.0f;
    EXPECT_EQ(shared::makeBrdf(params, 0.7f, ab).diffuse, vec3(0.0f));
}

TEST(Brdf, IsZeroBelowTheHorizon) {
    const Brdf brdf{.diffuse = vec3(1), .alpha = 0.5f, .f0 = vec3(1), .f90 = 1.0f};
    EXPECT_EQ(shared::evalBrdf(brdf, kUp, direction(0.5f, 0), -direction(0.5f, 0)), vec3(0.0f));
}

TEST(ShadingNormal, FacesTheViewerAndIsUnit) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
    for (int i = 0; i < 2000; ++i) {
        const auto unit = [&] {
            return glm::normalize(vec3(uniform(random), uniform(random), uniform(random)) +
                                  vec3(1e-3f));
        };
        const vec3 wo = unit();
        const vec3 n_g = shared::faceViewer(unit(), wo);
        EXPECT_GE(glm::dot(n_g, wo), 0.0f);
        const vec3 n = shared::shadingNormal(unit(), n_g, wo);
        EXPECT_NEAR(glm::length(n), 1.0f, 1e-5f);
        EXPECT_GE(glm::dot(n, wo), shared::MIN_VIEW_COSINE - 1e-5f);
    }
}

PunctualLight pointLight() {
    PunctualLight light{};
    light.kind = shared::LIGHT_POINT;
    light.intensity = vec3(8.0f, 4.0f, 2.0f);
    light.spot_offset = 1.0f;
    light.cos_outer = -1.0f;
    light.direction = vec3(0, 0, -1);
    return light;
}

TEST(Light, PointLightFallsWithTheSquaredDistance) {
    const LightSample sample = shared::sampleLight(pointLight(), vec3(0, 2, 0));
    EXPECT_EQ(sample.distance, 2.0f);
    EXPECT_EQ(sample.wi, vec3(0, -1, 0));
    EXPECT_EQ(sample.irradiance, vec3(2.0f, 1.0f, 0.5f));
}

TEST(Light, RangeWindowEndsAtTheRange) {
    PunctualLight light = pointLight();
    light.inverse_range = 0.25f;
    EXPECT_FLOAT_EQ(shared::sampleLight(light, vec3(2, 0, 0)).irradiance.x,
                    2.0f * (1.0f - 1.0f / 16.0f));
    EXPECT_EQ(shared::sampleLight(light, vec3(4, 0, 0)).irradiance, vec3(0.0f));
    EXPECT_EQ(shared::sampleLight(light, vec3(9, 0, 0)).irradiance, vec3(0.0f));
}

TEST(Light, SpotIsFullInsideItsInnerConeAndDarkOutsideTheOuter) {
    PunctualLight light = pointLight();
    light.kind = shared::LIGHT_SPOT;
    const float cos_inner = std::cos(0.3f);
    const float cos_outer = std::cos(0.7f);
    light.spot_scale = 1.0f / (cos_inner - cos_outer);
    light.spot_offset = -cos_outer * light.spot_scale;
    const auto at = [&](float angle) {
        return shared::sampleLight(light, vec3(std::sin(angle), 0.0f, -std::cos(angle)))
            .irradiance.x;
    };
    EXPECT_NEAR(at(0.0f), 8.0f, 1e-5f);
    EXPECT_NEAR(at(0.29f), 8.0f, 1e-5f);
    EXPECT_EQ(at(0.71f), 0.0f);
    EXPECT_EQ(at(3.0f), 0.0f);
    const float middle = (std::cos(0.5f) - cos_outer) / (cos_inner - cos_outer);
    EXPECT_NEAR(at(0.5f), 8.0f * middle * middle, 1e-4f);
}

TEST(Light, DirectionalLightIsTheSameEverywhere) {
    PunctualLight light = pointLight();
    light.kind = shared::LIGHT_DIRECTIONAL;
    const LightSample sample = shared::sampleLight(light, vec3(100, -3, 7));
    EXPECT_EQ(sample.wi, vec3(0, 0, 1));
    EXPECT_LT(sample.distance, 0.0f);
    EXPECT_EQ(sample.irradiance, light.intensity);
}

TEST(Texture, WrapModesMapEveryTexel) {
    const auto row = [](int wrap) {
        std::vector<int> texels;
        for (int i = -4; i < 8; ++i) {
            texels.push_back(shared::wrapTexel(i, 3, wrap));
        }
        return texels;
    };
    EXPECT_EQ(row(shared::WRAP_REPEAT), (std::vector<int>{2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1}));
    EXPECT_EQ(row(shared::WRAP_CLAMP), (std::vector<int>{0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2}));
    EXPECT_EQ(row(shared::WRAP_MIRROR), (std::vector<int>{2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1}));
}

// A triangle of one pair of texture coordinates under a texture of two texels, black and white.
struct Checkered {
    explicit Checkered(int wrap, const vec3& factor = vec3(1.0f)) {
        scene.materials.emplace_back();
        scene.materials[0].textures[shared::TEXTURE_BASE_COLOR].texture =
            addTexture(scene, 2, 1, {vec3(0.0f), vec3(1.0f)}, wrap);
        scene.materials[0].params.base_color = factor;
        scene.triangles.emplace_back(0, 0, 0);
        scene.materials_of.push_back(0);
    }
    vec3 at(float u) {
        scene.uvs.assign(1, vec2(u, 0.3f));
        return materialAt(scene, 0, vec3(1, 0, 0)).base_color;
    }

    Scene scene;
};

TEST(Texture, IsBilinearBetweenTexelCentresAndScaledByTheFactor) {
    Checkered texture(shared::WRAP_CLAMP, vec3(0.5f, 1.0f, 2.0f));
    EXPECT_EQ(texture.at(0.25f), vec3(0.0f));
    EXPECT_EQ(texture.at(0.75f), vec3(0.5f, 1.0f, 2.0f));
    EXPECT_EQ(texture.at(0.5f), vec3(0.25f, 0.5f, 1.0f));
    EXPECT_EQ(texture.at(-3.0f), vec3(0.0f));
    EXPECT_EQ(texture.at(3.0f), vec3(0.5f, 1.0f, 2.0f));
}

TEST(Texture, RepeatsAndMirrorsFarOut) {
    Checkered repeat(shared::WRAP_REPEAT);
    Checkered mirror(shared::WRAP_MIRROR);
    for (const float turn : {-1000.0f, -2.0f, 0.0f, 2.0f, 1000.0f}) {
        EXPECT_EQ(repeat.at(turn + 0.75f).x, 1.0f);
        EXPECT_EQ(repeat.at(turn + 1.75f).x, 1.0f);
        EXPECT_EQ(mirror.at(turn + 0.75f).x, 1.0f);
        EXPECT_EQ(mirror.at(turn + 1.75f).x, 0.0f);
    }
    EXPECT_EQ(repeat.at(0.0f).x, 0.5f) << "across the seam";
}

TEST(Texture, NearestIsNotInterpolated) {
    Checkered texture(shared::WRAP_REPEAT);
    texture.scene.textures[0].nearest = true;
    EXPECT_EQ(texture.at(0.01f).x, 0.0f);
    EXPECT_EQ(texture.at(0.49f).x, 0.0f);
    EXPECT_EQ(texture.at(0.51f).x, 1.0f);
    EXPECT_EQ(texture.at(0.99f).x, 1.0f);
    EXPECT_EQ(texture.at(1.01f).x, 0.0f);
}

}  // namespace
}  // namespace sheen
