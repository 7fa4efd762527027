// The glTF loader: parses the file, then walks its nodes, appending meshes, lights and cameras in
// world space, about an origin that suits the camera. Never trusts the file: see gltf_parts.h.
// Based on: the glTF 2.0 specification, KHR_lights_punctual.
#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <set>

#include "core/memory.h"
#include "scene/defaults.h"
#include "scene/gltf_parts.h"
#include "scene/sun.h"

namespace sheen {
namespace gltf {
namespace {

// Squares of distances up to here are floats.
constexpr double kLargestExtent = 1e18;

// What the lights bring to a scene, in lux or nits: beyond these, squares of radiances and what is
// a thousandth of the brightest leave the range of floats.
constexpr double kDimmestLevel = 1e-12;
constexpr double kBrightestLevel = 1e12;

// A node's matrix, whose last row must be 0 0 0 w; w divides all else.
glm::dmat4 affineMatrix(File& file, const std::vector<double>& values, const std::string& where) {
    constexpr double kRounding = 1e-6;
    glm::dmat4 matrix = glm::make_mat4(values.data());
    const double w = matrix[3][3];
    const glm::dvec3 row(matrix[0][3], matrix[1][3], matrix[2][3]);
    if (w == 0.0 || glm::length(row) > kRounding * std::abs(w)) {
        file.fail(where,
                  "its matrix is projective: the last row is {} {} {} {} and must be 0 0 0 1; "
                  "export the file again",
                  row.x, row.y, row.z, w);
    }
    if (std::abs(w - 1.0) > kRounding) {
        file.notes.add(fmt::format(
            "{}: the last element of its matrix is {} and should be 1: all of it divided by that",
            where, w));
        matrix /= w;
    }
    matrix[0][3] = matrix[1][3] = matrix[2][3] = 0.0;
    matrix[3][3] = 1.0;
    return matrix;
}

// The glTF matrix of a node, from its matrix or its translation, rotation and scale.
glm::dmat4 localTransform(File& file, const tinygltf::Node& node, const std::string& where) {
    const auto check = [&](const std::vector<double>& values, size_t count, const char* what) {
        if (!values.empty() && values.size() != count) {
            file.fail(where, "{} must hold {} numbers, not {}", what, count, values.size());
        }
        for (const double value : values) {
            finiteFloat(file, value, where, what);
        }
        return !values.empty();
    };
    if (check(node.matrix, 16, "matrix")) {
        return affineMatrix(file, node.matrix, where);
    }
    glm::dmat4 transform(1.0);
    if (check(node.translation, 3, "translation")) {
        transform[3] = glm::dvec4(glm::make_vec3(node.translation.data()), 1.0);
    }
    if (check(node.rotation, 4, "rotation")) {
        const std::vector<double>& q = node.rotation;
        const glm::dquat rotation(q[3], q[0], q[1], q[2]);
        if (!(glm::length(rotation) > 0.0)) {
            file.fail(where, "rotation must not be the zero quaternion");
        }
        transform = transform * glm::mat4_cast(glm::normalize(rotation));
    }
    if (check(node.scale, 3, "scale")) {
        for (int c = 0; c < 3; ++c) {
            transform[c] *= node.scale[static_cast<size_t>(c)];
        }
    }
    return transform;
}

std::string firstName(const std::string& own, const std::string& node, const char* kind,
                      size_t index) {
    return !own.empty()    ? oneLine(own)
           : !node.empty() ? oneLine(node)
                           : fmt::format("{} {}", kind, index);
}

void appendCamera(File& file, const tinygltf::Node& node, const glm::dmat4& world_from_node,
                  const std::string& where, Scene& scene) {
    const tinygltf::Camera& source = file.at(file.model.cameras, node.camera, where, "camera");
    const std::string camera_where = fmt::format("camera {}", node.camera);
    const bool parallel = source.type == "orthographic";
    const double y_fov = parallel ? Camera().y_fov : source.perspective.yfov;
    const bool in_range = y_fov > 0.0 && y_fov < 4.0;  // that a float holds
    if (!in_range || !(static_cast<float>(y_fov) > 0.0f) || !(static_cast<float>(y_fov) < kPi)) {
        file.fail(camera_where, "yfov must lie between 0 and pi radians, but is {}", y_fov);
    }
    if (parallel && !(source.orthographic.ymag > 0.0)) {
        file.fail(camera_where, "ymag must be positive, but is {}", source.orthographic.ymag);
    }
    // Only where it stands and looks: a camera's node may be scaled or mirrored.
    const glm::dvec3 back = glm::normalize(glm::dvec3(world_from_node[2]));
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(world_from_node[1]), back));
    const glm::dvec3 up = glm::cross(back, right);
    const glm::dmat4 rigid(glm::dvec4(right, 0.0), glm::dvec4(up, 0.0), glm::dvec4(back, 0.0),
                           world_from_node[3]);
    if (!std::isfinite(glm::dot(back, back) + glm::dot(right, right))) {
        file.notes.add("camera whose transform is singular left out");
        return;
    }
    scene.cameras.push_back(
        {.name = firstName(source.name, node.name, "camera", scene.cameras.size()),
         .world_from_camera = mat4(rigid),
         .y_fov = static_cast<float>(y_fov),
         .aspect = std::max(0.0f, finiteFloat(file, source.perspective.aspectRatio, camera_where,
                                              "aspectRatio"))});
    if (parallel) {
        file.parallel_cameras.push_back(
            {.camera = scene.cameras.size() - 1,
             .half_height = finiteFloat(file, source.orthographic.ymag, camera_where, "ymag"),
             .near = finiteFloat(file, source.orthographic.znear, camera_where, "znear")});
    }
}

// Parallel cameras become ones of perspective, so far away that what they see hardly converges:
// it is as large as it should be at the scene's middle. What lay behind them stays unseen.
void placeParallelCameras(File& file, Scene& scene) {
    constexpr float kDistance = 200.0f;  // of the scene's size: 1/400 larger or smaller at its ends
    for (const File::ParallelCamera& parallel : file.parallel_cameras) {
        Camera& camera = scene.cameras[parallel.camera];
        const float back = kDistance * std::max(scene.bounds.size(), parallel.half_height);
        const vec3 axis(camera.world_from_camera[2]);
        const float to_middle =
            scene.bounds.empty()
                ? 0.0f
                : glm::dot(axis, vec3(camera.world_from_camera[3]) - scene.bounds.center());
        camera.world_from_camera[3] += vec4(back * axis, 0.0f);
        camera.near = back + std::max(parallel.near, 0.0f);
        camera.y_fov = 2.0f * std::atan(parallel.half_height / (back + to_middle));
        file.notes.add(
            "orthographic camera is approximated: seen from afar, in perspective that converges "
            "by less than 1 in 200");
    }
}

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

std::vector<int> rootNodes(const File& file) {
    const tinygltf::Model& model = file.model;
    if (!model.scenes.empty()) {
        const int index = model.defaultScene >= 0 ? model.defaultScene : 0;
        return file.at(model.scenes, index, "scene", "scene").nodes;
    }
    std::set<int> children;
    for (const tinygltf::Node& node : model.nodes) {
        children.insert(node.children.begin(), node.children.end());
    }
    std::vector<int> roots;
    for (int i = 0; i < static_cast<int>(model.nodes.size()); ++i) {
        if (children.count(i) == 0) {
            roots.push_back(i);
        }
    }
    return roots;
}

// EXT_mesh_gpu_instancing: where a node's mesh stands, each time; once without.
std::vector<glm::dmat4> instancesOf(const File& file, const tinygltf::Node& node,
                                    const std::string& node_where) {
    const auto found = node.extensions.find("EXT_mesh_gpu_instancing");
    if (found == node.extensions.end() || !found->second.Has("attributes")) {
        return {glm::dmat4(1.0)};
    }
    const std::string where = node_where + ", EXT_mesh_gpu_instancing";
    const tinygltf::Value& attributes = found->second.Get("attributes");
    std::vector<glm::dmat4> transforms;
    const auto read = [&](const char* name, int components) {
        std::vector<float> values;
        const int accessor = integerMember(file, attributes, name, -1, where);
        if (accessor != -1) {
            values = readFloats(file, accessor, components, Integers::kAny, where);
            const size_t count = values.size() / static_cast<size_t>(components);
            if (!transforms.empty() && transforms.size() != count) {
                file.fail(where, "its attributes differ in length; export the file again");
            }
            transforms.resize(count, glm::dmat4(1.0));
        }
        return values;
    };
    const std::vector<float> translations = read("TRANSLATION", 3);
    const std::vector<float> rotations = read("ROTATION", 4);
    const std::vector<float> scales = read("SCALE", 3);
    for (size_t i = 0; i < transforms.size(); ++i) {
        glm::dmat4& transform = transforms[i];
        if (!translations.empty()) {
            transform[3] = glm::dvec4(glm::make_vec3(&translations[3 * i]), 1.0);
        }
        if (!rotations.empty()) {
            const float* q = &rotations[4 * i];
            const glm::dquat rotation(q[3], q[0], q[1], q[2]);
            transform *= glm::mat4_cast(glm::normalize(rotation));
        }
        for (int c = 0; c < 3 && !scales.empty(); ++c) {
            transform[c] *= scales[3 * i + static_cast<size_t>(c)];
        }
        for (int c = 0; c < 16; ++c) {
            finiteFloat(file, transform[c / 4][c % 4], where, "transform element");
        }
        if (glm::length(glm::dvec3(transform[3])) > kLargestExtent) {
            file.fail(where, "an instance lies more than {} m away; move it closer",
                      kLargestExtent);
        }
    }
    return transforms;
}

void appendNode(File& file, const tinygltf::Node& node, const glm::dmat4& file_from_node,
                const std::string& where, Scene& scene) {
    glm::dmat4 world_from_node = file_from_node;
    world_from_node[3] -= glm::dvec4(scene.origin, 0.0);
    if (node.mesh != -1) {
        file.at(file.model.meshes, node.mesh, where, "mesh");
        for (const glm::dmat4& node_from_instance : instancesOf(file, node, where)) {
            appendMesh(file, node.mesh, world_from_node * node_from_instance, scene);
        }
    }
    if (node.skin != -1) {
        file.notes.add("skins are not supported: mesh shown as it was before skinning");
    }
    if (node.camera != -1) {
        appendCamera(file, node, world_from_node, where, scene);
    }
    if (node.extensions.count("KHR_lights_punctual") > 0) {
        appendLight(file, node, world_from_node, where, scene);
    }
}

// Depth first, children in their order, without recursion: a chain of nodes may be long.
void walkNodes(File& file, Scene& scene) {
    struct Visit {
        int node;
        glm::dmat4 file_from_parent;
        std::string parent;
    };
    std::vector<Visit> pending;
    std::vector<bool> seen(file.model.nodes.size(), false);
    const auto push = [&](const std::vector<int>& nodes, const glm::dmat4& file_from_parent,
                          const std::string& parent) {
        for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
            pending.push_back({*node, file_from_parent, parent});
        }
    };
    push(rootNodes(file), glm::dmat4(1.0), "scene");
    while (!pending.empty()) {
        const Visit visit = pending.back();
        pending.pop_back();
        const tinygltf::Node& node = file.at(file.model.nodes, visit.node, visit.parent, "node");
        const std::string where = label("node", static_cast<size_t>(visit.node), node.name);
        if (seen[static_cast<size_t>(visit.node)]) {
            file.fail(where, "is reached twice: nodes must form a tree; export the file again");
        }
        seen[static_cast<size_t>(visit.node)] = true;
        const glm::dmat4 file_from_node =
            visit.file_from_parent * localTransform(file, node, where);
        for (int c = 0; c < 16; ++c) {
            finiteFloat(file, file_from_node[c / 4][c % 4], where, "transform element");
        }
        if (glm::length(glm::dvec3(file_from_node[3])) > kLargestExtent) {
            file.fail(where, "lies more than {} m from the origin; move it closer", kLargestExtent);
        }
        appendNode(file, node, file_from_node, where, scene);
        push(node.children, file_from_node, where);
    }
}

// Where world space should begin, in its present coordinates: where the camera stands, if what is
// nearest to it lies so much nearer than the present origin that floats would lose it; else there.
vec3 betterOrigin(const Scene& scene, const std::string& camera) {
    constexpr float kFarthest = 256.0f;
    vec3 eye = scene.bounds.center();
    float nearest = scene.bounds.size();  // a camera is made that frames them
    if (!scene.cameras.empty()) {
        eye = vec3(findCamera(scene, camera).world_from_camera[3]);
        nearest = kInfinity;
        for (const vec3& p : scene.positions) {
            nearest = std::min(nearest, glm::distance(p, eye));
        }
    }
    const bool lost = !scene.bounds.empty() && maxAbs(eye) > kFarthest * nearest;
    return lost ? eye : vec3(0.0f);
}

// Fills geometry, lights and cameras.
void flatten(File& file, const std::string& camera, Scene& scene) {
    const Notes notes = file.notes;
    walkNodes(file, scene);
    const vec3 origin = betterOrigin(scene, camera);
    if (origin == vec3(0.0f)) {
        return;
    }
    // Anew from doubles, since what is there has lost digits.
    file.notes = notes;
    file.parallel_cameras.clear();
    Scene again;
    again.materials = std::move(scene.materials);
    again.textures = std::move(scene.textures);
    again.images = std::move(scene.images);
    again.origin = dvec3(origin);
    scene = std::move(again);
    walkNodes(file, scene);
}

// Many nodes may show one mesh, and a small file become a large scene.
void checkMeshMemory(const File& file) {
    constexpr uint64_t kBytesPerCorner = 96;  // a vertex each, while arrays grow
    const tinygltf::Model& model = file.model;
    uint64_t corners = 0;
    const auto instances = [&](const tinygltf::Node& node) {
        uint64_t most = 1;
        const auto found = node.extensions.find("EXT_mesh_gpu_instancing");
        for (const char* name : {"TRANSLATION", "ROTATION", "SCALE"}) {
            if (found != node.extensions.end() && found->second.Has("attributes") &&
                found->second.Get("attributes").Has(name)) {
                const auto index = static_cast<size_t>(integerMember(
                    file, found->second.Get("attributes"), name, -1, "EXT_mesh_gpu_instancing"));
                most = index < model.accessors.size()
                           ? std::max(most, accessorCount(file, model.accessors[index]))
                           : most;
            }
        }
        return most;
    };
    for (const tinygltf::Node& node : model.nodes) {
        if (node.mesh < 0 || static_cast<size_t>(node.mesh) >= model.meshes.size()) {
            continue;
        }
        for (const tinygltf::Primitive& p :
             model.meshes[static_cast<size_t>(node.mesh)].primitives) {
            const auto position = p.attributes.find("POSITION");
            const int index = p.indices >= 0                   ? p.indices
                              : position == p.attributes.end() ? -1
                                                               : position->second;
            if (index >= 0 && static_cast<size_t>(index) < model.accessors.size()) {
                corners += instances(node) *
                           accessorCount(file, model.accessors[static_cast<size_t>(index)]);
            }
        }
    }
    checkMemory({.bytes = corners * kBytesPerCorner}, file.path,
                fmt::format("its meshes have {} corners, simplify them", corners));
}

void checkExtent(const File& file, const Scene& scene) {
    const Bounds& b = scene.bounds;
    if (b.empty()) {
        return;
    }
    const double farthest =
        std::max(glm::length(scene.inFile(b.lower)), glm::length(scene.inFile(b.upper)));
    if (farthest > kLargestExtent) {
        file.fail("meshes", "reach {} m from the origin, more than {}; move or scale them",
                  farthest, kLargestExtent);
    }
    const double size = glm::length(glm::dvec3(b.upper) - glm::dvec3(b.lower));
    if (size > kLargestExtent) {
        file.fail("meshes", "together they extend over {} m, more than {}; scale or mend them",
                  size, kLargestExtent);
    }
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

// Light that floats cannot follow is refused: the image would be black, white or not finite.
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

}  // namespace
}  // namespace gltf

Scene loadScene(const std::string& path, const std::string& camera,
                const EnvironmentParams& environment) {
    gltf::File file{.path = path, .model = {}, .notes = {}};
    Scene scene;
    try {
        gltf::parse(file);
        gltf::loadMaterials(file, scene);
        gltf::checkMeshMemory(file);
        gltf::flatten(file, camera, scene);
        gltf::checkExtent(file, scene);
        gltf::placeParallelCameras(file, scene);
        gltf::checkLightLevel(file, scene);
        gltf::separateCoplanar(file, scene);
    } catch (const std::bad_alloc&) {
        throwEnvironment("{}: not enough memory to load it", path);
    }
    gltf::noteIgnoredParts(file);
    gltf::listFeatures(file, scene);
    std::vector<std::string> sky_warnings;
    scene.environment = loadEnvironment(environment, file.read, sky_warnings);
    for (const std::string& warning : sky_warnings) {
        file.notes.add(warning);
    }
    if (const auto sun = takeOutSun(scene.environment)) {
        scene.lights.push_back(*sun);
        scene.light_names.push_back("sun");
        file.notes.add(fmt::format(
            "{}: its sun, {:.3g} lux, is taken out of the image and shines as a directional light",
            environment.source, luminance(sun->intensity)));
    }
    if (scene.triangles.empty()) {
        file.notes.add("the scene has no geometry");
    }
    if (scene.cameras.empty()) {
        scene.cameras.push_back(framingCamera(scene.bounds));
        if (!scene.triangles.empty()) {
            file.notes.add(
                "the scene has no camera: seen from the front, all of it in view; "
                "export it with a camera to see it from there");
        }
    }
    if (!scene.triangles.empty() && environment.source != "none" && isDark(scene)) {
        scene.lights.push_back(keyLight(scene.cameras.front()));
        scene.light_names.push_back("default");
        if (!environment.no_sky) {
            scene.environment = studioSky(scene.cameras.front());
            scene.environment.visible = !environment.transparent;
        }
        file.notes.add(
            environment.no_sky
                ? "the scene has no light and nothing that emits: lit by a key light from above, "
                  "to the left of its first view; --gather ray lights it by a studio's sky as well"
                : "the scene has no light and nothing that emits: lit by a studio's grey sky and a "
                  "key light from above, to the left of its first view; --environment lights it by "
                  "another sky or, by none, not at all");
    }
    scene.files = std::move(file.read);
    scene.files.push_back(path);
    scene.warnings = file.notes.lines();
    return scene;
}

}  // namespace sheen
