// The path tracer against closed forms.
#include "reference/reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "reference/ray_scene.h"
#include "scene/brdf_albedo.h"
#include "test_reference.h"

namespace sheen {
namespace {

// The albedo table is tabulated and interpolated.
constexpr double kTableError = 3e-3;

// In a closed room whose walls shine with Le, direct light is the directional albedo times Le.
void expectFurnace(Scene& scene, const Camera& camera, const vec3& radiance) {
    const ReferenceResult r = renderReference(scene, smallParams(camera, 8, 256));
    expectWithin(
        r.frame.direct, r.frame.direct_variance,
        [&](int i) {
            const auto pixel = static_cast<size_t>(i);
            return (r.frame.albedo.pixels[pixel] + r.specular_albedo.pixels[pixel]) * radiance;
        },
        kSigmas, kTableError);
    EXPECT_EQ(r.nonfinite_samples, 0);
}

TEST(Reference, FurnaceGivesDirectionalAlbedo) {
    const vec3 radiance(2.0f, 1.0f, 0.5f);
    const Camera camera = lookAt(vec3(0.1f, 0.2f, 0.7f), vec3(-0.4f, -1.0f, -0.3f));
    for (const MaterialParams& material :
         {diffuseParams(vec3(0.8f), radiance), glossyParams(vec3(0.6f), 0.0f, 0.5f, radiance),
          glossyParams(vec3(1.0f, 0.8f, 0.3f), 1.0f, 1.0f, radiance),
          glossyParams(vec3(0.9f), 0.5f, 0.2f, radiance),
          glossyParams(vec3(0.9f), 1.0f, 0.0f, radiance)}) {
        Scene scene;
        addBox(scene, vec3(-1), vec3(1), addMaterial(scene, material), true);
        expectFurnace(scene, camera, radiance);
    }
}

// Directions below a tilted normal's surface bring no light: of the cosine around the normal a
// share (1 + n.n_g) / 2 lies above the surface.
TEST(Reference, TiltedShadingNormalsSeeNothingBelowTheSurface) {
    const float albedo = 0.5f;
    const vec3 tilted = glm::normalize(vec3(1.0f, 1.0f, 0.0f));
    Scene scene;
    const uint32_t bright = addMaterial(scene, diffuseParams(vec3(albedo), vec3(1.0f)));
    addBox(scene, vec3(-1), vec3(1), bright, true);
    addQuad(scene, vec3(-0.9f, 0, -0.9f), vec3(0, 0, 1.8f), vec3(1.8f, 0, 0), bright);
    std::fill(scene.normals.end() - 4, scene.normals.end(), tilted);
    const ReferenceResult r =
        renderReference(scene, smallParams(lookAt(vec3(0.05f, 0.8f, 0.1f), vec3(0.0f)), 8, 256));
    const vec3 expected(albedo * 0.5f * (1.0f + tilted.y));
    expectWithin(
        r.frame.direct, r.frame.direct_variance, [&](int) { return expected; }, kSigmas,
        kTableError);
    for (uint32_t triangle : r.frame.primitive.pixels) {
        EXPECT_GE(triangle, 12u);  // the quad fills the view
    }
}

TEST(Reference, FurnaceOfSeveralBounces) {
    Scene scene;
    const float rho = 0.8f;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseParams(vec3(rho), vec3(1.0f))),
           true);
    ReferenceParams params = smallParams(lookAt(vec3(0, 0, 0.5f), vec3(0, -1, -1)), 8, 256);
    float expected = 0.0f;
    for (params.bounces = 0; params.bounces <= 4; ++params.bounces) {
        const ReferenceResult r = renderReference(scene, params);
        expectWithin(
            r.frame.direct, r.frame.direct_variance, [&](int) { return vec3(rho); }, kSigmas, 1e-4);
        expectWithin(
            r.frame.indirect, r.frame.indirect_variance, [&](int) { return vec3(expected); },
            kSigmas, 1e-4);
        expected = rho * (rho + expected);
    }
}

// Paths that end by chance alone add up to the whole series.
TEST(Reference, FurnaceOfAllBounces) {
    for (const float rho : {0.5f, 0.8f, 0.95f}) {
        Scene scene;
        addBox(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseParams(vec3(rho), vec3(1.0f))),
               true);
        ReferenceParams params = smallParams(lookAt(vec3(0, 0, 0.5f), vec3(0, -1, -1)), 4, 256);
        params.bounces = kAllBounces;
        const ReferenceResult r = renderReference(scene, params);
        expectWithin(
            r.frame.indirect, r.frame.indirect_variance,
            [&](int) { return vec3(rho * rho / (1.0f - rho)); }, kSigmas, 1e-4);
    }
}

// A diffuse sphere around a point light: direct E/pi*rho with E = I/r^2 everywhere, and indirect
// rho times that, since every direction sees the same radiance.
TEST(Reference, SphereAroundAPointLight) {
    const float rho = 0.5f, radius = 3.0f, intensity = 7.0f;
    // The mesh of 64 rings lies up to 1 - cos(pi/128)^2 = 0.06% inside the sphere: 0.12% in E.
    constexpr double kMeshError = 2e-3;
    Scene scene;
    addSphere(scene, vec3(0), radius, 64, addMaterial(scene, diffuseParams(vec3(rho))));
    scene.lights.push_back(pointLight(vec3(0.0f), vec3(intensity)));
    const ReferenceResult r =
        renderReference(scene, smallParams(lookAt(vec3(1, 0.5f, 0), vec3(-1, 0.2f, 0.4f)), 8, 64));
    const float direct = rho / kPi * intensity / (radius * radius);
    for (const vec3& pixel : r.frame.direct.pixels) {
        EXPECT_NEAR(pixel.x, direct, kMeshError * direct);
    }
    expectWithin(
        r.frame.indirect, r.frame.indirect_variance, [&](int) { return vec3(rho * direct); },
        kSigmas, kMeshError);
}

// The shading of a flat surface point from one direction, without rays.
Surface flatSurface(const vec3& p, const vec3& n, const vec3& wo, const MaterialParams& material) {
    Surface s;
    s.position = p;
    s.n = s.n_g = n;
    s.wo = wo;
    s.brdf = shared::makeBrdf(material, glm::dot(n, wo),
                              brdfAlbedo(glm::dot(n, wo), material.roughness));
    return s;
}

// A floor point under a square panel that glows and is lit by a point light: the integral over the
// panel's area instead of the hemisphere, by the midpoint rule, without rays.
TEST(Reference, PanelAgreesWithIntegralOverItsArea) {
    constexpr float kHalf = 0.5f, kHeight = 0.8f, kIntensity = 0.6f;
    constexpr int kCells = 200;
    const float radiance = 2.0f;
    const vec3 eye(1.5f, 0.7f, 0.4f), lamp(0.3f, 0.1f, -0.2f);
    for (const float roughness : {0.25f, 0.6f}) {
        for (const float metallic : {0.0f, 1.0f}) {
            Scene scene;
            const MaterialParams floor = glossyParams(vec3(0.8f, 0.6f, 0.4f), metallic, roughness);
            const MaterialParams panel = glossyParams(vec3(0.5f), 0.0f, 0.5f, vec3(radiance));
            addQuad(scene, vec3(-4, 0, -4), vec3(0, 0, 8), vec3(8, 0, 0),
                    addMaterial(scene, floor));
            addQuad(scene, vec3(-kHalf, kHeight, -kHalf), vec3(2 * kHalf, 0, 0),
                    vec3(0, 0, 2 * kHalf), addMaterial(scene, panel));
            scene.lights.push_back(pointLight(lamp, vec3(kIntensity)));

            const vec3 up(0, 1, 0);
            const Surface p = flatSurface(vec3(0), up, glm::normalize(eye), floor);
            const auto lit = [&](const Surface& at) {
                const vec3 way = lamp - at.position;
                const float d2 = glm::dot(way, way);
                const vec3 wi = way / std::sqrt(d2);
                return shared::evalBrdf(at.brdf, at.n, at.wo, wi) *
                       (kIntensity / d2 * glm::dot(at.n, wi));
            };
            glm::dvec3 expected(0.0), expected_diffuse(0.0), expected_direct(lit(p));
            for (int cell = 0; cell < kCells * kCells; ++cell) {
                const float x = (2.0f * (cell % kCells + 0.5f) / kCells - 1.0f) * kHalf;
                const float z = (2.0f * (cell / kCells + 0.5f) / kCells - 1.0f) * kHalf;
                const vec3 point(x, kHeight, z);
                const float d2 = glm::dot(point, point);
                const vec3 wi = point / std::sqrt(d2);
                const Surface q = flatSurface(point, -up, -wi, panel);
                const float form = wi.y * wi.y / d2 * (4.0f * kHalf * kHalf / (kCells * kCells));
                const vec3 transfer = shared::evalBrdf(p.brdf, p.n, p.wo, wi) * form;
                expected += glm::dvec3(transfer * lit(q));
                expected_diffuse += glm::dvec3(p.brdf.diffuse / kPi * lit(q) * form);
                expected_direct += glm::dvec3(transfer * radiance);
            }
            // One pixel, whose centre sees the origin.
            const Frame frame =
                renderReference(scene, smallParams(lookAt(eye, vec3(0)), 1, 1 << 16)).frame;
            ASSERT_NEAR(glm::length(frame.position.at(0, 0)), 0.0f, 1e-6f);
            expectWithin(
                frame.direct, frame.direct_variance, [&](int) { return vec3(expected_direct); },
                kSigmas, 1e-3);
            expectWithin(
                frame.indirect, frame.indirect_variance, [&](int) { return vec3(expected); },
                kSigmas, 1e-3);
            expectWithin(
                frame.indirect_diffuse, frame.indirect_diffuse_variance,
                [&](int) { return vec3(expected_diffuse); }, kSigmas, 1e-3);
            EXPECT_LT(frame.indirect_variance.at(0, 0).x, 1e-5 * expected.x * expected.x);
        }
    }
}

TEST(Reference, DirectLightOnAPlane) {
    const float rho = 0.6f, height = 2.0f;
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(rho)));
    addQuad(scene, vec3(-5, 0, -5), vec3(0, 0, 10), vec3(10, 0, 0), white);
    scene.lights.push_back(pointLight(vec3(0, height, 0), vec3(3.0f)));
    scene.lights.push_back(directionalLight(vec3(0, -1, 1), vec3(0.5f)));
    // A spot whose cone's centre meets the origin; outside 30 degrees it gives nothing.
    const PunctualLight spot =
        spotLight(vec3(0, 1, 0), vec3(0, -1, 0), vec3(2.0f), 0.0f, kPi / 6.0f);
    scene.lights.push_back(spot);
    const ReferenceResult r =
        renderReference(scene, smallParams(lookAt(vec3(0, 1.5f, 3), vec3(0)), 16, 16));
    for (int i = 0; i < r.frame.direct.count(); ++i) {
        const auto pixel = static_cast<size_t>(i);
        if (r.frame.primitive.pixels[pixel] == kNoPrimitive) {
            continue;
        }
        const vec3 p = r.frame.position.pixels[pixel];
        const float d2 = p.x * p.x + p.z * p.z;
        const float point = 3.0f * height / std::pow(d2 + height * height, 1.5f);
        const float sun = 0.5f * std::sqrt(0.5f);
        const float cosine = 1.0f / std::sqrt(d2 + 1.0f);
        const float cone =
            glm::clamp((cosine - spot.cos_outer) / (1.0f - spot.cos_outer), 0.0f, 1.0f);
        const float expected =
            rho / kPi * (point + sun + 2.0f * cone * cone * cosine / (d2 + 1.0f));
        EXPECT_NEAR(r.frame.direct.pixels[pixel].x, expected, 1e-4f * expected);
        EXPECT_EQ(r.frame.direct_variance.pixels[pixel], vec3(0.0f));
    }
}

TEST(Reference, ShadowsAreTraced) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addQuad(scene, vec3(-5, 0, -5), vec3(0, 0, 10), vec3(10, 0, 0), white);
    addQuad(scene, vec3(-1, 1, -1), vec3(0, 0, 2), vec3(2, 0, 0), white);
    scene.lights.push_back(pointLight(vec3(0, 2, 0), vec3(3.0f)));
    // From below the blocker: its shadow on the floor is 4 wide.
    const ReferenceResult r =
        renderReference(scene, smallParams(lookAt(vec3(0, 0.9f, 4.5f), vec3(0)), 16, 16));
    int lit = 0, dark = 0;
    for (int i = 0; i < r.frame.direct.count(); ++i) {
        const auto pixel = static_cast<size_t>(i);
        const uint32_t primitive = r.frame.primitive.pixels[pixel];
        if (primitive == kNoPrimitive) {
            continue;
        }
        const vec3 p = r.frame.position.pixels[pixel];
        const bool in_shadow = primitive >= 2 || std::max(std::abs(p.x), std::abs(p.z)) < 2.0f;
        EXPECT_EQ(r.frame.direct.pixels[pixel].x > 0.0f, !in_shadow);
        (in_shadow ? dark : lit) += 1;
    }
    EXPECT_GT(lit, 10);
    EXPECT_GT(dark, 10);
}

TEST(Reference, GBufferAtPixelCentres) {
    Scene scene;
    const uint32_t paint = addMaterial(scene, diffuseParams(vec3(0.2f, 0.4f, 0.6f), vec3(3.0f)));
    // Wound and shaded away from the camera: both normals turn.
    addQuad(scene, vec3(-10, -10, -4), vec3(0, 20, 0), vec3(20, 0, 0), paint);
    Camera camera;
    const ReferenceResult r = renderReference(scene, smallParams(camera, 5, 16));
    const float tan_half = std::tan(0.5f * camera.y_fov);
    for (int y = 0; y < 5; ++y) {
        for (int x = 0; x < 5; ++x) {
            const vec3 p((x - 2) / 2.5f * tan_half * 4.0f, (2 - y) / 2.5f * tan_half * 4.0f, -4.0f);
            EXPECT_NEAR(glm::distance(r.frame.position.at(x, y), p), 0.0f, 1e-5f);
            EXPECT_NEAR(r.frame.depth.at(x, y), 4.0f, 1e-5f);
            EXPECT_NEAR(glm::distance(r.frame.normal.at(x, y), vec3(0, 0, 1)), 0.0f, 1e-6f);
            EXPECT_EQ(r.frame.albedo.at(x, y), vec3(0.2f, 0.4f, 0.6f));
            EXPECT_EQ(r.frame.emission.at(x, y), vec3(3.0f));
            EXPECT_EQ(r.frame.roughness.at(x, y), 1.0f);
        }
    }
    // The image's rows run downward: its top right pixel lies on the triangle with +x or +y.
    EXPECT_LT(r.frame.primitive.at(4, 0), 2u);
}

}  // namespace
}  // namespace sheen
