#include "core/error.h"
#include "scene/scene.h"

namespace sheen {

Scene loadScene(const std::string& path) {
    throwInput("{}: loading is not there yet", path);
}

}  // namespace sheen
