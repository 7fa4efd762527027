// Direct light against closed forms and the reference.
#include <gtest/gtest.h>

#include <functional>

#include "image/frame.h"
#include "test_reference.h"
#include "test_stage.h"

namespace sheen {
namespace {

// A lit pixel is off by no more than this share: the design's limit for shadow acne.
constexpr float kAcne = 1e-3f;

const vec3 kAlbedo(0.8f, 0.5f, 0.2f);

// Radiance of a Lambertian surface under one unshadowed light.
vec3 lambert(const PunctualLight& light, const vec3& p, const vec3& n) {
    const LightSample s = shared::sampleLight(light, p);
    return kAlbedo / kPi * s.irradiance * std::max(glm::dot(n, s.wi), 0.0f);
}

// A square that nothing shadows: centre 0, with normal n.
Scene tiltedSquare(const vec3& n, float scale) {
    Scene scene;
    const vec3 u =
        glm::normalize(glm::cross(n, std::abs(n.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0)));
    const vec3 v = glm::cross(n, u);
    addQuad(scene, scale * (-u - v), 2.0f * scale * u, 2.0f * scale * v,
            addMaterial(scene, diffuseParams(kAlbedo)));
    return scene;
}

// Every pixel of the square has the closed form's radiance, and enough of them are lit.
void expectClosedForm(const Scene& scene, const Camera& camera, const vec3& n, int least_lit) {
    TestStage stage(scene);
    const GBuffer g = stage.gbuffer(camera, 64, 64);
    int lit = 0;
    float brightest = 0.0f;
    for (int i = 0; i < 64 * 64; ++i) {
        brightest = std::max(brightest, g.direct.pixels[static_cast<size_t>(i)].x);
    }
    for (int i = 0; i < 64 * 64; ++i) {
        if (!g.seen(i)) {
            continue;
        }
        const auto p = static_cast<size_t>(i);
        const vec3 expected = lambert(scene.lights[0], g.position.pixels[p], n);
        lit += expected.x > 0.0f ? 1 : 0;
        for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(g.direct.pixels[p][c], expected[c], kAcne * expected[c] + 1e-5f * brightest)
                << "pixel " << i % 64 << " " << i / 64;
        }
    }
    EXPECT_GE(lit, least_lit);
}

TEST(DirectLight, PointLightOnTiltedSquaresWithoutAcne) {
    Random random(1);
    for (int trial = 0; trial < 12; ++trial) {
        const float scale = trial % 3 == 0 ? 1.0f : (trial % 3 == 1 ? 1000.0f : 0.001f);
        const vec3 n = trial == 0 ? vec3(0, 1, 0) : random.direction();
        Scene scene = tiltedSquare(n, scale);
        // From high above to grazing.
        const float height = trial % 2 == 0 ? 1.5f : 0.1f;
        const vec3 aside = glm::normalize(glm::cross(n, random.direction()));
        scene.lights.push_back(
            pointLight(scale * (height * n + 0.7f * aside), vec3(3, 2, 1) * scale * scale));
        SCOPED_TRACE("trial " + std::to_string(trial));
        expectClosedForm(scene, lookAt(scale * (2.0f * n + 0.8f * aside), vec3(0)), n, 800);
    }
}

TEST(DirectLight, SunOnTiltedSquaresWithoutAcne) {
    Random random(2);
    for (int trial = 0; trial < 9; ++trial) {
        const float scale = trial % 3 == 0 ? 1.0f : (trial % 3 == 1 ? 1000.0f : 0.001f);
        const vec3 n = random.direction();
        Scene scene = tiltedSquare(n, scale);
        const vec3 aside = glm::normalize(glm::cross(n, random.direction()));
        // Down to three degrees above the surface.
        const float height = trial < 3 ? 1.0f : (trial < 6 ? 0.2f : 0.05f);
        scene.lights.push_back(directionalLight(-(height * n + aside), vec3(3, 2, 1)));
        SCOPED_TRACE("trial " + std::to_string(trial));
        expectClosedForm(scene, lookAt(scale * (2.0f * n + 0.8f * aside), vec3(0)), n, 800);
    }
}

TEST(DirectLight, NarrowAndWideSpots) {
    // Outer half-angles; from 60 degrees on a spot has the six maps of a point light.
    for (float degrees : {2.0f, 20.0f, 59.0f, 61.0f, 89.0f}) {
        Scene scene = tiltedSquare(vec3(0, 1, 0), 1.0f);
        scene.lights.push_back(spotLight(vec3(0.1f, 1.0f, 0.2f), vec3(0.1f, -1, -0.1f),
                                         vec3(3, 2, 1), glm::radians(0.7f * degrees),
                                         glm::radians(degrees)));
        SCOPED_TRACE("angle " + std::to_string(degrees));
        expectClosedForm(scene, lookAt(vec3(0.2f, 1.5f, 0.8f), vec3(0)), vec3(0, 1, 0),
                         degrees > 10.0f ? 100 : 1);
    }
}

TEST(DirectLight, RangeEndsTheLight) {
    Scene scene = tiltedSquare(vec3(0, 1, 0), 1.0f);
    scene.lights.push_back(pointLight(vec3(0, 0.5f, 0), vec3(1)));
    scene.lights[0].inverse_range = 1.0f / 0.8f;
    expectClosedForm(scene, lookAt(vec3(0, 1.5f, 0.8f), vec3(0)), vec3(0, 1, 0), 100);
}

TEST(DirectLight, NoLightsNoLight) {
    const Scene scene = [] {
        Scene s = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
        s.lights.clear();
        return s;
    }();
    TestStage stage(scene);
    for (const vec3& v : stage.gbuffer(32, 32).direct.pixels) {
        EXPECT_EQ(v, vec3(0.0f));
    }
}

TEST(DirectLight, LightFromBehindDoesNotShineThrough) {
    Scene scene = tiltedSquare(vec3(0, 1, 0), 1.0f);
    scene.lights.push_back(pointLight(vec3(0.1f, -0.3f, 0), vec3(5)));
    scene.lights.push_back(directionalLight(vec3(0.3f, 1, 0.1f), vec3(5)));
    TestStage stage(scene);
    const GBuffer g = stage.gbuffer(lookAt(vec3(0, 2, 0.5f), vec3(0)), 48, 48);
    for (const vec3& v : g.direct.pixels) {
        EXPECT_EQ(v, vec3(0.0f));
    }
}

// Share of pixels, those that see the same surface, whose direct light is that of the reference.
double agreeingShare(const Scene& scene, float tolerance) {
    const int size = 96;
    TestStage stage(scene);
    const GBuffer g = stage.gbuffer(size, size);
    const Frame frame = firstHits(scene, size, size);
    double agreeing = 0.0, compared = 0.0;
    for (size_t i = 0; i < frame.primitive.pixels.size(); ++i) {
        if (g.primitive.pixels[i] != frame.primitive.pixels[i]) {
            continue;
        }
        const vec3 a = g.direct.pixels[i], b = frame.direct.pixels[i];
        compared += 1.0;
        agreeing += glm::length(a - b) <= tolerance * (glm::length(b) + 1e-3f) ? 1.0 : 0.0;
    }
    return agreeing / compared;
}

// Shadow edges are filtered over three texels of the shadow map: few pixels of a small image.
constexpr double kAwayFromEdges = 0.975;

TEST(DirectLight, AgreesWithTheReferenceAwayFromShadowEdges) {
    Scene scene = glossyRoom(0.4f, 0.3f);
    for (float scale : {1.0f, 1000.0f, 0.001f}) {
        EXPECT_GT(agreeingShare(scaled(scene, scale), 0.005f), kAwayFromEdges) << "scale " << scale;
    }
    scene.lights = {spotLight(vec3(0.3f, 0.9f, 0.4f), vec3(-0.3f, -1, -0.5f), vec3(2), 0.3f, 0.6f)};
    EXPECT_GT(agreeingShare(scene, 0.005f), kAwayFromEdges) << "spot";
    scene.lights = {pointLight(vec3(-0.2f, 0.5f, 0.2f), vec3(1)),
                    spotLight(vec3(0.3f, 0.9f, 0.4f), vec3(0.2f, -1, -0.5f), vec3(2), 0.8f, 1.4f)};
    EXPECT_GT(agreeingShare(scene, 0.005f), kAwayFromEdges) << "two lights";
    // The sun through an open front.
    Scene open;
    const uint32_t white = addMaterial(open, diffuseParams(vec3(0.7f)));
    addQuad(open, vec3(-3, 0, 3), vec3(6, 0, 0), vec3(0, 0, -6), white);
    addBox(open, vec3(-0.5f, 0.0f, -0.5f), vec3(0.5f, 1.0f, 0.5f), white, false);
    addSphere(open, vec3(1.2f, 0.5f, 0.2f), 0.5f, 24, white);
    open.lights.push_back(directionalLight(vec3(-0.5f, -1, -0.7f), vec3(2)));
    open.cameras.push_back(lookAt(vec3(1, 3, 3), vec3(0)));
    EXPECT_GT(agreeingShare(open, 0.005f), kAwayFromEdges) << "sun";
}

}  // namespace
}  // namespace sheen
