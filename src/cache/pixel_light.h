// What a pixel asks of records, and what it would send to the camera by one of them.
#pragma once

#include "cache/classes.h"
#include "cache/lobes.h"
#include "cache/record.h"
#include "raster/gbuffer.h"

namespace sheen {

/// Where a pixel's light is to be gathered; of the records around it nothing is known yet.
RecordSite siteAt(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
                  int pixel);

/// Luminance that a pixel sends to the camera by what a record predicts there, by its lobe and
/// reflectance; of the diffuse class the irradiance, since the reflectance cancels in comparisons.
/// `sh`: the record's coefficients.
float outgoingLuminance(const GBuffer& gbuffer, const PixelClasses& classes,
                        const PixelLobes& lobes, const Record& record, const float* sh, int pixel);

/// The mean of the light that a pixel's lobe sees, by a record's coefficients or, of the diffuse
/// class, by its irradiance; what it missed at its own pixel not added.
vec3 lobeLight(const GBuffer& gbuffer, const PixelClasses& classes, const PixelLobes& lobes,
               const Record& record, const float* sh, int pixel);

}  // namespace sheen
