// Pixels with edges: how much of what they show, against closed forms and the reference's pixels.
#include <gtest/gtest.h>

#include <cstring>

#include "core/error.h"
#include "core/parallel.h"
#include "metrics/compare.h"
#include "test_render.h"

namespace sheen {
namespace {

constexpr int kSize = 32;
constexpr int kSamples = 16;

// A square of side 1.1 in front of the camera, a little turned in the image, with that material.
Scene squareAlone(const MaterialParams& material) {
    Scene scene;
    const vec3 right = 1.1f * vec3(std::cos(0.2f), std::sin(0.2f), 0.0f);
    const vec3 up(-right.y, right.x, 0.0f);
    addQuad(scene, -0.5f * (right + up), right, up, addMaterial(scene, material));
    scene.cameras.push_back(lookAt(vec3(0, 0, 2), vec3(0)));
    return scene;
}

RenderParams smooth(Method method) {
    RenderParams params = smallRender(kSize, kSize, method);
    params.aa = kSamples;
    params.spp = 64;
    return params;
}

double sumOf(const Image<float>& image) {
    double sum = 0.0;
    for (const float value : image.pixels) {
        sum += value;
    }
    return sum;
}

// The square covers as many pixels as its area over theirs, to a hundredth of a pixel's side along
// its outline; its glow, averaged, follows.
TEST(SmoothEdges, CoverageIsTheArea) {
    const Scene scene = squareAlone(diffuseParams(vec3(0.0f), vec3(3.0f)));
    const float pixel = 2.0f * 2.0f * std::tan(0.5f * scene.cameras[0].y_fov) / kSize;
    const double area = 1.1 * 1.1 / (pixel * pixel);
    for (const Method method : {Method::kRadiance, Method::kReference}) {
        const Frame frame = renderFrame(scene, smooth(method)).frame;
        EXPECT_NEAR(sumOf(alpha(frame)), area, 0.01 * 4.0 * 1.1 / pixel);
        int partly = 0;
        for (size_t i = 0; i < frame.coverage.pixels.size(); ++i) {
            const float covered = frame.coverage.pixels[i];
            partly += covered > 0.0f && covered < 1.0f ? 1 : 0;
            EXPECT_NEAR(frame.emission.pixels[i].x, 3.0f * covered, 1e-5f);
        }
        EXPECT_GT(partly, kSize);
    }
}

// Each pixel, of edges too, is as bright as its share of a box under a constant sky: no dark or
// bright fringe.
TEST(SmoothEdges, AFurnaceHasNoFringe) {
    const vec3 sky(1.0f, 0.8f, 0.5f);
    for (const bool glossy : {false, true}) {
        const MaterialParams material =
            glossy ? glossyParams(vec3(0.9f), 1.0f, 0.5f) : diffuseParams(vec3(0.6f));
        const Scene scene = furnace(material, sky, GatherRoad::kRays);
        const Frame middles = renderFrame(scene, smallRender(kSize, kSize)).frame;
        const RenderResult result = renderFrame(scene, smooth(Method::kRadiance));
        EXPECT_GT(result.stats.pixels_edges, 30);
        const Frame& frame = result.frame;
        float darkest = kInfinity, brightest = 0.0f;  // of pixels' middles
        for (size_t i = 0; i < middles.primitive.pixels.size(); ++i) {
            if (middles.primitive.pixels[i] != kNoPrimitive) {
                darkest = std::min(darkest, middles.indirect.pixels[i].x);
                brightest = std::max(brightest, middles.indirect.pixels[i].x);
            }
        }
        for (size_t i = 0; i < frame.indirect.pixels.size(); ++i) {
            const float covered = frame.coverage.pixels[i];
            EXPECT_GE(frame.indirect.pixels[i].x, 0.98f * darkest * covered) << i;
            EXPECT_LE(frame.indirect.pixels[i].x, 1.02f * brightest * covered + 1e-6f) << i;
            EXPECT_NEAR(frame.emission.pixels[i].x, sky.x * (1.0f - covered), 1e-5f);
        }
    }
}

// Bars a third of a pixel wide, of which few pixels' middles see anything, before a wall.
TEST(SmoothEdges, ThinThingsAreLitAsTheReferenceHasThem) {
    Scene scene;
    const uint32_t wall = addMaterial(scene, diffuseParams(vec3(0.2f, 0.3f, 0.4f)));
    const uint32_t bars = addMaterial(scene, diffuseParams(vec3(0.9f)));
    const float pixel = 2.0f * std::tan(0.45f) / kSize;
    addBox(scene, vec3(-2), vec3(2), wall, true);
    for (int i = -5; i < 6; ++i) {
        const vec3 at(0.11f * static_cast<float>(i), -0.8f, 0.0f);
        addQuad(scene, at, vec3(0.33f * pixel, 0, 0), vec3(0.1f, 1.6f, 0.0f), bars);
    }
    scene.lights.push_back(pointLight(vec3(0.4f, 0.9f, 1.2f), vec3(2.0f)));
    scene.cameras.push_back(lookAt(vec3(0, 0, 1), vec3(0)));
    RenderParams params = smooth(Method::kReference);
    params.spp = 256;
    const Frame truth = renderFrame(scene, params).frame;
    params.method = Method::kRadiance;
    const auto errorOf = [&](const Frame& frame, const Image<vec3> Frame::*layer) {
        return compareImages({.test = frame.*layer, .reference = truth.*layer}).rel_rmse;
    };
    const RenderResult result = renderFrame(scene, params);
    EXPECT_LT(errorOf(result.frame, &Frame::direct), 0.2);
    EXPECT_LT(errorOf(result.frame, &Frame::indirect), 0.1);
    params.aa = 1;
    const Frame middles = renderFrame(scene, params).frame;
    EXPECT_GT(errorOf(middles, &Frame::direct), 0.4);
}

// A mirror that shows a black square before a white sky.
TEST(SmoothEdges, MirrorsShowThemToo) {
    Scene scene;
    const uint32_t mirror = addMaterial(scene, glossyParams(vec3(1.0f), 1.0f, 0.0f));
    const uint32_t black = addMaterial(scene, diffuseParams(vec3(0.0f)));
    addQuad(scene, vec3(-2, -2, 0), vec3(4, 0, 0), vec3(0, 4, 0), mirror);
    addQuad(scene, vec3(-0.4f, -0.5f, 1.5f), vec3(1.0f, 0.15f, 0), vec3(-0.15f, 1.0f, 0), black);
    scene.environment.texels = Image<vec3>(1, 1, vec3(1.0f));
    scene.cameras.push_back(lookAt(vec3(0, 0, 1), vec3(0)));
    RenderParams params = smooth(Method::kReference);
    const Frame truth = renderFrame(scene, params).frame;
    const auto error = [&](int samples) {
        params.method = Method::kRadiance;
        params.aa = samples;
        const Frame frame = renderFrame(scene, params).frame;
        return compareImages({.test = frame.indirect, .reference = truth.indirect}).rel_rmse;
    };
    EXPECT_LT(error(kSamples), 0.5 * error(1));
}

TEST(SmoothEdges, RecordsAndTheirEstimateStayThoseOfPixelsMiddles) {
    const Scene scene = glossyRoom(0.5f, 0.5f);
    const RenderResult smooth_edges = renderFrame(scene, smooth(Method::kRadiance));
    const RenderResult middles = renderFrame(scene, smallRender(kSize, kSize));
    EXPECT_EQ(smooth_edges.stats.records, middles.stats.records);
    EXPECT_EQ(smooth_edges.stats.estimate_high, middles.stats.estimate_high);
    EXPECT_EQ(smooth_edges.frame.normal.pixels, middles.frame.normal.pixels);
    EXPECT_EQ(smooth_edges.frame.primitive.pixels, middles.frame.primitive.pixels);
}

TEST(SmoothEdges, SameBitsForAnyNumberOfThreads) {
    const Scene scene = glossyRoom();
    std::vector<Frame> frames;
    for (const int threads : {1, 3}) {
        setThreadCount(threads);
        frames.push_back(renderFrame(scene, smooth(Method::kRadiance)).frame);
    }
    setThreadCount(0);
    EXPECT_EQ(frames[0].direct.pixels, frames[1].direct.pixels);
    EXPECT_EQ(frames[0].indirect.pixels, frames[1].indirect.pixels);
}

TEST(SmoothEdges, MethodsThatSeeMiddlesSaySo) {
    const Scene scene = squareAlone(diffuseParams(vec3(0.5f)));
    RenderParams params = smooth(Method::kOctree);
    EXPECT_THROW(renderFrame(scene, params), Error);
    params.method = Method::kDenoised;
    EXPECT_THROW(renderFrame(scene, params), Error);
    params.method = Method::kRadiance;
    params.gather_road = GatherRoad::kRaster;
    EXPECT_THROW(renderFrame(scene, params), Error);
}

}  // namespace
}  // namespace sheen
