// Scenes that are handed over as arrays become a file in memory, so that they are loaded, checked
// and mended as any other.
#pragma once

#include <string>

#include "sheen/sheen_c.h"

namespace sheen::library {

/// What stands for the file's name in messages.
constexpr const char* kArrays = "arrays";

/// The bytes of a .glb file. Input error, naming the array, where one is NULL, a number is not
/// finite, an index leads nowhere or an image or camera cannot be.
std::string glbOf(const sheen_arrays& arrays);

}  // namespace sheen::library
