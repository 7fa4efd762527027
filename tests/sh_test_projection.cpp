// From texels to coefficients: constant light exactly, band-limited light closely, hostile light
// within bounds.
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "sh/projection.h"
#include "sh_test_evaluate.h"
#include "test_scenes.h"

namespace sheen {
namespace {

constexpr float kExact = 5e-5f;  // float matrix entries, sums over thousands of texels

std::vector<float> project(const Hemisphere& h, const std::vector<float>& matrix,
                           const std::vector<float>& texels) {
    const size_t count = texels.size();
    std::vector<float> c(matrix.size() / count);
    EXPECT_EQ(count, static_cast<size_t>(h.texelCount()));
    for (size_t k = 0; k < c.size(); ++k) {
        double sum = 0.0;
        for (size_t t = 0; t < count; ++t) {
            sum += static_cast<double>(matrix[k * count + t]) * texels[t];
        }
        c[k] = static_cast<float>(sum);
    }
    return c;
}

// Mean of `light` over each texel's footprint.
std::vector<float> render(const Hemisphere& h, const std::function<double(const vec3&)>& light) {
    std::vector<float> texels;
    for (int t = 0; t < h.texelCount(); ++t) {
        double sum = 0.0, weight = 0.0;
        for (const FootprintSample& s : footprint(h, t)) {
            sum += s.solid_angle * light(s.direction);
            weight += s.solid_angle;
        }
        texels.push_back(static_cast<float>(sum / weight));
    }
    return texels;
}

// Largest deviation over the upper hemisphere.
double worstError(const std::vector<float>& c, int order,
                  const std::function<double(const vec3&)>& light) {
    Random random(9);
    double worst = 0.0;
    for (int i = 0; i < 500; ++i) {
        const vec3 d = random.direction(vec3(0, 0, 1));
        worst = std::max(worst, std::abs(evaluate(c, d, order) - light(d)));
    }
    return worst;
}

const HemisphereParams kCovering[] = {
    {.kind = HemisphereKind::kBorder, .size = 24, .extent = 3.0f},
    {.kind = HemisphereKind::kBorder, .size = 17, .extent = 1.5f},
    {.kind = HemisphereKind::kHemicube, .size = 16},
};

TEST(Projection, ConstantLightIsReproducedExactly) {
    for (const HemisphereParams& params : kCovering) {
        const Hemisphere h = makeHemisphere(params);
        for (int order = 1; order <= shared::SH_MAX_ORDER; ++order) {
            const std::vector<float> matrix = projectionMatrix(h, {.order = order});
            ASSERT_EQ(matrix.size(), static_cast<size_t>(order * order * h.texelCount()));
            const float L = 2.5f;
            const std::vector<float> c =
                project(h, matrix, std::vector<float>(static_cast<size_t>(h.texelCount()), L));
            EXPECT_NEAR(c[0], std::sqrt(4.0f * kPi) * L, kExact * L) << "order " << order;
            for (size_t k = 1; k < c.size(); ++k) {
                EXPECT_NEAR(c[k], 0.0f, kExact * L) << "order " << order << " coefficient " << k;
            }
        }
    }
}

TEST(Projection, LinearLightIsReproducedWithoutTheBand) {
    // Band-limited light: nothing but texel quadrature and the ridge stands between it and its
    // coefficients.
    const auto light = [](const vec3& d) { return 1.0 + 0.4 * d.x - 0.3 * d.y + 0.2 * d.z; };
    for (const HemisphereParams& params :
         {HemisphereParams{.kind = HemisphereKind::kHemicube, .size = 32},
          HemisphereParams{.kind = HemisphereKind::kBorder, .size = 32, .extent = 4.0f}}) {
        const Hemisphere h = makeHemisphere(params);
        for (int order : {2, 3, 4}) {
            const std::vector<float> matrix =
                projectionMatrix(h, {.order = order, .band_weight = 1e-6f, .ridge = 1e-6f});
            const std::vector<float> c = project(h, matrix, render(h, light));
            EXPECT_LT(worstError(c, order, light), 0.03) << "order " << order;
        }
    }
}

TEST(Projection, LightWhoseHorizonContinuesBelowIsReproduced) {
    // L = 1 + x y / (x^2 + y^2 + z^2) has nearly its horizon's values down to -30 degrees.
    const auto light = [](const vec3& d) { return 1.0 + 0.8 * d.x * d.y; };
    const Hemisphere h =
        makeHemisphere({.kind = HemisphereKind::kBorder, .size = 32, .extent = 4.0f});
    for (int order : {3, 4, 6, 8}) {
        const std::vector<float> c =
            project(h, projectionMatrix(h, {.order = order}), render(h, light));
        EXPECT_LT(worstError(c, order, light), 0.06) << "order " << order;
        // Below the horizon, where tilted pixels read: the horizon's value at the same azimuth.
        for (int i = 0; i < 32; ++i) {
            const float phi = 2.0f * kPi * static_cast<float>(i) / 32.0f;
            const float z = -std::sin(glm::radians(20.0f));
            const float r = std::sqrt(1.0f - z * z);
            const double at_horizon = light(vec3(std::cos(phi), std::sin(phi), 0.0f));
            EXPECT_NEAR(evaluate(c, vec3(r * std::cos(phi), r * std::sin(phi), z), order),
                        at_horizon, 0.15)
                << "order " << order;
        }
    }
}

TEST(Projection, CoefficientsStayBounded) {
    // Texels in [0, 1]: half-precision storage and sane extrapolation need coefficients below 10
    // (design, section 3); the reconstruction may ring, but not explode, anywhere above -30
    // degrees.
    constexpr double kCoefficientBound = 10.0;
    constexpr double kRinging = 1.0;
    Random random(5);
    for (const HemisphereParams& params : kCovering) {
        const Hemisphere h = makeHemisphere(params);
        const auto count = static_cast<size_t>(h.texelCount());
        for (int order : {1, 3, 6, 10}) {
            const std::vector<float> matrix = projectionMatrix(h, {.order = order});
            for (int kind = 0; kind < 4; ++kind) {
                std::vector<float> texels(count);
                for (size_t t = 0; t < count; ++t) {
                    const vec3& d = h.directions[t];
                    texels[t] = kind == 0   ? (random.uniform(0.0f, 1.0f) > 0.5f ? 1.0f : 0.0f)
                                : kind == 1 ? (d.x > 0.0f ? 1.0f : 0.0f)
                                : kind == 2 ? (h.at_horizon[t] != 0 ? 1.0f : 0.0f)
                                            : (d.z > 0.9f ? 1.0f : 0.0f);
                }
                const std::vector<float> c = project(h, matrix, texels);
                for (float v : c) {
                    EXPECT_LT(std::abs(v), kCoefficientBound)
                        << "order " << order << " light " << kind;
                }
                for (int i = 0; i < 200; ++i) {
                    vec3 d = random.direction(vec3(0, 0, 1));
                    d = i % 3 == 0 ? glm::normalize(vec3(d.x, d.y, -0.5f * d.z)) : d;
                    if (d.z < -0.5f) {
                        continue;
                    }
                    const double value = evaluate(c, d, order);
                    EXPECT_GT(value, -kRinging) << "order " << order << " light " << kind;
                    EXPECT_LT(value, 1.0 + kRinging) << "order " << order << " light " << kind;
                }
            }
        }
    }
}

TEST(Projection, TurnsWithTheTexels) {
    // A quarter turn of the texels is a quarter turn of the function.
    const Hemisphere h =
        makeHemisphere({.kind = HemisphereKind::kBorder, .size = 16, .extent = 3.0f});
    const int order = 6;
    const std::vector<float> matrix = projectionMatrix(h, {.order = order});
    Random random(6);
    std::vector<float> texels(static_cast<size_t>(h.texelCount()));
    for (float& v : texels) {
        v = random.uniform(0.0f, 1.0f);
    }
    std::vector<float> turned(texels.size());
    for (int y = 0; y < h.height; ++y) {
        for (int x = 0; x < h.width; ++x) {
            // (x, y) -> (-y, x)
            turned[static_cast<size_t>(x * h.width + (h.width - 1 - y))] =
                texels[static_cast<size_t>(y * h.width + x)];
        }
    }
    const std::vector<float> c = project(h, matrix, texels);
    const std::vector<float> expected = project(h, matrix, turned);
    std::vector<float> rotated(c.size());
    ShRotation(mat3(vec3(0, 1, 0), vec3(-1, 0, 0), vec3(0, 0, 1)), order)
        .apply(c.data(), rotated.data());
    for (size_t k = 0; k < c.size(); ++k) {
        EXPECT_NEAR(rotated[k], expected[k], 5e-3f) << k;
    }
}

TEST(Projection, RefusesOrdersOutOfRange) {
    const Hemisphere h = makeHemisphere({.size = 4});
    EXPECT_THROW(projectionMatrix(h, {.order = 0}), std::logic_error);
    EXPECT_THROW(projectionMatrix(h, {.order = shared::SH_MAX_ORDER + 1}), std::logic_error);
}

}  // namespace
}  // namespace sheen
