// What projection onto spherical harmonics loses, by itself: coefficients times lobe against the
// same radiance image times the BRDF.
#pragma once

#include <cmath>
#include <vector>

#include "accuracy_sites.h"
#include "sh/sh.h"

namespace sheen::bench {

constexpr int kMinOrder = 3;
constexpr int kOrders = shared::SH_MAX_ORDER - kMinOrder + 1;
constexpr float kAlphas[] = {1.0f, 0.7f, 0.5f, 0.3f, 0.2f, 0.1f};
constexpr int kAlphaCount = 6;
constexpr float kViewDegrees[] = {10.0f, 40.0f, 65.0f, 78.0f};
constexpr int kViewCount = 4;
/// Every alpha from every view.
constexpr int kLobes = kAlphaCount * kViewCount;
constexpr int lobeIndex(int alpha, int view) { return alpha * kViewCount + view; }

/// Sums over sites; errors are of outgoing light. [order - kMinOrder][lobe]
struct Sums {
    double squares[kOrders][kLobes] = {};          // of errors
    std::vector<float> relative[kOrders][kLobes];  // |error| / truth
    int negative_light[kOrders][kLobes] = {};
    double truth[kLobes] = {};
    double noise[kLobes] = {};  // squared differences of two images
    int noise_sites = 0;
    int sites = 0;
    int negative[kOrders] = {};  // records whose fit is negative somewhere
    double band_power[shared::SH_MAX_ORDER] =
        {};  // mean squares of a band's coefficients, light mirrored below the horizon

    void add(const Sums& other);
    double relRmse(int order, int lobe) const {
        return std::sqrt(squares[order - kMinOrder][lobe] / sites) / (truth[lobe] / sites);
    }
};

/// Writes sh_*.csv and the tables sh_*.md.
void studyProjection(const BenchScenes& scenes, int sites, const Output& output);
/// Its last step; `sums` by scene.
void writeProjectionReport(const BenchScenes& scenes, const std::vector<Sums>& sums,
                           const Output& output);

}  // namespace sheen::bench
