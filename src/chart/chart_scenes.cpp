#include "chart/chart_scenes.h"

#include <filesystem>
#include <set>

#include "chart/point_file.h"
#include "core/error.h"

namespace sheen {

namespace fs = std::filesystem;

SceneIdentity identify(const Scene& scene, const std::string& camera_option, ChartScene& chart) {
    for (const std::string& warning : scene.warnings) {
        warn(warning);
    }
    const Camera& camera = findCamera(scene, camera_option);
    const int index = static_cast<int>(&camera - scene.cameras.data());
    chart.camera = camera.name.empty() ? fmt::format("{}", index) : camera.name;
    return {contentHash(scene), index};
}

std::vector<ChartScene> nameScenes(const std::vector<std::string>& files) {
    std::vector<ChartScene> scenes;
    std::set<fs::path> seen;
    std::multiset<std::string> stems;
    for (const std::string& file : files) {
        std::error_code ignored;
        const fs::path canonical = fs::weakly_canonical(file, ignored);
        if (!seen.insert(ignored ? fs::path(file) : canonical).second) {
            throwUsage("{}: this scene is given twice", file);
        }
        stems.insert(fs::path(file).stem().string());
    }
    for (const std::string& file : files) {
        const std::string stem = fs::path(file).stem().string();
        ChartScene scene;
        scene.name = stems.count(stem) > 1 ? file : stem;
        scene.file = file;
        scenes.push_back(scene);
    }
    return scenes;
}

}  // namespace sheen
