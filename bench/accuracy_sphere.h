// The finely divided sphere that the study of projections works on: what of a radiance image gives
// the true outgoing light, and what gives the coefficients of each way to project it. Everything is
// a sum over the image, so that only the projections differ.
#pragma once

#include <string>
#include <vector>

#include "accuracy_sites.h"
#include "hemisphere/hemisphere.h"
#include "sh/sh.h"

namespace sheen::bench {

constexpr int kMinOrder = 3;
constexpr int kOrders = shared::SH_MAX_ORDER - kMinOrder + 1;
constexpr float kAlphas[] = {1.0f, 0.7f, 0.5f, 0.3f, 0.2f, 0.1f};
constexpr int kAlphaCount = 6;
constexpr float kViewDegrees[] = {10.0f, 40.0f, 65.0f, 78.0f};
constexpr int kViewCount = 4;
constexpr float kTiltDegrees[] = {0.0f, 10.0f, 20.0f, 27.0f};
constexpr int kTiltCount = 4;
constexpr int kTiltAzimuths = 3;  // toward the viewer, aside, away
/// Upright, and every tilt at every azimuth.
constexpr int kTilts = 1 + (kTiltCount - 1) * kTiltAzimuths;

/// A pixel: how wide its lobe is, how it is seen, how its normal tilts against the record's.
struct Pixel {
    int alpha = 0;  ///< index
    int view = 0;   ///< index; the angle is to the pixel's own normal
    int tilt = 0;   ///< index of degrees
    vec3 n{};       ///< record's local frame
    vec3 wo{};
};
/// Every combination; pixelIndex(a, v, 0) is upright.
std::vector<Pixel> allPixels();
constexpr int pixelIndex(int alpha, int view, int tilt) {
    return (alpha * kViewCount + view) * kTilts + tilt;
}

/// How coefficients come from the image.
enum class Way {
    kZero,           ///< black below the horizon
    kEven,           ///< the mirror image below the horizon
    kProgram,        ///< projectionMatrix() of src/sh
    kFit,            ///< the same formula with a quadrature of its own, for other parameters
    kHemispherical,  ///< hemispherical harmonics; lobes are cut at the record's horizon
    kHalf,           ///< kProgram stored in 16 bits
    kTable,          ///< kProgram times the program's tabulated lobes
    kDamped,         ///< kProgram, its bands damped where it goes negative
    kSmoothed        ///< kFit, made smoother where it goes negative
};
struct Projection {
    std::string name;
    Way way = Way::kFit;
    int band = 1;  ///< index of kBandDegrees
    float weight = 0.1f;
    float ridge = 1e-4f;
};
constexpr float kBandDegrees[] = {15.0f, 30.0f, 45.0f};
constexpr int kBands = 3;
std::vector<Projection> allProjections();
/// Indices in it.
constexpr int kZeroExtension = 0;
constexpr int kEvenReflection = 1;
constexpr int kProgramFit = 3;
constexpr int kMaxProjections = 20;

/// Grey radiance of both halves of the sphere, texels of Sphere::upper; below its lowest height the
/// lower half is not looked at.
struct SphereImage {
    std::vector<float> upper;
    std::vector<float> lower;
};

struct Coefficients {
    float c[shared::SH_MAX_COEFFICIENTS] = {};
};

class Sphere {
  public:
    explicit Sphere(int size);

    static constexpr int kSmoothSteps = 12;
    /// The lowest direction that a tilted pixel looks in, as a height.
    static constexpr float kLowest = -0.5f;

    const Hemisphere& upper() const { return upper_; }
    const std::vector<Pixel>& pixels() const { return pixels_; }

    /// True outgoing light of a pixel; its response to radiance 1 everywhere.
    float outgoing(int pixel, const SphereImage& image) const;
    float albedo(int pixel) const { return albedos_[static_cast<size_t>(pixel)]; }

    /// What all projections start from: integrals of the image over the hemisphere and the bands.
    struct Moments {
        Coefficients upper;
        Coefficients hemispherical;
        Coefficients bands[kBands];
        Coefficients program[kOrders];
    };
    Moments moments(const SphereImage& image) const;

    /// Coefficients of a projection at an order.
    Coefficients project(const Projection& projection, size_t index, int order,
                         const Moments& moments) const;
    /// The lobe to multiply them with.
    const Coefficients& lobe(const Projection& projection, int pixel) const;

    /// Whether a fit is negative in some direction of the hemisphere.
    bool negative(int order, const Coefficients& c) const;

  private:
    void integrateBasis();
    void integrateLobes();
    void invertFits();
    void damp(int order, Coefficients& c) const;
    void smooth(int order, const Moments& moments, Coefficients& c) const;

    Hemisphere upper_;
    std::vector<Pixel> pixels_;
    std::vector<std::vector<FootprintSample>> footprints_;
    std::vector<float> basis_;          // [coefficient][texel]
    std::vector<float> hemispherical_;  // [coefficient][texel]
    std::vector<float> bands_[kBands];  // [coefficient][texel]
    std::vector<float> lobes_upper_;    // [pixel][texel]
    std::vector<float> lobes_lower_;
    std::vector<float> albedos_;
    std::vector<Coefficients> lobe_sh_, lobe_hemispherical_, lobe_table_;
    using Inverses = std::vector<double>[kOrders];  // [coefficient][coefficient]
    Inverses inverses_[kMaxProjections];            // of the projections' normal equations
    Inverses smoother_[kSmoothSteps];
    std::vector<float> program_[kOrders];   // [coefficient][texel]
    std::vector<Coefficients> directions_;  // the basis where negative() looks
};

}  // namespace sheen::bench
