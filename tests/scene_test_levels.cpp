// Textures averaged over what a look stands for: smaller copies of images, and which is looked up.
#include <cmath>
#include <random>

#include "scene_test_gltf.h"
#include "test_scenes.h"

namespace sheen {
namespace {

TextureImage randomImage(int width, int height) {
    std::mt19937 random(5);
    TextureImage image{.width = width, .height = height};
    for (size_t i = 0; i < 4 * image.texelCount(); ++i) {
        image.bytes.push_back(static_cast<uint8_t>(random() >> 24));
    }
    return image;
}

glm::dvec4 meanOf(const TextureImage& image, bool srgb) {
    glm::dvec4 sum(0.0);
    for (const vec4& texel : linearTexels(image, srgb)) {
        sum += glm::dvec4(texel);
    }
    return sum / static_cast<double>(image.texelCount());
}

// Half a step of 8 bits at the bright end, in linear light of sRGB.
constexpr double kStored = 0.5 * 2.4 / 255.0;

TEST(SmallerImages, KeepTheMeanOfAnySizeInLinearLight) {
    for (const ivec2 size : {ivec2(8, 8), ivec2(7, 5), ivec2(1, 9), ivec2(13, 2), ivec2(2, 1)}) {
        for (const bool srgb : {false, true}) {
            TextureImage image = randomImage(size.x, size.y);
            makeSmaller(image, srgb);
            const glm::dvec4 mean = meanOf(image, srgb);
            const int last = image.levels(srgb) - 1;
            EXPECT_EQ(image.levels(!srgb), 1);
            EXPECT_EQ(image.level(srgb, last).texelCount(), 1u);
            for (int level = 1; level <= last; ++level) {
                const glm::dvec4 there = meanOf(image.level(srgb, level), srgb);
                for (int c = 0; c < 4; ++c) {
                    EXPECT_NEAR(there[c], mean[c], level * kStored)
                        << size.x << " x " << size.y << " level " << level;
                }
            }
        }
    }
}

TEST(SmallerImages, OfOneTexelHaveNone) {
    TextureImage image = randomImage(1, 1);
    makeSmaller(image, true);
    EXPECT_EQ(image.levels(true), 1);
    EXPECT_EQ(sampled(image, {.srgb = true}, vec2(0.3f), 7.5f), texelOf(image, true, 0, 0));
}

TEST(SmallerImages, AreMadeOnce) {
    TextureImage image = randomImage(16, 16);
    makeSmaller(image, true);
    makeSmaller(image, true);
    EXPECT_EQ(image.levels(true), 5);
}

TEST(SmallerImages, WordsStayWords) {
    TextureImage image{.width = 2, .height = 1};
    image.words = {0, 0, 0, 65535, 3, 65535, 1, 65535};
    makeSmaller(image, false);
    EXPECT_EQ(image.level(false, 1).words, (std::vector<uint16_t>{2, 32768, 1, 65535}));
}

// Between levels it is linear, and at either end it is the image or its mean.
TEST(Sampled, GoesFromTheImageToItsMean) {
    TextureImage image = randomImage(8, 8);
    makeSmaller(image, false);
    const Texture texture{};
    const vec2 uv(0.31f, 0.77f);
    const vec4 point = sampled(image, texture, uv, 0.0f);
    EXPECT_EQ(sampled(image, texture, uv, -3.0f), point);
    EXPECT_EQ(sampled(image, texture, uv, std::nanf("")), point);
    const vec4 mean = texelOf(image.level(false, 3), false, 0, 0);
    for (const float level : {3.0f, 8.0f, kInfinity}) {
        for (int c = 0; c < 4; ++c) {
            EXPECT_NEAR(sampled(image, texture, uv, level)[c], mean[c], 1e-6f);
        }
    }
    const vec4 half = sampled(image, texture, uv, 0.5f);
    const vec4 next = sampled(image, texture, uv, 1.0f);
    for (int c = 0; c < 4; ++c) {
        EXPECT_NEAR(half[c], 0.5f * (point[c] + next[c]), 1e-6f);
    }
}

TEST(TextureLevel, HasTexelsAsLargeAsTheFootprint) {
    const vec2 d1(1.0f, 0.0f), d2(0.0f, 1.0f);  // the whole image on half a unit square
    const ivec2 size(64, 64);
    EXPECT_EQ(shared::textureLevel(1.0f / (64 * 64), d1, d2, size), 0.0f);
    EXPECT_EQ(shared::textureLevel(1e-9f, d1, d2, size), 0.0f);
    EXPECT_NEAR(shared::textureLevel(1.0f, d1, d2, size), 6.0f, 1e-5f);
    EXPECT_NEAR(shared::textureLevel(0.25f, d1, d2, size), 5.0f, 1e-5f);
    EXPECT_NEAR(shared::textureLevel(0.25f, 4.0f * d1, d2, size), 6.0f, 1e-5f) << "repeated";
    EXPECT_EQ(shared::textureLevel(1.0f, d1, d1, size), 0.0f) << "coordinates without area";
}

// At the image's middle a pixel's side is 2 tan(fov / 2) / rows of the distance; tilted, as much
// longer.
TEST(PixelFootprint, IsTheAreaThatAPixelShows) {
    Camera camera = lookAt(vec3(0, 0, 4), vec3(0));
    camera.y_fov = 1.0f;
    const float width = 4.0f * 2.0f * std::tan(0.5f) / 100.0f;
    EXPECT_NEAR(pixelFootprint(camera, 100, vec3(0), vec3(0, 0, 1)), width * width, 1e-7f);
    EXPECT_NEAR(pixelFootprint(camera, 100, vec3(0), vec3(0, 0.8f, 0.6f)), width * width / 0.6f,
                1e-6f);
    // Of a plane across the view each pixel shows as much.
    EXPECT_NEAR(pixelFootprint(camera, 100, vec3(1.5f, -1.0f, 0), vec3(0, 0, 1)), width * width,
                1e-7f);
    EXPECT_EQ(pixelFootprint(camera, 100, vec3(0, 0, 4), vec3(0, 0, 1)), 0.0f);
}

// A fine chessboard far away is grey, and near by black and white.
TEST(MaterialAt, IsAveragedOverTheFootprint) {
    Scene scene;
    const uint32_t board = addMaterial(scene, diffuseParams(vec3(1.0f)));
    scene.materials[board].textures[shared::TEXTURE_BASE_COLOR].texture =
        addTexture(scene, 2, 2, {vec3(0), vec3(1), vec3(1), vec3(0)});
    addQuad(scene, vec3(0), vec3(1, 0, 0), vec3(0, 1, 0), board);
    scene.uvs = {{0, 0}, {64, 0}, {64, 64}, {0, 64}};
    const vec3 at(0.93359375f, 0.046875f, 0.01953125f);  // a texel's middle
    const float white = materialAt(scene, 0, at).base_color.x;
    EXPECT_GT(std::abs(white - 0.5f), 0.2f);
    EXPECT_EQ(materialAt(scene, 0, at, 1e-8f).base_color.x, white) << "less than a texel";
    EXPECT_NEAR(materialAt(scene, 0, at, 1e-2f).base_color.x, 0.5f, 1e-4f);
}

TEST(TextureLoader, MakesNoLevelsWhereTheSamplerAsksForNone) {
    GltfFile file = textured();
    for (const int filter : {9728, 9729}) {
        file.json["samplers"][0]["minFilter"] = filter;
        EXPECT_EQ(file.load().images[0].levels(true), 1) << filter;
    }
    file.json["samplers"][0]["minFilter"] = 9985;
    EXPECT_EQ(file.load().images[0].levels(true), 2);
}

TEST(TextureLoader, SharesImagesAndTheirLevels) {
    GltfFile file = textured();
    file.json["materials"].push_back(file.json["materials"][0]);
    file.json["materials"][1]["normalTexture"]["index"] = 0;
    const Scene scene = file.load();
    ASSERT_EQ(scene.images.size(), 1u);
    EXPECT_EQ(scene.images[0].levels(true), 2);
    EXPECT_EQ(scene.images[0].levels(false), 2) << "as a normal map it is linear";
    EXPECT_NEAR(scene.images[0].level(false, 1).bytes[0], (0 + 255 + 128 + 255) / 4.0, 1.0);
}

}  // namespace
}  // namespace sheen
