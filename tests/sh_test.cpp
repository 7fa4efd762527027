// Spherical harmonics: the basis against closed forms and by quadrature, rotation against turned
// arguments, and the solver.
#include "sh/sh.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "test_scenes.h"

namespace sheen {
namespace {

using shared::ShVector;

// Single precision, recurrences of ten steps and values up to about 2.
constexpr double kBasisError = 3e-6;
// The same, summed over a hundred coefficients.
constexpr double kSumError = 3e-5;

// Nodes and weights of Gauss-Legendre quadrature on [-1, 1], exact to degree 2n - 1.
std::vector<std::pair<double, double>> gaussLegendre(int n) {
    std::vector<std::pair<double, double>> nodes;
    for (int i = 0; i < n; ++i) {
        double x = std::cos(M_PI * (i + 0.75) / (n + 0.5));
        double slope = 1.0;
        for (int step = 0; step < 20; ++step) {
            double p0 = 1.0, p1 = x;
            for (int k = 2; k <= n; ++k) {
                const double p2 = ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = n * (x * p1 - p0) / (x * x - 1.0);
            x -= p1 / slope;
        }
        nodes.emplace_back(x, 2.0 / ((1.0 - x * x) * slope * slope));
    }
    return nodes;
}

TEST(ShBasis, BandsZeroToThreeHaveTheirClosedForms) {
    Random random(1);
    for (int i = 0; i < 200; ++i) {
        const vec3 d = i < 2 ? vec3(0, 0, i == 0 ? 1 : -1) : random.direction();
        const double x = d.x, y = d.y, z = d.z;
        const double pi = M_PI;
        // [Slo08, appendix A2], without the Condon-Shortley phase.
        const double expected[16] = {
            std::sqrt(1 / (4 * pi)),
            std::sqrt(3 / (4 * pi)) * y,
            std::sqrt(3 / (4 * pi)) * z,
            std::sqrt(3 / (4 * pi)) * x,
            std::sqrt(15 / (4 * pi)) * x * y,
            std::sqrt(15 / (4 * pi)) * y * z,
            std::sqrt(5 / (16 * pi)) * (3 * z * z - 1),
            std::sqrt(15 / (4 * pi)) * x * z,
            std::sqrt(15 / (16 * pi)) * (x * x - y * y),
            std::sqrt(35 / (32 * pi)) * y * (3 * x * x - y * y),
            std::sqrt(105 / (4 * pi)) * x * y * z,
            std::sqrt(21 / (32 * pi)) * y * (5 * z * z - 1),
            std::sqrt(7 / (16 * pi)) * z * (5 * z * z - 3),
            std::sqrt(21 / (32 * pi)) * x * (5 * z * z - 1),
            std::sqrt(105 / (16 * pi)) * z * (x * x - y * y),
            std::sqrt(35 / (32 * pi)) * x * (x * x - 3 * y * y),
        };
        const ShVector basis = shared::shBasis(d, 4);
        for (int k = 0; k < 16; ++k) {
            EXPECT_NEAR(basis.c[k], expected[k], kBasisError) << "coefficient " << k;
        }
    }
}

TEST(ShBasis, OrthonormalAtOrderTen) {
    constexpr int kOrder = shared::SH_MAX_ORDER;
    constexpr int kCount = kOrder * kOrder;
    constexpr int kAzimuths = 2 * kOrder;  // exact for products: |m| + |m'| <= 18
    std::vector<double> gram(kCount * kCount);
    for (const auto& [z, weight] : gaussLegendre(kOrder)) {
        for (int j = 0; j < kAzimuths; ++j) {
            const double phi = 2.0 * M_PI * (j + 0.3) / kAzimuths;
            const double r = std::sqrt(1.0 - z * z);
            const ShVector y =
                shared::shBasis(vec3(r * std::cos(phi), r * std::sin(phi), z), kOrder);
            for (int a = 0; a < kCount; ++a) {
                for (int b = 0; b < kCount; ++b) {
                    gram[static_cast<size_t>(a * kCount + b)] +=
                        weight * 2.0 * M_PI / kAzimuths * y.c[a] * y.c[b];
                }
            }
        }
    }
    for (int a = 0; a < kCount; ++a) {
        for (int b = 0; b < kCount; ++b) {
            EXPECT_NEAR(gram[static_cast<size_t>(a * kCount + b)], a == b ? 1.0 : 0.0, kSumError)
                << a << " " << b;
        }
    }
}

TEST(ShBasis, AdditionTheoremHoldsToTheTopBandAtThePoles) {
    // sum_m Y_lm^2 = (2 l + 1) / 4 pi everywhere: also where sin(theta) vanishes.
    Random random(2);
    std::vector<vec3> directions = {{0, 0, 1},      {0, 0, -1},     {1, 0, 0},
                                    {1e-20f, 0, 1}, {0, 1e-8f, -1}, {1e-4f, 1e-4f, 1}};
    for (int i = 0; i < 50; ++i) {
        directions.push_back(random.direction());
    }
    for (const vec3& d : directions) {
        const ShVector y = shared::shBasis(glm::normalize(d), shared::SH_MAX_ORDER);
        for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
            double sum = 0.0;
            for (int m = -l; m <= l; ++m) {
                sum += std::pow(y.c[shared::shIndex(l, m)], 2);
            }
            EXPECT_NEAR(sum, (2 * l + 1) / (4.0 * M_PI), kSumError) << "band " << l;
        }
    }
}

TEST(ShBasis, LowerOrdersArePrefixes) {
    const vec3 d = glm::normalize(vec3(0.3f, -0.5f, 0.2f));
    const ShVector all = shared::shBasis(d, shared::SH_MAX_ORDER);
    for (int order = 1; order < shared::SH_MAX_ORDER; ++order) {
        const ShVector some = shared::shBasis(d, order);
        for (int k = 0; k < order * order; ++k) {
            EXPECT_EQ(some.c[k], all.c[k]);
        }
    }
}

double evaluate(const std::vector<float>& c, const vec3& d, int order) {
    const ShVector y = shared::shBasis(d, order);
    double sum = 0.0;
    for (int k = 0; k < order * order; ++k) {
        sum += static_cast<double>(c[static_cast<size_t>(k)]) * y.c[k];
    }
    return sum;
}

std::vector<float> randomCoefficients(Random& random, int order) {
    std::vector<float> c(static_cast<size_t>(order * order));
    for (float& v : c) {
        v = random.uniform(-1.0f, 1.0f);
    }
    return c;
}

std::vector<float> apply(const mat3& rotation, const std::vector<float>& c, int order) {
    std::vector<float> out(c.size());
    ShRotation(rotation, order).apply(c.data(), out.data());
    return out;
}

TEST(ShRotation, RotatedFunctionIsTheFunctionOfTurnedBackDirections) {
    Random random(3);
    for (int order = 1; order <= shared::SH_MAX_ORDER; ++order) {
        for (int trial = 0; trial < 4; ++trial) {
            const mat3 r = random.rotation();
            const std::vector<float> c = randomCoefficients(random, order);
            const std::vector<float> turned = apply(r, c, order);
            for (int i = 0; i < 20; ++i) {
                const vec3 d = random.direction();
                // The sum has order^2 terms of the size of the basis.
                EXPECT_NEAR(evaluate(turned, d, order), evaluate(c, glm::transpose(r) * d, order),
                            kSumError * order)
                    << "order " << order;
            }
        }
    }
}

TEST(ShRotation, InverseUndoesAndLengthIsKept) {
    Random random(4);
    for (int order = 1; order <= shared::SH_MAX_ORDER; ++order) {
        const mat3 r = random.rotation();
        const std::vector<float> c = randomCoefficients(random, order);
        const std::vector<float> turned = apply(r, c, order);
        const std::vector<float> back = apply(glm::transpose(r), turned, order);
        for (int l = 0; l < order; ++l) {
            double before = 0.0, after = 0.0;
            for (auto k = static_cast<size_t>(l * l); k < static_cast<size_t>((l + 1) * (l + 1));
                 ++k) {
                EXPECT_NEAR(back[k], c[k], kSumError) << "order " << order;
                before += std::pow(c[k], 2);
                after += std::pow(turned[k], 2);
            }
            EXPECT_NEAR(after, before, kSumError * (2 * l + 1)) << "band " << l;
        }
    }
}

TEST(ShRotation, IdentityAndHalfTurnsAreExactSigns) {
    Random random(5);
    const int order = shared::SH_MAX_ORDER;
    const std::vector<float> c = randomCoefficients(random, order);
    const std::vector<float> same = apply(mat3(1.0f), c, order);
    // A half turn about z changes the sign of odd m.
    const std::vector<float> half =
        apply(mat3(vec3(-1, 0, 0), vec3(0, -1, 0), vec3(0, 0, 1)), c, order);
    for (int l = 0; l < order; ++l) {
        for (int m = -l; m <= l; ++m) {
            const auto k = static_cast<size_t>(shared::shIndex(l, m));
            EXPECT_NEAR(same[k], c[k], kSumError);
            EXPECT_NEAR(half[k], m % 2 == 0 ? c[k] : -c[k], kSumError);
        }
    }
}

TEST(ShRotation, RefusesOrdersOutOfRange) {
    EXPECT_THROW(ShRotation(mat3(1.0f), 0), std::logic_error);
    EXPECT_THROW(ShRotation(mat3(1.0f), shared::SH_MAX_ORDER + 1), std::logic_error);
}

TEST(SolveSpd, SolvesRandomSystems) {
    Random random(6);
    for (int n : {1, 2, 5, 19, 40}) {
        const int columns = n % 3 + 1;
        const auto size = static_cast<size_t>(n);
        std::vector<double> root(size * size), a(size * size);
        for (double& v : root) {
            v = random.uniform(-1.0f, 1.0f);
        }
        for (size_t i = 0; i < size; ++i) {
            for (size_t j = 0; j < size; ++j) {
                for (size_t k = 0; k < size; ++k) {
                    a[i * size + j] += root[i * size + k] * root[j * size + k];
                }
                a[i * size + j] += i == j ? 0.1 : 0.0;
            }
        }
        std::vector<double> b(size * static_cast<size_t>(columns));
        for (double& v : b) {
            v = random.uniform(-1.0f, 1.0f);
        }
        std::vector<double> x = b;
        solveSpd(n, a, x, columns);
        for (int i = 0; i < n; ++i) {
            for (int c = 0; c < columns; ++c) {
                double sum = 0.0;
                for (int k = 0; k < n; ++k) {
                    sum +=
                        a[static_cast<size_t>(i * n + k)] * x[static_cast<size_t>(k * columns + c)];
                }
                // Double precision times a condition number of at most 1e4 or so.
                EXPECT_NEAR(sum, b[static_cast<size_t>(i * columns + c)], 1e-10);
            }
        }
    }
}

TEST(SolveSpd, RefusesWhatIsNotPositiveDefinite) {
    std::vector<double> b = {1.0, 1.0};
    EXPECT_THROW(solveSpd(2, {1.0, 2.0, 2.0, 1.0}, b, 1), std::logic_error);
    EXPECT_THROW(solveSpd(2, {0.0, 0.0, 0.0, 1.0}, b, 1), std::logic_error);
    EXPECT_THROW(solveSpd(1, {std::nan("")}, b, 1), std::logic_error);
}

}  // namespace
}  // namespace sheen
