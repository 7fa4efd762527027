// Weights, tangent frames and screen bounds of records.
#include <gtest/gtest.h>

#include "cache/placement.h"
#include "cache/record.h"
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

// Every pixel whose centre's ray meets the sphere lies in the rectangle.
void expectConservative(const Camera& camera, int width, int height, const vec3& center,
                        float radius) {
    const View view = cameraView(camera, width, height, 1e-4f);
    const PixelRect rect = sphereBounds(view, width, height, center, radius);
    EXPECT_TRUE(rect.x0 >= 0 && rect.x1 <= width && rect.y0 >= 0 && rect.y1 <= height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const CameraRay ray =
                cameraRay(camera, width, height, static_cast<float>(x), static_cast<float>(y));
            const glm::dvec3 d = glm::normalize(glm::dvec3(ray.direction));
            const glm::dvec3 to(center - ray.origin);
            const double along = glm::dot(d, to);
            const double miss2 = glm::dot(to, to) - along * along;
            const double inside = static_cast<double>(radius) * radius;
            const bool hit = miss2 < inside && along + std::sqrt(inside - miss2) > 0.0;
            if (hit) {
                ASSERT_TRUE(x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1)
                    << "pixel " << x << " " << y << " radius " << radius << " rect " << rect.x0
                    << " " << rect.y0 << " " << rect.x1 << " " << rect.y1;
            }
        }
    }
}

TEST(SphereBounds, ConservativeForRandomSpheres) {
    Random random(5);
    for (int i = 0; i < 400; ++i) {
        Camera camera = lookAt(random.point(-1.0f, 1.0f), random.point(-1.0f, 1.0f));
        camera.y_fov = random.uniform(0.1f, 2.8f);
        expectConservative(camera, 48, i % 2 == 0 ? 32 : 64, random.point(-3.0f, 3.0f),
                           std::pow(10.0f, random.uniform(-3.0f, 0.5f)));
    }
}

TEST(SphereBounds, ConservativeAroundTheEyeAndItsPlane) {
    const Camera camera = lookAt(vec3(0), vec3(0, 0, -1));
    for (float z : {-1.0f, -0.5f, 0.0f, 0.5f, 0.999f, 1.0f, 1.000001f, 1.001f, 2.0f}) {
        for (float x : {0.0f, 0.5f, 1.0f, 3.0f, -3.0f}) {
            expectConservative(camera, 32, 32, vec3(x, 0.2f * x, -z), 1.0f);
        }
    }
}

TEST(SphereBounds, TightInFrontAndEmptyBehindOrBeside) {
    const Camera camera = lookAt(vec3(0), vec3(0, 0, -1));
    const View view = cameraView(camera, 100, 100, 1e-4f);
    const PixelRect front = sphereBounds(view, 100, 100, vec3(0, 0, -10), 0.1f);
    EXPECT_LE(front.x1 - front.x0, 6);
    EXPECT_LE(front.y1 - front.y0, 6);
    EXPECT_EQ(sphereBounds(view, 100, 100, vec3(0, 0, 10), 1.0f).x1, 0);
    EXPECT_EQ(sphereBounds(view, 100, 100, vec3(100, 0, -10), 1.0f).x1, 0);
    const PixelRect all = sphereBounds(view, 100, 100, vec3(0), 1.0f);
    EXPECT_EQ(all.x1 - all.x0, 100);
}

TEST(Serves, ItsOwnClassAndLowerOnes) {
    EXPECT_TRUE(serves(4, 4));
    EXPECT_TRUE(serves(4, 3));
    EXPECT_TRUE(serves(4, shared::DIFFUSE_ORDER));
    EXPECT_FALSE(serves(3, 4));
    EXPECT_FALSE(serves(shared::DIFFUSE_ORDER, 3));
    EXPECT_TRUE(serves(shared::DIFFUSE_ORDER, shared::DIFFUSE_ORDER));
    EXPECT_FALSE(serves(10, kNoOrder));
}

}  // namespace
}  // namespace sheen
