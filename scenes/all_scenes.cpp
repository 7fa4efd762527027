#include "scenes/all_scenes.h"

namespace sheen::scenes {

const std::vector<NamedScene>& allScenes() {
    static const std::vector<NamedScene> scenes = {
        {"cornell_diffuse.glb", &cornellDiffuse},
        {"cornell_glossy.glb", &cornellGlossy},
        {"venus_glossy.glb", &venusGlossy},
        {"atrium.glb", &atrium},
        {"furnace.glb", &furnace},
        {"sphere_room.glb", &sphereRoom},
    };
    return scenes;
}

}  // namespace sheen::scenes
