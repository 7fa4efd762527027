// The directions that texels of a hemisphere's face stand for, and which texel a direction meets.
#pragma once

#include <optional>

#include "hemisphere/hemisphere.h"

namespace sheen {

/// A face of the hemisphere in the space of `frame`, whose columns are a record's axes.
struct FaceDirections {
    mat3 axes;  ///< right, up, forward
    mat3 inverse_axes;
    vec2 step;  ///< from texel to texel, in u and v

    FaceDirections(const HemisphereFace& face, const mat3& frame)
        : axes(frame * mat3(face.right, face.up, face.forward)),
          inverse_axes(glm::inverse(axes)),
          step(2.0f / vec2(face.width, face.height)) {}

    /// Unit; `place` within the texel, (0, 0) to (1, 1).
    vec3 direction(int x, int y, const vec2& place) const {
        const vec2 uv = (vec2(x, y) + place) * step - 1.0f;
        return glm::normalize(axes * vec3(uv, 1.0f));
    }
    /// Where a direction meets the face, in texels; nothing where it does not.
    std::optional<vec2> meet(const vec3& direction) const {
        const vec3 p = inverse_axes * direction;
        const vec2 uv = vec2(p) / p.z;
        const bool meets = p.z > 0.0f && std::abs(uv.x) <= 1.0f && std::abs(uv.y) <= 1.0f;
        return meets ? std::optional((uv + 1.0f) / step) : std::nullopt;
    }
};

/// Index in the atlas of a face's texel.
inline size_t texelOf(const Hemisphere& h, const HemisphereFace& face, int x, int y) {
    return static_cast<size_t>((face.y + y) * h.width + face.x + x);
}

}  // namespace sheen
