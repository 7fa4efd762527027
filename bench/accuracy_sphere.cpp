#include "accuracy_sphere.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>

#include "core/error.h"
#include "core/parallel.h"
#include "sh/brdf_sh.h"
#include "sh/projection.h"

namespace sheen::bench {
namespace {

constexpr int kCount = shared::SH_MAX_COEFFICIENTS;
constexpr int kBandHeights = 24;  // pieces of a band between the horizon and its lower end
constexpr int kBandAzimuths = 4;  // pieces of a texel's part of it
constexpr int kRingHeights = 16;  // directions that dering() looks in
constexpr int kRingAzimuths = 40;

vec3 sphereDirection(float z, float phi) {
    const float s = std::sqrt(std::max(0.0f, 1.0f - z * z));
    return {s * std::cos(phi), s * std::sin(phi), z};
}

// Shifted Legendre functions are those of the direction whose height runs from -1 to 1. [GKPB04]
shared::ShVector hemisphericalBasis(const vec3& d) {
    shared::ShVector y = shared::shBasis(sphereDirection(2.0f * d.z - 1.0f, std::atan2(d.y, d.x)),
                                         shared::SH_MAX_ORDER);
    for (float& c : y.c) {
        c *= std::sqrt(2.0f);
    }
    return y;
}

shared::ShVector basis(const vec3& d) { return shared::shBasis(d, shared::SH_MAX_ORDER); }

void add(Coefficients& sum, const shared::ShVector& y, float weight) {
    for (int k = 0; k < kCount; ++k) {
        sum.c[k] += weight * y.c[k];
    }
}

// Adds weight * Y Y^T to a symmetric matrix's lower half.
void addOuter(std::vector<double>& gram, const shared::ShVector& y, double weight) {
    for (int a = 0; a < kCount; ++a) {
        for (int b = 0; b <= a; ++b) {
            gram[static_cast<size_t>(a * kCount + b)] += weight * y.c[a] * y.c[b];
        }
    }
}

// Solves normal equations whose inverse is known.
void fit(const std::vector<double>& inverse, int order, const Projection& projection,
         const Sphere::Moments& moments, Coefficients& c) {
    const int count = order * order;
    for (int a = 0; a < count; ++a) {
        double sum = 0.0;
        for (int b = 0; b < count; ++b) {
            sum += inverse[static_cast<size_t>(a * count + b)] *
                   (static_cast<double>(moments.upper.c[b]) +
                    projection.weight * moments.bands[projection.band].c[b]);
        }
        c.c[a] = static_cast<float>(sum);
    }
}

}  // namespace

std::vector<Pixel> allPixels() {
    std::vector<Pixel> pixels;
    for (int alpha = 0; alpha < kAlphaCount; ++alpha) {
        for (int view = 0; view < kViewCount; ++view) {
            for (int t = 0; t < kTilts; ++t) {
                const int tilt = (t + kTiltAzimuths - 1) / kTiltAzimuths;
                const float azimuth =
                    t == 0 ? 0.0f : 0.5f * kPi * static_cast<float>((t - 1) % kTiltAzimuths);
                const float angle = glm::radians(kTiltDegrees[tilt]);
                const vec3 n = sphereDirection(std::cos(angle), azimuth);
                const vec3 side = glm::normalize(vec3(1, 0, 0) - n.x * n);
                const float theta = glm::radians(kViewDegrees[view]);
                pixels.push_back(
                    {alpha, view, tilt, n, std::cos(theta) * n + std::sin(theta) * side});
            }
        }
    }
    return pixels;
}

std::vector<Projection> allProjections() {
    return {{"zero below the horizon", Way::kZero},
            {"even reflection", Way::kEven},
            {"least squares, no band", Way::kFit, 1, 0.0f, 1e-4f},
            {"**least squares with a band, the program's**", Way::kProgram},
            {"the same, finer quadrature", Way::kFit, 1, 0.1f, 1e-4f},
            {"band to -15 degrees", Way::kFit, 0, 0.1f, 1e-4f},
            {"band to -15 degrees, weight 0.03", Way::kFit, 0, 0.03f, 1e-4f},
            {"band to -15 degrees, weight 0.3", Way::kFit, 0, 0.3f, 1e-4f},
            {"band to -45 degrees", Way::kFit, 2, 0.1f, 1e-4f},
            {"weight 0.03", Way::kFit, 1, 0.03f, 1e-4f},
            {"weight 0.3", Way::kFit, 1, 0.3f, 1e-4f},
            {"ridge 1e-5", Way::kFit, 1, 0.1f, 1e-5f},
            {"ridge 1e-3", Way::kFit, 1, 0.1f, 1e-3f},
            {"ridge 1e-2", Way::kFit, 1, 0.1f, 1e-2f},
            {"hemispherical harmonics", Way::kHemispherical},
            {"the program's, stored in 16 bits", Way::kHalf},
            {"the program's, times its tabulated lobes", Way::kTable},
            {"deringed by damping bands", Way::kDamped},
            {"deringed by a smoother fit", Way::kSmoothed}};
}

Sphere::Sphere(int size)
    : upper_(makeHemisphere({HemisphereKind::kHemicube, size, 1.0f})), pixels_(allPixels()) {
    for (int t = 0; t < upper_.texelCount(); ++t) {
        footprints_.push_back(footprint(upper_, t));
    }
    integrateBasis();
    integrateLobes();
    invertFits();
    for (int order = kMinOrder; order <= shared::SH_MAX_ORDER; ++order) {
        program_[order - kMinOrder] = projectionMatrix(upper_, {.order = order});
    }
    for (int i = 0; i < kRingHeights; ++i) {
        for (int j = 0; j < kRingAzimuths; ++j) {
            const vec3 d = sphereDirection((static_cast<float>(i) + 0.5f) / kRingHeights,
                                           2.0f * kPi * static_cast<float>(j) / kRingAzimuths);
            add(directions_.emplace_back(), basis(d), 1.0f);
        }
    }
}

void Sphere::integrateBasis() {
    const auto texels = static_cast<size_t>(upper_.texelCount());
    basis_.resize(kCount * texels);
    hemispherical_.resize(kCount * texels);
    for (auto& band : bands_) {
        band.resize(kCount * texels);
    }
    parallelFor(upper_.texelCount(), [&](int texel) {
        const auto t = static_cast<size_t>(texel);
        Coefficients y, h;
        for (const FootprintSample& s : footprints_[t]) {
            add(y, basis(s.direction), s.solid_angle);
            add(h, hemisphericalBasis(s.direction), s.solid_angle);
        }
        Coefficients below[kBands];
        for (int band = 0; band < kBands && upper_.at_horizon[t] != 0; ++band) {
            const vec2 az = upper_.azimuths[t];
            const float lowest = -std::sin(glm::radians(kBandDegrees[band]));
            const float dz = -lowest / kBandHeights;
            const float dphi = (az.y - az.x) / kBandAzimuths;
            for (int i = 0; i < kBandHeights * kBandAzimuths; ++i) {
                const float z = lowest + (static_cast<float>(i / kBandAzimuths) + 0.5f) * dz;
                const float phi = az.x + (static_cast<float>(i % kBandAzimuths) + 0.5f) * dphi;
                add(below[band], basis(sphereDirection(z, phi)), dz * dphi);
            }
        }
        for (size_t k = 0; k < kCount; ++k) {
            basis_[k * texels + t] = y.c[k];
            hemispherical_[k * texels + t] = h.c[k];
            for (int band = 0; band < kBands; ++band) {
                bands_[band][k * texels + t] = below[band].c[k];
            }
        }
    });
}

void Sphere::integrateLobes() {
    const auto texels = static_cast<size_t>(upper_.texelCount());
    const size_t count = pixels_.size();
    lobes_upper_.resize(count * texels);
    lobes_lower_.resize(count * texels);
    albedos_.resize(count);
    lobe_sh_.resize(count);
    lobe_hemispherical_.resize(count);
    lobe_table_.resize(count);
    // The basis at every sample once; lobes reuse it.
    std::vector<shared::ShVector> up, down, hemispherical;
    for (const auto& samples : footprints_) {
        for (const FootprintSample& s : samples) {
            up.push_back(basis(s.direction));
            down.push_back(basis(s.direction * vec3(1, 1, -1)));
            hemispherical.push_back(hemisphericalBasis(s.direction));
        }
    }
    const BrdfRotator rotator(shared::SH_MAX_ORDER);
    parallelFor(static_cast<int>(count), [&](int index) {
        const auto p = static_cast<size_t>(index);
        const Pixel& pixel = pixels_[p];
        const float alpha = kAlphas[pixel.alpha];
        double albedo = 0.0;
        size_t sample = 0;
        for (size_t t = 0; t < texels; ++t) {
            for (const FootprintSample& s : footprints_[t]) {
                const float above =
                    s.solid_angle * metalLobe(alpha, pixel.n, pixel.wo, s.direction);
                const float below = s.solid_angle * metalLobe(alpha, pixel.n, pixel.wo,
                                                              s.direction * vec3(1, 1, -1));
                lobes_upper_[p * texels + t] += above;
                lobes_lower_[p * texels + t] += below;
                albedo += above + below;
                if (above > 0.0f) {
                    add(lobe_sh_[p], up[sample], above);
                    add(lobe_hemispherical_[p], hemispherical[sample], above);
                }
                if (below > 0.0f) {
                    add(lobe_sh_[p], down[sample], below);
                }
                ++sample;
            }
        }
        albedos_[p] = static_cast<float>(albedo);
        const float NoV = glm::dot(pixel.n, pixel.wo);
        rotator.rotate(brdfSh(NoV, std::sqrt(alpha)), kMetalF0, 1.0f, pixel.n, pixel.wo,
                       lobe_table_[p].c);
    });
}

void Sphere::invertFits() {
    const size_t entries = static_cast<size_t>(kCount) * kCount;
    std::vector<double> upper(entries);
    for (const auto& samples : footprints_) {
        for (const FootprintSample& s : samples) {
            addOuter(upper, basis(s.direction), s.solid_angle);
        }
    }
    std::vector<double> below[kBands];
    for (int band = 0; band < kBands; ++band) {
        below[band].resize(entries);
        constexpr int kAzimuths = 64;
        const float depth = std::sin(glm::radians(kBandDegrees[band]));
        for (int i = 0; i < kBandHeights * kAzimuths; ++i) {
            const float z = -depth * (static_cast<float>(i / kAzimuths) + 0.5f) / kBandHeights;
            const float phi = 2.0f * kPi * (static_cast<float>(i % kAzimuths) + 0.5f) / kAzimuths;
            addOuter(below[band], basis(sphereDirection(z, phi)),
                     depth / kBandHeights * 2.0 * kPi / kAzimuths);
        }
    }
    // The normal equations of an order: [coefficient][coefficient], with a penalty by band.
    const auto invert = [&](int order, float weight, int band, const auto& penalty) {
        const int n = order * order;
        std::vector<double> gram(static_cast<size_t>(n) * n);
        std::vector<double> inverse(gram.size());
        for (int l = 0; l < order; ++l) {
            for (int a = l * l; a < (l + 1) * (l + 1); ++a) {
                for (int b = 0; b < n; ++b) {
                    const auto from = static_cast<size_t>(std::max(a, b) * kCount + std::min(a, b));
                    gram[static_cast<size_t>(a * n + b)] = upper[from] + weight * below[band][from];
                }
                gram[static_cast<size_t>(a * n + a)] += penalty(l);
                inverse[static_cast<size_t>(a * n + a)] = 1.0;
            }
        }
        solveSpd(n, gram, inverse, n);
        return inverse;
    };
    const std::vector<Projection> projections = allProjections();
    SHEEN_CHECK(projections.size() <= kMaxProjections);
    for (size_t p = 0; p < projections.size(); ++p) {
        const Projection& projection = projections[p];
        for (int order = kMinOrder; order <= shared::SH_MAX_ORDER; ++order) {
            const auto ridge = [&](int l) { return l > 0 ? projection.ridge : 0.0f; };
            inverses_[p][order - kMinOrder] =
                invert(order, projection.weight, projection.band, ridge);
        }
    }
    const Projection program;  // its parameters are the defaults
    for (int step = 0; step < kSmoothSteps; ++step) {
        const double t = 1e-8 * std::pow(4.0, step);
        for (int order = kMinOrder; order <= shared::SH_MAX_ORDER; ++order) {
            const auto roughness = [&](int l) {
                const double laplacian = l * (l + 1.0);
                return (l > 0 ? program.ridge : 0.0) + t * laplacian * laplacian;
            };
            smoother_[step][order - kMinOrder] =
                invert(order, program.weight, program.band, roughness);
        }
    }
}

float Sphere::outgoing(int pixel, const SphereImage& image) const {
    const size_t texels = image.upper.size();
    const size_t first = static_cast<size_t>(pixel) * texels;
    const float above = dotProduct(&lobes_upper_[first], image.upper.data(), texels);
    return image.lower.empty()
               ? above
               : above + dotProduct(&lobes_lower_[first], image.lower.data(), texels);
}

Sphere::Moments Sphere::moments(const SphereImage& image) const {
    const size_t texels = image.upper.size();
    Moments m;
    for (size_t k = 0; k < kCount; ++k) {
        m.upper.c[k] = dotProduct(&basis_[k * texels], image.upper.data(), texels);
        m.hemispherical.c[k] = dotProduct(&hemispherical_[k * texels], image.upper.data(), texels);
        for (int band = 0; band < kBands; ++band) {
            m.bands[band].c[k] = dotProduct(&bands_[band][k * texels], image.upper.data(), texels);
        }
    }
    for (int order = kMinOrder; order <= shared::SH_MAX_ORDER; ++order) {
        for (size_t k = 0; k < static_cast<size_t>(order * order); ++k) {
            m.program[order - kMinOrder].c[k] =
                dotProduct(&program_[order - kMinOrder][k * texels], image.upper.data(), texels);
        }
    }
    return m;
}

Coefficients Sphere::project(const Projection& projection, size_t index, int order,
                             const Moments& moments) const {
    Coefficients c = moments.program[order - kMinOrder];
    switch (projection.way) {
        case Way::kProgram:
        case Way::kTable:
            break;
        case Way::kZero:
        case Way::kEven:
            for (int l = 0; l < order; ++l) {
                for (int m = -l; m <= l; ++m) {
                    const int k = shared::shIndex(l, m);
                    const float mirrored = (l + m) % 2 != 0 ? 0.0f : 2.0f;
                    c.c[k] = moments.upper.c[k] * (projection.way == Way::kEven ? mirrored : 1.0f);
                }
            }
            break;
        case Way::kHemispherical:
            c = moments.hemispherical;
            break;
        case Way::kFit:
            fit(inverses_[index][order - kMinOrder], order, projection, moments, c);
            break;
        case Way::kHalf:
            for (float& value : c.c) {
                value = glm::unpackHalf1x16(glm::packHalf1x16(value));
            }
            break;
        case Way::kDamped:
            damp(order, c);
            break;
        case Way::kSmoothed:
            smooth(order, moments, c);
            break;
    }
    return c;
}

const Coefficients& Sphere::lobe(const Projection& projection, int pixel) const {
    const auto p = static_cast<size_t>(pixel);
    return projection.way == Way::kHemispherical ? lobe_hemispherical_[p]
           : projection.way == Way::kTable       ? lobe_table_[p]
                                                 : lobe_sh_[p];
}

bool Sphere::negative(int order, const Coefficients& c) const {
    return std::any_of(directions_.begin(), directions_.end(), [&](const Coefficients& y) {
        return dotProduct(y.c, c.c, static_cast<size_t>(order * order)) < 0.0f;
    });
}

// Multiplies bands by the least 1 / (1 + t l^2 (l + 1)^2) that leaves nothing negative. [Slo08]
void Sphere::damp(int order, Coefficients& c) const {
    if (!negative(order, c)) {
        return;
    }
    const auto damped = [&](float t) {
        Coefficients d;
        for (int l = 0; l < order; ++l) {
            const auto laplacian = static_cast<float>(l * (l + 1));
            for (int k = l * l; k < (l + 1) * (l + 1); ++k) {
                d.c[k] = c.c[k] / (1.0f + t * laplacian * laplacian);
            }
        }
        return d;
    };
    // Bisect the logarithm.
    float low = -16.0f;
    float high = 2.0f;
    for (int i = 0; i < 8; ++i) {
        const float middle = 0.5f * (low + high);
        (negative(order, damped(std::exp(middle))) ? low : high) = middle;
    }
    c = damped(std::exp(high));
}

// Fits again with the least penalty on l^2 (l + 1)^2 that leaves nothing negative.
void Sphere::smooth(int order, const Moments& moments, Coefficients& c) const {
    for (int step = 0; step < kSmoothSteps && negative(order, c); ++step) {
        fit(smoother_[step][order - kMinOrder], order, {}, moments, c);
    }
}

}  // namespace sheen::bench
