// What the filter must leave alone, and what it is for.
#include <gtest/gtest.h>

#include <cmath>

#include "baselines/denoise.h"
#include "metrics/compare.h"
#include "test_reference.h"

namespace sheen {
namespace {

constexpr int kDenoisedSize = 32;

// A wall at distance 1 that fills the view, pixels 0.01 apart.
Frame flatGuide() {
    Frame guide;
    guide.position = Image<vec3>(kDenoisedSize, kDenoisedSize);
    for (int y = 0; y < kDenoisedSize; ++y) {
        for (int x = 0; x < kDenoisedSize; ++x) {
            guide.position.at(x, y) = 0.01f * vec3(x, -y, -100);
        }
    }
    guide.normal = Image<vec3>(kDenoisedSize, kDenoisedSize, vec3(0, 0, 1));
    guide.roughness = Image<float>(kDenoisedSize, kDenoisedSize, 1.0f);
    guide.primitive = Image<uint32_t>(kDenoisedSize, kDenoisedSize, 0u);
    return guide;
}

Image<vec3> constant(const vec3& value) { return Image<vec3>(kDenoisedSize, kDenoisedSize, value); }

Image<vec3> randomImage(uint32_t seed, float low, float high) {
    Random random(seed);
    Image<vec3> image(kDenoisedSize, kDenoisedSize);
    for (vec3& pixel : image.pixels) {
        pixel = random.point(low, high);
    }
    return image;
}

TEST(Denoise, ConstantLightStaysUnderAnyTexture) {
    const vec3 light(2.0f, 1.0f, 0.5f);
    const Image<vec3> albedo = randomImage(1, 0.05f, 0.9f);
    Image<vec3> color = albedo;
    for (vec3& pixel : color.pixels) {
        pixel *= light;
    }
    const Image<vec3> filtered =
        filterAtrous(color, randomImage(2, 0.0f, 1.0f), albedo, flatGuide());
    for (size_t i = 0; i < color.pixels.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(filtered.pixels[i][c], color.pixels[i][c], 1e-5f * color.pixels[i][c]);
        }
    }
}

// One side is black, so that any light there has crossed the edge.
void expectNothingCrosses(const Frame& guide) {
    Image<vec3> color = randomImage(3, 0.5f, 1.5f);
    for (int y = 0; y < kDenoisedSize; ++y) {
        for (int x = kDenoisedSize / 2; x < kDenoisedSize; ++x) {
            color.at(x, y) = vec3(0.0f);
        }
    }
    // So much noise that light alone would tell nothing from anything.
    const Image<vec3> filtered =
        filterAtrous(color, constant(vec3(100.0f)), constant(vec3(1.0f)), guide);
    for (int y = 0; y < kDenoisedSize; ++y) {
        for (int x = 0; x < kDenoisedSize; ++x) {
            if (x < kDenoisedSize / 2) {
                EXPECT_GT(filtered.at(x, y).x, 0.7f);
            } else {
                EXPECT_EQ(filtered.at(x, y), vec3(0.0f));
            }
        }
    }
}

TEST(Denoise, NothingCrossesAnEdgeOfNormals) {
    Frame guide = flatGuide();
    for (int y = 0; y < kDenoisedSize; ++y) {
        for (int x = kDenoisedSize / 2; x < kDenoisedSize; ++x) {
            guide.normal.at(x, y) = vec3(1, 0, 0);
        }
    }
    expectNothingCrosses(guide);
}

TEST(Denoise, NothingCrossesAnEdgeOfDepth) {
    Frame guide = flatGuide();
    for (int y = 0; y < kDenoisedSize; ++y) {
        for (int x = kDenoisedSize / 2; x < kDenoisedSize; ++x) {
            guide.position.at(x, y).z -= 2.0f;
        }
    }
    expectNothingCrosses(guide);
}

TEST(Denoise, NothingCrossesAnEdgeOfRoughness) {
    Frame guide = flatGuide();
    for (int y = 0; y < kDenoisedSize; ++y) {
        for (int x = kDenoisedSize / 2; x < kDenoisedSize; ++x) {
            guide.roughness.at(x, y) = 0.3f;
        }
    }
    expectNothingCrosses(guide);
}

TEST(Denoise, PixelsWithoutVarianceStay) {
    const Image<vec3> color = randomImage(4, 0.5f, 1.5f);
    EXPECT_EQ(filterAtrous(color, constant(vec3(0.0f)), constant(vec3(1.0f)), flatGuide()).pixels,
              color.pixels);
}

TEST(Denoise, PixelsWithoutGeometryAreLeftAloneAndLendNothing) {
    Frame guide = flatGuide();
    Image<vec3> color = randomImage(5, 0.5f, 1.5f);
    for (int x = 0; x < kDenoisedSize; ++x) {
        guide.primitive.at(x, 5) = kNoPrimitive;
        color.at(x, 5) = vec3(1e6f);
    }
    const Image<vec3> filtered =
        filterAtrous(color, constant(vec3(100.0f)), constant(vec3(1.0f)), guide);
    for (int y = 0; y < kDenoisedSize; ++y) {
        for (int x = 0; x < kDenoisedSize; ++x) {
            EXPECT_TRUE(y == 5 ? filtered.at(x, y) == color.at(x, y) : filtered.at(x, y).x < 2.0f);
        }
    }
}

// A red wall tells nothing of the blue light that a white one beside it reflects.
TEST(Denoise, BlackChannelsOfAnAlbedoLendNothing) {
    Image<vec3> albedo = constant(vec3(0.5f));
    for (int y = 0; y < kDenoisedSize; ++y) {
        for (int x = 0; x < kDenoisedSize / 2; ++x) {
            albedo.at(x, y) = vec3(0.5f, 0.0f, 0.0f);
        }
    }
    Image<vec3> color = albedo;
    const Image<vec3> filtered = filterAtrous(color, constant(vec3(1.0f)), albedo, flatGuide());
    for (size_t i = 0; i < color.pixels.size(); ++i) {
        EXPECT_LT(glm::length(filtered.pixels[i] - color.pixels[i]), 1e-5f);
    }
}

// Measured: a fifth of what it was.
TEST(Denoise, LowersTheErrorOfAPathTracedImage) {
    const Scene scene = litRoom();
    ReferenceParams params = smallParams(scene, 48, 32);
    params.replicates = 4;
    ReferenceResult traced = renderReference(scene, params);
    const Frame truth = renderReference(scene, smallParams(scene, 48, 512)).frame;
    const auto errorOf = [&](const Image<vec3>& test, const Image<vec3>& reference) {
        return compareImages({.test = test, .reference = reference}).rel_rmse;
    };
    const Frame noisy = traced.frame;
    denoise(traced);
    const Frame& frame = traced.frame;
    EXPECT_LT(errorOf(frame.indirect, truth.indirect),
              0.3 * errorOf(noisy.indirect, truth.indirect));
    EXPECT_LT(errorOf(frame.indirect_diffuse, truth.indirect_diffuse),
              0.3 * errorOf(noisy.indirect_diffuse, truth.indirect_diffuse));
    EXPECT_EQ(frame.direct.pixels, noisy.direct.pixels);
    EXPECT_EQ(frame.emission.pixels, noisy.emission.pixels);
    EXPECT_TRUE(frame.indirect_variance.empty());
    for (const vec3& pixel : frame.indirect.pixels) {
        EXPECT_TRUE(std::isfinite(pixel.x + pixel.y + pixel.z));
    }
}

}  // namespace
}  // namespace sheen
