// The sky: where in its image a direction looks, and what becomes of files that hold it.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "core/error.h"
#include "image/exr.h"
#include "image/hdr.h"
#include "scene/environment.h"
#include "scene/sun.h"
#include "test_folder.h"

namespace sheen {
namespace {

class EnvironmentFiles : public testing::Test {
  protected:
    std::string file(const std::string& name) const { return (folder_.path() / name).string(); }

    std::string write(const std::string& name, const std::string& bytes) const {
        std::ofstream(file(name), std::ios::binary) << bytes;
        return file(name);
    }

    // A frame that sees nothing but `sky`.
    std::string writeSky(const Image<vec3>& sky) const {
        Frame frame;
        frame.emission = sky;
        frame.primitive = Image<uint32_t>(sky.width, sky.height, kNoPrimitive);
        frame.indirect_variance = Image<vec3>(sky.width, sky.height);  // floats, not halfs
        writeExr(file("sky.exr"), frame, ExrLayers::kBasic);
        return file("sky.exr");
    }

    Environment load(const std::string& source) {
        warnings_.clear();
        return loadEnvironment({.source = source}, files_, warnings_);
    }

    void expectError(const std::string& source, ExitCode code, const std::string& part) {
        try {
            load(source);
            ADD_FAILURE() << source << " was read";
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), code) << error.what();
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    }

    TestFolder folder_;
    std::vector<std::string> files_, warnings_;
};

std::string radiance(const std::string& pixels, int width, int height,
                     const std::string& header = "") {
    return fmt::format("#?RADIANCE\n{}FORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", header, height,
                       width) +
           pixels;
}

// Exponent 129: a mantissa of 128 is 1.
std::string texel(int r, int g, int b, int e = 129) {
    return {static_cast<char>(r), static_cast<char>(g), static_cast<char>(b), static_cast<char>(e)};
}

// Each of whose texels is another.
Environment patchwork() {
    Environment sky{.texels = Image<vec3>(8, 4)};
    for (int i = 0; i < sky.texels.count(); ++i) {
        sky.texels.pixels[static_cast<size_t>(i)] = vec3(1.0f + static_cast<float>(i), 2.0f, 3.0f);
    }
    return sky;
}

TEST(Environment, TheMiddleColumnIsWhereCamerasLook) {
    Environment sky{.texels = Image<vec3>(8, 4)};
    EXPECT_NEAR(glm::distance(sky.directionFromImage(vec2(0.5f)), vec3(0, 0, -1)), 0.0f, 1e-6f);
    EXPECT_NEAR(glm::distance(sky.directionFromImage(vec2(0.75f, 0.5f)), vec3(1, 0, 0)), 0, 1e-6f);
    EXPECT_NEAR(glm::distance(sky.directionFromImage(vec2(0.3f, 0.0f)), vec3(0, 1, 0)), 0, 1e-6f);
    // Turned counter-clockwise by a quarter, what was ahead is to the left.
    sky.rotation = 0.5f * kPi;
    EXPECT_NEAR(glm::distance(sky.directionFromImage(vec2(0.5f)), vec3(-1, 0, 0)), 0.0f, 1e-6f);
}

TEST(Environment, DirectionsAndTexelsAreInverse) {
    Environment sky = patchwork();
    for (const float rotation : {0.0f, 1.0f, -4.0f}) {
        sky.rotation = rotation;
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 8; ++x) {
                const vec2 uv((static_cast<float>(x) + 0.5f) / 8.0f,
                              (static_cast<float>(y) + 0.5f) / 4.0f);
                const vec3 direction = sky.directionFromImage(uv);
                EXPECT_NEAR(glm::length(direction), 1.0f, 1e-6f);
                EXPECT_NEAR(glm::distance(sky.imageFromDirection(direction), uv), 0.0f, 1e-6f);
                EXPECT_NEAR(sky.radiance(direction).x, sky.texels.at(x, y).x, 1e-3f);
            }
        }
    }
}

TEST(Environment, IsBilinearAroundTheSeamAndFiniteAtThePoles) {
    const Environment sky = patchwork();
    // Behind, between the last column and the first.
    EXPECT_NEAR(sky.radiance(sky.directionFromImage(vec2(0.0f, 0.375f))).x,
                0.5f * (sky.texels.at(0, 1).x + sky.texels.at(7, 1).x), 1e-3f);
    for (const vec3& pole : {vec3(0, 1, 0), vec3(0, -1, 0), vec3(0, 1.0000001f, 0)}) {
        const vec3 seen = sky.radiance(pole);
        EXPECT_GE(seen.x, 1.0f);
        EXPECT_LE(seen.x, 32.0f);
    }
}

TEST_F(EnvironmentFiles, AColourIsTheSameFromEverywhere) {
    const Environment sky = loadEnvironment(
        {.source = "1,0.5,2e1", .rotation = 90.0f, .strength = 2.0f, .transparent = true}, files_,
        warnings_);
    EXPECT_EQ(sky.radiance(vec3(0, 1, 0)), vec3(2, 1, 40));
    EXPECT_EQ(sky.radiance(vec3(0, 0, 1)), vec3(2, 1, 40));
    EXPECT_FALSE(sky.visible);
    EXPECT_TRUE(load("none").empty());
    EXPECT_EQ(load("none").radiance(vec3(0, 1, 0)), vec3(0.0f));
    EXPECT_TRUE(load("").empty());
    expectError("1,-1,1", ExitCode::kUsage, "must be 0..1e+12 nits");
    expectError("1,nan,1", ExitCode::kUsage, "must be 0..");
    expectError("1,1", ExitCode::kInput, "not an environment");
    EXPECT_TRUE(files_.empty());
}

TEST_F(EnvironmentFiles, ExrKeepsItsFloats) {
    const Image<vec3> pixels = patchwork().texels;
    const std::string path = writeSky(pixels);
    EXPECT_EQ(load(path).texels.pixels, pixels.pixels);
    EXPECT_EQ(files_, std::vector<std::string>{path});
    EXPECT_TRUE(warnings_.empty());
}

TEST_F(EnvironmentFiles, RadianceFilesOfEveryForm) {
    const std::string red = texel(128, 0, 0), green = texel(0, 64, 0), black = texel(9, 9, 9, 0);
    // Texel by texel, with the old form of runs: two more of green.
    Image<vec3> image = readHdr(write("flat.hdr", radiance(red + green + texel(1, 1, 1, 2), 4, 1)));
    EXPECT_EQ(image.at(0, 0), vec3(1, 0, 0));
    EXPECT_EQ(image.at(1, 0), vec3(0, 0.5f, 0));
    EXPECT_EQ(image.at(3, 0), vec3(0, 0.5f, 0));
    // Runs a channel; exposures multiply, and are undone.
    const std::string line = {2, 2,      0,  8,      '\x88', '\x80', '\x84',
                              0, '\x84', 64, '\x88', 0,      '\x88', '\x81'};
    image = readHdr(write("runs.hdr", radiance(line, 8, 1, "EXPOSURE=4\nEXPOSURE=0.5\n")));
    EXPECT_EQ(image.at(0, 0), vec3(0.5f, 0, 0));
    EXPECT_EQ(image.at(7, 0), vec3(0.5f, 0.25f, 0));
    EXPECT_EQ(readHdr(write("b.hdr", radiance(black + black, 2, 1))).at(1, 0), vec3(0.0f));
}

TEST_F(EnvironmentFiles, DamagedRadianceFilesAreRefused) {
    const std::string pixels = texel(128, 0, 0) + texel(0, 64, 0);
    const std::string whole = radiance(pixels, 2, 1);
    for (size_t size = 0; size < whole.size(); ++size) {
        expectError(write("cut.hdr", whole.substr(0, size)), ExitCode::kInput, "cut.hdr");
    }
    const auto refused = [&](const std::string& bytes, const std::string& part) {
        expectError(write("bad.hdr", bytes), ExitCode::kInput, part);
    };
    refused(radiance(pixels, 0, 1), "each 1..16384");
    refused(radiance(pixels, 16385, 1), "each 1..16384");
    refused(radiance(pixels, 16384, 16384), "cannot hold");
    refused(radiance(texel(1, 1, 1, 5) + pixels, 2, 1), "a run does not fit");
    refused(radiance(texel(9, 9, 9) + texel(1, 1, 1, 0), 2, 1), "a run does not fit");
    refused(radiance({2, 2, 0, 8, 0, 0, 0, 0, 0, 0}, 8, 1), "a run does not fit");
    refused(radiance({2, 2, 0, 8, '\x89', 0, 0, 0, 0, 0}, 8, 1), "a run does not fit");
    refused(radiance(pixels, 2, 1, "EXPOSURE=0\n"), "exposure");
    refused(radiance(pixels, 2, 1, "FORMAT=32-bit_rle_xyze\n"), "must be 32-bit_rle_rgbe");
    refused("P6 1 1 255 xxx\n", "not a Radiance file");
    expectError(file("no.hdr"), ExitCode::kInput, "no such file");
    expectError(file("no.exr"), ExitCode::kInput, "no such file");
    expectError(file("sky.jpg"), ExitCode::kInput, "use a .hdr or .exr file");
    expectError(write("text.exr", "text"), ExitCode::kInput, "not an EXR file");
}

TEST_F(EnvironmentFiles, OddTexelsAreMendedAndCounted) {
    Image<vec3> pixels = patchwork().texels;
    pixels.at(2, 1).y = std::nanf("");
    pixels.at(3, 1).x = -1.0f;
    pixels.at(4, 1).z = kInfinity;
    const Environment sky = load(writeSky(pixels));
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_NE(warnings_[0].find("3 texels are negative or not finite"), std::string::npos);
    EXPECT_EQ(sky.texels.at(2, 1), vec3(0.0f));
    EXPECT_EQ(sky.texels.at(5, 1), pixels.at(5, 1));

    load(writeSky(Image<vec3>(4, 2)));
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_NE(warnings_[0].find("is black"), std::string::npos);
    load(writeSky(Image<vec3>(4, 4, vec3(1.0f))));
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_NE(warnings_[0].find("twice as wide as high"), std::string::npos);
    expectError(writeSky(Image<vec3>(4, 2, vec3(2e12f))), ExitCode::kInput, "make it dimmer");
}

// ---- The sun ------------------------------------------------------------------------------------

// A bluish sky, brighter toward the horizon, with a round sun of that radius, in degrees.
Environment sunnySky(float radius, float radiance) {
    Environment sky{.texels = Image<vec3>(720, 360), .rotation = 2.0f};
    const vec3 toward = glm::normalize(vec3(0.5f, 0.4f, -0.3f));
    for (int y = 0; y < 360; ++y) {
        for (int x = 0; x < 720; ++x) {
            const vec3 d = sky.directionFromImage((vec2(x, y) + 0.5f) / vec2(720, 360));
            const float degrees = glm::degrees(std::acos(glm::min(glm::dot(d, toward), 1.0f)));
            const vec3 air = d.y > 0.0f ? vec3(0.3f, 0.5f, 1.0f) * (1.5f - d.y) : vec3(0.1f);
            sky.texels.at(x, y) =
                air + (degrees < radius ? vec3(1.0f, 0.9f, 0.7f) * radiance : vec3(0.0f));
        }
    }
    return sky;
}

glm::dvec3 irradianceFrom(const Environment& sky, const vec3& n) {
    glm::dvec3 sum(0.0);
    for (int y = 0; y < sky.texels.height; ++y) {
        const double v = M_PI / sky.texels.height;
        const double solid_angle =
            2.0 * M_PI / sky.texels.width * (std::cos(v * y) - std::cos(v * (y + 1)));
        for (int x = 0; x < sky.texels.width; ++x) {
            const vec3 d = sky.directionFromImage((vec2(x, y) + 0.5f) /
                                                  vec2(sky.texels.width, sky.texels.height));
            sum += glm::dvec3(sky.texels.at(x, y)) * (solid_angle * std::max(0.0f, glm::dot(d, n)));
        }
    }
    return sum;
}

TEST(Sun, IsTakenOutAndIrradianceStays) {
    constexpr double kShare = 0.01;
    for (const float radius : {0.3f, 1.5f}) {
        const Environment before = sunnySky(radius, 20000.0f / (radius * radius));
        Environment after = before;
        const auto sun = takeOutSun(after);
        ASSERT_TRUE(sun) << radius;
        EXPECT_EQ(sun->kind, shared::LIGHT_DIRECTIONAL);
        EXPECT_GT(-sun->direction.y, 0.5f);
        for (const vec3& n : {vec3(0, 1, 0), vec3(1, 0, 0), vec3(0, 0, -1), vec3(-1, 0, 0),
                              glm::normalize(vec3(0.5f, 0.4f, -0.3f))}) {
            const glm::dvec3 whole = irradianceFrom(before, n);
            const glm::dvec3 parts =
                irradianceFrom(after, n) +
                glm::dvec3(sun->intensity) *
                    static_cast<double>(std::max(0.0f, glm::dot(n, -sun->direction)));
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(parts[c], whole[c], kShare * whole[c]) << radius;
            }
        }
        // What is left is smooth: no texel stands out, and there is no second sun.
        EXPECT_LT(irradianceFrom(after, vec3(0, 1, 0)).x, 5.0);
        EXPECT_LT(std::max_element(after.texels.pixels.begin(), after.texels.pixels.end(),
                                   [](const vec3& a, const vec3& b) { return a.x < b.x; })
                      ->x,
                  1.0f);
        EXPECT_FALSE(takeOutSun(after));
    }
}

TEST(Sun, IsOnlyWhatIsSmallAndBright) {
    Environment window = sunnySky(10.0f, 100.0f);
    Environment dim = sunnySky(0.5f, 50.0f);
    Environment uniform{.texels = Image<vec3>(1, 1, vec3(1.0f))};
    Environment black{.texels = Image<vec3>(720, 360)};
    Environment none;
    for (Environment* sky : {&window, &dim, &uniform, &black, &none}) {
        const std::vector<vec3> before = sky->texels.pixels;
        EXPECT_FALSE(takeOutSun(*sky));
        EXPECT_EQ(sky->texels.pixels, before);
    }
}

}  // namespace
}  // namespace sheen
