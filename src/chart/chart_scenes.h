// The scenes of a chart: what they are called, and what tells their images from others'.
#pragma once

#include <string>
#include <vector>

#include "chart/chart.h"
#include "scene/scene.h"

namespace sheen {

/// What a sweep needs to know of a scene once its reference is rendered.
struct SceneIdentity {
    std::string hash;
    int camera = 0;
};

/// Hashes the scene, and tells its camera's name; warnings are printed here and nowhere else.
SceneIdentity identify(const Scene& scene, const std::string& camera_option, ChartScene& chart);

/// Those of these files, called by their stems, or by whole names where two share a stem. Usage
/// error where one is given twice.
std::vector<ChartScene> nameScenes(const std::vector<std::string>& files);

}  // namespace sheen
