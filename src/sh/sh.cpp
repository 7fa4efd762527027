#include "sh/sh.h"

#include <cmath>

#include "core/error.h"

namespace sheen {
namespace {

constexpr int kMaxBandSize = 2 * shared::SH_MAX_ORDER - 1;
constexpr int kDirections = 2 * kMaxBandSize;  // twice as many as needed, for a good condition

// Directions spread evenly over the sphere: a Fibonacci spiral, over one hemisphere because the
// antipode of a direction says nothing new about a single band.
std::vector<vec3> spreadDirections() {
    std::vector<vec3> directions;
    const float golden = kPi * (3.0f - std::sqrt(5.0f));
    for (int i = 0; i < kDirections; ++i) {
        const float z = (static_cast<float>(i) + 0.5f) / kDirections;
        const float r = std::sqrt(1.0f - z * z);
        const float phi = golden * static_cast<float>(i);
        directions.emplace_back(r * std::cos(phi), r * std::sin(phi), z);
    }
    return directions;
}

// For each band, the matrix that turns values at the directions into coefficients:
// (Y Y^T)^-1 Y with Y [coefficient][direction].
struct BandFits {
    std::vector<vec3> directions = spreadDirections();
    std::vector<float> fit[shared::SH_MAX_ORDER];  // [coefficient][direction]
    std::vector<float> basis;                      // [direction][SH_MAX_COEFFICIENTS]

    BandFits() {
        for (const vec3& d : directions) {
            const shared::ShVector y = shared::shBasis(d, shared::SH_MAX_ORDER);
            basis.insert(basis.end(), y.c, y.c + shared::SH_MAX_COEFFICIENTS);
        }
        for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
            const int size = 2 * l + 1;
            std::vector<double> gram(static_cast<size_t>(size) * size);
            std::vector<double> rhs(static_cast<size_t>(size) * kDirections);
            for (int i = 0; i < size; ++i) {
                for (int j = 0; j < size; ++j) {
                    for (int d = 0; d < kDirections; ++d) {
                        gram[static_cast<size_t>(i) * size + j] += at(d, l, i) * at(d, l, j);
                    }
                }
                for (int d = 0; d < kDirections; ++d) {
                    rhs[static_cast<size_t>(i) * kDirections + d] = at(d, l, i);
                }
            }
            solveSpd(size, gram, rhs, kDirections);
            fit[l].assign(rhs.begin(), rhs.end());
        }
    }
    double at(int direction, int l, int i) const {
        return basis[static_cast<size_t>(direction) * shared::SH_MAX_COEFFICIENTS + l * l + i];
    }
};

const BandFits& bandFits() {
    static const BandFits fits;
    return fits;
}

}  // namespace

ShRotation::ShRotation(const mat3& rotation, int order) : order_(order) {
    SHEEN_CHECK(order >= 1 && order <= shared::SH_MAX_ORDER);
    const BandFits& fits = bandFits();
    // f'(w) = f(R^-1 w), so the value of f' at w_i is f's basis at R^-1 w_i.
    const mat3 inverse = glm::transpose(rotation);
    std::vector<shared::ShVector> turned;
    for (const vec3& d : fits.directions) {
        turned.push_back(shared::shBasis(inverse * d, order));
    }
    for (int l = 0; l < order; ++l) {
        const int size = 2 * l + 1;
        const size_t first = matrices_.size();
        matrices_.resize(first + static_cast<size_t>(size) * size);
        // Only as many directions as a well-conditioned fit of this band needs would do; all of
        // them cost little and keep the fit the same for every order.
        for (int i = 0; i < size; ++i) {
            for (int d = 0; d < kDirections; ++d) {
                const float weight = fits.fit[l][static_cast<size_t>(i) * kDirections + d];
                for (int j = 0; j < size; ++j) {
                    matrices_[first + static_cast<size_t>(i) * size + j] +=
                        weight * turned[static_cast<size_t>(d)].c[l * l + j];
                }
            }
        }
    }
}

void ShRotation::apply(const float* in, float* out) const {
    size_t first = 0;
    for (int l = 0; l < order_; ++l) {
        const int size = 2 * l + 1;
        for (int i = 0; i < size; ++i) {
            float sum = 0.0f;
            for (int j = 0; j < size; ++j) {
                sum += matrices_[first + static_cast<size_t>(i) * size + j] * in[l * l + j];
            }
            out[l * l + i] = sum;
        }
        first += static_cast<size_t>(size) * size;
    }
}

void solveSpd(int n, std::vector<double> a, std::vector<double>& b, int columns) {
    const auto at = [n, &a](int i, int j) -> double& { return a[static_cast<size_t>(i) * n + j]; };
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < j; ++k) {
            for (int i = j; i < n; ++i) {
                at(i, j) -= at(i, k) * at(j, k);
            }
        }
        SHEEN_CHECK(at(j, j) > 0.0);
        const double root = std::sqrt(at(j, j));
        for (int i = j; i < n; ++i) {
            at(i, j) /= root;
        }
    }
    const auto rhs = [columns, &b](int i) { return &b[static_cast<size_t>(i) * columns]; };
    const auto eliminate = [columns](double* row, const double* other, double factor) {
        for (int c = 0; c < columns; ++c) {
            row[c] -= factor * other[c];
        }
    };
    const auto scale = [columns](double* row, double factor) {
        for (int c = 0; c < columns; ++c) {
            row[c] *= factor;
        }
    };
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < i; ++k) {
            eliminate(rhs(i), rhs(k), at(i, k));
        }
        scale(rhs(i), 1.0 / at(i, i));
    }
    for (int i = n - 1; i >= 0; --i) {
        for (int k = i + 1; k < n; ++k) {
            eliminate(rhs(i), rhs(k), at(k, i));
        }
        scale(rhs(i), 1.0 / at(i, i));
    }
}

}  // namespace sheen
