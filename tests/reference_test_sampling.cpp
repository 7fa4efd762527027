// Sample points, samplers against their densities, and the guide that warps them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "reference/guide.h"
#include "reference/sampling.h"
#include "reference/sobol.h"
#include "scene/brdf_albedo.h"
#include "test_scenes.h"

namespace sheen {
namespace {

// Upper quantile of chi-square with k degrees of freedom where the normal deviate is z.
double chiSquareQuantile(double k, double z) {
    const double a = 2.0 / (9.0 * k);  // Wilson and Hilferty 1931
    return k * std::pow(1.0 - a + z * std::sqrt(a), 3.0);
}

// Draws directions (local frame, z up; z <= 0 means "no sample") and compares their histogram over
// (cos theta, phi) with the density per solid angle.
void expectDistribution(const std::function<vec3(const vec2&)>& draw,
                        const std::function<double(const vec3&)>& pdf) {
    constexpr int kTheta = 16, kPhi = 32, kSub = 24, kSamples = 1 << 18;
    constexpr double kZ = 4.0;  // false alarm: 3e-5
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0.0f, 0x1.fffffep-1f);
    std::vector<double> seen(kTheta * kPhi + 1, 0.0), expected(kTheta * kPhi + 1, 0.0);
    for (int i = 0; i < kSamples; ++i) {
        const float u = uniform(random), v = uniform(random);
        const vec3 w = draw(vec2(u, v));
        if (w.z <= 0.0f) {
            seen.back() += 1.0;
            continue;
        }
        double phi = std::atan2(w.y, w.x) / (2.0 * M_PI);
        phi -= std::floor(phi);
        const int t = std::min(static_cast<int>(w.z * kTheta), kTheta - 1);
        seen[static_cast<size_t>(t * kPhi + std::min(static_cast<int>(phi * kPhi), kPhi - 1))] += 1;
    }
    double total = 0.0;
    for (int bin = 0; bin < kTheta * kPhi; ++bin) {
        double sum = 0.0;
        for (int s = 0; s < kSub * kSub; ++s) {
            const double z = (bin / kPhi + (s / kSub + 0.5) / kSub) / kTheta;
            const double phi = 2.0 * M_PI * (bin % kPhi + (s % kSub + 0.5) / kSub) / kPhi;
            const double r = std::sqrt(1.0 - z * z);
            sum += pdf(vec3(r * std::cos(phi), r * std::sin(phi), z));
        }
        const double probability = sum * 2.0 * M_PI / (kTheta * kPhi * kSub * kSub);
        expected[static_cast<size_t>(bin)] = probability * kSamples;
        total += probability;
    }
    expected.back() = std::max(0.0, 1.0 - total) * kSamples;
    EXPECT_LT(total, 1.002);

    // Merge bins until each expects five.
    double chi2 = 0.0, o = 0.0, e = 0.0;
    int cells = 0;
    for (size_t bin = 0; bin < seen.size(); ++bin) {
        o += seen[bin];
        e += expected[bin];
        if (e >= 5.0) {
            chi2 += (o - e) * (o - e) / e;
            ++cells;
            o = e = 0.0;
        }
    }
    EXPECT_LT(chi2, chiSquareQuantile(cells - 1, kZ)) << cells << " cells";
}

// ---- Sample points ------------------------------------------------------------------------------

TEST(Sobol, SecondDimensionIsSobols) {
    for (uint32_t index : {0u, 1u, 2u, 3u, 77u, 0x80000000u, 0xdeadbeefu, 0xffffffffu}) {
        uint32_t direct = 0;  // the loop of Kollig and Keller 2002, "Efficient multidimensional
        for (uint32_t i = index, v = 1u << 31; i != 0; i >>= 1, v ^= v >> 1) {  // sampling"
            direct ^= (i & 1u) != 0 ? v : 0u;
        }
        EXPECT_EQ(sobolBits(index).y, direct);
        EXPECT_EQ(sobolBits(index).x, reverseBits(index));
    }
}

TEST(Sobol, OnePointInEachElementaryInterval) {
    for (uint32_t seed : {0u, 1u, 12345u, 0xffffffffu}) {
        for (int k = 0; k <= 8; ++k) {
            const uint32_t count = 1u << k;
            for (uint32_t block : {0u, 5u}) {
                for (int a = 0; a <= k; ++a) {
                    std::vector<int> hits(count, 0);
                    for (uint32_t i = 0; i < count; ++i) {
                        const vec2 u = owenSobol(block * count + i, seed);
                        const auto x = static_cast<uint32_t>(std::ldexp(u.x, a));
                        const auto y = static_cast<uint32_t>(std::ldexp(u.y, k - a));
                        ++hits[(y << a) + x];
                    }
                    EXPECT_EQ(std::count(hits.begin(), hits.end(), 1), count)
                        << "k " << k << " a " << a << " seed " << seed;
                }
            }
        }
    }
}

TEST(Sobol, EachPointIsUniformOverSeeds) {
    constexpr int kSeeds = 20000;
    vec2 sum(0.0f);
    float product = 0.0f;
    for (int seed = 0; seed < kSeeds; ++seed) {
        const vec2 u = owenSobol(3, hash32(static_cast<uint32_t>(seed)));
        sum += u;
        product += (u.x - 0.5f) * (u.y - 0.5f);
    }
    // Standard errors 1/sqrt(12 n) and 1/(12 sqrt(n)).
    EXPECT_NEAR(sum.x / kSeeds, 0.5, 4.0 / std::sqrt(12.0 * kSeeds));
    EXPECT_NEAR(sum.y / kSeeds, 0.5, 4.0 / std::sqrt(12.0 * kSeeds));
    EXPECT_NEAR(product / kSeeds, 0.0, 4.0 / (12.0 * std::sqrt(1.0 * kSeeds)));
}

TEST(Sampling, FrameIsARotationOntoTheNormal) {
    for (const vec3& n : {vec3(0, 0, 1), vec3(0, 0, -1), vec3(1, 0, 0), vec3(0, -1, 0),
                          glm::normalize(vec3(1e-4f, -1e-4f, -1)), glm::normalize(vec3(1, 2, 3))}) {
        const mat3 m = tangentFrame(n);
        EXPECT_NEAR(glm::determinant(m), 1.0f, 1e-5f);
        EXPECT_NEAR(glm::length(m * vec3(0, 0, 1) - n), 0.0f, 1e-6f);
        EXPECT_NEAR(glm::dot(m[0], m[1]), 0.0f, 1e-6f);
        EXPECT_NEAR(glm::dot(m[0], m[2]), 0.0f, 1e-6f);
    }
}

TEST(Sampling, CosineFollowsItsDensity) {
    expectDistribution([](const vec2& u) { return sampleCosine(u); },
                       [](const vec3& w) { return w.z / M_PI; });
}

TEST(Sampling, GgxReflectionFollowsItsDensity) {
    const vec3 n(0, 0, 1);
    for (const float alpha : {0.2f, 0.7f}) {
        for (const float NoV : {0.95f, 0.3f}) {
            const vec3 wo(std::sqrt(1.0f - NoV * NoV), 0.0f, NoV);
            expectDistribution(
                [&](const vec2& u) {
                    const vec3 h = sampleGgxVisibleNormal(wo, alpha, u);
                    return 2.0f * glm::dot(wo, h) * h - wo;
                },
                [&](const vec3& w) { return ggxReflectionPdf(n, wo, w, alpha); });
        }
    }
}

// The mixture and plain cosine sampling estimate the same integral of a lopsided environment.
TEST(Sampling, MixtureAgreesWithCosineSampling) {
    constexpr uint32_t kSamples = 1u << 17;
    const auto radiance = [](const vec3& w) { return w.x > 0.2f ? 1.0f : 0.1f * w.z; };
    const vec3 n = glm::normalize(vec3(0.2f, 0.3f, 1.0f));
    const vec3 wo = glm::normalize(vec3(-0.7f, 0.1f, 0.5f));
    for (const float metallic : {0.0f, 0.5f, 1.0f}) {
        for (const float roughness : {0.3f, 0.6f, 1.0f}) {
            const MaterialParams m = glossyParams(vec3(0.8f), metallic, roughness);
            const vec2 ab = brdfAlbedo(glm::dot(n, wo), roughness);
            const Brdf brdf = shared::makeBrdf(m, 1.0f, ab);
            const BrdfSampler sampler(brdf, brdf.f0 * ab.x + vec3(brdf.f90 * ab.y), n, wo);
            double mixed = 0.0, diffuse = 0.0, cosine = 0.0, cosine_diffuse = 0.0;
            for (uint32_t i = 0; i < kSamples; ++i) {
                const vec2 u = owenSobol(i, 99);
                const DirectionSample s = sampleBrdf(sampler, brdf, n, wo, u);
                mixed += s.weight.x * radiance(s.wi);
                diffuse += s.diffuse.x * radiance(s.wi);
                const vec3 wi = glm::normalize(sampler.world_from_local * sampleCosine(u));
                cosine += shared::evalBrdf(brdf, n, wo, wi).x * M_PI * radiance(wi);
                cosine_diffuse += brdf.diffuse.x * radiance(wi);
            }
            // Stratified in two dimensions with one jump: far below 1/sqrt(kSamples) = 0.3%.
            EXPECT_NEAR(mixed / cosine, 1.0, 3e-3) << metallic << " " << roughness;
            if (metallic < 1.0f) {
                EXPECT_NEAR(diffuse / cosine_diffuse, 1.0, 3e-3) << metallic << " " << roughness;
            }
        }
    }
}

// Likewise with a coat whose normal is another.
TEST(Sampling, ACoatedMixtureAgreesWithCosineSampling) {
    constexpr uint32_t kSamples = 1u << 17;
    const auto radiance = [](const vec3& w) { return w.x > 0.2f ? 1.0f : 0.1f * w.z; };
    const vec3 n = glm::normalize(vec3(0.2f, 0.3f, 1.0f));
    const vec3 wo = glm::normalize(vec3(-0.7f, 0.1f, 0.5f));
    const Brdf brdf =
        shared::makeBrdf(glossyParams(vec3(0.8f), 0.5f, 0.6f), 1.0f, vec2(0.7f, 0.1f));
    const Brdf coat_brdf = coatBrdf({.coat = 1.0f, .coat_roughness = 0.5f});
    const Coat coat{.brdf = coat_brdf, .n = vec3(0, 0, 1), .albedo = 0.1f};
    const BrdfSampler sampler(brdf, vec3(0.5f), n, wo, coat);
    double mixed = 0.0, cosine = 0.0;
    for (uint32_t i = 0; i < kSamples; ++i) {
        const vec2 u = owenSobol(i, 99);
        const DirectionSample s = sampleBrdf(sampler, brdf, n, wo, u);
        mixed += s.weight.x * radiance(s.wi);
        const vec3 wi = glm::normalize(sampler.world_from_local * sampleCosine(u));
        cosine += shared::evalBrdf(brdf, n, wo, wi).x * M_PI * radiance(wi);
        const vec3 coat_wi = sampleCosine(u);  // about the coat's own normal
        cosine += evalCoat(coat, wo, coat_wi).x / coat_wi.z * M_PI * radiance(coat_wi);
    }
    EXPECT_NEAR(mixed / cosine, 1.0, 3e-3);
}

// ---- The guide ----------------------------------------------------------------------------------

// Contributions of an 8 x 8 grid: all in one cell.
Guide cornerGuide() {
    std::vector<float> contributions(64, 0.0f);
    contributions[7 * 8 + 7] = 5.0f;
    return Guide(8, contributions);
}

TEST(Guide, KeepsIntegralsAndFollowsWhatItLearned) {
    constexpr uint32_t kSamples = 1u << 16;
    const Guide guide = cornerGuide();
    double ones = 0.0, integral = 0.0;
    int learned = 0;
    for (uint32_t i = 0; i < kSamples; ++i) {
        const GuidedPoint p = guide.warp(owenSobol(i, 5));
        ASSERT_TRUE(p.u.x >= 0.0f && p.u.x < 1.0f && p.u.y >= 0.0f && p.u.y < 1.0f);
        EXPECT_LE(p.weight, 1.0f / 0.3f + 1e-3f);
        ones += p.weight;
        integral += p.weight * p.u.x * p.u.x * p.u.y;
        learned += p.u.x >= 0.75f && p.u.y >= 0.75f ? 1 : 0;
    }
    EXPECT_NEAR(ones / kSamples, 1.0, 1e-3);
    EXPECT_NEAR(integral / kSamples, 1.0 / 6.0, 1e-3);
    // The blur spreads the one cell over four: seven tenths of the samples and their uniform share.
    EXPECT_NEAR(1.0 * learned / kSamples, 0.7 + 0.3 / 16.0, 1e-3);
}

TEST(Guide, ItsWeightsAreItsDensity) {
    constexpr int kSamples = 1 << 16;
    const Guide guide = cornerGuide();
    std::vector<double> seen(64, 0.0), expected(64, 0.0);
    for (uint32_t i = 0; i < kSamples; ++i) {
        const GuidedPoint p = guide.warp(owenSobol(i, 9));
        const auto cell = static_cast<size_t>(p.u.y * 8.0f) * 8 + static_cast<size_t>(p.u.x * 8.0f);
        seen[cell] += 1.0;
        expected[cell] = kSamples / (64.0 * p.weight);
    }
    for (size_t i = 0; i < 64; ++i) {
        EXPECT_NEAR(seen[i], expected[i], 0.02 * expected[i] + 4.0) << i;
    }
}

TEST(Guide, ThatLearnedNothingIsUniform) {
    for (const Guide& guide : {Guide(), Guide(4, std::vector<float>(16, 0.0f))}) {
        const GuidedPoint p = guide.warp(vec2(0.3f, 0.9f));
        EXPECT_EQ(p.u, vec2(0.3f, 0.9f));
        EXPECT_EQ(p.weight, 1.0f);
    }
    EXPECT_THROW(Guide(3, std::vector<float>(9, 1.0f)), std::logic_error);
    EXPECT_THROW(Guide(4, std::vector<float>(9, 1.0f)), std::logic_error);
}

}  // namespace
}  // namespace sheen
