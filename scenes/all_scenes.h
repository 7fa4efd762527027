// The scenes that come with Sheen; scenes/README.md says what each is for.
#pragma once

#include <string>
#include <vector>

#include "scenes/model.h"

namespace sheen::scenes {

Model cornellDiffuse();
Model cornellGlossy();
Model venusGlossy();
Model atrium();
Model corridor();
Model ledges();
Model gallery();
Model lampRoom();
Model tiles();
Model furnace();
Model sphereRoom();
Model kite();
Model doors();
Model orbit();

struct NamedScene {
    std::string file_name;
    Model (*make)();
    bool measured = false;  ///< in the README's table
};
/// All of them, in a fixed order.
const std::vector<NamedScene>& allScenes();

}  // namespace sheen::scenes
