// What the study of hemispheres asks for at every point, and the converged answer: irradiance, and
// one lobe at several views.
#pragma once

#include "accuracy_sites.h"

namespace sheen::bench {
namespace hemispheres {

constexpr float kAlpha = 0.3f;
constexpr float kViewDegrees[] = {45.0f, 75.0f, 85.0f};
constexpr int kViews = 3;
constexpr int kQuantities = 1 + kViews;  // irradiance, then the lobe at each view
constexpr int kAzimuths = 8;             // of the viewers; a site has one of them

/// Which of the viewers' azimuths a site has, and where that viewer is, in the local frame.
int azimuthOf(int site);
vec3 viewer(int view, int azimuth);
/// What the lobe reflects toward a viewer of constant light.
float lobeAlbedo(const vec3& wo);

/// Values of one quantity set at all sites of all scenes: [quantity][site].
struct Values {
    std::vector<float> of[kQuantities];

    explicit Values(size_t sites = 0) {
        for (auto& v : of) {
            v.resize(sites);
        }
    }
};

struct Truth {
    Values values;
    Values variance;  ///< of the values
};

/// By rays of a sampler of its own: the cosine for irradiance, visible normals for the lobe. Only
/// the first so many `quantities`; the others stay 0.
Truth traceTruth(const BenchScenes& scenes, int sites, int quantities = kQuantities);

}  // namespace hemispheres
}  // namespace sheen::bench
