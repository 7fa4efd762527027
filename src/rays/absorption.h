// What of a ray's light is left by the bodies that it travels in: Beer's law.
// Based on: the glTF extension KHR_materials_volume.
#pragma once

#include "scene/material.h"

namespace sheen {

/// Along one ray, whose crossings of surfaces are told from its start on. Where bodies overlap both
/// absorb. A body that is left but was not entered holds the ray's start; one that is entered and
/// not left holds its end, unless that is nowhere. Of a ray that stays in a body and meets nothing
/// of it, it knows nothing.
class Absorption {
  public:
    /// At that distance; `outward`: through the surface's back.
    void cross(const Material& material, bool outward, float distance) {
        const vec3 at = material.absorption * distance;
        depth_ += outward ? at : -at;
        inside_ += outward ? -material.absorption : material.absorption;
    }
    /// What share of the light is left of what comes from there.
    vec3 passing(float distance) const {
        if (depth_ == vec3(0.0f) && inside_ == vec3(0.0f)) {
            return vec3(1.0f);  // none absorbs
        }
        const vec3 to_end =
            distance < kInfinity ? glm::max(inside_, vec3(0.0f)) * distance : vec3(0.0f);
        return glm::exp(-glm::max(depth_ + to_end, vec3(0.0f)));
    }

    /// Of the ray that goes on from where it has come to, its distances told from there.
    Absorption onward() const {
        Absorption next;
        next.inside_ = glm::max(inside_, vec3(0.0f));
        return next;
    }

  private:
    vec3 depth_{0.0f};   // of what is left, less what was entered
    vec3 inside_{0.0f};  // per unit of length
};

}  // namespace sheen
