// What the window's panels show and change.
#pragma once

#include <string>
#include <vector>

#include "viewer/camera_control.h"
#include "viewer/live_thread.h"

namespace sheen {

/// Everything that the interface changes, as it stands.
struct ViewerState {
    RenderParams render;
    DisplaySettings display;
    std::vector<Camera> cameras;  ///< the file's
    std::vector<PunctualLight> lights;
    std::vector<std::string> light_names;
    std::vector<MaterialParams> materials;
    std::vector<std::string> material_names;
    int material = 0;  ///< that is shown
    bool shortcuts = false, panel = true, records = false;
    std::vector<float> frame_ms;  ///< of the last steps
    int last_step = 0;            ///< whose time is among them
    std::string message;          ///< one line
};

/// What the user asked for in a frame.
struct Wishes {
    bool render = false, lights = false, materials = false;  ///< changed
    int camera = -1;                                         ///< of the file: to go there
    float y_fov = 0.0f;                                      ///< radians; 0: stays
    bool save_png = false, save_exr = false, save_camera = false;
};

/// What the state begins with.
ViewerState stateOf(const Scene& scene, const RenderParams& render, const DisplaySettings& display);

/// Draws the panels over `shown`, which is `fresh` as well where it was not seen before; null where
/// there is nothing yet. `y_fov`: of the camera, radians.
Wishes drawPanels(ViewerState& state, const Shown* fresh, const Shown* shown, float y_fov);

/// Marks the records on the image, as discs in which they serve; `size` of the window's units.
void drawMarks(const Shown& shown, const vec2& size);

}  // namespace sheen
