// Punctual lights, and whether what they bring can be computed with.
// Based on: KHR_lights_punctual.
#include <algorithm>
#include <cmath>

#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

// What the lights bring to a scene, in lux or nits: beyond these, squares of radiances and what is
// a thousandth of the brightest leave the range of floats.
constexpr double kDimmestLevel = 1e-12;
constexpr double kBrightestLevel = 1e12;
// Sets a spot's cone as KHR_lights_punctual recommends, but for the least difference of cosines
// over which light falls to zero. 0.001 as there would dim a narrow cone's axis; here a hard edge
// takes a thousandth of any cone.
void setCone(File& file, const tinygltf::SpotLight& spot, const std::string& where,
             PunctualLight& light) {
    constexpr double kHardEdge = 1e-3;
    constexpr double kRounding = 1e-6;   // of angles that were floats
    constexpr double kNarrowest = 2e-3;  // that cosines in floats can tell from none
    const double inner = spot.innerConeAngle;
    const double outer = spot.outerConeAngle;
    if (!(inner >= 0.0) || !(outer >= inner - kRounding) || !(outer <= 1.5707964)) {
        file.fail(where, "cone angles must be 0 <= inner <= outer <= pi/2, but are {} and {}",
                  inner, outer);
    }
    if (!(outer >= kNarrowest)) {
        file.fail(where, "its cone of {} radians is too narrow; widen it to {} or more", outer,
                  kNarrowest);
    }
    if (inner >= outer) {
        file.notes.add(fmt::format(
            "{}: innerConeAngle is as large as outerConeAngle and clamped: its edge is hard",
            where));
    }
    const double scale =
        1.0 / std::max(kHardEdge * (1.0 - std::cos(outer)), std::cos(inner) - std::cos(outer));
    light.spot_scale = static_cast<float>(scale);
    light.spot_offset = static_cast<float>(-std::cos(outer) * scale);
    light.cos_outer = static_cast<float>(std::cos(outer));
}
double brightestChannel(const PunctualLight& light) {
    return std::max({light.intensity.x, light.intensity.y, light.intensity.z});
}

// The illuminance that a light brings to the scene's middle, or to its rim where it lies inside.
double levelOf(const PunctualLight& light, const Bounds& bounds) {
    const double intensity = brightestChannel(light);
    if (light.kind == shared::LIGHT_DIRECTIONAL) {
        return intensity;
    }
    const double distance =
        std::max<double>(glm::distance(glm::dvec3(light.position), glm::dvec3(bounds.center())),
                         0.5 * bounds.size());
    return intensity / (distance * distance);
}

// The illuminance that a point or spot light brings to the vertex nearest to it, but not at it.
double nearestLevel(const PunctualLight& light, const Scene& scene) {
    double nearest2 = kInfinity;
    for (const vec3& p : scene.positions) {
        const glm::dvec3 way(p - light.position);
        const double distance2 = glm::dot(way, way);
        nearest2 = distance2 > 0.0 ? std::min(nearest2, distance2) : nearest2;
    }
    return brightestChannel(light) / nearest2;
}

}  // namespace

void appendLight(File& file, const tinygltf::Node& node, const glm::dmat4& world_from_node,
                 const std::string& where, Scene& scene) {
    const tinygltf::Value& reference = node.extensions.at("KHR_lights_punctual");
    const double index = numberMember(file, reference, "light", -1.0, where);
    const tinygltf::Light& source =
        file.at(file.model.lights, index >= 0.0 && index < 1e9 ? static_cast<int>(index) : -1,
                where, "light");
    const std::string light_where = fmt::format("light {}", index);
    if (!(source.intensity >= 0.0) || !(source.range >= 0.0)) {
        file.fail(light_where, "intensity and range must not be negative");
    }
    if (!source.color.empty() && source.color.size() != 3) {
        file.fail(light_where, "color must hold three numbers");
    }
    PunctualLight light{};
    light.position = vec3(world_from_node[3]);
    light.inverse_range =
        source.range > 0.0 ? finiteFloat(file, 1.0 / source.range, light_where, "1/range") : 0.0f;
    for (int c = 0; c < 3; ++c) {
        const double color = source.color.empty() ? 1.0 : source.color[static_cast<size_t>(c)];
        if (color < 0.0) {
            file.notes.add(
                fmt::format("{}: color {} is negative and counts as 0", light_where, color));
        }
        light.intensity[c] =
            std::max(0.0f, finiteFloat(file, source.intensity * color, light_where, "intensity"));
    }
    light.spot_offset = 1.0f;
    light.cos_outer = -1.0f;
    light.direction = vec3(0.0f, 0.0f, -1.0f);
    if (source.type == "point") {
        light.kind = shared::LIGHT_POINT;
    } else if (source.type == "spot" || source.type == "directional") {
        light.direction = vec3(-glm::normalize(glm::dvec3(world_from_node[2])));
        if (!std::isfinite(glm::dot(light.direction, light.direction))) {
            file.notes.add("light whose transform is singular left out");
            return;
        }
        light.kind = source.type == "spot" ? shared::LIGHT_SPOT : shared::LIGHT_DIRECTIONAL;
        if (light.kind == shared::LIGHT_SPOT) {
            setCone(file, source.spot, light_where, light);
        }
    } else {
        file.fail(light_where, "type {} is unknown; use point, spot or directional",
                  oneLine(source.type));
    }
    scene.lights.push_back(light);
    scene.light_names.push_back(
        firstName(source.name, node.name, "light", scene.lights.size() - 1));
}
void checkLightLevel(const File& file, const Scene& scene) {
    double brightest = 0.0;
    const auto check = [&](double level, const std::string& where, const char* unit) {
        if (level > kBrightestLevel) {
            file.fail(where, "brings {:.3g} {} to the scene, more than {:g}; make it dimmer", level,
                      unit, kBrightestLevel);
        }
        brightest = std::max(brightest, level);
    };
    for (size_t i = 0; i < scene.lights.size() && !scene.bounds.empty(); ++i) {
        check(levelOf(scene.lights[i], scene.bounds), label("light", i, scene.light_names[i]),
              "lux");
    }
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const vec3& emission = scene.materials[i].params.emission;
        check(std::max({emission.x, emission.y, emission.z}),
              label("material", i, scene.materials[i].name), "nits");
    }
    // A large scene's rim may be dark.
    for (size_t i = 0; i < scene.lights.size() && brightest < kDimmestLevel; ++i) {
        if (scene.lights[i].kind != shared::LIGHT_DIRECTIONAL) {
            brightest = std::max(brightest, nearestLevel(scene.lights[i], scene));
        }
    }
    if (brightest > 0.0 && brightest < kDimmestLevel) {
        file.fail("lights", "bring {:.3g} lux to the scene, less than {:g}; make them brighter",
                  brightest, kDimmestLevel);
    }
}

}  // namespace sheen::gltf
