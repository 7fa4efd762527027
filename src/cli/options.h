// Option values that CLI11 does not know: their forms, ranges and error lines.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "core/math.h"
#include "gl/context.h"
#include "image/crop.h"
#include "scene/environment.h"
#include "scene/scene.h"

namespace sheen::cli {

/// Accepts numbers in [lower, upper]; unlike CLI::Range never NaN.
CLI::Validator numberIn(double lower, double upper);

/// Accepts any name but the empty one, which scripts make of variables that are not set.
CLI::Validator fileName();

/// "WxH", each 1..16384. Usage error otherwise.
ivec2 parseSize(const std::string& text);

/// "auto" (none) or a number of stops in [-50, 50]. Usage error otherwise.
std::optional<float> parseExposure(const std::string& text);

/// "X,Y,W,H", whole numbers from 0 on, below 1e6. Usage error otherwise.
Crop parseCrop(const std::string& text);

/// "X,Y,Z", numbers. Usage error otherwise, which names the option.
dvec3 parsePoint(const char* option, const std::string& text);

/// Where light probes go: so many along each axis, or with so much space between them.
struct ProbeSpacing {
    std::optional<ivec3> counts;
    float space = 0.0f;  ///< scene units
};
/// "NxNxN", each 1..4096, or a number above 0. Usage error otherwise.
ProbeSpacing parseProbes(const std::string& text);

/// "auto" (0) or 2..10. Usage error otherwise.
int parseShOrder(const std::string& text);

/// "all" (kAllBounces) or 1..64. Usage error otherwise.
int parseBounces(const std::string& text);

/// "none" (0) or 1000..1e8. Usage error otherwise.
int parseCaustics(const std::string& text);

/// The scene that a command is about.
void addSceneOption(CLI::App& app, std::string& scene);

/// --camera, --camera-at, --look-at and --fov.
void addViewpointOptions(CLI::App& app, std::string& camera, std::string& camera_at,
                         std::string& look_at, double& fov);

/// What these say, in `load`; `camera` is emptied where another one becomes the first. Usage error
/// for what is no point.
void parseViewpoint(const std::string& camera_at, const std::string& look_at, double fov,
                    std::string& camera, LoadParams& load);

/// --environment and what belongs to it, of any command that renders.
void addEnvironmentOptions(CLI::App& app, EnvironmentParams& params);

/// --threads.
void addThreadsOption(CLI::App& app, int& threads);

/// --gl, whose value parseGl() reads; without a value the default holds.
void addGlOption(CLI::App& app, std::string& gl);
gl::Backend parseGl(const std::string& gl);

enum class FileKind { kExr, kPng };
/// By the name's extension, in any case. Usage error where it is another.
FileKind imageKind(const std::string& path);

}  // namespace sheen::cli
