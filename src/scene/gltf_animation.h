// Animations of a file, and the file's nodes, lights and cameras at a time.
#pragma once

#include <functional>

#include "scene/gltf_parts.h"
#include "scene/keyframes.h"

namespace sheen::gltf {

/// One property, and how it comes into the file.
struct Track {
    Keyframes keys;
    std::function<void(tinygltf::Model&, const std::vector<double>&)> set;
};

struct Animation {
    std::string name;
    double seconds = 0.0;  ///< up to its last key
    std::vector<Track> tracks = {};
};

/// The animation called `name`, or the one with that index; empty: the first, of several with a
/// note. Usage error where there is none; input error where it is broken: times that do not grow,
/// numbers that are not finite, a sampler, accessor or node that is not there, keys and values that
/// differ in number. Notes what it moves and is not followed.
Animation readAnimation(File& file, const std::string& name);

/// Sets what it moves, and nothing else: at any two times it is the same.
void pose(const Animation& animation, double seconds, tinygltf::Model& model);

}  // namespace sheen::gltf
