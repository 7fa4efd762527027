// What a receiver would send to the viewer by one record.
#pragma once

#include "receivers/receivers.h"
#include "record/record.h"

namespace sheen {

/// Luminance that a receiver sends to the viewer by what a record predicts there, by its lobe and
/// reflectance; of the diffuse class the irradiance, since the reflectance cancels in comparisons.
/// `sh`: the record's coefficients.
float outgoingLuminance(const Receivers& receivers, const Record& record, const float* sh,
                        size_t i);

/// The mean of the light that a receiver's lobe sees, by a record's coefficients or, of the diffuse
/// class, by its irradiance; what it missed at its own receiver not added.
vec3 lobeLight(const Receivers& receivers, const Record& record, const float* sh, size_t i);

}  // namespace sheen
