// Lamps and sky: closed forms of what they bring, and the densities of directions toward them.
#include <gtest/gtest.h>

#include <cmath>

#include "reference/lights.h"
#include "reference/sobol.h"
#include "test_reference.h"

namespace sheen {
namespace {

constexpr float kRho = 0.6f;
constexpr float kRadiance = 3.0f;

uint32_t addLamp(Scene& scene) {
    return addMaterial(scene, diffuseParams(vec3(0.0f), vec3(kRadiance)));
}

void addFloor(Scene& scene) {
    addQuad(scene, vec3(-8, 0, -8), vec3(0, 0, 16), vec3(16, 0, 0),
            addMaterial(scene, diffuseParams(vec3(kRho))));
}

// The one pixel of a camera that looks at the origin from the side.
ReferenceResult seeOrigin(const Scene& scene, int spp, int bounces = 1) {
    ReferenceParams params = smallParams(lookAt(vec3(2, 0.3f, 0.5f), vec3(0.0f)), 1, spp);
    params.bounces = bounces;
    ReferenceResult result = renderReference(scene, params);
    EXPECT_NEAR(glm::length(result.frame.position.at(0, 0)), 0.0f, 1e-6f);
    return result;
}

void expectDirect(const ReferenceResult& r, float expected, double bias) {
    expectWithin(
        r.frame.direct, r.frame.direct_variance, [&](int) { return vec3(expected); }, kSigmas,
        bias);
    // Small enough to tell.
    EXPECT_LT(std::sqrt(r.frame.direct_variance.at(0, 0).x), 3e-3f * expected);
    EXPECT_EQ(r.frame.indirect.at(0, 0), vec3(0.0f));
}

// ---- Lamps --------------------------------------------------------------------------------------

TEST(ReferenceLamps, FormFactorOfADisc) {
    constexpr int kCorners = 256;  // whose polygon lacks 1e-4 of the disc's area
    constexpr float kRadius = 0.7f;
    for (const float height : {0.05f, 1.0f, 5.0f}) {
        Scene scene;
        addFloor(scene);
        const uint32_t lamp = addLamp(scene);
        const uint32_t center = addVertex(scene, vec3(0, height, 0), vec3(0, -1, 0));
        for (int i = 0; i < kCorners; ++i) {
            const float phi = 2.0f * kPi * static_cast<float>(i) / kCorners;
            addVertex(scene, vec3(kRadius * std::cos(phi), height, kRadius * std::sin(phi)),
                      vec3(0, -1, 0));
        }
        for (uint32_t i = 0; i < kCorners; ++i) {
            scene.triangles.emplace_back(center, center + 1 + i, center + 1 + (i + 1) % kCorners);
            scene.materials_of.push_back(lamp);
        }
        const float r2 = kRadius * kRadius;
        // The camera looks past the edge of the lowest disc.
        ReferenceParams params =
            smallParams(lookAt(vec3(2, 0.02f * height, 0.5f), vec3(0.0f)), 1, 1 << 14);
        expectDirect(renderReference(scene, params), kRho * kRadiance * r2 / (r2 + height * height),
                     5e-4);
    }
}

TEST(ReferenceLamps, FormFactorOfARectangleFromBothSides) {
    constexpr float kA = 0.8f, kB = 0.3f, kHeight = 1.1f;  // half its sides
    const auto term = [](float a, float b) {
        const float root = std::sqrt(1.0f + a * a);
        return a / root * std::atan(b / root);
    };
    // Of a corner over the point, times four.
    const float form =
        4.0f / (2.0f * kPi) * (term(kA / kHeight, kB / kHeight) + term(kB / kHeight, kA / kHeight));
    for (const bool turned : {false, true}) {
        Scene scene;
        addFloor(scene);
        const vec3 x(2 * kA, 0, 0), z(0, 0, 2 * kB);
        addQuad(scene, vec3(-kA, kHeight, -kB), turned ? x : z, turned ? z : x, addLamp(scene));
        expectDirect(seeOrigin(scene, 1 << 12), kRho * kRadiance * form, 2e-4);
    }
}

TEST(ReferenceLamps, SphereLamp) {
    constexpr int kRings = 64;
    constexpr float kRadius = 0.4f;
    constexpr double kMeshError = 2e-3;  // of its silhouette, inside the sphere
    for (const float height : {0.5f, 2.0f}) {
        Scene scene;
        addFloor(scene);
        addSphere(scene, vec3(0, height, 0), kRadius, kRings, addLamp(scene));
        const float sine = kRadius / height;
        expectDirect(seeOrigin(scene, 1 << 14), kRho * kRadiance * sine * sine, kMeshError);
    }
}

// A small lamp amid a diffuse sphere lights all of it alike, and hides of each point's hemisphere
// its form factor: direct and indirect light are known for any number of bounces.
TEST(ReferenceLamps, SphereAroundALampForSeveralBounces) {
    constexpr float kRadius = 3.0f, kLampRadius = 0.5f;
    constexpr double kMeshError = 5e-3;
    Scene scene;
    addSphere(scene, vec3(0.0f), kRadius, 64, addMaterial(scene, diffuseParams(vec3(kRho))));
    addSphere(scene, vec3(0.0f), kLampRadius, 32, addLamp(scene));
    const float form = kLampRadius * kLampRadius / (kRadius * kRadius);
    const float direct = kRho * kRadiance * form;
    ReferenceParams params = smallParams(lookAt(vec3(1.5f, 0.5f, 0), vec3(3, 0.2f, 0.4f)), 8, 1024);
    float expected = 0.0f;
    for (params.bounces = 0; params.bounces <= 3; ++params.bounces) {
        const ReferenceResult r = renderReference(scene, params);
        expectWithin(
            r.frame.direct, r.frame.direct_variance, [&](int) { return vec3(direct); }, kSigmas,
            kMeshError);
        expectWithin(
            r.frame.indirect, r.frame.indirect_variance, [&](int) { return vec3(expected); },
            kSigmas, kMeshError);
        expected = kRho * (1.0f - form) * (direct + expected);
    }
}

TEST(ReferenceLamps, HiddenLampsDoNotShine) {
    Scene scene;
    addFloor(scene);
    addQuad(scene, vec3(-1, 2, -1), vec3(2, 0, 0), vec3(0, 0, 2), addLamp(scene));
    addQuad(scene, vec3(-3, 1, -3), vec3(6, 0, 0), vec3(0, 0, 6),
            addMaterial(scene, diffuseParams(vec3(0.0f))));
    EXPECT_EQ(seeOrigin(scene, 256).frame.direct.at(0, 0), vec3(0.0f));
}

// Whoever draws a point and whoever meets it agree how likely it was.
TEST(ReferenceLamps, DensityOfAChoiceIsThatOfItsHit) {
    Scene scene;
    const uint32_t bright = addLamp(scene);
    const uint32_t dim = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(0.1f)));
    addSphere(scene, vec3(2, 1, 0), 0.5f, 8, bright);
    addQuad(scene, vec3(-3, -1, 2), vec3(2, 0, 0.3f), vec3(0, 2, 0), dim);
    addQuad(scene, vec3(-3, -1, -3), vec3(2, 0, 0.3f), vec3(0, 2, 0),
            addMaterial(scene, diffuseParams(vec3(0.5f))));
    const RayScene rays(scene);
    const Lamps lamps(scene);
    const vec3 from(0.0f);
    int met = 0;
    for (uint32_t i = 0; i < 4096; ++i) {
        const LightChoice choice = lamps.choose(from, owenSobol(i, 5));
        if (choice.pdf == 0.0f || rays.passing(choice.way) == vec3(0.0f)) {
            continue;  // the sphere's back
        }
        const RayHit hit = rays.intersect(from, choice.way.direction);
        ASSERT_TRUE(hit.found());
        ++met;
        EXPECT_TRUE(lamps.contains(hit.triangle));
        const Surface s = rays.surfaceAt(hit, -choice.way.direction);
        const float pdf = lamps.pdf(hit.triangle, s, from);
        EXPECT_NEAR(pdf, choice.pdf, 2e-3f * choice.pdf);  // rounding at edges
        EXPECT_EQ(choice.radiance, s.emission);
    }
    EXPECT_GT(met, 1500);
}

TEST(ReferenceLamps, PunctualLightAloneHasNoVariance) {
    Scene scene;
    addFloor(scene);
    scene.lights.push_back(pointLight(vec3(0, 2, 0), vec3(4.0f)));
    const ReferenceResult r = seeOrigin(scene, 64);
    EXPECT_NEAR(r.frame.direct.at(0, 0).x, kRho / kPi, 1e-5f);
    EXPECT_EQ(r.frame.direct_variance.at(0, 0), vec3(0.0f));
}

// ---- Sky ----------------------------------------------------------------------------------------

Environment uniformSky(const vec3& radiance) { return {.texels = Image<vec3>(1, 1, radiance)}; }

// Radiance by the direction.
template <class F>
Environment skyOf(int height, const F& radiance) {
    Environment sky{.texels = Image<vec3>(2 * height, height)};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < 2 * height; ++x) {
            const vec2 uv((static_cast<float>(x) + 0.5f) / static_cast<float>(2 * height),
                          (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
            sky.texels.at(x, y) = vec3(radiance(sky.directionFromImage(uv)));
        }
    }
    return sky;
}

TEST(ReferenceSky, WhiteFurnaceGivesDirectionalAlbedo) {
    constexpr double kTableError = 3e-3;
    const vec3 radiance(2.0f, 1.0f, 0.5f);
    for (const MaterialParams& material :
         {diffuseParams(vec3(0.8f)), glossyParams(vec3(0.6f), 0.0f, 0.5f),
          glossyParams(vec3(1.0f, 0.8f, 0.3f), 1.0f, 1.0f), glossyParams(vec3(0.9f), 0.5f, 0.2f),
          glossyParams(vec3(0.9f), 1.0f, 0.0f)}) {
        Scene scene;
        addQuad(scene, vec3(-8, 0, -8), vec3(0, 0, 16), vec3(16, 0, 0),
                addMaterial(scene, material));
        scene.environment = uniformSky(radiance);
        const ReferenceResult r =
            renderReference(scene, smallParams(lookAt(vec3(0.5f, 2, 1), vec3(0.0f)), 8, 256));
        const auto at = [](const Image<vec3>& image, int i) {
            return image.pixels[static_cast<size_t>(i)];
        };
        expectWithin(
            r.frame.indirect, r.frame.indirect_variance,
            [&](int i) { return (at(r.frame.albedo, i) + at(r.specular_albedo, i)) * radiance; },
            kSigmas, kTableError);
        expectWithin(
            r.frame.indirect_diffuse, r.frame.indirect_diffuse_variance,
            [&](int i) { return at(r.frame.albedo, i) * radiance; }, kSigmas, 1e-4);
        for (const vec3& pixel : r.frame.direct.pixels) {
            EXPECT_EQ(pixel, vec3(0.0f));
        }
    }
}

// The integral of two clamped cosines, gamma apart: 2/3 ((pi - gamma) cos gamma + sin gamma).
TEST(ReferenceSky, DiffuseSphereUnderACosineSky) {
    Scene scene;
    addSphere(scene, vec3(0.0f), 1.0f, 64, addMaterial(scene, diffuseParams(vec3(kRho))));
    scene.environment = skyOf(128, [](const vec3& d) { return std::max(d.y, 0.0f); });
    const ReferenceResult r =
        renderReference(scene, smallParams(lookAt(vec3(0, 0, 3), vec3(0.0f)), 8, 1024));
    int seen = 0;
    for (int i = 0; i < r.frame.indirect.count(); ++i) {
        const auto pixel = static_cast<size_t>(i);
        if (r.frame.primitive.pixels[pixel] == kNoPrimitive) {
            continue;
        }
        ++seen;
        const float cosine = glm::clamp(r.frame.normal.pixels[pixel].y, -1.0f, 1.0f);
        const float gamma = std::acos(cosine);
        const float expected =
            kRho / kPi * 2.0f / 3.0f * ((kPi - gamma) * cosine + std::sin(gamma));
        const float sigma = std::sqrt(r.frame.indirect_variance.pixels[pixel].x);
        // The facets' planes hide what a sphere would see near its horizon.
        EXPECT_NEAR(r.frame.indirect.pixels[pixel].x, expected, 7.0f * sigma + 3e-3f) << i;
    }
    EXPECT_GT(seen, 20);
}

// From a diffuse floor, light of the sky comes twice where a wall scatters it once.
TEST(ReferenceSky, BouncesScatterItOnceMore) {
    Scene scene;  // a box open above, of which each point scatters what it sees
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(kRho)));
    addBox(scene, vec3(-1), vec3(1), white, true);
    scene.environment = uniformSky(vec3(kRadiance));
    ReferenceParams params = smallParams(lookAt(vec3(0, 0, 0.5f), vec3(0, -1, -1)), 4, 64);
    // Closed: no sky at all.
    for (const vec3& pixel : renderReference(scene, params).frame.indirect.pixels) {
        EXPECT_EQ(pixel, vec3(0.0f));
    }
    // Without its top the floor sees the sky through a square, and more by way of the walls.
    scene.triangles.erase(scene.triangles.begin() + 6, scene.triangles.begin() + 8);
    scene.materials_of.erase(scene.materials_of.begin() + 6, scene.materials_of.begin() + 8);
    const auto origin = [&](int bounces) {
        params = smallParams(lookAt(vec3(0.1f, 0, 0.05f), vec3(0, -1, 0)), 1, 1 << 14);
        params.bounces = bounces;
        return renderReference(scene, params).frame;
    };
    EXPECT_EQ(origin(0).indirect.at(0, 0), vec3(0.0f));
    // A square of half-width 1 at distance 2.
    const float root = std::sqrt(1.25f);
    const float form = 4.0f / kPi * 0.5f / root * std::atan(0.5f / root);
    const float once = origin(1).indirect.at(0, 0).x;
    const float twice = origin(2).indirect.at(0, 0).x;
    const float straight = kRho * kRadiance * form;
    EXPECT_GT(once, 1.2f * straight);
    // Walls as bright as the sky times their albedo would be too much.
    EXPECT_LT(once, straight + kRho * kRho * kRadiance * (1.0f - form));
    EXPECT_GT(twice, 1.02f * once);
    EXPECT_LT(twice, kRadiance);
}

TEST(ReferenceSky, DirectionsFollowTheDensityTheyTell) {
    // A small bright sun, a band, dark ground; turned.
    Environment sky = skyOf(32, [](const vec3& d) {
        return d.y < 0.0f                                              ? 0.0f
               : glm::dot(d, glm::normalize(vec3(1, 2, 0.5f))) > 0.98f ? 50.0f
                                                                       : 1.0f;
    });
    sky.rotation = 0.7f;
    const Sky sampler(sky);
    constexpr uint32_t kSamples = 1 << 16;
    const auto f = [](const vec3& d) { return 1.0f + d.x + 2.0f * d.y * d.z + d.y; };
    double radiance = 0.0, lopsided = 0.0, ones = 0.0;
    for (uint32_t i = 0; i < kSamples; ++i) {
        const LightChoice choice = sampler.choose(vec3(0.0f), owenSobol(i, 3));
        const vec3& d = choice.way.direction;
        ASSERT_GT(choice.pdf, 0.0f);
        EXPECT_NEAR(sampler.pdf(d), choice.pdf, 1e-3f * choice.pdf);
        EXPECT_EQ(choice.radiance, sky.radiance(d));
        ones += 1.0 / choice.pdf / kSamples;
        radiance += choice.radiance.x / choice.pdf / kSamples;
        lopsided += choice.radiance.x * f(d) / choice.pdf / kSamples;
    }
    double sum = 0.0, sum_lopsided = 0.0, shining = 0.0;
    constexpr int kHeight = 1024;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < 2 * kHeight; ++x) {
            const vec3 d =
                sky.directionFromImage(vec2((x + 0.5f) / (2.0f * kHeight), (y + 0.5f) / kHeight));
            const double solid_angle =
                M_PI / kHeight * (M_PI / kHeight) * std::sin(M_PI * (y + 0.5) / kHeight);
            const double value = sky.radiance(d).x;
            sum += value * solid_angle;
            sum_lopsided += value * f(d) * solid_angle;
            shining += sampler.pdf(d) > 0.0f ? solid_angle : 0.0;
        }
    }
    EXPECT_NEAR(radiance / sum, 1.0, 2e-3);
    EXPECT_NEAR(lopsided / sum_lopsided, 1.0, 4e-3);
    EXPECT_NEAR(ones / shining, 1.0, 2e-2);
}

TEST(ReferenceSky, ShowsWhereNothingIsSeenUnlessHidden) {
    Scene scene;
    addQuad(scene, vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0),
            addMaterial(scene, diffuseParams(vec3(kRho))));
    scene.environment = uniformSky(vec3(1, 2, 3));
    const ReferenceParams params = smallParams(lookAt(vec3(0, 0, 5), vec3(0.0f)), 8, 16);
    for (const bool visible : {true, false}) {
        scene.environment.visible = visible;
        const Frame frame = renderReference(scene, params).frame;
        EXPECT_EQ(frame.emission.at(0, 0), visible ? vec3(1, 2, 3) : vec3(0.0f));
        EXPECT_EQ(frame.emission.at(4, 4), vec3(0.0f));
        EXPECT_GT(frame.indirect.at(4, 4).x, 0.0f);
    }
}

}  // namespace
}  // namespace sheen
