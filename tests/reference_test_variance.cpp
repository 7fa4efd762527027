// The path tracer's variance against what repeated runs show, what may not change an image, and
// scenes that hardly are any.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "test_reference.h"

namespace sheen {
namespace {

// ---- Variance and reproducibility ---------------------------------------------------------------

// Mean over the pixels of the ratio of the variance seen between runs to the one they report.
double varianceRatio(int spp) {
    constexpr int kRuns = 48, kSize = 8;
    const Scene scene = litRoom();
    ReferenceParams params = smallParams(scene, kSize, spp);
    std::vector<double> sum(kSize * kSize, 0.0), squares = sum, reported = sum;
    for (int run = 0; run < kRuns; ++run) {
        params.seed = static_cast<uint32_t>(run);
        const Frame frame = renderReference(scene, params).frame;
        for (size_t i = 0; i < sum.size(); ++i) {
            const double v = frame.indirect.pixels[i].y;
            sum[i] += v;
            squares[i] += v * v;
            reported[i] += frame.indirect_variance.pixels[i].y;
        }
    }
    double ratio = 0.0;
    for (size_t i = 0; i < sum.size(); ++i) {
        const double mean = sum[i] / kRuns;
        const double seen = (squares[i] - kRuns * mean * mean) / (kRuns - 1);
        ratio += seen / (reported[i] / kRuns) / static_cast<double>(sum.size());
    }
    return ratio;
}

TEST(Reference, VarianceIsThatOfRepeatedRuns) {
    // Each pixel's ratio scatters by sqrt(2/47) = 21% or, with heavy tails, more; the mean of 64
    // pixels by about 3%.
    EXPECT_NEAR(varianceRatio(32), 1.0, 0.15);
    EXPECT_NEAR(varianceRatio(256), 1.0, 0.15);  // guided
}

// Pixels that see a caustic are found by few paths, so that single ones stray further than a normal
// distribution would; the image's mean does not.
TEST(Reference, ErrorOfTheMeanIsWhatTheVarianceSays) {
    const Scene scene = litRoom();
    const Frame truth = renderReference(scene, smallParams(scene, 8, 8192)).frame;
    ReferenceParams params = smallParams(scene, 8, 64);
    for (uint32_t seed = 1; seed <= 8; ++seed) {
        params.seed = seed;
        params.spp = seed % 2 == 0 ? 64 : 256;  // without and with the guide
        const Frame frame = renderReference(scene, params).frame;
        double error = 0.0, variance = 0.0;
        for (size_t i = 0; i < truth.indirect.pixels.size(); ++i) {
            error += frame.indirect.pixels[i].y - truth.indirect.pixels[i].y;
            variance += frame.indirect_variance.pixels[i].y + truth.indirect_variance.pixels[i].y;
        }
        EXPECT_LT(std::abs(error), 4.0 * std::sqrt(variance)) << "seed " << seed;
    }
}

void expectSameBits(const Image<vec3>& a, const Image<vec3>& b) {
    ASSERT_EQ(a.pixels.size(), b.pixels.size());
    EXPECT_EQ(std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(vec3)), 0);
}

TEST(Reference, ThreadCountChangesNoBit) {
    const Scene scene = litRoom();
    const ReferenceParams params = smallParams(scene, 16, 256);  // guided
    setThreadCount(1);
    const Frame one = renderReference(scene, params).frame;
    for (const int threads : {2, 5}) {
        setThreadCount(threads);
        const Frame many = renderReference(scene, params).frame;
        expectSameBits(one.indirect, many.indirect);
        expectSameBits(one.indirect_variance, many.indirect_variance);
        expectSameBits(one.direct, many.direct);
        EXPECT_EQ(one.primitive.pixels, many.primitive.pixels);
    }
    setThreadCount(0);
}

TEST(Reference, ScaleChangesNothing) {
    const Scene room = litRoom();
    const Frame metre = renderReference(room, smallParams(room, 16, 64)).frame;
    // Powers of two round alike: the same bits.
    for (const float scale : {1024.0f, 1.0f / 1024.0f}) {
        const Scene scene = scaled(room, scale);
        const Frame other = renderReference(scene, smallParams(scene, 16, 64)).frame;
        expectSameBits(metre.indirect, other.indirect);
        expectSameBits(metre.direct, other.direct);
    }
    // Others round differently; the paths are the same but for the rare one that passes an edge.
    for (const float scale : {1000.0f, 0.001f}) {
        const Scene scene = scaled(room, scale);
        const Frame other = renderReference(scene, smallParams(scene, 16, 64)).frame;
        EXPECT_EQ(metre.primitive.pixels, other.primitive.pixels);
        double difference = 0.0, total = 0.0;
        for (size_t i = 0; i < metre.indirect.pixels.size(); ++i) {
            difference += std::abs(metre.indirect.pixels[i].y - other.indirect.pixels[i].y);
            total += metre.indirect.pixels[i].y;
        }
        EXPECT_LT(difference, 1e-3 * total) << scale;
    }
}

// Far from the origin, where coordinates are coarse, nothing shadows itself.
TEST(Reference, NoSelfShadowingFarFromTheOrigin) {
    for (const float far : {0.0f, 100.0f, 10000.0f}) {
        Scene scene;
        addQuad(scene, vec3(far - 5, 0.3f * far, far - 5), vec3(0.1f, 0.7f, 10),
                vec3(10, 0.2f, 0.3f), addMaterial(scene, diffuseParams(vec3(0.5f))));
        scene.lights.push_back(directionalLight(vec3(1, -0.05f, 0.2f), vec3(1.0f)));
        const vec3 target(far, 0.3f * far + 0.4f, far);
        const Frame frame =
            renderReference(scene, smallParams(lookAt(target + vec3(0, 4, 1), target), 32, 16))
                .frame;
        const float expected = frame.direct.at(16, 16).x;
        EXPECT_GT(expected, 0.0f);
        for (const vec3& pixel : frame.direct.pixels) {
            EXPECT_NEAR(pixel.x, expected, 1e-3f * expected) << far;
        }
        // An open plane sees nothing of itself.
        for (const vec3& pixel : frame.indirect.pixels) {
            EXPECT_EQ(pixel, vec3(0.0f)) << far;
        }
    }
}

// ---- Degenerate scenes --------------------------------------------------------------------------

TEST(Reference, NoLightsIsBlack) {
    Scene scene = litRoom();
    scene.lights.clear();
    for (Material& material : scene.materials) {
        material.params.emission = vec3(0.0f);
    }
    const Frame frame = renderReference(scene, smallParams(scene, 8, 16)).frame;
    for (size_t i = 0; i < frame.direct.pixels.size(); ++i) {
        EXPECT_EQ(frame.direct.pixels[i], vec3(0.0f));
        EXPECT_EQ(frame.indirect.pixels[i], vec3(0.0f));
        EXPECT_EQ(frame.indirect_variance.pixels[i], vec3(0.0f));
        EXPECT_NE(frame.primitive.pixels[i], kNoPrimitive);
    }
}

TEST(Reference, NoGeometry) {
    Scene scene;
    scene.lights.push_back(pointLight(vec3(0), vec3(1)));
    const ReferenceResult r = renderReference(scene, smallParams(Camera{}, 4, 16));
    for (size_t i = 0; i < 16; ++i) {
        EXPECT_EQ(r.frame.primitive.pixels[i], kNoPrimitive);
        EXPECT_EQ(r.frame.depth.pixels[i], kInfinity);
        EXPECT_EQ(r.frame.indirect.pixels[i], vec3(0.0f));
        EXPECT_EQ(r.frame.direct.pixels[i], vec3(0.0f));
    }
    EXPECT_EQ(r.rays, 16);
}

// Inside a closed metal box the light outside does not reach; the back faces are surfaces too.
TEST(Reference, CameraInsideAnObject) {
    const Scene scene = litRoom();
    const Camera camera = lookAt(vec3(-0.25f, -0.65f, -0.1f), vec3(0.1f, -0.6f, 0.2f));
    const Frame frame = renderReference(scene, smallParams(camera, 8, 16)).frame;
    for (size_t i = 0; i < frame.direct.pixels.size(); ++i) {
        EXPECT_GE(frame.primitive.pixels[i], 12u);  // the box's, not the room's
        EXPECT_EQ(frame.direct.pixels[i], vec3(0.0f));
        EXPECT_EQ(frame.indirect.pixels[i], vec3(0.0f));
    }
}

TEST(Reference, WhatIsNotFiniteNeverReachesAnImage) {
    Scene scene = litRoom();
    scene.lights[0].intensity = vec3(kInfinity);
    const ReferenceResult r = renderReference(scene, smallParams(scene, 8, 16));
    EXPECT_GT(r.nonfinite_samples, 0);
    for (const Image<vec3>* layer : {&r.frame.direct, &r.frame.indirect, &r.frame.indirect_variance,
                                     &r.frame.indirect_diffuse_variance}) {
        for (const vec3& pixel : layer->pixels) {
            EXPECT_TRUE(std::isfinite(pixel.x + pixel.y + pixel.z));
        }
    }
}

TEST(Reference, SamplesAreRoundedUpToReplicates) {
    const Scene scene = litRoom();
    EXPECT_EQ(renderReference(scene, smallParams(scene, 2, 1)).spp, 16);
    EXPECT_EQ(renderReference(scene, smallParams(scene, 2, 17)).spp, 32);
}

TEST(Reference, RejectsSenselessParameters) {
    const Scene scene = litRoom();
    const ReferenceParams good = smallParams(scene, 2, 16);
    ReferenceParams params = good;
    params.width = 0;
    EXPECT_THROW(renderReference(scene, params), Error);
    params = good;
    params.spp = 0;
    EXPECT_THROW(renderReference(scene, params), Error);
    params = good;
    params.bounces = -1;
    EXPECT_THROW(renderReference(scene, params), Error);
    params = good;
    params.replicates = 1;
    EXPECT_THROW(renderReference(scene, params), std::logic_error);
}

}  // namespace
}  // namespace sheen
