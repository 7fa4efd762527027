// What the studies of the accuracy bench share, and the stage benchmarks in part: scenes and the
// points judged in them, radiance images by rays, errors, and tables.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gather/integrate.h"
#include "hemisphere/hemisphere.h"
#include "light/scattered_once.h"
#include "record/record.h"
#include "scene/scene.h"

namespace sheen::bench {

/// A scene, its rays, and the points of its surfaces where approximations are judged.
struct BenchScene {
    BenchScene(const std::string& scene_name, Scene made, int site_count);
    BenchScene(const BenchScene&) = delete;

    std::string name;
    Scene scene;
    Tracer tracer;
    ScatteredOnce light;  ///< every hit lit by itself
    /// Visible points: Owen-scrambled Sobol points over the square images of the scene's cameras,
    /// as many of each camera.
    std::vector<RecordSite> sites;
};
using BenchScenes = std::vector<std::unique_ptr<BenchScene>>;
BenchScenes loadBenchScenes(const std::string& folder, const std::vector<std::string>& names,
                            int sites_per_scene);

/// A study's way to write: `folder`/NAME.csv for plots, `folder`/NAME.md for the page.
struct Output {
    std::string folder;

    void write(const std::string& file, const std::string& text) const;
};

/// A Markdown table that grows row by row.
class Table {
  public:
    explicit Table(const std::vector<std::string>& head);
    void add(const std::vector<std::string>& row);
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};
/// A share as a percentage, three significant digits at most.
std::string percent(double share);

/// How texels are looked at.
struct TexelRays {
    int side = 1;         ///< side * side rays a texel
    bool random = false;  ///< through random places of its parts; else through their middles
    uint32_t seed = 0;
    bool mirrored = false;  ///< the hemisphere below the horizon
    vec3 above{0.0f};       ///< world space: directions below the plane of this normal are black
    float lowest = -1.0f;   ///< directions below this height, in the local frame, are black
};
/// What a hemisphere's texels see, turned to world space by `frame`: mean radiance, harmonic mean
/// distance, the plane that the first ray meets.
SeenTexels traceTexels(const OutgoingLight& light, const Hemisphere& hemisphere, const mat3& frame,
                       const vec3& eye, const TexelRays& how);

/// Mean of the channels: what the studies judge.
inline float grey(const vec3& c) { return (c.x + c.y + c.z) / 3.0f; }
inline float grey(const vec4& c) { return grey(vec3(c)); }

/// The lobe that glossy studies convolve with: GGX of a grey metal, F0 = 0.8, times the cosine.
constexpr float kMetalF0 = 0.8f;
float metalLobe(float alpha, const vec3& n, const vec3& wo, const vec3& wi);

/// Errors of estimates of positive values; the truth's noise is taken off the mean squares.
struct Errors {
    double rel_rmse = 0;   ///< RMS error over the mean of the truth, as `sheen compare` counts
    double bias = 0;       ///< mean error over the same
    double point_rms = 0;  ///< RMS of error / (truth + 1% of its mean), point by point
    double noise = 0;      ///< RMS noise of the truth over its mean
};
/// `variance`: of each truth's mean.
Errors errorsOf(std::span<const float> estimate, std::span<const float> truth,
                std::span<const float> variance);
/// Root of the mean square.
double rms(std::span<const double> values);

}  // namespace sheen::bench
