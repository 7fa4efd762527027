#include "light/many_lights.h"

#include <algorithm>
#include <iterator>

#include "light/punctual.h"

namespace sheen {

ManyLights::ManyLights(const Scene& scene) {
    const auto far = [](const PunctualLight& light) {
        return light.kind == shared::LIGHT_DIRECTIONAL;
    };
    std::copy_if(scene.lights.begin(), scene.lights.end(), std::back_inserter(others_),
                 [&](const PunctualLight& light) { return !far(light); });
    if (others_.size() <= kFew) {
        each_ = scene.lights;
        others_.clear();
        return;
    }
    std::copy_if(scene.lights.begin(), scene.lights.end(), std::back_inserter(each_), far);
    std::vector<LightBounds> bounds;
    for (const PunctualLight& light : others_) {
        const float power = luminance(light.intensity);
        LightBounds& b = bounds.emplace_back();
        b.box.add(light.position);
        b.intensity = light.kind == shared::LIGHT_SPOT
                          ? Intensity::inCone(light.direction, light.cos_outer, power)
                          : Intensity::everywhere(power);
        b.reach = light.inverse_range > 0.0f ? 1.0f / light.inverse_range : kInfinity;
    }
    tree_ = LightTree(bounds);
}

std::optional<ManyLights::Sample> ManyLights::sample(
    const SurfaceSide& surface, const vec3& n,
    const std::optional<LightTree::Choice>& choice) const {
    if (!choice) {
        return std::nullopt;
    }
    const PunctualLight& light = others_[choice->light];
    Sample s{.light = shared::sampleLight(light, surface.position), .way = {}};
    if (glm::dot(surface.n_g, s.light.wi) <= 0.0f || glm::dot(n, s.light.wi) <= 0.0f ||
        s.light.irradiance == vec3(0.0f)) {
        return std::nullopt;
    }
    s.way = wayTo(light, s.light, surface.start());
    s.light.irradiance /= choice->probability;
    return s;
}

}  // namespace sheen
