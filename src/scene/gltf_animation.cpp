// Reading animations: as all else of a file, never trusted.
// Based on: the glTF 2.0 specification, 3.11; KHR_animation_pointer.
#include "scene/gltf_animation.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

namespace sheen::gltf {
namespace {

using Json = nlohmann::json;
using Values = std::vector<double>;

// What a channel moves: how many numbers that has, whether they are a rotation, and where they go.
struct Target {
    std::string name;  // for messages, and to tell whether two channels move one thing
    size_t width = 1;
    bool rotation = false;
    bool list = false;  // of single numbers, in the file
    std::function<void(tinygltf::Model&, const Values&)> set = {};  // none: it is not followed
};

const Json* memberOf(const Json& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    return object.is_object() && found != object.end() ? &*found : nullptr;
}

// -1 where it is absent.
int indexOf(const File& file, const Json& object, const char* key, const std::string& where) {
    const Json* member = memberOf(object, key);
    if (member == nullptr) {
        return -1;
    }
    if (!member->is_number_integer() || member->get<double>() < 0.0 ||
        member->get<double>() > 1e9) {
        file.fail(where, "its {} is not an index; export the file again", key);
    }
    return member->get<int>();
}

std::string textOf(const Json& object, const char* key, const char* fallback) {
    const Json* member = memberOf(object, key);
    return member != nullptr && member->is_string() ? member->get<std::string>() : fallback;
}

const Json& listOf(const File& file, const Json& animation, const char* key,
                   const std::string& where) {
    const Json* list = memberOf(animation, key);
    if (list == nullptr || !list->is_array()) {
        file.fail(where, "it has no list of {}; export the file again", key);
    }
    return *list;
}

// How many morph targets a node's mesh has.
size_t targetsOf(const File& file, int node) {
    size_t most = 0;
    const int mesh = file.model.nodes[static_cast<size_t>(node)].mesh;
    if (mesh >= 0 && static_cast<size_t>(mesh) < file.model.meshes.size()) {
        for (const tinygltf::Primitive& primitive :
             file.model.meshes[static_cast<size_t>(mesh)].primitives) {
            most = std::max(most, primitive.targets.size());
        }
    }
    return most;
}

Target nodeTarget(const File& file, int index, const std::string& path, const std::string& where) {
    const tinygltf::Node& node = file.at(file.model.nodes, index, where, "node");
    const auto i = static_cast<size_t>(index);
    Target target{.name = fmt::format("{}, {}", label("node", i, node.name), oneLine(path))};
    std::vector<double> tinygltf::Node::*property = nullptr;
    if (path == "translation") {
        property = &tinygltf::Node::translation;
        target.width = 3;
    } else if (path == "rotation") {
        property = &tinygltf::Node::rotation;
        target.width = 4;
        target.rotation = true;
    } else if (path == "scale") {
        property = &tinygltf::Node::scale;
        target.width = 3;
    } else if (path == "weights") {
        property = &tinygltf::Node::weights;
        target.width = targetsOf(file, index);
        target.list = true;
        if (target.width == 0) {
            file.fail(where, "moves morph targets, but {} has none; export the file again",
                      label("node", i, node.name));
        }
    } else {
        return target;
    }
    if (path != "weights" && !node.matrix.empty()) {
        file.fail(where,
                  "moves {}, which has a matrix: give it translation, rotation and scale instead",
                  label("node", i, node.name));
    }
    target.set = [i, property](tinygltf::Model& model, const Values& values) {
        model.nodes[i].*property = values;
    };
    return target;
}

double notNegative(double value) { return std::max(value, 0.0); }  // splines may swing below

Target lightTarget(const File& file, int index, const std::string& path, const std::string& where) {
    file.at(file.model.lights, index, where, "light");
    const auto i = static_cast<size_t>(index);
    Target target{.name = fmt::format("light {}, {}", index, oneLine(path))};
    const auto set = [&](const auto& property) {
        target.set = [i, property](tinygltf::Model& model, const Values& values) {
            property(model.lights[i]) = notNegative(values[0]);
        };
    };
    using Light = tinygltf::Light;
    if (path == "color") {
        target.width = 3;
        target.set = [i](tinygltf::Model& model, const Values& values) {
            model.lights[i].color.resize(3);
            std::transform(values.begin(), values.end(), model.lights[i].color.begin(),
                           notNegative);
        };
    } else if (path == "intensity") {
        set([](Light& light) -> double& { return light.intensity; });
    } else if (path == "range") {
        set([](Light& light) -> double& { return light.range; });
    } else if (path == "spot/innerConeAngle") {
        set([](Light& light) -> double& { return light.spot.innerConeAngle; });
    } else if (path == "spot/outerConeAngle") {
        set([](Light& light) -> double& { return light.spot.outerConeAngle; });
    }
    return target;
}

Target cameraTarget(const File& file, int index, const std::string& path,
                    const std::string& where) {
    file.at(file.model.cameras, index, where, "camera");
    Target target{.name = fmt::format("camera {}, {}", index, oneLine(path))};
    if (path == "perspective/yfov") {
        target.set = [index](tinygltf::Model& model, const Values& values) {
            model.cameras[static_cast<size_t>(index)].perspective.yfov = values[0];
        };
    }
    return target;
}

// KHR_animation_pointer: a JSON pointer to what is moved, such as "/nodes/3/translation".
Target pointedTarget(const File& file, const std::string& pointer, const std::string& where) {
    const struct {
        const char* list;
        Target (*target)(const File&, int, const std::string&, const std::string&);
    } kLists[] = {{"/nodes/", nodeTarget},
                  {"/extensions/KHR_lights_punctual/lights/", lightTarget},
                  {"/cameras/", cameraTarget}};
    for (const auto& [list, target] : kLists) {
        const size_t slash = pointer.find('/', std::char_traits<char>::length(list));
        if (pointer.starts_with(list) && slash != std::string::npos) {
            const char* end = pointer.data() + slash;
            int index = -1;
            const auto [stop, error] =
                std::from_chars(pointer.data() + std::char_traits<char>::length(list), end, index);
            if (error == std::errc() && stop == end) {
                return target(file, index, pointer.substr(slash + 1), where);
            }
        }
    }
    return {.name = oneLine(pointer)};
}

Target targetOf(const File& file, const Json& channel, const std::string& where) {
    const Json* target = memberOf(channel, "target");
    if (target == nullptr) {
        file.fail(where, "it has no target; export the file again");
    }
    const std::string path = textOf(*target, "path", "");
    if (path == "pointer") {
        const Json* extensions = memberOf(*target, "extensions");
        const Json* extension =
            extensions != nullptr ? memberOf(*extensions, "KHR_animation_pointer") : nullptr;
        if (extension == nullptr) {
            file.fail(where, "its target has no pointer; export the file again");
        }
        return pointedTarget(file, textOf(*extension, "pointer", ""), where);
    }
    const int node = indexOf(file, *target, "node", where);
    return node == -1 ? Target{.name = "no node"} : nodeTarget(file, node, path, where);
}

Values finiteNumbers(const File& file, const std::vector<float>& floats, const std::string& where) {
    for (size_t i = 0; i < floats.size(); ++i) {
        if (!std::isfinite(floats[i])) {
            file.fail(where, "its number {} is {}; mend it or export the file again", i, floats[i]);
        }
    }
    return Values(floats.begin(), floats.end());
}

Values timesOf(const File& file, int accessor, const std::string& where) {
    const Values times =
        finiteNumbers(file, readFloats(file, accessor, 1, Integers::kNo, where), where);
    for (size_t i = 1; i < times.size(); ++i) {
        if (!(times[i] > times[i - 1])) {
            file.fail(where, "its times must grow, but key {} is at {} s after one at {} s", i,
                      times[i], times[i - 1]);
        }
    }
    return times;
}

Interpolation interpolationOf(const File& file, const Json& sampler, const std::string& where) {
    const std::string name = textOf(sampler, "interpolation", "LINEAR");
    const std::map<std::string, Interpolation> kNames = {
        {"STEP", Interpolation::kStep},
        {"LINEAR", Interpolation::kLinear},
        {"CUBICSPLINE", Interpolation::kCubicSpline}};
    const auto found = kNames.find(name);
    if (found == kNames.end()) {
        file.fail(where, "interpolation {} is unknown; use STEP, LINEAR or CUBICSPLINE",
                  oneLine(name));
    }
    return found->second;
}

void checkRotations(const File& file, const Keyframes& keys, const std::string& where) {
    const bool cubic = keys.interpolation == Interpolation::kCubicSpline;
    for (size_t i = 0; i < keys.times.size(); ++i) {
        const double* q = &keys.values[keys.width * (cubic ? 3 * i + 1 : i)];
        if (q[0] == 0.0 && q[1] == 0.0 && q[2] == 0.0 && q[3] == 0.0) {
            file.fail(where, "the rotation of key {} is the zero quaternion; mend it", i);
        }
    }
}

Keyframes keysOf(const File& file, const Json& sampler, const Target& target,
                 const std::string& where) {
    const int input = indexOf(file, sampler, "input", where);
    const int output = indexOf(file, sampler, "output", where);
    if (input == -1 || output == -1) {
        file.fail(where, "it has no {}; export the file again", input == -1 ? "input" : "output");
    }
    Keyframes keys{.times = timesOf(file, input, where + ", input"),
                   .values = {},
                   .width = target.width,
                   .interpolation = interpolationOf(file, sampler, where),
                   .rotation = target.rotation};
    const auto components = target.list ? 1 : static_cast<int>(target.width);
    keys.values = finiteNumbers(
        file, readFloats(file, output, components, Integers::kAny, where + ", output"),
        where + ", output");
    const size_t parts = keys.interpolation == Interpolation::kCubicSpline ? 3 : 1;
    if (keys.values.size() != keys.times.size() * parts * keys.width) {
        file.fail(where,
                  "it has {} numbers for {} keys, which take {} each ({}); export the file again",
                  keys.values.size(), keys.times.size(), parts * keys.width, target.name);
    }
    if (keys.rotation) {
        checkRotations(file, keys, where);
    }
    return keys;
}

std::string nameOf(const Json& animation) { return oneLine(textOf(animation, "name", "")); }

size_t chosenAnimation(File& file, const Json& animations, const std::string& name) {
    std::string names;
    size_t index = animations.size();
    for (size_t i = 0; i < animations.size(); ++i) {
        const std::string own = nameOf(animations[i]);
        names += fmt::format("{}{}", i == 0 ? "" : ", ", own.empty() ? std::to_string(i) : own);
        if (index == animations.size() && (name.empty() || name == own)) {
            index = i;
        }
    }
    size_t number = 0;
    const char* end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data(), end, number);
    if (index == animations.size() && error == std::errc() && stop == end) {
        index = number;
    }
    if (index >= animations.size()) {
        throwUsage("--animation {}: {} has no such animation; it has {}", oneLine(name), file.path,
                   names.empty() ? "none" : names);
    }
    if (name.empty() && animations.size() > 1) {
        file.notes.add(fmt::format("the file has {} animations, {}: {} shown; --animation chooses",
                                   animations.size(), names,
                                   label("animation", 0, nameOf(animations[0]))));
    }
    return index;
}

}  // namespace

Animation readAnimation(File& file, const std::string& name) {
    const Json none = Json::array();
    const Json& animations = file.animations ? *file.animations : none;
    if (animations.empty() && name.empty()) {
        return {};
    }
    const size_t index = chosenAnimation(file, animations, name);
    const Json& source = animations[index];
    Animation animation{.name = nameOf(source)};
    const std::string whole = label("animation", index, animation.name);
    const Json& samplers = listOf(file, source, "samplers", whole);
    const Json& channels = listOf(file, source, "channels", whole);
    std::set<std::string> moved;
    for (size_t i = 0; i < channels.size(); ++i) {
        const std::string where = fmt::format("{}, channel {}", whole, i);
        const Target target = targetOf(file, channels[i], where);
        if (!target.set) {
            file.notes.add(fmt::format("{}: what it moves ({}) stays at rest", whole, target.name));
            continue;
        }
        if (!moved.insert(target.name).second) {
            file.fail(where, "{} is moved by another channel, too; export the file again",
                      target.name);
        }
        const int sampler = indexOf(file, channels[i], "sampler", where);
        if (sampler < 0 || static_cast<size_t>(sampler) >= samplers.size()) {
            file.fail(where, "refers to sampler {}, but the animation has {}; export it again",
                      sampler, samplers.size());
        }
        Keyframes keys = keysOf(file, samplers[static_cast<size_t>(sampler)], target,
                                fmt::format("{}, sampler {}", whole, sampler));
        animation.seconds = std::max(animation.seconds, keys.times.back());
        animation.tracks.push_back({std::move(keys), target.set});
    }
    return animation;
}

void pose(const Animation& animation, double seconds, tinygltf::Model& model) {
    for (const Track& track : animation.tracks) {
        track.set(model, valueAt(track.keys, seconds));
    }
}

}  // namespace sheen::gltf
