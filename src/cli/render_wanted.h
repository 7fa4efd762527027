// The frame that the options of sheen render ask for.
#pragma once

#include "cli/render_options.h"

namespace sheen::cli {

/// Renders it: all of the image or the part that is asked for, by the records of --cache where that
/// is given, to which what was gathered is added. Errors: Session::render(), loadRecords(),
/// saveRecords().
RenderResult renderWanted(Session& session, const Scene& scene, const RenderOptions& o);

}  // namespace sheen::cli
