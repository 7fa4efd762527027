// What is seen through bodies of glass, which bend a camera's rays, and through rough glass, which
// blurs what it shows: closed forms, and the renderer against the reference.
#include <gtest/gtest.h>

#include "metrics/compare.h"
#include "test_glass.h"
#include "test_light.h"
#include "test_reference.h"
#include "test_render.h"

namespace sheen {
namespace {

// What lies behind all glass on a ray's way, by the renderer's rays and by the reference's.
struct Behind {
    vec3 position, direction, share;
};

Behind behindBy(const Tracer& tracer, const vec3& origin, const vec3& direction) {
    const Sight::Part part = tracer.seeAlone(origin, direction).ground;
    return {part.origin + part.hit.distance * part.direction, part.direction, part.share};
}

Behind behindBy(const RayScene& rays, const vec3& origin, const vec3& direction) {
    const Seen seen = rays.see(origin, direction).back();
    return {rays.surfaceAt(seen.hit, -seen.direction).position, seen.direction, seen.share};
}

template <class F>
void forBoth(const Scene& scene, const F& body) {
    const Tracer tracer(scene);
    const RayScene rays(scene);
    body([&](const vec3& origin, const vec3& along) { return behindBy(tracer, origin, along); });
    body([&](const vec3& origin, const vec3& along) { return behindBy(rays, origin, along); });
}

constexpr float kTableError = 0.01f;  // of the table of lobes' albedos
constexpr float kRounding = 1e-4f;

// A slab moves what is behind it aside by d sin a (1 - cos a / (n cos b)) and turns no ray.
TEST(Refraction, SlabShiftsWhatIsBehindIt) {
    constexpr float kThickness = 0.7f;
    for (const float ior : {1.0f, 1.33f, 1.5f, 2.4f}) {
        Scene scene;
        addQuad(scene, vec3(-9, -1, -9), vec3(0, 0, 18), vec3(18, 0, 0),
                addMaterial(scene, diffuseParams(vec3(0.5f))));
        addBox(scene, vec3(-4, 0, -4), vec3(4, kThickness, 4), addBody(scene, ior), false);
        scene.materials[1].single_sided = ior > 1.4f;  // both are solid
        forBoth(scene, [&](const auto& look) {
            for (const float a : {0.0f, 0.3f, 0.8f, 1.2f}) {
                const vec3 along(std::sin(a), -std::cos(a), 0.0f);
                const vec3 origin = vec3(0.1f, kThickness, 0.2f) - along;
                const Behind seen = look(origin, along);
                const vec3 off = seen.position - origin;
                const float aside = glm::length(off - glm::dot(off, along) * along);
                const float b = std::asin(std::sin(a) / ior);
                EXPECT_NEAR(aside,
                            kThickness * std::sin(a) * (1.0f - std::cos(a) / (ior * std::cos(b))),
                            kRounding)
                    << "index " << ior << " angle " << a;
                EXPECT_LT(maxAbs(seen.direction - along), kRounding);
                EXPECT_NEAR(seen.position.y, -1.0f, kRounding);
            }
        });
    }
}

// A right-angled prism that a ray enters straight: its long side reflects all of it where the sine
// of 45 degrees exceeds 1 / n, and nothing is lost; else it leaves there by Snell's law.
TEST(Refraction, ReflectsTotallyBeyondTheCriticalAngle) {
    for (const float ior : {1.3f, 1.38f, 1.45f, 1.5f, 2.0f}) {
        Scene scene;
        addBox(scene, vec3(-5), vec3(5), addMaterial(scene, diffuseParams(vec3(0.5f))), true);
        const uint32_t glass = addBody(scene, ior);
        // Legs face -x and -y, the long side +x and +y.
        addQuad(scene, vec3(0, 0, -1), vec3(0, 0, 2), vec3(0, 2, 0), glass);
        addQuad(scene, vec3(0, 0, -1), vec3(2, 0, 0), vec3(0, 0, 2), glass);
        addQuad(scene, vec3(2, 0, -1), vec3(-2, 2, 0), vec3(0, 0, 2), glass);
        const float root = (ior - 1.0f) / (ior + 1.0f);
        const float straight = 1.0f - root * root;
        forBoth(scene, [&](const auto& look) {
            const Behind seen = look(vec3(-1.0f, 0.8f, 0.1f), vec3(1, 0, 0));
            const float sine = ior * std::sqrt(0.5f);
            if (sine > 1.0f) {
                EXPECT_LT(maxAbs(seen.direction - vec3(0, -1, 0)), kRounding) << "index " << ior;
                EXPECT_LT(maxAbs(seen.position - vec3(1.2f, -5.0f, 0.1f)), 10 * kRounding);
                EXPECT_NEAR(seen.share.y, straight * straight, kTableError);
            } else {
                const float turned = std::asin(sine) - 0.25f * kPi;  // toward the long side
                const vec3 along(std::cos(turned), -std::sin(turned), 0.0f);
                EXPECT_LT(maxAbs(seen.direction - along), kRounding) << "index " << ior;
                const float reflected = glm::mix(
                    root * root, 1.0f, shared::schlickWeight(std::sqrt(1.0f - sine * sine)));
                EXPECT_NEAR(seen.share.y, straight * (1.0f - reflected), 2 * kTableError);
            }
        });
    }
}

// A body with a colour inside and on its surface: by the length of the bent way, whichever of its
// sides it shows; the surface's colour counts once.
TEST(Refraction, AbsorbsOverTheBentWay) {
    const vec3 absorption(0.2f, 0.5f, 1.0f), color(0.81f, 0.64f, 0.25f);
    for (const bool single_sided : {false, true}) {
        Scene scene;
        addQuad(scene, vec3(-9, -1, -9), vec3(0, 0, 18), vec3(18, 0, 0),
                addMaterial(scene, diffuseParams(vec3(0.5f))));
        const uint32_t glass = addBody(scene, 1.5f, 0.0f, color);
        scene.materials[glass].absorption = absorption;
        scene.materials[glass].single_sided = single_sided;
        addBox(scene, vec3(-4, 0, -4), vec3(4, 1, 4), glass, false);
        forBoth(scene, [&](const auto& look) {
            const float a = 0.9f;
            const vec3 along(std::sin(a), -std::cos(a), 0.0f);
            const float way = 1.0f / std::cos(std::asin(std::sin(a) / 1.5f));
            const float reflected = glm::mix(0.04f, 1.0f, shared::schlickWeight(std::cos(a)));
            const vec3 expected =
                (1.0f - reflected) * (1.0f - reflected) * color * glm::exp(-way * absorption);
            const Behind from_air = look(vec3(-1, 1, 0) - 2.0f * along, along);
            EXPECT_LT(maxAbs(from_air.share - expected), kTableError);
            // From its middle on half of the way is left, and one surface.
            const vec3 within = glm::refract(along, vec3(0, 1, 0), 1.0f / 1.5f);
            const Behind from_middle = look(vec3(-1, 0.5f, 0), within);
            EXPECT_LT(maxAbs(from_middle.direction - along), kRounding);
            EXPECT_LT(maxAbs(from_middle.share - (1.0f - reflected) * glm::sqrt(color) *
                                                     glm::exp(-0.5f * way * absorption)),
                      kTableError);
        });
    }
}

// Squares of a floor in two colours, under a body before the camera; lit by a sun and a lamp's
// worth of other walls.
Scene chequeredRoom(float ior, float roughness, bool ball) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    const uint32_t light = addMaterial(scene, diffuseParams(vec3(0.8f)));
    const uint32_t dark = addMaterial(scene, diffuseParams(vec3(0.2f, 0.1f, 0.05f)));
    addBox(scene, vec3(-2, -1, -2), vec3(2, 2, 2), {white, white, dark, white, white, white}, true);
    for (int i = 0; i < 16; ++i) {
        addQuad(scene, vec3(-2 + i % 4, -0.99f, -2 + i / 4), vec3(0, 0, 1), vec3(1, 0, 0),
                (i % 4 + i / 4) % 2 == 0 ? light : dark);
    }
    const uint32_t glass = addBody(scene, ior, roughness);
    if (ball) {
        addSphere(scene, vec3(0.0f, -0.2f, 0.0f), 0.6f, 24, glass);
    } else {
        addBox(scene, vec3(-1.0f, -0.5f, -0.3f), vec3(1.0f, 0.5f, 0.1f), glass, false);
    }
    scene.lights.push_back(pointLight(vec3(0.9f, 1.5f, 1.2f), vec3(4.0f)));
    scene.cameras.push_back(lookAt(vec3(0.2f, 0.4f, 1.9f), vec3(0.0f, -0.3f, 0.0f)));
    return scene;
}

void expectAlike(const Scene& scene, const RenderParams& params, const ReferenceParams& paths,
                 double direct_error, double indirect_error) {
    const ReferenceResult truth = renderReference(scene, paths);
    const Frame frame = renderFrame(scene, params).frame;
    const Comparison direct = errorOf(frame, truth.frame, &Frame::direct, &Frame::direct_variance);
    const Comparison indirect =
        errorOf(frame, truth.frame, &Frame::indirect, &Frame::indirect_variance);
    EXPECT_LT(direct.rel_rmse, direct_error);
    EXPECT_LT(std::abs(direct.bias), 0.5 * direct_error);
    EXPECT_LT(indirect.rel_rmse, indirect_error);
    EXPECT_LT(std::abs(indirect.bias), 0.5 * indirect_error);
}

// What is seen through glass is lit by records and lights as all else is.
TEST(Refraction, ShowsWhatTheReferenceShows) {
    constexpr int kSize = 24;
    for (const bool ball : {false, true}) {
        const Scene scene = chequeredRoom(1.5f, 0.0f, ball);
        ReferenceParams paths = smallParams(scene, kSize, 256);
        paths.caustics_apart = true;
        RenderParams params = smallRender(kSize, kSize);
        params.caustics = 50'000;
        expectAlike(scene, params, paths, 0.005, 0.01);
    }
}

// Rough glass blurs it: by the samples of a pixel here, by one microfacet a path there. Samples
// leave noise: 19% of direct light with 16 of them, 7% with 64, 4% with 256.
TEST(Refraction, BlursByRoughnessAsTheReference) {
    constexpr int kSize = 16;
    const Scene scene = chequeredRoom(1.5f, 0.3f, false);
    ReferenceParams paths = smallParams(scene, kSize, 256);
    paths.pixel_area = true;
    paths.caustics_apart = true;
    RenderParams params = smallRender(kSize, kSize);
    params.caustics = 50'000;
    params.aa = 256;
    expectAlike(scene, params, paths, 0.06, 0.05);
}

}  // namespace
}  // namespace sheen
