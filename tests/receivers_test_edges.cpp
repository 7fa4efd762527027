// Which pixels have edges, and whose light their samples take.
#include <gtest/gtest.h>

#include <set>

#include "light/direct.h"
#include "receivers/edges.h"
#include "test_scenes.h"

namespace sheen {
namespace {

constexpr int kSize = 24;

TEST(PixelSamples, HaveARowAndAColumnEach) {
    for (const int count : {1, 2, 8, 64}) {
        std::set<int> rows, columns;
        for (const vec2& sample : pixelSamples(count)) {
            columns.insert(static_cast<int>(sample.x * static_cast<float>(count)));
            rows.insert(static_cast<int>(sample.y * static_cast<float>(count)));
        }
        EXPECT_EQ(rows.size(), static_cast<size_t>(count));
        EXPECT_EQ(columns.size(), static_cast<size_t>(count));
    }
    EXPECT_EQ(pixelSamples(1), std::vector<vec2>{vec2(0.5f)});
}

struct Found {
    Receivers pixels;
    Edges edges;
};

Found find(const Scene& scene, int count) {
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const Camera& camera = scene.cameras.front();
    GBuffer gbuffer = renderGBuffer(tracer, camera, kSize, kSize);
    gbuffer.direct = traceDirect(tracer, lights, gbuffer);
    Found found;
    found.pixels = receiversOf(scene, std::move(gbuffer), 0, false);
    const Image<vec3> all;
    found.edges = findEdges(tracer, lights, camera, found.pixels, {0, all}, 0, count);
    return found;
}

// A floor that fills the image, evenly lit, of two materials that meet in the middle of a pixel.
TEST(Edges, ArePixelsWhereMaterialsMeet) {
    Scene scene;
    const float pixel = 2.0f * std::tan(0.45f) / kSize;
    const uint32_t left = addMaterial(scene, diffuseParams(vec3(0.8f)));
    const uint32_t right = addMaterial(scene, diffuseParams(vec3(0.2f)));
    const float border = 3.75f * pixel;  // a quarter of column 15 lies to its right
    addQuad(scene, vec3(-9, -9, 0), vec3(9 + border, 0, 0), vec3(0, 18, 0), left);
    addQuad(scene, vec3(border, -9, 0), vec3(9, 0, 0), vec3(0, 18, 0), right);
    scene.lights.push_back(directionalLight(vec3(0, 0, -1), vec3(kPi)));
    scene.cameras.push_back(lookAt(vec3(0, 0, 1), vec3(0)));
    const Found found = find(scene, 8);
    std::set<size_t> columns;
    for (size_t k = 0; k < found.edges.pixels.size(); ++k) {
        const EdgePixel& edge = found.edges.pixels[k];
        columns.insert(edge.pixel % kSize);
        EXPECT_EQ(edge.coverage, 1.0f);
        vec3 diffuse(0.0f);
        for (size_t s = edge.first_share; s < found.edges.endOfShares(k); ++s) {
            const EdgeShare& share = found.edges.shares[s];
            diffuse += share.diffuse;
            const size_t column = static_cast<size_t>(share.receiver) % kSize;
            EXPECT_EQ(share.diffuse.x > 0.3f, column <= 15) << column;
        }
        const float expected = edge.pixel % kSize == 15  ? 0.75f * 0.8f + 0.25f * 0.2f
                               : edge.pixel % kSize < 15 ? 0.8f
                                                         : 0.2f;
        EXPECT_NEAR(diffuse.x, expected, 1e-5f);
        EXPECT_NEAR(edge.direct.x, expected, 1e-4f);
    }
    EXPECT_EQ(found.edges.strays.count(), 0);
    EXPECT_TRUE(columns.count(15) == 1 && columns.size() <= 3);
}

TEST(Edges, AreShadowsToo) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.8f)));
    addQuad(scene, vec3(-9, -9, 0), vec3(18, 0, 0), vec3(0, 18, 0), white);
    addQuad(scene, vec3(0.013f, -9, 2), vec3(9, 0, 0), vec3(0, 18, 0), white);  // behind the eye
    scene.lights.push_back(directionalLight(vec3(0, 0, -1), vec3(kPi)));
    scene.cameras.push_back(lookAt(vec3(0, 0, 1), vec3(0)));
    const Found found = find(scene, 8);
    EXPECT_EQ(found.edges.pixels.size(), size_t{2 * kSize});
    const float pixel = 2.0f * std::tan(0.45f) / kSize;
    for (const EdgePixel& edge : found.edges.pixels) {
        const float lit = edge.pixel % kSize == kSize / 2 ? 0.013f / pixel : 1.0f;
        EXPECT_NEAR(edge.direct.x / 0.8f, lit, 1.0f / 16.0f + 1e-4f);
        EXPECT_EQ(found.edges.shares[edge.first_share].receiver, static_cast<int>(edge.pixel));
    }
}

}  // namespace
}  // namespace sheen
