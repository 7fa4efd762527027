// The BRDF's spherical harmonics against the directional albedo and against quadrature of the lobe
// itself; the rotator against the lobe in its own frame.
#include <gtest/gtest.h>

#include <numbers>

#include "scene/brdf_albedo.h"
#include "sh/brdf_sh.h"
#include "sh/brdf_sh_table.h"
#include "sh_test_evaluate.h"
#include "test_scenes.h"

namespace sheen {
namespace {

const float kSqrt4Pi = std::sqrt(4.0f * kPi);

// Band 0 against quadrature, at most 5e-3 off. Measured: 1.6e-3 at view cosines from
// 0.02, 2.3e-3 from MIN_VIEW_COSINE, which is where shading normals stop.
constexpr double kAlbedoError = 2.5e-3;
// Nodes of both tables, sums of some thousand samples.
constexpr float kAlbedoAtNodes = 1e-3f;
// Between nodes of both.
constexpr float kAlbedoInterpolated = 5e-3f;
// The light that a lobe lets through, typical light being (l + 1)^-1.3 in band l. Measured: 3e-3,
// near the normal, where the table's step is three degrees.
constexpr double kConvolutionError = 4e-3;
// Table entries against quadrature on a fine grid; entries are below 1.
constexpr double kTableError = 5e-4;
// A rotated lobe is a sum of up to ten zonal harmonics a band, with weights of order one.
constexpr float kRotationError = 2e-4f;

// F0's and F90's parts of the lobe's coefficients by the midpoint rule over half vectors, in
// double: with tan^2 = alpha^2 u / (1 - u), D cos dw_h is uniform in (u, phi), and dw_i = 4 (wo.h)
// dw_h. Shares neither sampling nor arithmetic with the table.
struct Lobe {
    std::vector<double> a, b;
};
Lobe lobeByQuadrature(double NoV, double roughness, int order, int heights, int azimuths) {
    const int count = order * (order + 1) / 2;
    Lobe lobe{std::vector<double>(static_cast<size_t>(count)),
              std::vector<double>(static_cast<size_t>(count))};
    const double alpha = std::pow(std::max<double>(roughness, shared::MIN_ROUGHNESS), 2);
    const double a2 = alpha * alpha;
    const glm::dvec3 wo(std::sqrt(1.0 - NoV * NoV), 0.0, NoV);
    for (int i = 0; i < heights; ++i) {
        // Squared spacing at the far end: at grazing views few and far normals matter.
        const double v = 1.0 - (i + 0.5) / heights;
        const double tan2 = a2 * (1.0 - v * v) / (v * v);
        const double NoH = 1.0 / std::sqrt(1.0 + tan2);
        for (int j = 0; j < azimuths; ++j) {
            const double phi = std::numbers::pi * (j + 0.5) / azimuths;
            const double sin_h = std::sqrt(tan2) * NoH;
            const glm::dvec3 h(sin_h * std::cos(phi), sin_h * std::sin(phi), NoH);
            const double VoH = glm::dot(wo, h);
            const glm::dvec3 wi = 2.0 * VoH * h - wo;
            if (VoH <= 0.0 || wi.z <= 0.0) {
                continue;
            }
            // [Hei14, eq. 99], [Sch94, eq. 15]
            const double visibility = 0.5 / (wi.z * std::sqrt(NoV * NoV * (1.0 - a2) + a2) +
                                             NoV * std::sqrt(wi.z * wi.z * (1.0 - a2) + a2));
            const double value =
                visibility * wi.z * 4.0 * VoH / NoH * 2.0 * v / (heights * azimuths);
            const double f = std::pow(1.0 - VoH, 5.0);
            const shared::ShVector y = shared::shBasis(glm::normalize(vec3(wi)), order);
            for (int l = 0; l < order; ++l) {
                for (int m = 0; m <= l; ++m) {
                    const auto k = static_cast<size_t>(shTriangleIndex(l, m));
                    const double basis = y.c[shared::shIndex(l, m)];
                    lobe.a[k] += value * (1.0 - f) * basis;
                    lobe.b[k] += value * f * basis;
                }
            }
        }
    }
    return lobe;
}

TEST(BrdfSh, EntryZeroIsTheDirectionalAlbedo) {
    for (float NoV : {0.0f, 1.0f}) {
        for (float roughness : {0.0f, 1.0f}) {
            const BrdfShSample lobe = brdfSh(NoV, roughness);
            const vec2 albedo = brdfAlbedo(NoV, roughness);
            EXPECT_NEAR(lobe.a[0] * kSqrt4Pi, albedo.x, kAlbedoAtNodes) << NoV << " " << roughness;
            EXPECT_NEAR(lobe.b[0] * kSqrt4Pi, albedo.y, kAlbedoAtNodes) << NoV << " " << roughness;
        }
    }
    Random random(1);
    for (int i = 0; i < 500; ++i) {
        const float NoV = random.uniform(0.01f, 1.0f);
        const float roughness = random.uniform(0.05f, 1.0f);
        const BrdfShSample lobe = brdfSh(NoV, roughness);
        const vec2 albedo = brdfAlbedo(NoV, roughness);
        EXPECT_NEAR(lobe.a[0] * kSqrt4Pi, albedo.x, kAlbedoInterpolated) << NoV << " " << roughness;
        EXPECT_NEAR(lobe.b[0] * kSqrt4Pi, albedo.y, kAlbedoInterpolated) << NoV << " " << roughness;
    }
}

TEST(BrdfSh, AlbedoOfMetalsAndDielectricsAtEveryRoughnessAndView) {
    // Steps that meet no node; finer toward smooth surfaces and grazing views.
    for (double s = 0.0; s <= 1.0; s += 0.043) {
        for (double t = 1.0; t >= 0.1; t -= 0.037) {
            const double roughness = s * s;
            const double NoV = t * t;
            const Lobe truth = lobeByQuadrature(NoV, roughness, 1, 600, 100);
            const BrdfShSample lobe =
                brdfSh(static_cast<float>(NoV), static_cast<float>(roughness));
            // Either part, white metal, gold's blue, dielectrics with and without grazing light.
            const double fresnel[][2] = {{1, 0}, {0, 1}, {1, 1}, {0.3, 1}, {0.04, 1}, {0.04, 0.04}};
            for (const auto& [f0, f90] : fresnel) {
                EXPECT_NEAR((f0 * lobe.a[0] + f90 * lobe.b[0]) * kSqrt4Pi,
                            (f0 * truth.a[0] + f90 * truth.b[0]) * kSqrt4Pi, kAlbedoError)
                    << "NoV " << NoV << " roughness " << roughness << " F0 " << f0;
            }
        }
    }
}

TEST(BrdfSh, BetweenNodesAllBandsAreIntegralsOfTheLobe) {
    Random random(5);
    for (int i = 0; i < 60; ++i) {
        const float roughness = std::pow(random.uniform(0.0f, 1.0f), 2.0f);
        const float NoV = std::pow(random.uniform(0.1f, 1.0f), i % 2 == 0 ? 2.0f : 0.5f);
        const Lobe truth = lobeByQuadrature(NoV, roughness, shared::SH_MAX_ORDER, 300, 100);
        const BrdfShSample lobe = brdfSh(NoV, roughness);
        double error = 0.0, whole = 0.0;
        for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
            for (int m = 0; m <= l; ++m) {
                const int k = shTriangleIndex(l, m);
                const auto at = static_cast<size_t>(k);
                const double expected = 0.9 * truth.a[at] + truth.b[at];
                const double light = std::pow(l + 1.0, -1.3);
                error += std::pow(light * (0.9 * lobe.a[k] + lobe.b[k] - expected), 2);
                whole += std::pow(light * expected, 2);
            }
        }
        EXPECT_LT(std::sqrt(error / whole), kConvolutionError)
            << "NoV " << NoV << " roughness " << roughness;
    }
}

TEST(BrdfSh, FiniteAndBoundedOverTheWholeTableAndBeyond) {
    for (float NoV : {-1.0f, 0.0f, 1e-6f, 0.5f, 1.0f, 2.0f}) {
        for (float roughness : {-1.0f, 0.0f, 0.02f, 0.5f, 1.0f, 2.0f}) {
            const BrdfShSample lobe = brdfSh(NoV, roughness);
            for (int k = 0; k < kShTriangle; ++k) {
                // |b_lm| <= max |Y| * albedo; |Y| stays below sqrt(2 * 19 / 4 pi) for l < 10.
                ASSERT_LE(std::abs(lobe.a[k]), 1.8f) << NoV << " " << roughness << " " << k;
                ASSERT_LE(std::abs(lobe.b[k]), 1.8f) << NoV << " " << roughness << " " << k;
            }
        }
    }
}

TEST(BrdfSh, TableEntriesAreIntegralsOfTheLobe) {
    const int nodes[][2] = {
        {63, 39}, {52, 28}, {34, 32}, {57, 25}, {16, 30}};  // (view cosine, roughness)
    for (const auto& node : nodes) {
        const vec2 at = brdfShParams(node[0], node[1]);
        const BrdfShSample lobe = brdfSh(at.x, at.y);
        const float alpha = shared::alphaFromRoughness(at.y);
        const vec3 wo(std::sqrt(1.0f - at.x * at.x), 0.0f, at.x);
        std::vector<double> a(kShTriangle), b(kShTriangle);
        constexpr int kHeights = 300, kAzimuths = 300;  // half the azimuths: mirror symmetry
        for (int i = 0; i < kHeights; ++i) {
            for (int j = 0; j < kAzimuths; ++j) {
                const float z = (static_cast<float>(i) + 0.5f) / kHeights;
                const float phi = kPi * (static_cast<float>(j) + 0.5f) / kAzimuths;
                const float r = std::sqrt(1.0f - z * z);
                const vec3 wi(r * std::cos(phi), r * std::sin(phi), z);
                const vec2 f = shared::specularLobe(alpha, vec3(0, 0, 1), wo, wi);
                const double value = 2.0 * M_PI / (kHeights * kAzimuths) * f.x * z;
                const shared::ShVector y = shared::shBasis(wi, shared::SH_MAX_ORDER);
                for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
                    for (int m = 0; m <= l; ++m) {
                        const auto k = static_cast<size_t>(shTriangleIndex(l, m));
                        const double basis = y.c[shared::shIndex(l, m)];
                        a[k] += value * (1.0 - f.y) * basis;
                        b[k] += value * f.y * basis;
                    }
                }
            }
        }
        for (int k = 0; k < kShTriangle; ++k) {
            EXPECT_NEAR(lobe.a[k], a[static_cast<size_t>(k)], kTableError) << at.x << " " << at.y;
            EXPECT_NEAR(lobe.b[k], b[static_cast<size_t>(k)], kTableError) << at.x << " " << at.y;
        }
    }
}

// The lobe's bands in its own frame (z the normal, x toward the viewer's side).
double localLobe(const BrdfShSample& lobe, float f0, float f90, const vec3& d, int order) {
    const shared::ShVector y = shared::shBasis(d, order);
    double sum = 0.0;
    for (int l = 0; l < order; ++l) {
        for (int m = 0; m <= l; ++m) {
            const int k = shTriangleIndex(l, m);
            sum +=
                static_cast<double>(f0 * lobe.a[k] + f90 * lobe.b[k]) * y.c[shared::shIndex(l, m)];
        }
    }
    return sum;
}

std::vector<float> rotated(int order, const BrdfShSample& lobe, float f0, float f90, const vec3& n,
                           const vec3& wo) {
    std::vector<float> c(static_cast<size_t>(order * order), 7.0f);  // rotate() must overwrite
    BrdfRotator(order).rotate(lobe, f0, f90, n, wo, c.data());
    return c;
}

TEST(BrdfRotator, EqualsTheLobeInItsOwnFrame) {
    Random random(2);
    for (int order = 1; order <= shared::SH_MAX_ORDER; ++order) {
        for (int trial = 0; trial < 10; ++trial) {
            const vec3 n = random.direction();
            const vec3 wo = random.direction(n);
            const float NoV = glm::dot(n, wo);
            const BrdfShSample lobe = brdfSh(NoV, random.uniform(0.2f, 1.0f));
            const float f0 = random.uniform(0.02f, 1.0f);
            const std::vector<float> c = rotated(order, lobe, f0, 1.0f, n, wo);
            const vec3 t = glm::normalize(wo - NoV * n);
            const vec3 b = glm::cross(n, t);
            for (int i = 0; i < 20; ++i) {
                const vec3 d = random.direction();
                const vec3 local(glm::dot(d, t), glm::dot(d, b), glm::dot(d, n));
                EXPECT_NEAR(evaluate(c, d, order), localLobe(lobe, f0, 1.0f, local, order),
                            kRotationError)
                    << "order " << order;
            }
        }
    }
}

TEST(BrdfRotator, MirrorsInThePlaneOfIncidence) {
    Random random(3);
    const int order = shared::SH_MAX_ORDER;
    for (int trial = 0; trial < 10; ++trial) {
        const vec3 n = random.direction();
        const vec3 wo = random.direction(n);
        const std::vector<float> c =
            rotated(order, brdfSh(glm::dot(n, wo), 0.3f), 0.5f, 1.0f, n, wo);
        const vec3 across = glm::normalize(glm::cross(n, wo));
        for (int i = 0; i < 20; ++i) {
            const vec3 d = random.direction();
            const vec3 mirrored = d - 2.0f * glm::dot(d, across) * across;
            EXPECT_NEAR(evaluate(c, d, order), evaluate(c, mirrored, order), kRotationError);
        }
    }
}

TEST(BrdfRotator, SeenAlongTheNormalTheLobeIsRound) {
    // The table's column at NoV = 1 is round up to rounding; m > 0 entries are what is left.
    Random random(4);
    const int order = shared::SH_MAX_ORDER;
    for (const vec3& n : {vec3(0, 0, 1), vec3(0, 0, -1), vec3(1, 0, 0), random.direction()}) {
        const std::vector<float> c = rotated(order, brdfSh(1.0f, 0.5f), 0.5f, 1.0f, n, n);
        for (int i = 0; i < 40; ++i) {
            const vec3 a = random.direction();
            // The same angle to the normal, another azimuth.
            const vec3 side = glm::normalize(glm::cross(n, random.direction()));
            const float cosine = glm::dot(a, n);
            const vec3 b = cosine * n + std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)) * side;
            EXPECT_TRUE(std::isfinite(evaluate(c, a, order)));
            EXPECT_NEAR(evaluate(c, a, order), evaluate(c, b, order), kRotationError);
        }
    }
}

TEST(BrdfRotator, NearlyAlongTheNormalStaysContinuous) {
    const int order = shared::SH_MAX_ORDER;
    const vec3 n(0, 0, 1);
    const BrdfShSample lobe = brdfSh(1.0f, 0.3f);
    const std::vector<float> straight = rotated(order, lobe, 1.0f, 1.0f, n, n);
    for (float tilt : {1e-7f, 1e-6f, 1e-5f, 2e-5f, 1e-4f}) {
        const std::vector<float> c =
            rotated(order, lobe, 1.0f, 1.0f, n, glm::normalize(vec3(tilt, 0, 1)));
        for (size_t k = 0; k < c.size(); ++k) {
            EXPECT_NEAR(c[k], straight[k], 2e-3f) << "tilt " << tilt << " coefficient " << k;
        }
    }
}

TEST(BrdfRotator, CoefficientZeroIsTheAlbedoWhateverTheOrder) {
    const vec3 n = glm::normalize(vec3(1, 2, 3));
    const vec3 wo = glm::normalize(vec3(-1, 2, 3));
    const BrdfShSample lobe = brdfSh(glm::dot(n, wo), 0.4f);
    for (int order = 1; order <= shared::SH_MAX_ORDER; ++order) {
        EXPECT_NEAR(rotated(order, lobe, 0.3f, 0.9f, n, wo)[0], 0.3f * lobe.a[0] + 0.9f * lobe.b[0],
                    1e-6f);
    }
}

TEST(LobePrediction, MoreBandsNeverPredictMoreError) {
    for (float roughness : {0.0f, 0.1f, 0.3f, 0.6f, 1.0f}) {
        for (float NoV : {0.0f, 0.1f, 0.5f, 1.0f}) {
            const LobePrediction p = predictLobeError(NoV, roughness);
            for (int n = 0; n < shared::SH_MAX_ORDER; ++n) {
                EXPECT_GE(p.truncated[n], p.truncated[n + 1]) << roughness << " " << NoV;
            }
            EXPECT_GE(p.truncated[shared::SH_MAX_ORDER], 0.0f);
            EXPECT_TRUE(std::isfinite(p.truncated[0]) && std::isfinite(p.as_diffuse));
            EXPECT_GE(p.as_diffuse, 0.0f);
        }
    }
}

// Beyond the table: a lobe that ends before band 10 leaves nothing out, a mirror nearly as much
// again as light has there, and the prediction falls from one to the other with the lobe's width.
TEST(LobePrediction, KnowsWhatTheHighestOrderMisses) {
    // Every band of a mirror's lobe is 2 l + 1 times the square of band 0.
    double mirror = 0.0;
    for (int l = shared::SH_MAX_ORDER; l < 400; ++l) {
        mirror += (2.0 * l + 1.0) * std::pow(l + 1.0, -2.0);
    }
    constexpr int kOrder = shared::SH_MAX_ORDER;
    EXPECT_NEAR(predictLobeError(0.9f, 0.0f).truncated[kOrder], std::sqrt(mirror),
                0.15 * std::sqrt(mirror));
    EXPECT_LT(predictLobeError(0.9f, 1.0f).truncated[kOrder], 1e-3f);
    float last = kInfinity;
    for (float roughness : {0.0f, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f}) {
        const float error = predictLobeError(0.5f, roughness).truncated[kOrder];
        EXPECT_LT(error, last) << roughness;
        last = error;
    }
}

TEST(LobePrediction, RougherLobesLoseLess) {
    for (int n : {3, 5, 8}) {
        float last = kInfinity;
        for (float roughness : {0.2f, 0.4f, 0.6f, 0.8f}) {
            const float error = predictLobeError(0.8f, roughness).truncated[n];
            EXPECT_LT(error, last) << "order " << n << " roughness " << roughness;
            last = error;
        }
    }
}

TEST(LobePrediction, AsDiffuseComparesWithTheCosine) {
    // Bands of max(z, 0) relative to band 0, by quadrature.
    double cosine[shared::SH_MAX_ORDER] = {};
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
        const double z = (i + 0.5) / kSteps;
        const double r = std::sqrt(1.0 - z * z);
        const shared::ShVector y = shared::shBasis(vec3(r, 0.0, z), shared::SH_MAX_ORDER);
        for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
            cosine[l] += z * y.c[shared::shIndex(l, 0)];
        }
    }
    // The amplitude s_l of light that the prediction assumes follows from its own tails.
    for (float NoV : {1.0f, 0.7f}) {
        const BrdfShSample lobe = brdfSh(NoV, 1.0f);
        const LobePrediction p = predictLobeError(NoV, 1.0f);
        double expected = 0.0;
        for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
            double power = 0.0, difference = 0.0;
            for (int m = 0; m <= l; ++m) {
                const double b = lobe.a[shTriangleIndex(l, m)] / lobe.a[0];
                const double c = m == 0 ? cosine[l] / cosine[0] : 0.0;
                power += b * b;
                difference += (b - c) * (b - c);
            }
            const double tail = std::pow(p.truncated[l], 2) - std::pow(p.truncated[l + 1], 2);
            expected += tail / power * difference;
        }
        // Differences of squared floats; a wrong band 6 or 8 shows at 2e-4.
        EXPECT_NEAR(p.as_diffuse, std::sqrt(expected), 4e-5 * p.as_diffuse);
    }
}

}  // namespace
}  // namespace sheen
