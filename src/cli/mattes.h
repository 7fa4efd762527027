// Mattes of a frame: which materials and objects it shows.
#pragma once

#include "image/cryptomatte.h"
#include "scene/scene.h"

namespace sheen::cli {

/// CryptoMaterial and CryptoObject, by the names that the scene's file gives, numbered where it
/// gives one twice.
std::vector<Matte> mattesOf(const Scene& scene, const Frame& frame);

}  // namespace sheen::cli
