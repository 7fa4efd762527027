// Views, and the G-buffer against rays.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "image/frame.h"
#include "reference/ray_scene.h"
#include "test_reference.h"
#include "test_stage.h"

namespace sheen {
namespace {

// ---- Views --------------------------------------------------------------------------------------

TEST(View, ProjectingUndoesTheDirection) {
    Random random(1);
    for (int i = 0; i < 300; ++i) {
        const mat3 r = random.rotation();
        // A leaning forward axis, as half faces of a hemicube have.
        const View view = perspectiveView(random.point(-2.0f, 2.0f), 1.5f * r[0], 0.5f * r[1],
                                          r[2] + (i % 2 == 0 ? 0.5f * r[1] : vec3(0.0f)), 0.01f);
        const vec2 uv(random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f));
        const float depth = std::pow(10.0f, random.uniform(-2.0f, 3.0f));
        const vec3 p = view.origin + depth * shared::viewDirection(view, uv);
        const vec4 clip = shared::clipFromWorld(view, p);
        // Coordinates of order one, and the origin's: cancellation at small depths.
        const float rounding = 1e-5f + 1e-6f / depth;
        EXPECT_NEAR(clip.x / clip.w, uv.x, rounding);
        EXPECT_NEAR(clip.y / clip.w, uv.y, rounding);
        EXPECT_NEAR(clip.w, depth, rounding * depth);
        EXPECT_NEAR(clip.z / clip.w, 0.01f / depth, rounding);
    }
}

TEST(View, ParallelViewMapsItsBox) {
    Random random(2);
    for (int i = 0; i < 100; ++i) {
        const mat3 r = random.rotation();
        const View view =
            parallelView(random.point(-2.0f, 2.0f), 3.0f * r[0], 2.0f * r[1], 5.0f * r[2]);
        const vec3 c = random.point(0.0f, 1.0f);
        const vec3 p = view.origin + (2.0f * c.x - 1.0f) * view.right +
                       (2.0f * c.y - 1.0f) * view.up + c.z * view.forward;
        const vec4 clip = shared::clipFromWorld(view, p);
        EXPECT_NEAR(clip.x, 2.0f * c.x - 1.0f, 1e-5f);
        EXPECT_NEAR(clip.y, 2.0f * c.y - 1.0f, 1e-5f);
        EXPECT_NEAR(clip.z, 1.0f - c.z, 1e-5f);  // reversed: 1 at the near end
        EXPECT_EQ(clip.w, 1.0f);
    }
}

TEST(View, CameraViewSeesTheRaysOfTheCamera) {
    Random random(3);
    for (const auto& [width, height] : {std::pair(64, 48), std::pair(1, 1), std::pair(300, 7)}) {
        Camera camera = lookAt(random.point(-1.0f, 1.0f), random.point(-1.0f, 1.0f));
        camera.y_fov = random.uniform(0.2f, 2.0f);
        const View view = cameraView(camera, width, height);
        for (int i = 0; i < 50; ++i) {
            const float x = random.uniform(0.0f, static_cast<float>(width) - 1.0f);
            const float y = random.uniform(0.0f, static_cast<float>(height) - 1.0f);
            const CameraRay ray = cameraRay(camera, width, height, x, y);
            const vec2 uv(2.0f * (x + 0.5f) / static_cast<float>(width) - 1.0f,
                          2.0f * (y + 0.5f) / static_cast<float>(height) - 1.0f);
            const vec3 d = glm::normalize(shared::viewDirection(view, uv));
            EXPECT_NEAR(glm::length(d - ray.direction), 0.0f, 1e-5f);
            EXPECT_EQ(view.origin, ray.origin);
        }
    }
}

TEST(SphereInView, NeverLosesAVisibleSphere) {
    Random random(4);
    int seen = 0;
    for (int i = 0; i < 2000; ++i) {
        const mat3 r = random.rotation();
        const View view =
            perspectiveView(random.point(-1.0f, 1.0f), random.uniform(0.1f, 4.0f) * r[0],
                            random.uniform(0.1f, 4.0f) * r[1], r[2], 1e-4f);
        const vec3 center = random.point(-4.0f, 4.0f);
        const float radius = std::pow(10.0f, random.uniform(-2.0f, 0.7f));
        bool visible = false;
        for (int k = 0; k < 60 && !visible; ++k) {
            const vec3 p = center + radius * random.uniform(0.0f, 1.0f) * random.direction();
            const vec4 clip = shared::clipFromWorld(view, p);
            visible = clip.w > 0.0f && std::abs(clip.x) < clip.w && std::abs(clip.y) < clip.w;
        }
        if (visible) {
            ++seen;
            EXPECT_TRUE(sphereInView(view, center, radius));
        }
    }
    EXPECT_GT(seen, 200);
    const View view = perspectiveView(vec3(0), vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), 1e-4f);
    EXPECT_FALSE(sphereInView(view, vec3(0, 0, -2), 1.0f));
    EXPECT_FALSE(sphereInView(view, vec3(10, 0, 2), 1.0f));
}

TEST(SphereInView, ParallelViewsKeepWhatReachesThem) {
    const View view = parallelView(vec3(1, 2, 3), vec3(2, 0, 0), vec3(0, 0.5f, 0), vec3(0, 0, -4));
    EXPECT_TRUE(sphereInView(view, vec3(1, 2, 1), 0.1f));
    EXPECT_TRUE(sphereInView(view, vec3(3.09f, 2, 1), 0.1f));
    EXPECT_FALSE(sphereInView(view, vec3(3.11f, 2, 1), 0.1f));
    EXPECT_TRUE(sphereInView(view, vec3(1, 1.41f, 1), 0.1f));
    EXPECT_FALSE(sphereInView(view, vec3(1, 1.39f, 1), 0.1f));
}

// ---- G-buffer -----------------------------------------------------------------------------------

// Positions come from single-precision rays; relative to the scene's size.
constexpr float kPositionError = 3e-6f;

TEST(GBuffer, AgreesWithTheReferencesFirstHits) {
    for (float scale : {1.0f, 1000.0f, 0.001f}) {
        const Scene scene = scaled(glossyRoom(0.4f, 0.3f), scale);
        TestStage stage(scene);
        const int width = 90, height = 70;
        const GBuffer g = stage.gbuffer(width, height);
        const Frame frame = firstHits(scene, width, height);
        EXPECT_EQ(g.primitive.pixels, frame.primitive.pixels) << "scale " << scale;
        for (int i = 0; i < width * height; ++i) {
            const auto p = static_cast<size_t>(i);
            ASSERT_TRUE(g.seen(i));
            const float size = scene.bounds.size();
            EXPECT_LT(glm::length(g.position.pixels[p] - frame.position.pixels[p]),
                      kPositionError * size);
            EXPECT_NEAR(g.depth.pixels[p], frame.depth.pixels[p], kPositionError * size);
            EXPECT_LT(glm::length(g.normal.pixels[p] - frame.normal.pixels[p]), 1e-4f);
            EXPECT_NEAR(g.roughness.pixels[p], frame.roughness.pixels[p], 1e-6f);
            EXPECT_LT(glm::length(g.diffuse.pixels[p] - frame.albedo.pixels[p]), 1e-4f);
            const vec3 emission = g.emission.empty() ? vec3(0.0f) : g.emission.pixels[p];
            EXPECT_LT(glm::length(emission - frame.emission.pixels[p]), 1e-6f);
        }
    }
}

// One surface for pixels and rays, edges and contacts included.
TEST(GBuffer, SeesTheTrianglesThatRaysMeet) {
    constexpr int kSide = 128;
    for (const char* name : {"atrium", "ledges", "venus_glossy", "cornell_glossy"}) {
        const Scene scene = loadScene(fmt::format("{}/{}.glb", SHEEN_SCENES, name));
        const Tracer rays(scene);
        const RayScene reference(scene);
        for (const Camera& camera : scene.cameras) {
            const GBuffer g = renderGBuffer(rays, camera, kSide, kSide);
            int differing = 0;
            for (int i = 0; i < kSide * kSide; ++i) {
                const CameraRay ray = cameraRay(camera, kSide, kSide, static_cast<float>(i % kSide),
                                                static_cast<float>(i / kSide));
                const uint32_t triangle = reference.intersect(ray.origin, ray.direction).triangle;
                differing += g.primitive.pixels[static_cast<size_t>(i)] != triangle ? 1 : 0;
            }
            EXPECT_EQ(differing, 0) << name << ", camera " << camera.name;
        }
    }
}

TEST(GBuffer, NormalsFaceTheViewerOnBothSides) {
    Scene scene;
    addQuad(scene, vec3(-5, -5, 0), vec3(10, 0, 0), vec3(0, 10, 0),
            addMaterial(scene, diffuseParams(vec3(0.5f))));
    TestStage stage(scene);
    for (float side : {-1.0f, 1.0f}) {
        const GBuffer g = stage.gbuffer(lookAt(vec3(0.3f, 0.2f, side), vec3(0)), 9, 9);
        for (const vec3& n : g.normal.pixels) {
            EXPECT_NEAR(n.z, side, 1e-6f);
        }
    }
}

TEST(GBuffer, ManyTrianglesKeepTheirNumbers) {
    // More triangles than one cluster, and than any 8-bit number.
    Scene scene;
    const uint32_t m = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addSphere(scene, vec3(0), 1.0f, 48, m);
    TestStage stage(scene, 1);
    EXPECT_GT(stage.gpu.clusters.size(), 10u);
    const Camera camera = lookAt(vec3(0, 0.2f, 3), vec3(0));
    const GBuffer g = stage.gbuffer(camera, 64, 64);
    int seen = 0;
    for (int i = 0; i < 64 * 64; ++i) {
        if (!g.seen(i)) {
            EXPECT_EQ(g.primitive.pixels[static_cast<size_t>(i)], kNoPrimitive);
            continue;
        }
        ++seen;
        // The pixel's position lies on the plane of its triangle.
        const uint32_t t = g.primitive.pixels[static_cast<size_t>(i)];
        ASSERT_LT(t, scene.triangles.size());
        const vec3& p = g.position.pixels[static_cast<size_t>(i)];
        const vec3& corner = scene.positions[scene.triangles[t].x];
        EXPECT_NEAR(glm::dot(p - corner, geometricNormal(scene, static_cast<int>(t))), 0.0f, 1e-5f);
        EXPECT_LT(glm::length(p - corner), 0.15f);
    }
    EXPECT_GT(seen, 500);
}

TEST(GBuffer, EmptySceneShowsNothing) {
    Scene scene;
    scene.lights.push_back(pointLight(vec3(0), vec3(1)));
    scene.lights.push_back(directionalLight(vec3(0, -1, 0), vec3(1)));
    TestStage stage(scene);
    const GBuffer g = stage.gbuffer(lookAt(vec3(0, 0, 1), vec3(0)), 17, 5);
    for (int i = 0; i < 17 * 5; ++i) {
        EXPECT_FALSE(g.seen(i));
        EXPECT_EQ(g.primitive.pixels[static_cast<size_t>(i)], kNoPrimitive);
        EXPECT_EQ(g.direct.pixels[static_cast<size_t>(i)], vec3(0.0f));
    }
}

TEST(GBuffer, OnePixelAndVeryWideImages) {
    const Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    TestStage stage(scene);
    for (const auto& [width, height] : {std::pair(1, 1), std::pair(1000, 1), std::pair(1, 130)}) {
        const GBuffer g = stage.gbuffer(width, height);
        for (int i = 0; i < width * height; ++i) {
            EXPECT_TRUE(g.seen(i)) << width << "x" << height;
        }
    }
}

TEST(GBuffer, TheSameBitsForAnyNumberOfWorkers) {
    const Scene scene =
        cornellRoom(glossyParams(vec3(0.5f), 0.0f, 0.4f), diffuseParams(vec3(0.5f)));
    GBuffer first;
    for (int workers : {1, 2, 3}) {
        TestStage stage(scene, workers);
        const GBuffer g = stage.gbuffer(50, 140);
        if (workers == 1) {
            first = g;
        }
        EXPECT_EQ(g.position.pixels, first.position.pixels) << workers;
        EXPECT_EQ(g.direct.pixels, first.direct.pixels) << workers;
        EXPECT_EQ(g.primitive.pixels, first.primitive.pixels) << workers;
    }
}

}  // namespace
}  // namespace sheen
