// The scenes that come with Sheen as parameters of tests, and a hash that freezes their files.
#pragma once

#include <cstdint>
#include <ostream>
#include <vector>

#include "scenes/all_scenes.h"

namespace sheen {
namespace scenes {

inline void PrintTo(const NamedScene& scene, std::ostream* out) { *out << scene.file_name; }

}  // namespace scenes

/// FNV-1a, 64 bits.
inline uint64_t hashOf(const std::vector<uint8_t>& bytes) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (const uint8_t byte : bytes) {
        hash = (hash ^ byte) * 0x100000001b3u;
    }
    return hash;
}

}  // namespace sheen
