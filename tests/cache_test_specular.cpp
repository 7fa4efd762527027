// Pixels too glossy for the cache: which they are, and how they share their rays.
#include <gtest/gtest.h>

#include <cmath>

#include "core/parallel.h"
#include "glossy/specular_rays.h"
#include "receivers/classes.h"
#include "sh/brdf_sh.h"
#include "test_light.h"
#include "test_scenes.h"
#include "test_stage.h"

namespace sheen {
namespace {

constexpr int kSize = 64;
// So many rays that their noise is small beside that of the usual ones.
constexpr SpecularParams kMany{
    .rays_per_alpha = 1e6f, .max_rays = 20 * SpecularParams{}.max_rays, .window = 0};

MaterialParams metal(float alpha) { return glossyParams(vec3(1.0f), 1.0f, std::sqrt(alpha)); }

// A black room from -1 to 1; the camera looks along -z.
struct Room {
    Scene scene;
    uint32_t black = addMaterial(scene, diffuseParams(vec3(0.0f)));

    Room() {
        addBox(scene, vec3(-1), vec3(1), black, true);
        scene.cameras.push_back(lookAt(vec3(0.0f, 0.0f, 0.9f), vec3(0.0f)));
    }
    uint32_t lamp(const vec3& emission) {
        return addMaterial(scene, diffuseParams(vec3(0.0f), emission));
    }
};

// What is needed to gather.
struct Gathering {
    explicit Gathering(const Scene& gathered)
        : scene(gathered),
          receivers(receiversOf(scene, TestStage(scene, 1).gbuffer(kSize, kSize), 0, false)),
          lit(scene) {}
    Image<vec3> gather() const { return gather(Image<vec3>(kSize, kSize)); }
    Image<vec3> gather(const Image<vec3>& cached) const {
        return reflectSpecular(receivers, traceSpecular(lit.light, receivers, {}), cached);
    }
    // What each pixel reflects by its own rays alone.
    Image<vec3> alone(const SpecularParams& params = {.window = 0}) const {
        const Image<SpecularSeen> seen = traceSpecular(lit.light, receivers, params);
        Image<vec3> reflected(kSize, kSize);
        for (size_t i = 0; i < kSize * kSize; ++i) {
            const SpecularSeen& s = seen.pixels[i];
            if (receivers.by_rays[i] != 0) {
                reflected.pixels[i] = receivers.specularAlbedo(i) * (s.light[0] + s.light[1]) /
                                      (s.weight[0] + s.weight[1]);
            }
        }
        return reflected;
    }

    Scene scene;
    Receivers receivers;
    LitScene lit;
};

// Root of the sum of the squared differences.
double distance(const Image<vec3>& image, const Image<vec3>& truth) {
    double squares = 0.0;
    for (size_t i = 0; i < truth.pixels.size(); ++i) {
        const vec3 d = image.pixels[i] - truth.pixels[i];
        squares += static_cast<double>(glm::dot(d, d));
    }
    return std::sqrt(squares);
}

// A floor whose lobe has this width and that reflects a small lamp on the ceiling.
Scene litFloor(float alpha) {
    Room room;
    const uint32_t lamp = room.lamp(vec3(40.0f, 20.0f, 10.0f));
    addQuad(room.scene, vec3(-0.1f, 0.99f, -0.5f), vec3(0.2f, 0, 0), vec3(0, 0, 0.2f), lamp);
    const uint32_t floor = addMaterial(room.scene, metal(alpha));
    addQuad(room.scene, vec3(-1, -0.9f, -1), vec3(0, 0, 2), vec3(2, 0, 0), floor);
    room.scene.cameras[0] = lookAt(vec3(0.0f, 0.0f, 0.9f), vec3(0.0f, -0.9f, 0.0f));
    return room.scene;
}

TEST(SpecularRays, MirrorsShareNothing) {
    constexpr double kBlur = 0.01;
    const Gathering mirror(litFloor(0.0f));
    EXPECT_GT(mirror.receivers.counts.too_glossy, kSize * kSize / 5);
    const Image<vec3> alone = mirror.alone();
    EXPECT_LT(distance(mirror.gather(), alone), kBlur * distance(Image<vec3>(kSize, kSize), alone));
}

// Against twenty times as many rays, whose own noise is small beside both.
TEST(SpecularRays, SharingTakesNoiseAway) {
    constexpr double kNoiseFalls = 2.2;
    constexpr double kBias = 0.02;
    const Gathering floor(litFloor(0.1f));
    const Image<vec3> truth = floor.alone(kMany);
    const auto difference = [&](const Image<vec3>& image) { return distance(image, truth); };
    const auto sum = [](const Image<vec3>& image) {
        double all = 0.0;
        for (const vec3& pixel : image.pixels) {
            all += static_cast<double>(pixel.x);
        }
        return all;
    };
    const Image<vec3> shared = floor.gather();
    const Image<vec3> alone = floor.alone();
    EXPECT_LT(kNoiseFalls * difference(shared), difference(alone));
    EXPECT_NEAR(sum(shared) / sum(alone), 1.0, kBias);  // of the same rays, whose sum has noise
}

// A ridge whose left side cannot see the green wall, nor its right side the red one.
TEST(SpecularRays, NothingLeaksAcrossACrease) {
    Room room;
    const uint32_t red = room.lamp(vec3(1, 0, 0));
    const uint32_t green = room.lamp(vec3(0, 1, 0));
    addQuad(room.scene, vec3(-0.99f, -1, -1), vec3(0, 2, 0), vec3(0, 0, 1.9f), red);
    addQuad(room.scene, vec3(0.99f, -1, -1), vec3(0, 0, 1.9f), vec3(0, 2, 0), green);
    const uint32_t side = addMaterial(room.scene, metal(0.1f));
    addQuad(room.scene, vec3(-0.9f, -1, -0.9f), vec3(0.9f, 0, 0.9f), vec3(0, 2, 0), side);
    addQuad(room.scene, vec3(0, -1, 0), vec3(0.9f, 0, -0.9f), vec3(0, 2, 0), side);
    const Gathering ridge(room.scene);
    const Image<vec3> seen = ridge.gather();
    int coloured = 0;
    for (size_t i = 0; i < seen.pixels.size(); ++i) {
        const float side_of = ridge.receivers.normals[i].x;
        if (ridge.receivers.by_rays[i] != 0) {
            EXPECT_EQ(side_of < 0.0f ? seen.pixels[i].y : seen.pixels[i].x, 0.0f);
            coloured += seen.pixels[i] != vec3(0.0f) ? 1 : 0;
        }
    }
    EXPECT_GT(coloured, kSize * kSize / 4);
}

// A panel before a deeper one of the same direction, beside which is a light it cannot see.
class AcrossAStep : public testing::TestWithParam<int> {};

TEST_P(AcrossAStep, NothingLeaks) {
    const int order = GetParam();
    Room room;
    const uint32_t lamp = room.lamp(vec3(1.0f));
    addQuad(room.scene, vec3(0.99f, -1, -1), vec3(0, 0, 1), vec3(0, 2, 0), lamp);
    const uint32_t panel = addMaterial(room.scene, metal(0.25f));
    addQuad(room.scene, vec3(-1, -1, -0.6f), vec3(2, 0, 0), vec3(0, 2, 0), panel);
    addQuad(room.scene, vec3(-1, -1, 0.1f), vec3(1, 0, 0), vec3(0, 2, 0), panel);
    Gathering step(room.scene);
    // As if all of it were by rays: what is tested is what is shared.
    step.receivers.by_rays.assign(kSize * kSize, 1);
    step.receivers.orders.assign(kSize * kSize, static_cast<int8_t>(order));
    const Image<vec3> seen = step.gather();
    int lit = 0;
    for (size_t i = 0; i < kSize * kSize; ++i) {
        if (step.receivers.positions[i].z > 0.05f) {
            EXPECT_EQ(seen.pixels[i], vec3(0.0f));
        } else {
            lit += seen.pixels[i] != vec3(0.0f) ? 1 : 0;
        }
    }
    EXPECT_GT(lit, kSize * kSize / 8);
}

INSTANTIATE_TEST_SUITE_P(SpecularRays, AcrossAStep,
                         testing::Values(shared::DIFFUSE_ORDER, shared::SH_MAX_ORDER),
                         [](const auto& tested) {
                             return tested.param == shared::DIFFUSE_ORDER ? "TooGlossy"
                                                                          : "Corrected";
                         });

// Records that miss a fifth of the light everywhere, and records that miss nothing.
TEST(SpecularRays, CorrectWhatRecordsMissAndSpareWhatTheyDoNot) {
    constexpr double kLeftOfTheError = 0.5;  // noise, and a tenth that is held back
    constexpr double kAddedNoise = 0.15;     // of what the rays of each pixel alone have
    const Gathering floor(litFloor(0.2f));
    ASSERT_GT(floor.receivers.counts.corrected, kSize * kSize / 5);
    ASSERT_EQ(floor.receivers.counts.too_glossy, 0);
    const Image<vec3> truth = floor.alone(kMany);
    const auto difference = [&](const Image<vec3>& image) { return distance(image, truth); };
    Image<vec3> too_dark = truth;
    for (vec3& pixel : too_dark.pixels) {
        pixel *= 0.8f;
    }
    // One pixel that its records know nothing of spoils no other.
    Image<vec3> spoilt = too_dark;
    const vec3 nan(std::nanf(""));
    const auto corrected = [&](int i) {
        return floor.receivers.isCorrected(floor.receivers.image.index(i, kSize - 10));
    };
    const int x = corrected(kSize / 2) ? kSize / 2 : kSize / 3;
    ASSERT_TRUE(corrected(x));
    spoilt.at(x, kSize - 10) = nan;
    int not_finite = 0;
    for (const vec3& pixel : floor.gather(spoilt).pixels) {
        not_finite += std::isfinite(pixel.x + pixel.y + pixel.z) ? 0 : 1;
    }
    EXPECT_EQ(not_finite, 1);
    EXPECT_LT(difference(floor.gather(too_dark)), kLeftOfTheError * difference(too_dark));
    EXPECT_LT(difference(floor.gather(truth)), kAddedNoise * difference(floor.alone()));
}

TEST(SpecularRays, AnyNumberOfThreadsGivesTheSameBits) {
    const Gathering floor(litFloor(0.1f));
    setThreadCount(1);
    const Image<vec3> one = floor.gather();
    setThreadCount(3);
    const Image<vec3> three = floor.gather();
    setThreadCount(0);
    EXPECT_EQ(one.pixels, three.pixels);
}

TEST(MaterialOrder, TexturesCountByTheirDarkTexels) {
    // A rough dielectric's lobe hardly shows on white, and is most of what black reflects.
    Scene scene;
    Material material;
    material.params = glossyParams(vec3(0.95f), 0.0f, 0.9f);
    const int white = materialOrder(material.params, 0);
    const int black = materialOrder(glossyParams(vec3(0.0f), 0.0f, 0.9f), 0);
    ASSERT_GT(black, white);
    EXPECT_EQ(materialOrder(scene, material, 0), white);
    const auto order = [&](int black_texels) {
        std::vector<vec3> texels(100, vec3(1.0f));
        std::fill_n(texels.end() - black_texels, black_texels, vec3(0.0f));
        material.textures[shared::TEXTURE_BASE_COLOR].texture = addTexture(scene, 10, 10, texels);
        return materialOrder(scene, material, 0);
    };
    EXPECT_EQ(order(0), white);
    EXPECT_EQ(order(5), white);
    EXPECT_EQ(order(6), black);
    EXPECT_EQ(order(100), black);
    material.textures[shared::TEXTURE_BASE_COLOR].texture = addTexture(scene, 1, 1, {vec3(0.0f)});
    EXPECT_EQ(materialOrder(scene, material, 0), black);
}

TEST(MaterialOrder, RoughnessTexturesCountByTheirSmoothTexels) {
    Scene scene;
    Material material;
    material.params = glossyParams(vec3(0.5f), 1.0f, 0.8f);
    const int rough = materialOrder(material.params, 0);
    const int smooth = materialOrder(glossyParams(vec3(0.5f), 1.0f, 0.4f), 0);
    ASSERT_GT(smooth, rough);
    const auto order = [&](int smooth_texels) {
        std::vector<vec3> texels(100, vec3(0, 1, 1));
        std::fill_n(texels.begin(), smooth_texels, vec3(0, 0.5f, 1));
        material.textures[shared::TEXTURE_METALLIC_ROUGHNESS].texture =
            addTexture(scene, 10, 10, texels);
        return materialOrder(scene, material, 0);
    };
    EXPECT_EQ(order(5), rough);
    EXPECT_EQ(order(6), smooth);
}

// Of a wall whose order misses more than the budget where it is seen at a grazing angle, rays
// correct that part alone; a smoother one is too glossy for the cache all over.
TEST(SpecularClasses, RaysGoWhereTheOrderMissesTheBudget) {
    for (float alpha : {0.3f, 0.12f}) {
        SCOPED_TRACE(alpha);
        Room room;
        const MaterialParams params = metal(alpha);
        const uint32_t wall = addMaterial(room.scene, params);
        addQuad(room.scene, vec3(-0.2f, -1, 0.8f), vec3(0, 0, -1.7f), vec3(0, 2, 0), wall);
        room.scene.cameras[0] = lookAt(vec3(0.25f, 0, 0.7f), vec3(-0.2f, 0, 0.0f));
        const Gathering g(room.scene);
        const int order = materialOrder(params, 0);
        int corrected = 0, left = 0, too_glossy = 0;
        const Receivers& r = g.receivers;
        for (size_t i = 0; i < kSize * kSize; ++i) {
            if (!r.seen(i) || std::abs(r.positions[i].x + 0.2f) > 1e-3f) {
                continue;
            }
            const float NoV = glm::dot(r.normals[i], r.towardViewer(i));
            const float missed = predictLobeError(NoV, params.roughness).truncated[order];
            if (std::abs(missed - kTruncationBudget) < 0.3f * kTruncationBudget) {
                continue;  // predictions come from a table
            }
            EXPECT_EQ(r.by_rays[i], missed > kTruncationBudget ? 1 : 0) << NoV;
            corrected += r.isCorrected(i) ? 1 : 0;
            too_glossy += r.isTooGlossy(i) ? 1 : 0;
            left += r.by_rays[i] == 0 ? 1 : 0;
        }
        if (alpha >= kTooGlossy) {
            EXPECT_GT(corrected, 50);
            EXPECT_GT(left, 50);
            EXPECT_EQ(too_glossy, 0);
        } else {
            EXPECT_EQ(corrected, 0);
            EXPECT_GT(too_glossy, 500);
        }
    }
}

}  // namespace
}  // namespace sheen
