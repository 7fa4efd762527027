// The window: a scene that is lit at once and becomes better while one looks and moves.
#pragma once

#include <optional>
#include <string>

#include "render/render.h"
#include "viewer/live_thread.h"

namespace sheen {

struct ViewerParams {
    std::string scene;  ///< file
    LoadParams load;
    RenderParams render;  ///< of the complete image; its size is the window's
    DisplaySettings display;
    /// Frames along a path that is always the same, flown twice, after which the window closes; 0:
    /// none.
    int benchmark = 0;
    std::string screenshot;    ///< a PNG file, written when the image is complete; empty: none
    int screenshot_after = 0;  ///< steps, rather than when it is complete; 0: when it is
};

/// What a benchmark measured.
struct ViewerFigures {
    double seconds_to_first = 0;  ///< from the loaded scene to a first image with indirect light
    double seconds_to_full = 0;   ///< to the complete image of the first view
    double fps_fill = 0;  ///< steps a second along the path, records being gathered as needed
    double fps_full = 0;  ///< along it again
    double seconds_gbuffer = 0;  ///< of one G-buffer of 512 x 512, the machine's yardstick
    int records = 0;             ///< kept at the end
    StageSeconds stages;         ///< of the steps along it again, their means
};

/// Opens the window and returns when it is closed; figures where there was a benchmark. Input error
/// for the scene; environment error without a display or OpenGL 3.3.
std::optional<ViewerFigures> runViewer(const ViewerParams& params);

}  // namespace sheen
