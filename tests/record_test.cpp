// Weights, extrapolation and tangent frames of records.
#include "record/record.h"

#include <gtest/gtest.h>

#include "test_scenes.h"

namespace sheen {
namespace {

constexpr WeightParams kWeight = {.accuracy = 0.15f, .normal_weight = 1.0f, .slab = 0.1f};
const vec3 kUp(0, 0, 1);

float weightAt(const vec3& d, const vec3& n = kUp, float R = 2.0f, float footprint = 1e-3f) {
    const vec3 p_k(3, -1, 2);
    return shared::recordWeight(kWeight, p_k, kUp, R, p_k + d, n, footprint);
}

TEST(RecordWeight, FollowsTheFormulaInsideAndIsZeroOutside) {
    Random random(1);
    for (int i = 0; i < 200; ++i) {
        const float R = 2.0f;
        const float distance = random.uniform(0.01f, 0.6f);
        const float phi = random.uniform(0.0f, 2.0f * kPi);
        const float e = distance / R;
        const float expected = std::max(kWeight.accuracy / e - 1.0f, 0.0f);
        EXPECT_NEAR(weightAt(distance * vec3(std::cos(phi), std::sin(phi), 0.0f)), expected,
                    1e-3f * (1.0f + expected));
    }
    EXPECT_EQ(weightAt(vec3(0.3001f, 0, 0)), 0.0f);
    EXPECT_EQ(weightAt(vec3(1e9f, 0, 0)), 0.0f);
}

TEST(RecordWeight, FiniteAndLargestAtTheRecord) {
    const float at = weightAt(vec3(0.0f));
    EXPECT_TRUE(std::isfinite(at));
    // e_min = half a footprint over R.
    EXPECT_NEAR(at, 0.15f / (0.5f * 1e-3f / 2.0f) - 1.0f, 1.0f);
    EXPECT_GE(at, weightAt(vec3(1e-3f, 0, 0)));
    EXPECT_EQ(at, weightAt(vec3(1e-4f, 0, 0)));  // closer than half a footprint
}

TEST(RecordWeight, TiltCountsLikeDistance) {
    for (float degrees : {2.0f, 5.0f, 8.0f}) {
        const float angle = glm::radians(degrees);
        const vec3 n(std::sin(angle), 0.0f, std::cos(angle));
        const float e = std::sqrt(1.0f - std::cos(angle));
        EXPECT_NEAR(weightAt(vec3(0.0f), n), std::max(0.15f / e - 1.0f, 0.0f), 0.01f) << degrees;
    }
    // sqrt(1 - cos) = 0.15 at 12.2 degrees.
    const auto tilted = [](float degrees) {
        return vec3(0.0f, std::sin(glm::radians(degrees)), std::cos(glm::radians(degrees)));
    };
    EXPECT_GT(weightAt(vec3(0.0f), tilted(12.0f)), 0.0f);
    EXPECT_EQ(weightAt(vec3(0.0f), tilted(12.4f)), 0.0f);
    EXPECT_EQ(weightAt(vec3(0.0f), -kUp), 0.0f);
    EXPECT_EQ(weightAt(vec3(0.0f), vec3(1, 0, 0)), 0.0f);
}

TEST(RecordWeight, NormalWeightStretchesTheTilt) {
    WeightParams w = kWeight;
    w.normal_weight = 0.2f;
    const vec3 n(std::sin(glm::radians(20.0f)), 0.0f, std::cos(glm::radians(20.0f)));
    EXPECT_GT(shared::recordWeight(w, vec3(0), kUp, 1.0f, vec3(0), n, 1e-3f), 0.0f);
    EXPECT_EQ(shared::recordWeight(kWeight, vec3(0), kUp, 1.0f, vec3(0), n, 1e-3f), 0.0f);
}

TEST(RecordWeight, SlabIsTwoSided) {
    const float half = kWeight.slab * kWeight.accuracy * 2.0f;
    for (float side : {-1.0f, 1.0f}) {
        EXPECT_GT(weightAt(vec3(0.05f, 0, side * 0.95f * half)), 0.0f);
        EXPECT_EQ(weightAt(vec3(0.05f, 0, side * 1.05f * half)), 0.0f);
    }
}

TEST(RecordWeight, ScalingAllLengthsChangesNothing) {
    Random random(2);
    for (float s : {1e-6f, 1e-3f, 1e3f, 1e6f}) {
        for (int i = 0; i < 100; ++i) {
            const vec3 d = random.point(-0.2f, 0.2f) * vec3(1, 1, 0.05f);
            const vec3 n = glm::normalize(kUp + 0.1f * random.direction());
            const float one = shared::recordWeight(kWeight, vec3(0), kUp, 1.0f, d, n, 0.01f);
            const float other = shared::recordWeight(kWeight, vec3(0), kUp, s, s * d, n, s * 0.01f);
            EXPECT_NEAR(other, one, 1e-4f * (1.0f + one)) << s;
        }
    }
}

TEST(RecordWeight, SymmetricInRecordAndPoint) {
    Random random(3);
    for (int i = 0; i < 100; ++i) {
        const vec3 a = random.point(-0.1f, 0.1f), b = random.point(-0.1f, 0.1f);
        const vec3 na = random.direction(), nb = glm::normalize(na + 0.1f * random.direction());
        EXPECT_FLOAT_EQ(shared::recordWeight(kWeight, a, na, 1.0f, b, nb, 1e-3f),
                        shared::recordWeight(kWeight, b, nb, 1.0f, a, na, 1e-3f));
    }
}

TEST(RecordIrradiance, ExtrapolatesAndNeverGoesBelowZero) {
    Record k{};
    k.position = vec3(1, 2, 3);
    k.normal = kUp;
    k.irradiance = vec3(1.0f, 2.0f, 3.0f);
    k.rotation_r = vec3(0.5f, 0, 0);
    k.translation_g = vec3(0, 1, 0);
    k.translation_b = vec3(0, -100, 0);
    const vec3 n = glm::normalize(vec3(0.2f, 0, 1));
    const vec3 e = shared::recordIrradiance(k, k.position + vec3(0, 0.5f, 0), n);
    EXPECT_NEAR(e.x, 1.0f + 0.5f * n.x, 1e-6f);
    EXPECT_NEAR(e.y, 2.5f, 1e-6f);
    EXPECT_EQ(e.z, 0.0f);
    EXPECT_EQ(shared::recordIrradiance(k, k.position, kUp), k.irradiance);
}

// On a bump: of light that is the same from everywhere a share, of a gradient what lies along it.
TEST(BumpIrradiance, IsAShareOfWhatIsEvenAndWhatLiesAlongAGradient) {
    Record uniform{};
    uniform.normal = kUp;
    uniform.irradiance = vec3(1.0f, 2.0f, 3.0f);
    Record k = uniform;
    k.rotation_r = vec3(0.5f, 0.1f, 0);
    k.rotation_b = vec3(-0.3f, 0, 0);
    EXPECT_EQ(shared::bumpIrradiance(k, k.position, kUp, kUp), k.irradiance);
    for (const float angle : {0.2f, 0.5f, 1.0f}) {
        const vec3 m = std::sin(angle) * vec3(1, 0, 0) + std::cos(angle) * kUp;
        const vec3 share = shared::bumpIrradiance(uniform, k.position, kUp, m) / k.irradiance;
        EXPECT_NEAR(share.x, 0.5f * (1.0f + std::cos(angle)), 1e-6f);
        const vec3 more = shared::bumpIrradiance(k, k.position, kUp, m) - share * k.irradiance;
        EXPECT_NEAR(more.x, glm::dot(m - kUp, k.rotation_r), 1e-5f);
        EXPECT_NEAR(more.z, glm::dot(m - kUp, k.rotation_b), 1e-5f);
    }
}

TEST(TangentFrame, OrthonormalAndRightHanded) {
    Random random(4);
    std::vector<vec3> normals = {
        {0, 0, 1},     {0, 0, -1},           {1, 0, 0},     {0, 1, 0},      {-1, 0, 0},
        {0, -1, 0},    {0, 0, -0.99999994f}, {1, 0, -0.0f}, {1e-4f, 0, -1}, {1e-8f, 1e-8f, -1},
        {1, 0, 1e-30f}};
    for (int i = 0; i < 2000; ++i) {
        normals.push_back(random.direction());
        normals.push_back(vec3(1e-3f, 1e-3f, 1.0f) * random.direction());
    }
    for (const vec3& v : normals) {
        const vec3 n = glm::normalize(v);
        const mat3 f = tangentFrame(n);
        EXPECT_EQ(f[2], n);
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                EXPECT_NEAR(glm::dot(f[i], f[j]), i == j ? 1.0f : 0.0f, 3e-6f) << n.x << " " << n.z;
            }
        }
        EXPECT_NEAR(glm::determinant(f), 1.0f, 3e-6f);
    }
}

}  // namespace
}  // namespace sheen
