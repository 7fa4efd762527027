// Translation gradients against finite differences of converged rays, and what they are worth at a
// distance from the record.
#pragma once

#include <array>
#include <vector>

#include "accuracy_sites.h"
#include "sh/sh.h"

namespace sheen::bench {

/// Writes gradients*.csv and the tables gradients*.md.
void studyGradients(const BenchScenes& scenes, int sites, const Output& output);

namespace gradients {

constexpr int kOrder = shared::SH_MAX_ORDER;
constexpr int kCount = kOrder * kOrder;
constexpr int kBands = 6;  // bands 0 to 5 are judged
constexpr int kJudged = kBands * kBands;
// Finite differences: half their length in harmonic mean distances, which near occluders forbid to
// be longer, and the root of their rays a texel.
constexpr float kStep = 0.02f;
constexpr int kStepRays = 3;
constexpr float kMove = 0.25f;  // where predictions are judged
constexpr float kNear = 0.4f;   // a surface nearer than this is a corner or an occluder
constexpr float kEdge = 1.0f;   // radians of depth steps that make an occluder
constexpr float kDepthStep = 2.0f;
constexpr float kFlat = 0.995f;  // least cosine between the site's two normals
constexpr float kAlpha = 0.3f;
constexpr float kViewDegrees[] = {10.0f, 40.0f, 65.0f};
constexpr int kViews = 3;
constexpr int kAzimuths = 4;
constexpr int kLobes = kViews * kAzimuths;

enum Class { kOpen, kCorner, kOccluder, kClasses };
constexpr const char* kClassNames[] = {"open", "corner", "beside an occluder"};

// What the program turns texels into.
struct Layout {
    std::string name;
    HemisphereParams params;
    bool random;
    bool planes;  ///< whether walls lie where the planes seen say; else at the nearer texel
};
const Layout kLayouts[] = {
    {"border, h = 3, 32", {HemisphereKind::kBorder, 32, 3.0f}, false, false},
    {"border, h = 3, 64", {HemisphereKind::kBorder, 64, 3.0f}, false, false},
    {"hemicube 32, middles", {HemisphereKind::kHemicube, 32, 1.0f}, false, false},
    {"hemicube 64, middles", {HemisphereKind::kHemicube, 64, 1.0f}, false, false},
    {"hemicube 20, random", {HemisphereKind::kHemicube, 20, 1.0f}, true, false},
    {"hemicube 64, random", {HemisphereKind::kHemicube, 64, 1.0f}, true, false},
    {"hemicube 20, random, planes", {HemisphereKind::kHemicube, 20, 1.0f}, true, true},
    {"hemicube 64, random, planes", {HemisphereKind::kHemicube, 64, 1.0f}, true, true},
};
constexpr size_t kLayoutCount = std::size(kLayouts);
constexpr size_t kProgramLayout = 6;

// Grey irradiance and coefficients in the local frame, or their change along one axis.
struct Light {
    float irradiance = 0.0f;
    std::array<float, kCount> c{};                    // of the fit of order 10
    std::array<float, kJudged> own[kBands + 1] = {};  // [n]: of a fit of order n, gradients only
};
using Gradient = std::array<Light, 2>;

// Where a prediction's gradients come from: the first bands of the gradient of order 10, as the
// program has it, or the gradient fitted in that many bands alone; the same of the true change.
enum Source { kFirstBands, kOwnFit, kTrueFirstBands, kTrueOwnFit, kSources };
constexpr const char* kSourceNames[] = {"first bands of order 10",
                                        "fitted in these bands alone (the program's, 3)",
                                        "true, first bands", "true, fitted in these bands"};

// Everything measured at a site, in units of irradiance and harmonic mean distance.
struct Judgement {
    Class kind = kOpen;
    size_t scene = 0;
    Gradient truth, half_difference;  // of two independent estimates
    Gradient program[kLayoutCount];
    // Outgoing light of each lobe at each moved point: true, and predicted with the gradients of n
    // bands.
    struct Moved {
        float truth[kLobes];
        float predicted[kSources][kBands + 1][kLobes];
    };
    std::vector<Moved> moved;
};

/// The study's last step.
void report(const std::vector<Judgement>& judgements, const BenchScenes& scenes,
            const Output& output);

}  // namespace gradients
}  // namespace sheen::bench
