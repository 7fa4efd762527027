// The options of sheen view, of which the program that shows windows takes the same.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "cli/options.h"
#include "image/tonemap.h"
#include "render/render.h"

namespace sheen::cli {

struct ViewOptions {
    std::string scene;
    std::string size = "800x600";
    std::string method = "radiance";
    std::string sh_order = "auto";
    std::string bounces = "all";
    std::string exposure = "auto";
    std::string tone = "neutral";
    std::string gl;
    std::string camera_at, look_at;
    double fov = 0.0;  ///< degrees; 0: the camera's
    std::string json, screenshot;
    int benchmark = 0, frames = 0, threads = 0;
    LoadParams load;
    RenderParams params;
};

void addViewOptions(CLI::App& app, ViewOptions& o);

/// Fills `params` and `load` by what the others say. Usage error for what cannot be, or does not go
/// together.
void understand(ViewOptions& o);

}  // namespace sheen::cli
