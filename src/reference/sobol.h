// Sample points: the two-dimensional Sobol sequence with hash-based Owen scrambling. An integrand
// of more than two dimensions takes one independently scrambled and shuffled pair of dimensions a
// bounce ("padding"). Any aligned block of 2^k points of one pair has exactly one point in each
// elementary interval of area 2^-k. Based on: [Bur20]; the hash is [Veg21].
#pragma once

#include <cstdint>

#include "core/math.h"

namespace sheen {

/// The largest number below one.
constexpr float kBelowOne = 0x1.fffffep-1f;

/// A well-mixed hash of 32 bits. [Wel19, "lowbias32"]
inline uint32_t hash32(uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

/// A seed from a seed and one more value; order matters.
inline uint32_t hashCombine(uint32_t seed, uint32_t value) {
    return hash32(seed ^ (hash32(value + 0x9e3779b9u) + 0x9e3779b9u + (seed << 6) + (seed >> 2)));
}

inline uint32_t reverseBits(uint32_t x) {
    x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    return __builtin_bswap32(x);
}

/// Permutes the binary digits of x in [0, 2^32), most significant first, by a tree of random flips:
/// a bit is flipped depending on the seed and on all higher bits. [Bur20, listing 2; Veg21]
inline uint32_t owenScramble(uint32_t x, uint32_t seed) {
    x = reverseBits(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

/// Both coordinates of point `index` of the unscrambled sequence, as fractions of 2^32. The second
/// coordinate's generator matrix is Pascal's triangle modulo 2, the fifth Kronecker power of
/// (1 1; 0 1): five steps apply it. [Ahm24]
inline uvec2 sobolBits(uint32_t index) {
    uint32_t x = index;
    x ^= (x & 0xaaaaaaaau) >> 1;
    x ^= (x & 0xccccccccu) >> 2;
    x ^= (x & 0xf0f0f0f0u) >> 4;
    x ^= (x & 0xff00ff00u) >> 8;
    x ^= x >> 16;
    return {reverseBits(index), reverseBits(x)};
}

/// Point `index` of the scrambled, shuffled pair of dimensions chosen by `seed`; in [0, 1)^2.
inline vec2 owenSobol(uint32_t index, uint32_t seed) {
    const uvec2 bits = sobolBits(owenScramble(index, hash32(seed)));
    const uint32_t x = owenScramble(bits.x, hash32(seed ^ 0xa511e9b3u));
    const uint32_t y = owenScramble(bits.y, hash32(seed ^ 0x63d83595u));
    constexpr float kScale = 1.0f / 16777216.0f;  // 24 bits: a float below 1
    return {static_cast<float>(x >> 8) * kScale, static_cast<float>(y >> 8) * kScale};
}

}  // namespace sheen
