// Views of an OpenColorIO configuration, as studios share them: light to display values.
#pragma once

#include <string>

#include "image/tonemap.h"

namespace sheen {

/// `view`: "VIEW" of the configuration's default display, or "DISPLAY/VIEW". Light is taken to be
/// in the configuration's linear Rec. 709, or, where it names no such space, in its scene_linear.
/// Input error for a configuration that cannot be read or used; usage error, which lists those
/// there are, for a view that it does not have.
ToDisplay colorView(const std::string& config, const std::string& view);

}  // namespace sheen
