#include "sh/projection.h"

#include <cmath>
#include <span>

#include "core/error.h"

namespace sheen {
namespace {

constexpr int kBandHeights = 8;   // pieces of the band between the horizon and its lower end
constexpr int kBandAzimuths = 2;  // pieces of a texel's part of it
constexpr int kGramHeights = 64;  // quadrature of the normal equations
// Products of two functions have frequencies below 2 SH_MAX_ORDER - 1 around the normal, whose sums
// over so many even steps are exact.
constexpr int kGramAzimuths = 2 * shared::SH_MAX_ORDER;

// Adds weight * Y(d) to one column of the right-hand side [coefficient][texel].
void addBasis(const vec3& d, float weight, int order, int texel, int texels,
              std::vector<double>& rhs) {
    const shared::ShVector y = shared::shBasis(d, order);
    for (int k = 0; k < order * order; ++k) {
        rhs[static_cast<size_t>(k) * texels + texel] += static_cast<double>(weight) * y.c[k];
    }
}

vec3 sphereDirection(float z, float phi) {
    const float s = std::sqrt(std::max(0.0f, 1.0f - z * z));
    return {s * std::cos(phi), s * std::sin(phi), z};
}

// Weighted inner products of the basis over z in [-sin(band), 1], plus the ridge.
std::vector<double> gramMatrix(const ProjectionParams& p) {
    const int count = p.order * p.order;
    std::vector<double> gram(static_cast<size_t>(count) * count);
    const float lowest = -std::sin(glm::radians(p.band_degrees));
    const auto integrate = [&](float z0, float z1, float weight, int heights) {
        for (int i = 0; i < heights; ++i) {
            const float z = z0 + (z1 - z0) * (static_cast<float>(i) + 0.5f) / heights;
            for (int j = 0; j < kGramAzimuths; ++j) {
                const float phi = 2.0f * kPi * (static_cast<float>(j) + 0.5f) / kGramAzimuths;
                const shared::ShVector y = shared::shBasis(sphereDirection(z, phi), p.order);
                const double w = weight * (z1 - z0) / heights * 2.0f * kPi / kGramAzimuths;
                for (int a = 0; a < count; ++a) {
                    for (int b = 0; b <= a; ++b) {
                        gram[static_cast<size_t>(a) * count + b] += w * y.c[a] * y.c[b];
                    }
                }
            }
        }
    };
    integrate(0.0f, 1.0f, 1.0f, kGramHeights);
    integrate(lowest, 0.0f, p.band_weight, kGramHeights / 2);
    for (int a = 0; a < count; ++a) {
        for (int b = a + 1; b < count; ++b) {
            gram[static_cast<size_t>(a) * count + b] = gram[static_cast<size_t>(b) * count + a];
        }
        if (a > 0) {
            gram[static_cast<size_t>(a) * count + a] += p.ridge;
        }
    }
    return gram;
}

// What quadratures leave of the response to constant light, which is to be `wanted`, is taken out
// in proportion to the texels' solid angles.
void makeConstantExact(const Hemisphere& hemisphere, std::span<const double> wanted,
                       std::vector<double>& matrix) {
    const auto texels = static_cast<size_t>(hemisphere.texelCount());
    for (size_t k = 0; k < wanted.size(); ++k) {
        double* row = &matrix[k * texels];
        double response = 0.0;
        for (size_t t = 0; t < texels; ++t) {
            response += row[t];
        }
        for (size_t t = 0; t < texels; ++t) {
            row[t] += (wanted[k] - response) * hemisphere.solid_angles[t] / (2.0 * kPi);
        }
    }
}

// The integral of the basis over the upper hemisphere: with m = 0 that of a Legendre polynomial,
// (P_l-1(0) - P_l+1(0)) / (2 l + 1) over z in [0, 1]; with others zero.
std::vector<double> hemisphereIntegrals(int order) {
    const auto size = static_cast<size_t>(order);
    std::vector<double> at_zero(size + 1, 0.0);  // P_l(0)
    at_zero[0] = 1.0;
    for (size_t l = 1; l < size; ++l) {
        at_zero[l + 1] = -static_cast<double>(l) / static_cast<double>(l + 1) * at_zero[l - 1];
    }
    std::vector<double> integrals(size * size, 0.0);
    for (size_t l = 0; l < size; ++l) {
        const auto width = static_cast<double>(2 * l + 1);
        const double legendre = l == 0 ? 1.0 : (at_zero[l - 1] - at_zero[l + 1]) / width;
        integrals[l * (l + 1)] = std::sqrt(kPi * width) * legendre;
    }
    return integrals;
}

}  // namespace

std::vector<float> projectionMatrix(const Hemisphere& hemisphere, const ProjectionParams& params) {
    SHEEN_CHECK(params.order >= 1 && params.order <= shared::SH_MAX_ORDER);
    const int count = params.order * params.order;
    const int texels = hemisphere.texelCount();
    std::vector<double> rhs(static_cast<size_t>(count) * texels);
    const float lowest = -std::sin(glm::radians(params.band_degrees));
    for (int texel = 0; texel < texels; ++texel) {
        for (const FootprintSample& s : footprint(hemisphere, texel)) {
            addBasis(s.direction, s.solid_angle, params.order, texel, texels, rhs);
        }
        if (hemisphere.at_horizon[static_cast<size_t>(texel)] == 0) {
            continue;
        }
        // The texel is the horizon's radiance over its azimuths.
        const vec2 az = hemisphere.azimuths[static_cast<size_t>(texel)];
        const float dphi = (az.y - az.x) / kBandAzimuths;
        const float dz = -lowest / kBandHeights;
        for (int i = 0; i < kBandHeights; ++i) {
            for (int j = 0; j < kBandAzimuths; ++j) {
                const vec3 d = sphereDirection(lowest + (static_cast<float>(i) + 0.5f) * dz,
                                               az.x + (static_cast<float>(j) + 0.5f) * dphi);
                addBasis(d, params.band_weight * dz * dphi, params.order, texel, texels, rhs);
            }
        }
    }
    solveSpd(count, gramMatrix(params), rhs, texels);
    if (hemisphere.params.kind == HemisphereKind::kBorder ||
        hemisphere.params.kind == HemisphereKind::kHemicube) {
        // The footprints and the normal equations are integrated by different quadratures.
        std::vector<double> wanted(static_cast<size_t>(count), 0.0);
        wanted[0] = std::sqrt(4.0 * kPi);
        makeConstantExact(hemisphere, wanted, rhs);
    }
    return {rhs.begin(), rhs.end()};
}

std::vector<float> integralMatrix(const Hemisphere& hemisphere, int order) {
    SHEEN_CHECK(order >= 1 && order <= shared::SH_MAX_ORDER);
    const int texels = hemisphere.texelCount();
    std::vector<double> matrix(static_cast<size_t>(order * order) * static_cast<size_t>(texels));
    for (int texel = 0; texel < texels; ++texel) {
        for (const FootprintSample& s : footprint(hemisphere, texel)) {
            addBasis(s.direction, s.solid_angle, order, texel, texels, matrix);
        }
    }
    makeConstantExact(hemisphere, hemisphereIntegrals(order), matrix);
    return {matrix.begin(), matrix.end()};
}

}  // namespace sheen
