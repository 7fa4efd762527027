// What a ray sees against closed forms, and against the path tracer, which shares only the shading.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "scene/brdf_albedo.h"
#include "test_light.h"
#include "test_reference.h"

namespace sheen {
namespace {

// A hit's position is rounded, and so is the way from it to the light.
constexpr float kRounding = 1e-4f;

const vec3 kAlbedo(0.8f, 0.5f, 0.2f);

vec4 castOne(const LitScene& rays, const vec3& origin, const vec3& direction) {
    // What was there before must not show.
    vec4 seen(std::numeric_limits<float>::quiet_NaN());
    rays.cast({.origin = origin, .directions = {&direction, 1}}, &seen);
    return seen;
}

vec4 castAt(const LitScene& rays, const vec3& origin, const vec3& target) {
    return castOne(rays, origin, glm::normalize(target - origin));
}

void expectSeen(const vec4& seen, const vec3& radiance, float distance) {
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(seen[c], radiance[c], kRounding * radiance[c] + 1e-7f) << "channel " << c;
    }
    EXPECT_NEAR(seen.w, distance, kRounding * distance);
}

// The floor y = 0, 8 by 8, of one material.
Scene floorOf(const MaterialParams& material) {
    Scene scene;
    addQuad(scene, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8), addMaterial(scene, material));
    return scene;
}

const vec3 kEye(0.3f, 2.0f, 1.0f);
const vec3 kTargets[] = {{0, 0, 0}, {1, 0, -2}, {-3, 0, 1}, {2.5f, 0, 3}, {0.3f, 0, 1}};

// Planes say how far the surface met is, along any direction that meets the same triangle.
TEST(ScatteredOnce, PlanesOfWhatIsMet) {
    const Scene scene = floorOf({});
    const LitScene rays(scene);
    std::vector<vec3> directions;
    for (const vec3& target : kTargets) {
        directions.push_back(glm::normalize(target - kEye));
    }
    directions.push_back(kUp);  // meets nothing
    std::vector<vec4> seen(directions.size());
    std::vector<vec3> planes(directions.size(), vec3(std::numeric_limits<float>::quiet_NaN()));
    rays.cast({.origin = kEye, .directions = directions}, seen.data(), planes.data());
    for (const vec3& plane : planes) {
        if (&plane == &planes.back()) {
            EXPECT_EQ(plane, vec3(0.0f));
            continue;
        }
        for (size_t i = 0; i + 1 < directions.size(); ++i) {
            EXPECT_NEAR(1.0f / glm::dot(plane, directions[i]), seen[i].w, kRounding * seen[i].w);
        }
    }
}

// Rays from kEye to kTargets on the floor see Lambert's law under the scene's first light.
void expectLambert(const Scene& scene) {
    const LitScene rays(scene);
    for (const vec3& p : kTargets) {
        const LightSample l = shared::sampleLight(scene.lights[0], p);
        expectSeen(castAt(rays, kEye, p),
                   kAlbedo / kPi * l.irradiance * std::max(glm::dot(kUp, l.wi), 0.0f),
                   glm::length(p - kEye));
    }
}

// ---- Closed forms -------------------------------------------------------------------------------

TEST(ScatteredOnce, LambertianFloorUnderAPointLight) {
    Scene scene = floorOf(diffuseParams(kAlbedo));
    scene.lights.push_back(pointLight(vec3(1.0f, 1.5f, -0.5f), vec3(3, 2, 1)));
    expectLambert(scene);
    // Spelled out once: I cos / d^2 over pi, the light 1.5 above its foot.
    expectSeen(castAt(LitScene(scene), kEye, vec3(1.0f, 0.0f, -0.5f)),
               kAlbedo / kPi * vec3(3, 2, 1) / (1.5f * 1.5f),
               glm::length(kEye - vec3(1.0f, 0.0f, -0.5f)));
    scene.lights[0].inverse_range = 1.0f / 3.0f;
    expectLambert(scene);
}

TEST(ScatteredOnce, LambertianFloorUnderASpot) {
    Scene scene = floorOf(diffuseParams(kAlbedo));
    scene.lights.push_back(spotLight(vec3(1.0f, 1.5f, -0.5f), vec3(-0.2f, -1, 0.1f), vec3(3, 2, 1),
                                     glm::radians(20.0f), glm::radians(50.0f)));
    expectLambert(scene);
    const LitScene rays(scene);
    const vec4 inside = castAt(rays, kEye, vec3(0.7f, 0, -0.35f));  // on the spot's axis
    const float d2 = 0.3f * 0.3f + 1.5f * 1.5f + 0.15f * 0.15f;
    EXPECT_NEAR(inside.x, kAlbedo.x / kPi * 3.0f * 1.5f / (d2 * std::sqrt(d2)), 1e-3f * inside.x);
    EXPECT_EQ(vec3(castAt(rays, kEye, vec3(-3, 0, 1))), vec3(0.0f));  // outside the cone
}

TEST(ScatteredOnce, LambertianFloorUnderASun) {
    Scene scene = floorOf(diffuseParams(kAlbedo));
    scene.lights.push_back(directionalLight(vec3(0.4f, -1.0f, 0.3f), vec3(3, 2, 1)));
    expectLambert(scene);
    const float cosine = 1.0f / std::sqrt(1.25f);
    for (const vec3& p : kTargets) {
        expectSeen(castAt(LitScene(scene), kEye, p), kAlbedo / kPi * vec3(3, 2, 1) * cosine,
                   glm::length(p - kEye));
    }
}

TEST(ScatteredOnce, LightsAndEmissionAddUp) {
    const vec3 Le(0.5f, 1.5f, 0.25f);
    Scene scene = floorOf(diffuseParams(kAlbedo, Le));
    for (const vec3& p : kTargets) {
        expectSeen(castAt(LitScene(scene), kEye, p), Le, glm::length(p - kEye));
    }
    scene.lights.push_back(pointLight(vec3(1.0f, 1.5f, -0.5f), vec3(3, 2, 1)));
    scene.lights.push_back(pointLight(vec3(-1.0f, 0.5f, 0.5f), vec3(1, 2, 3)));
    scene.lights.push_back(directionalLight(vec3(0.4f, -1.0f, 0.3f), vec3(1)));
    const LitScene rays(scene);
    for (const vec3& p : kTargets) {
        vec3 expected = Le;
        for (const PunctualLight& light : scene.lights) {
            const LightSample l = shared::sampleLight(light, p);
            expected += kAlbedo / kPi * l.irradiance * glm::dot(kUp, l.wi);
        }
        expectSeen(castAt(rays, kEye, p), expected, glm::length(p - kEye));
    }
}

TEST(ScatteredOnce, GlossyFloorScattersByTheBrdf) {
    // In and about the mirrored direction, for smooth, rough, plastic and metal.
    const vec3 target(0.2f, 0, -0.4f);
    const vec3 wo = glm::normalize(kEye - target);
    const vec3 mirrored(-wo.x, wo.y, -wo.z);
    Random random(1);
    for (const auto& [metallic, roughness] :
         {std::pair(0.0f, 0.2f), std::pair(0.0f, 0.6f), std::pair(1.0f, 0.3f),
          std::pair(1.0f, 1.0f), std::pair(0.5f, 0.05f)}) {
        const MaterialParams material = glossyParams(kAlbedo, metallic, roughness);
        for (int i = 0; i < 8; ++i) {
            const vec3 wi =
                glm::normalize(mirrored + 0.1f * static_cast<float>(i) * random.direction(kUp));
            Scene scene = floorOf(material);
            scene.lights.push_back(directionalLight(-wi, vec3(3, 2, 1)));
            const Brdf brdf = shared::makeBrdf(material, wo.y, brdfAlbedo(wo.y, roughness));
            const vec3 f = shared::evalBrdf(brdf, kUp, wo, wi);
            const vec4 seen = castAt(LitScene(scene), kEye, target);
            for (int c = 0; c < 3; ++c) {
                const float expected = f[c] * scene.lights[0].intensity[c] * wi.y;
                // Smooth lobes change by a percent a milliradian.
                EXPECT_NEAR(seen[c], expected, 1e-3f * expected)
                    << "metallic " << metallic << " roughness " << roughness;
            }
        }
    }
}

TEST(ScatteredOnce, BothSidesShadeAlike) {
    Scene scene = floorOf(glossyParams(kAlbedo, 0.0f, 0.4f, vec3(0.1f)));
    scene.lights.push_back(pointLight(vec3(1.0f, 1.5f, -0.5f), vec3(3, 2, 1)));
    scene.lights.push_back(pointLight(vec3(1.0f, -1.5f, -0.5f), vec3(3, 2, 1)));
    const LitScene rays(scene);
    for (const vec3& p : kTargets) {
        const vec4 front = castAt(rays, kEye, p);
        EXPECT_GT(front.x, 0.2f * 0.5f);
        expectSeen(castAt(rays, kEye * vec3(1, -1, 1), p), vec3(front), front.w);
    }
}

TEST(ScatteredOnce, LightsBelowEitherHorizonDoNotLight) {
    // Normals tilted by 45 degrees toward +x.
    Scene scene = floorOf(diffuseParams(kAlbedo));
    std::fill(scene.normals.begin(), scene.normals.end(), glm::normalize(vec3(1, 1, 0)));
    const vec3 eye(1, 2, 0);
    const auto lit = [&](const vec3& toward_light) {
        scene.lights = {directionalLight(-toward_light, vec3(1))};
        return castAt(LitScene(scene), eye, vec3(0)).x;
    };
    EXPECT_NEAR(lit(vec3(1, 1, 0)), kAlbedo.x / kPi, kRounding);
    EXPECT_EQ(lit(vec3(-1, 0.9f, 0)), 0.0f);  // above the surface, below the shading normal's
    EXPECT_EQ(lit(vec3(1, -0.1f, 0)), 0.0f);  // the other way round
}

TEST(ScatteredOnce, BaseColourTexture) {
    // One row of four texels across the floor, red to black.
    Scene scene = floorOf(diffuseParams(vec3(0.5f, 1.0f, 1.0f)));
    const std::vector<vec3> texels = {vec3(0.8f, 0, 0), vec3(0, 0.6f, 0), vec3(0, 0, 0.4f),
                                      vec3(0.0f)};
    scene.materials[0].textures[shared::TEXTURE_BASE_COLOR].texture =
        addTexture(scene, 4, 1, texels, shared::WRAP_CLAMP);
    scene.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    scene.lights.push_back(directionalLight(vec3(0, -1, 0), vec3(kPi)));
    const LitScene rays(scene);
    for (int i = 0; i < 4; ++i) {
        const vec3 p(-3.0f + 2.0f * static_cast<float>(i), 0, 0.7f);  // texels' middles
        const vec3& texel = texels[static_cast<size_t>(i)];
        // Middles are hit to within rounding: a trace of the neighbour.
        const vec3 seen(castAt(rays, kEye, p));
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(seen[c], (vec3(0.5f, 1, 1) * texel)[c], 1e-5f) << i;
        }
    }
    // Half way between red and green.
    const vec3 between(castAt(rays, kEye, vec3(-2, 0, 0.7f)));
    EXPECT_NEAR(between.x, 0.5f * 0.4f, 1e-5f);
    EXPECT_NEAR(between.y, 0.3f, 1e-5f);
}

// ---- Nothing ------------------------------------------------------------------------------------

TEST(ScatteredOnce, NothingMetIsAllZero) {
    Scene scene = floorOf(diffuseParams(kAlbedo, vec3(1.0f)));
    scene.lights.push_back(pointLight(vec3(0, 1, 0), vec3(3)));
    const LitScene rays(scene);
    EXPECT_EQ(castOne(rays, kEye, kUp), vec4(0.0f));
    EXPECT_EQ(castOne(rays, kEye, vec3(1, 0, 0)), vec4(0.0f));
    EXPECT_EQ(castAt(rays, kEye, vec3(4.01f, 0, 0)), vec4(0.0f));
    EXPECT_GT(castAt(rays, kEye, vec3(3.99f, 0, 0)).w, 0.0f);
}

TEST(ScatteredOnce, EmptyScene) {
    Scene scene;
    scene.lights.push_back(pointLight(vec3(0, 1, 0), vec3(3)));
    const LitScene rays(scene);
    std::vector<vec3> directions(9, glm::normalize(vec3(1, 2, 3)));
    std::vector<vec4> seen(directions.size(), vec4(7.0f));
    rays.cast({.origin = vec3(0), .directions = directions}, seen.data());
    for (const vec4& v : seen) {
        EXPECT_EQ(v, vec4(0.0f));
    }
}

// ---- Shadows ------------------------------------------------------------------------------------

// The floor, and a square of half-width 0.2 at height `height` over the origin.
Scene floorWithBlocker(float height) {
    Scene scene = floorOf(diffuseParams(kAlbedo));
    addQuad(scene, vec3(-0.2f, height, 0.2f), vec3(0.4f, 0, 0), vec3(0, 0, -0.4f), 0);
    return scene;
}

TEST(ScatteredOnce, OccludersShadowPointsSpotsAndSuns) {
    for (const PunctualLight& light :
         {pointLight(vec3(0, 1, 0), vec3(3)),
          spotLight(vec3(0, 1, 0), vec3(0, -1, 0), vec3(3), 1.3f, 1.4f),
          directionalLight(vec3(0, -1, 0), vec3(3))}) {
        Scene scene = floorWithBlocker(0.5f);
        scene.lights.push_back(light);
        const LitScene rays(scene);
        // A point light's shadow is twice as wide as what casts it, a sun's as wide.
        const float edge = light.kind == shared::LIGHT_DIRECTIONAL ? 0.2f : 0.4f;
        for (float sign : {-1.0f, 1.0f}) {
            const vec3 shaded(sign * (edge - 1e-3f), 0, 0), lit(sign * (edge + 1e-3f), 0, 0);
            const vec3 eye(sign * 3.0f, 0.4f, 0.1f);
            EXPECT_EQ(vec3(castAt(rays, eye, shaded)), vec3(0.0f)) << light.kind;
            EXPECT_GT(castAt(rays, eye, lit).x, 0.1f) << light.kind;
        }
    }
}

TEST(ScatteredOnce, OccludersBeyondTheLightDoNotShadow) {
    for (float beyond : {1e-3f, 0.5f}) {
        Scene scene = floorWithBlocker(1.0f + beyond);
        scene.lights.push_back(pointLight(vec3(0, 1, 0), vec3(3)));
        expectSeen(castAt(LitScene(scene), vec3(2, 0.5f, 0), vec3(0)), kAlbedo / kPi * 3.0f,
                   std::sqrt(4.25f));
    }
}

TEST(ScatteredOnce, ALightOnASurfaceIsNotHiddenByIt) {
    // It lights what is on either side, at any scale and however the surface is turned.
    Random random(2);
    for (float scale : {1e-3f, 1.0f, 1e4f}) {
        for (int trial = 0; trial < 20; ++trial) {
            const mat3 turn = random.rotation();
            const vec3 away = scale * 3.0f * random.direction();
            Scene scene = floorOf(diffuseParams(kAlbedo));
            addQuad(scene, vec3(-4, 1.5f, 4), vec3(8, 0, 0), vec3(0, 0, -8), 0);
            scene.bounds = {};
            for (vec3& p : scene.positions) {
                p = turn * (scale * p) + away;
                scene.bounds.add(p);
            }
            for (vec3& n : scene.normals) {
                n = turn * n;
            }
            const auto place = [&](const vec3& p) { return turn * (scale * p) + away; };
            scene.lights.push_back(
                pointLight(place(vec3(0.3f, 1.5f, -0.2f)), vec3(3) * scale * scale));
            const LitScene rays(scene);
            for (const vec3& p : {vec3(0.3f, 0, -0.2f), vec3(1, 0, 1), vec3(-3.5f, 0, 3)}) {
                const vec3 d = vec3(0.3f, 1.5f, -0.2f) - p;
                const float expected =
                    kAlbedo.x / kPi * 3.0f * 1.5f / std::pow(glm::length(d), 3.0f);
                const vec4 seen = castAt(rays, place(vec3(0, 1, 0)), place(p));
                EXPECT_NEAR(seen.x, expected, 1e-3f * expected) << "scale " << scale;
            }
        }
    }
}

TEST(ScatteredOnce, LightsBehindTheSurfaceDoNotShineThrough) {
    Scene scene = floorOf(diffuseParams(kAlbedo));
    scene.lights.push_back(pointLight(vec3(0.1f, -0.5f, 0), vec3(5)));
    scene.lights.push_back(pointLight(vec3(0.1f, -1e-3f, 0), vec3(5)));
    scene.lights.push_back(directionalLight(vec3(0.3f, 1, 0.1f), vec3(5)));
    const LitScene rays(scene);
    for (const vec3& p : kTargets) {
        EXPECT_EQ(vec3(castAt(rays, kEye, p)), vec3(0.0f));
    }
}

TEST(ScatteredOnce, SurfacesDoNotShadowThemselves) {
    // Large triangles away from the origin, lights down to a degree above them.
    Random random(3);
    for (int trial = 0; trial < 200; ++trial) {
        const vec3 n = random.direction();
        const vec3 u = glm::normalize(glm::cross(n, random.direction()));
        const vec3 v = glm::cross(n, u);
        const vec3 center = random.point(-5.0f, 5.0f);
        Scene scene;
        addQuad(scene, center - 10.0f * (u + v), 20.0f * u, 20.0f * v,
                addMaterial(scene, diffuseParams(kAlbedo)));
        const float height = trial % 2 == 0 ? 0.02f : 0.5f;
        scene.lights.push_back(directionalLight(-(u + height * n), vec3(1)));
        const float cosine = height / std::sqrt(1.0f + height * height);
        const vec3 p = center + random.uniform(-8.0f, 8.0f) * u + random.uniform(-8.0f, 8.0f) * v;
        // Higher than where the shading normal is bent toward the viewer.
        const vec3 viewer = glm::normalize(random.direction(n) + 0.05f * n);
        const vec4 seen = castAt(LitScene(scene), p + 3.0f * viewer, p);
        EXPECT_NEAR(seen.x, kAlbedo.x / kPi * cosine, 1e-3f * seen.x) << "trial " << trial;
    }
}

// ---- The same rays ------------------------------------------------------------------------------

TEST(ScatteredOnce, AnyNumberOfRaysSeesWhatEachSeesAlone) {
    const Scene scene = glossyRoom();
    const LitScene rays(scene);
    Random random(4);
    for (size_t count : {0u, 1u, 7u, 8u, 9u, 17u}) {
        for (int trial = 0; trial < 20; ++trial) {
            const vec3 origin = random.point(-0.9f, 0.9f);
            std::vector<vec3> directions;
            for (size_t i = 0; i < count; ++i) {
                directions.push_back(random.direction());
            }
            // One more than there are rays stays as it was.
            std::vector<vec4> seen(count + 1, vec4(7.0f));
            rays.cast({.origin = origin, .directions = directions}, seen.data());
            for (size_t i = 0; i < count; ++i) {
                EXPECT_EQ(seen[i], castOne(rays, origin, directions[i])) << i << " of " << count;
            }
            EXPECT_EQ(seen[count], vec4(7.0f));
        }
    }
}

TEST(ScatteredOnce, ScalingTheSceneScalesDistancesOnly) {
    // Rays that meet or pass an edge within rounding may see another surface or light.
    constexpr int kRays = 2000, kEdgeRays = 4;
    const Scene scene = glossyRoom();
    const LitScene rays(scene);
    for (float s : {1e-3f, 1e4f}) {
        const Scene other_scene = scaled(scene, s);
        const LitScene other_rays(other_scene);
        Random random(5);
        int different = 0;
        for (int i = 0; i < kRays; ++i) {
            const vec3 origin(0.1f, 0.2f, 0.8f), d = random.direction();
            const vec4 one = castOne(rays, origin, d);
            const vec4 other = castOne(other_rays, s * origin, d);
            const float error = glm::length(vec3(one) - vec3(other));
            const bool same = error <= 1e-3f * glm::length(vec3(one)) + 1e-6f &&
                              std::abs(other.w - s * one.w) <= 1e-4f * s * one.w;
            different += same ? 0 : 1;
        }
        EXPECT_LE(different, kEdgeRays) << "scale " << s;
    }
}

TEST(ScatteredOnce, SeesWhatTheReferenceSees) {
    constexpr int kSize = 64;
    Scene scene = glossyRoom();
    scene.lights.push_back(
        spotLight(vec3(-0.5f, 0.8f, 0.2f), vec3(0.3f, -1, 0), vec3(2), 0.3f, 0.6f));
    const LitScene rays(scene);
    const Frame frame = firstHits(scene, kSize, kSize);
    int same = 0;
    for (int i = 0; i < kSize * kSize; ++i) {
        const CameraRay ray =
            cameraRay(scene.cameras[0], kSize, kSize, static_cast<float>(i % kSize),
                      static_cast<float>(i / kSize));
        const vec4 seen = castOne(rays, ray.origin, ray.direction);
        const auto pixel = static_cast<size_t>(i);
        const vec3 expected = frame.direct.pixels[pixel];
        const float distance = glm::length(frame.position.pixels[pixel] - ray.origin);
        same += glm::length(vec3(seen) - expected) <= 1e-3f * glm::length(expected) + 1e-6f &&
                        std::abs(seen.w - distance) <= kRounding * distance
                    ? 1
                    : 0;
    }
    // A few pixels see an edge, of a surface or of a shadow.
    EXPECT_GE(same, kSize * kSize - 8);
}

}  // namespace
}  // namespace sheen
