#include "scenes/all_scenes.h"

namespace sheen::scenes {

const std::vector<NamedScene>& allScenes() {
    static const std::vector<NamedScene> scenes = {
        {"cornell_diffuse.glb", &cornellDiffuse, true},
        {"cornell_glossy.glb", &cornellGlossy, true},
        {"venus_glossy.glb", &venusGlossy, true},
        {"atrium.glb", &atrium, true},
        {"corridor.glb", &corridor, true},
        {"ledges.glb", &ledges},
        {"gallery.glb", &gallery},
        {"lamp_room.glb", &lampRoom},
        {"tiles.glb", &tiles},
        {"furnace.glb", &furnace},
        {"sphere_room.glb", &sphereRoom},
        {"kite.glb", &kite},
        {"doors.glb", &doors},
        {"orbit.glb", &orbit},
    };
    return scenes;
}

}  // namespace sheen::scenes
