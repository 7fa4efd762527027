// The options of sheen render, as text and as what they say.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cli/options.h"
#include "image/tonemap.h"
#include "render/render.h"

namespace sheen::cli {

/// An option that only some methods understand.
struct LimitedOption {
    CLI::Option* option = nullptr;
    std::vector<Method> methods;
};

struct RenderOptions {
    std::string scene;
    std::string output;
    std::string size = "512x512";
    std::string method = "radiance";
    std::string placement = "scan";
    std::string sh_order = "auto";
    std::string gather = "ray";
    std::string bounces = "all";
    std::string kept_by = "elements";
    std::string caustics;  ///< by default as many photons as `params` says
    std::string exposure = "auto";
    std::string tone = "neutral";
    std::string view, ocio;
    ToDisplay to_display = toSrgb();  ///< by these
    std::string layers = "basic";
    std::string cache;  ///< empty: records serve this frame alone
    std::string json;
    int threads = 0;
    std::string gl;
    LoadParams load;
    std::string crop;          ///< empty: all of the image
    std::optional<Crop> part;  ///< what it says
    std::string camera_at;
    std::string look_at;
    double fov = 0.0;  ///< degrees; 0: the camera's
    RenderParams params;
    const CLI::App* app = nullptr;  ///< that they were added to
    std::string settings;           ///< of the image, by options, "--size=64x64 --aa=1 ..."
    std::vector<LimitedOption> limited;
    bool by_file = false;  ///< the method is the file's choice
    CLI::Option* method_option = nullptr;
    CLI::Option* aa_option = nullptr;
    CLI::Option* exposure_option = nullptr;
    CLI::Option* tone_option = nullptr;
    CLI::Option* view_option = nullptr;
    CLI::Option* layers_option = nullptr;
    CLI::Option* extent_option = nullptr;
    CLI::Option* bounces_option = nullptr;
    CLI::Option* caustics_option = nullptr;
};

void addRenderOptions(CLI::App& app, RenderOptions& o);

/// Fills `params`, `load` and `settings` by what the others say. Usage error for what cannot be, or
/// does not go together.
void understandFrame(RenderOptions& o);

/// The same, and `output`; returns what file that is to be.
FileKind understand(RenderOptions& o);

/// Where no method is given, the scene may choose to be seen by its lightmaps: before it is loaded.
void allowLightmaps(RenderOptions& o);
/// And afterwards: what the others say where it has.
void understandFile(RenderOptions& o, const Scene& scene);

bool tracesPaths(Method method);

}  // namespace sheen::cli
