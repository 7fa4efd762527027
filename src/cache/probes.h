// Probes: pixels chosen by chance whose light is gathered anew, twice. They see what records, which
// may err alike, cannot tell of themselves.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "cache/estimate.h"
#include "cache/record_field.h"
#include "glossy/specular_rays.h"

namespace sheen {

/// A pixel, and two estimates of the radiance of its indirect light that are independent of each
/// other and of the image, without bias but for what a hemisphere's texels do not resolve.
struct Probe {
    int pixel = 0;
    float stands_for = 0;  ///< judged pixels
    vec3 light[2] = {};
};

/// About so many probes among the judged pixels, half of them where rays gather if there are such
/// pixels: half of these evenly over the image, the others where errors are expected.
std::vector<Probe> chooseProbes(const NeighbourErrors& neighbours, const Receivers& receivers,
                                const Image<vec3>& indirect, int count);

/// Gathers their light, `gatherer` being asked twice, for sites of other seeds. The closest of the
/// field's records tell where to look closer.
void gatherProbes(const Scene& scene, const Receivers& receivers, const RecordField& field,
                  Gatherer& gatherer, const OutgoingLight& outgoing, const SpecularParams& params,
                  std::span<Probe> probes);

/// The error of an image as a share of its mean, rel_rmse of docs/metrics.md.
struct ErrorEstimate {
    double rel_rmse = std::numeric_limits<double>::quiet_NaN();
    /// It is expected within low to high nine times of ten.
    double low = std::numeric_limits<double>::quiet_NaN();
    double high = std::numeric_limits<double>::quiet_NaN();
};

/// What neighbouring records expect, corrected by what probes find, as far as these are sure. No
/// numbers where nothing is lit.
ErrorEstimate estimateError(const NeighbourErrors& neighbours, std::span<const Probe> probes,
                            const Receivers& receivers, const Image<vec3>& indirect);

}  // namespace sheen
