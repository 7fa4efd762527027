// Scenes whose file is in memory.
#pragma once

#include <string>

#include "scene/scene.h"

namespace sheen {

/// loadScene() of a .glb or .gltf file's bytes. `name` stands for its path: in messages, and files
/// that it names are looked for beside that.
Scene sceneFromBytes(const std::string& name, std::string bytes, const LoadParams& params = {});

}  // namespace sheen
