// What projection onto spherical harmonics loses, by itself: coefficients times lobe against the
// same radiance image times the BRDF.
#pragma once

#include <vector>

#include "accuracy_sites.h"
#include "accuracy_sphere.h"

namespace sheen::bench {

constexpr int kPixels = kAlphaCount * kViewCount * kTilts;

// Where the radiance image is taken: on the surface as the gather does, for upright pixels; or
// lifted off it, where there is light below the horizon for tilted pixels to read.
enum Eye { kOnSurface, kLifted, kEyes };

// Sums over sites.
struct Sums {
    double squares[kEyes][kMaxProjections][kOrders][kPixels] = {};  // of errors
    double truth[kEyes][kPixels] = {};
    double noise[kPixels] = {};                              // squared differences of two images
    std::vector<float> relative[kOrders][kPixels / kTilts];  // |error| / truth, the program's fit
    int negative_light[kOrders][kPixels / kTilts] = {};      // of these, negative
    int noise_sites = 0;
    int sites = 0;
    int negative[kOrders] = {};  // records whose program's fit is negative somewhere
    double band_power[shared::SH_MAX_ORDER] =
        {};  // mean squares of a band's coefficients, light mirrored below the horizon

    void add(const Sums& o) {
        for (int eye = 0; eye < kEyes; ++eye) {
            for (int p = 0; p < kMaxProjections; ++p) {
                for (int n = 0; n < kOrders; ++n) {
                    for (int k = 0; k < kPixels; ++k) {
                        squares[eye][p][n][k] += o.squares[eye][p][n][k];
                    }
                }
            }
            for (int k = 0; k < kPixels; ++k) {
                truth[eye][k] += o.truth[eye][k];
            }
        }
        for (int n = 0; n < kOrders; ++n) {
            negative[n] += o.negative[n];
        }
        for (int k = 0; k < kPixels; ++k) {
            noise[k] += o.noise[k];
        }
        for (int n = 0; n < kOrders; ++n) {
            for (int k = 0; k < kPixels / kTilts; ++k) {
                negative_light[n][k] += o.negative_light[n][k];
                relative[n][k].insert(relative[n][k].end(), o.relative[n][k].begin(),
                                      o.relative[n][k].end());
            }
        }
        for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
            band_power[l] += o.band_power[l];
        }
        noise_sites += o.noise_sites;
        sites += o.sites;
    }
    double relRmse(int eye, int projection, int order, int pixel) const {
        return std::sqrt(squares[eye][projection][order - kMinOrder][pixel] / sites) /
               (truth[eye][pixel] / sites);
    }
};

/// Writes sh_*.csv and the tables sh_*.md.
void studyProjection(const BenchScenes& scenes, int sites, const Output& output);
/// Its last step; `sums` by scene.
void writeProjectionReport(const std::vector<Projection>& projections, const BenchScenes& scenes,
                           const std::vector<Sums>& sums, const Output& output);

}  // namespace sheen::bench
