// Numbers that look like chance, of numbers.
#pragma once

#include <cstdint>

namespace sheen {

/// A hash of 64 bits. [Sta14, "splitmix"]
inline uint64_t splitMix(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

}  // namespace sheen
