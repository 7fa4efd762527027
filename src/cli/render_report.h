// What sheen render says of a frame.
#pragma once

#include "cli/output.h"
#include "cli/render_options.h"
#include "image/exr.h"

namespace sheen::cli {

/// Warns of what is not as asked for, or as it should be. `limit`: the seconds of --time-limit, 0:
/// none.
void warnOf(const RenderOptions& o, const Scene& scene, const RenderResult& result, double limit);

/// Every figure.
Json statsJson(const RenderOptions& o, const RenderStats& stats);

/// What an EXR file is to say of itself: by which version, options and scene it was made, how wrong
/// its light may be. The same for the same image, whenever and by however many threads it was made.
ExrNotes notesOf(const RenderOptions& o, const RenderStats& stats);

/// Writes an EXR file to `output`: the layers that were asked for, masks among all of them, and
/// what notesOf() says.
void writeFrameExr(const RenderOptions& o, const Scene& scene, const RenderResult& result);

/// Every figure, for people.
void printStats(const RenderOptions& o, const RenderStats& stats);

}  // namespace sheen::cli
