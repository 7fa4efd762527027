// The glTF loader: reads and parses the file, then walks its nodes, appending meshes, lights and
// cameras in world space. Never trusts the file: see gltf_parts.h.
// Based on: the glTF 2.0 specification, KHR_lights_punctual.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <set>

#include "scene/gltf_parts.h"

namespace sheen {
namespace gltf {

void Notes::add(const std::string& what, int64_t count) {
    for (auto& [known, total] : notes_) {
        if (known == what) {
            total += count;
            return;
        }
    }
    notes_.emplace_back(what, count);
}

std::vector<std::string> Notes::lines() const {
    std::vector<std::string> lines;
    for (const auto& [what, count] : notes_) {
        lines.push_back(count == 1 ? what : fmt::format("{} ({} times)", what, count));
    }
    return lines;
}

bool File::uses(const std::string& extension) const {
    const std::vector<std::string>& used = model.extensionsUsed;
    return std::find(used.begin(), used.end(), extension) != used.end();
}

float finiteFloat(const File& file, double value, const std::string& where, const char* what) {
    const auto result = static_cast<float>(value);
    if (!std::isfinite(result)) {
        file.fail(where, "{} {} is not a number that can be used; mend it", what, value);
    }
    return result;
}

double numberMember(const File& file, const tinygltf::Value& object, const std::string& key,
                    double fallback, const std::string& where) {
    if (!object.Has(key)) {
        return fallback;
    }
    const tinygltf::Value& member = object.Get(key);
    if (!member.IsNumber()) {
        file.fail(where, "{} must be a number", key);
    }
    return member.GetNumberAsDouble();
}

namespace {

constexpr int kMaxJsonDepth = 200;
constexpr size_t kGlbHeaderSize = 20;

// Extensions that are read; KHR_texture_transform is not, but has its own note at the material.
const std::set<std::string> kSupported = {"KHR_materials_specular",
                                          "KHR_materials_emissive_strength", "KHR_lights_punctual",
                                          "KHR_mesh_quantization"};

std::string readWholeFile(const std::string& path) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) {
        throwInput("{}: no such file; check the path", path);
    }
    if (std::filesystem::is_directory(status)) {
        throwInput("{}: is a directory; name the .glb or .gltf file in it", path);
    }
    std::ifstream in(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (!in.is_open() || in.bad()) {
        throwInput("{}: cannot be read; check its permissions", path);
    }
    if (bytes.empty()) {
        throwInput("{}: is empty; export it again", path);
    }
    if (bytes.size() > std::numeric_limits<uint32_t>::max()) {
        throwInput("{}: has more than 4 GiB, which glTF cannot hold; split the scene", path);
    }
    return bytes;
}

uint32_t littleEndian32(const std::string& bytes, size_t offset) {
    uint32_t value = 0;
    for (size_t i = 4; i-- > 0;) {
        value = value << 8 | static_cast<unsigned char>(bytes[offset + i]);
    }
    return value;
}

bool isBinary(const std::string& bytes) { return bytes.compare(0, 4, "glTF") == 0; }

// Checks a .glb file's header and returns its JSON; for other files the whole text.
std::string_view jsonOf(const std::string& path, const std::string& bytes) {
    if (!isBinary(bytes)) {
        const size_t start = bytes.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
        if (start == std::string::npos || bytes[start] != '{') {
            throwInput("{}: is neither a .glb nor a .gltf file by its content; export it again",
                       path);
        }
        return bytes;
    }
    if (bytes.size() < kGlbHeaderSize) {
        throwInput("{}: header: the file ends after {} bytes; copy or export it again", path,
                   bytes.size());
    }
    const uint32_t version = littleEndian32(bytes, 4);
    if (version != 2) {
        throwInput("{}: header: is binary glTF version {}; export it as version 2", path, version);
    }
    const uint32_t length = littleEndian32(bytes, 8);
    const uint32_t json_length = littleEndian32(bytes, 12);
    if (length > bytes.size() || json_length > bytes.size() - kGlbHeaderSize) {
        throwInput(
            "{}: header: the file is truncated: it should have {} bytes and has {}; copy or "
            "export it again",
            path, std::max<uint64_t>(length, uint64_t{json_length} + kGlbHeaderSize), bytes.size());
    }
    return std::string_view(bytes).substr(kGlbHeaderSize, json_length);
}

// tinygltf copies JSON values recursively: nesting without end would overflow the stack.
void checkNesting(const std::string& path, std::string_view json) {
    int depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (in_string) {
            i += c == '\\' ? 1 : 0;
            in_string = c != '"';
        } else if (c == '"') {
            in_string = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kMaxJsonDepth) {
                throwInput("{}: JSON: nested more than {} deep; export it again", path,
                           kMaxJsonDepth);
            }
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
}

// Keeps an image's bytes; those in buffer views are read later, with their bounds checked.
bool keepImage(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
               const unsigned char* bytes, int size, void*) {
    if (image->bufferView < 0) {
        image->image.assign(bytes, bytes + size);
    }
    return true;
}

// External files must be regular ones: a scene cannot name a device or a directory.
bool readExternal(std::vector<unsigned char>* out, std::string* error, const std::string& path,
                  void* user_data) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code)) {
        *error += fmt::format("{} is not a file", path);
        return false;
    }
    return tinygltf::ReadWholeFile(out, error, path, user_data);
}

std::string oneLine(std::string text) {
    constexpr size_t kLongest = 240;
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) {
        text.pop_back();
    }
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text.size() > kLongest ? text.substr(0, kLongest) + "..." : text;
}

void checkRequiredExtensions(const File& file) {
    for (const std::string& name : file.model.extensionsRequired) {
        if (kSupported.count(name) == 0) {
            file.fail("extensionsRequired", "{} is not supported; export the file without it",
                      name);
        }
    }
}

void parse(File& file) {
    const std::string bytes = readWholeFile(file.path);
    checkNesting(file.path, jsonOf(file.path, bytes));
    tinygltf::TinyGLTF parser;
    parser.SetImageLoader(&keepImage, nullptr);
    parser.SetFsCallbacks({&tinygltf::FileExists, &tinygltf::ExpandFilePath, &readExternal,
                           &tinygltf::WriteWholeFile, nullptr});
    const std::string folder = std::filesystem::path(file.path).parent_path().string();
    const auto size = static_cast<unsigned int>(bytes.size());
    std::string error;
    std::string warning;
    bool parsed = false;
    try {
        parsed = isBinary(bytes)
                     ? parser.LoadBinaryFromMemory(
                           &file.model, &error, &warning,
                           reinterpret_cast<const unsigned char*>(bytes.data()), size, folder)
                     : parser.LoadASCIIFromString(&file.model, &error, &warning, bytes.data(), size,
                                                  folder);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {  // of the JSON library, on values of the wrong type
        error = e.what();
    }
    // A file compressed by an extension often fails to parse for that reason: name it first.
    checkRequiredExtensions(file);
    if (!parsed) {
        file.fail("glTF", "{}; export it again", oneLine(error));
    }
    if (file.model.asset.version.compare(0, 2, "2.") != 0) {
        file.fail("asset", "is glTF version {}; export it as version 2.0",
                  oneLine(file.model.asset.version));
    }
}

// The glTF matrix of a node, from its matrix or its translation, rotation and scale.
glm::dmat4 localTransform(const File& file, const tinygltf::Node& node, const std::string& where) {
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
        return glm::make_mat4(node.matrix.data());
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
    return !own.empty() ? own : !node.empty() ? node : fmt::format("{} {}", kind, index);
}

void appendCamera(File& file, const tinygltf::Node& node, const glm::dmat4& world_from_node,
                  const std::string& where, Scene& scene) {
    const tinygltf::Camera& source = file.at(file.model.cameras, node.camera, where, "camera");
    if (source.type != "perspective") {
        file.notes.add("orthographic cameras are not supported: camera left out");
        return;
    }
    const std::string camera_where = fmt::format("camera {}", node.camera);
    const double y_fov = source.perspective.yfov;
    if (!(y_fov > 0.0) || !(y_fov < static_cast<double>(kPi))) {
        file.fail(camera_where, "yfov must lie between 0 and pi radians, but is {}", y_fov);
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
}

// Sets a spot's cone as KHR_lights_punctual recommends.
void setCone(const File& file, const tinygltf::SpotLight& spot, const std::string& where,
             PunctualLight& light) {
    const double inner = spot.innerConeAngle;
    const double outer = spot.outerConeAngle;
    if (!(inner >= 0.0) || !(outer > inner) || !(outer <= 1.5707964)) {
        file.fail(where, "cone angles must be 0 <= inner < outer <= pi/2, but are {} and {}", inner,
                  outer);
    }
    const double scale = 1.0 / std::max(0.001, std::cos(inner) - std::cos(outer));
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

void appendNode(File& file, const tinygltf::Node& node, const glm::dmat4& world_from_node,
                const std::string& where, Scene& scene) {
    if (node.mesh != -1) {
        file.at(file.model.meshes, node.mesh, where, "mesh");
        appendMesh(file, node.mesh, world_from_node, scene);
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
        glm::dmat4 world_from_parent;
        std::string parent;
    };
    std::vector<Visit> pending;
    std::vector<bool> seen(file.model.nodes.size(), false);
    const auto push = [&](const std::vector<int>& nodes, const glm::dmat4& world_from_parent,
                          const std::string& parent) {
        for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
            pending.push_back({*node, world_from_parent, parent});
        }
    };
    push(rootNodes(file), glm::dmat4(1.0), "scene");
    while (!pending.empty()) {
        const Visit visit = pending.back();
        pending.pop_back();
        const tinygltf::Node& node = file.at(file.model.nodes, visit.node, visit.parent, "node");
        const std::string where =
            fmt::format("node {}{}", visit.node, node.name.empty() ? "" : " (" + node.name + ")");
        if (seen[static_cast<size_t>(visit.node)]) {
            file.fail(where, "is reached twice: nodes must form a tree; export the file again");
        }
        seen[static_cast<size_t>(visit.node)] = true;
        const glm::dmat4 world_from_node =
            visit.world_from_parent * localTransform(file, node, where);
        for (int c = 0; c < 16; ++c) {
            finiteFloat(file, world_from_node[c / 4][c % 4], where, "transform element");
        }
        appendNode(file, node, world_from_node, where, scene);
        push(node.children, world_from_node, where);
    }
}

// Looks at the centre of the bounds from the front, a little from above, with all of them in view.
Camera framingCamera(const Bounds& bounds) {
    Camera camera{.name = "default"};
    if (bounds.empty()) {
        return camera;
    }
    const vec3 back = glm::normalize(vec3(0.35f, 0.3f, 1.0f));
    const vec3 right = glm::normalize(glm::cross(vec3(0.0f, 1.0f, 0.0f), back));
    const vec3 up = glm::cross(back, right);
    const float distance = 0.5f * bounds.size() / std::sin(0.5f * camera.y_fov);
    camera.world_from_camera = mat4(vec4(right, 0.0f), vec4(up, 0.0f), vec4(back, 0.0f),
                                    vec4(bounds.center() + distance * back, 1.0f));
    return camera;
}

void noteIgnoredExtensions(File& file) {
    for (const std::string& name : file.model.extensionsUsed) {
        if (kSupported.count(name) == 0 && name != "KHR_texture_transform") {
            file.notes.add(fmt::format("extension {} is not supported and ignored", oneLine(name)));
        }
    }
    if (!file.model.animations.empty()) {
        file.notes.add("animations are not supported: the scene is shown at rest");
    }
}

}  // namespace
}  // namespace gltf

Scene loadScene(const std::string& path) {
    gltf::File file{.path = path, .model = {}, .notes = {}};
    Scene scene;
    try {
        gltf::parse(file);
        gltf::loadMaterials(file, scene);
        gltf::walkNodes(file, scene);
    } catch (const std::bad_alloc&) {
        throwEnvironment("{}: not enough memory to load it", path);
    }
    gltf::noteIgnoredExtensions(file);
    if (scene.triangles.empty()) {
        file.notes.add("the scene has no geometry");
    }
    if (scene.cameras.empty()) {
        scene.cameras.push_back(gltf::framingCamera(scene.bounds));
    }
    scene.warnings = file.notes.lines();
    return scene;
}

}  // namespace sheen
