// What sheen render says of a frame.
#pragma once

#include "cli/output.h"
#include "cli/render_options.h"

namespace sheen::cli {

/// Warns of what is not as asked for, or as it should be. `limit`: the seconds of --time-limit, 0:
/// none.
void warnOf(const RenderOptions& o, const Scene& scene, const RenderResult& result, double limit);

/// Every figure.
Json statsJson(const RenderOptions& o, const RenderStats& stats);

/// The same for people.
void printStats(const RenderOptions& o, const RenderStats& stats);

}  // namespace sheen::cli
