// The specular lobes of receivers, ready to be multiplied with records.
#pragma once

#include <cstdint>
#include <vector>

#include "core/math.h"
#include "sh/sh.h"

namespace sheen::shared {
using namespace glm;
#include "shared/lobe.glsl"
}  // namespace sheen::shared

namespace sheen {

struct Receivers;

/// The specular lobe of each glossy receiver in spherical harmonics, world space. One set of
/// coefficients serves the three channels: the lobe's shape is taken at the mean F0, and what a
/// coloured F0 changes of its albedo is a factor.
/// Coefficients are kept as whole LOBE_STEPS-ths of the receiver's greatest: there are up to 100
/// each to store and upload, and every record that serves it reads them.
struct Lobes {
    std::vector<int> first;      ///< [receiver]: of its coefficients, a multiple of 8; -1: none
    std::vector<int16_t> steps;  ///< [receiver][coefficient], zeros from order^2 to its groups' end
    std::vector<vec3> scale;     ///< [receiver]; empty where none has a lobe

    /// A receiver's lobe, before its scale.
    shared::ShVector at(size_t i, int order) const;
};

/// Of those of an order above shared::DIFFUSE_ORDER.
Lobes buildLobes(const Receivers& receivers);

}  // namespace sheen
