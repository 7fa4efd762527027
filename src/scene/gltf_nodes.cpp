// Nodes: where each stands, and what it shows there.
// Based on: the glTF 2.0 specification, EXT_mesh_gpu_instancing.
#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <set>

#include "core/memory.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

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
std::vector<int> rootNodes(File& file) {
    const tinygltf::Model& model = file.model;
    if (!model.scenes.empty()) {
        const int index = shownScene(file);
        if (model.scenes.size() > 1) {
            file.notes.add(
                fmt::format("the file has {} scenes: scene {} shown", model.scenes.size(), index));
        }
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

struct PlacedNode {
    int node;
    glm::dmat4 file_from_node;
};

// Depth first, children in their order, without recursion: a chain of nodes may be long.
std::vector<PlacedNode> placedNodes(File& file) {
    struct Visit {
        int node;
        glm::dmat4 file_from_parent;
        std::string parent;
    };
    std::vector<PlacedNode> placed;
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
        placed.push_back({visit.node, file_from_node});
        push(node.children, file_from_node, where);
    }
    return placed;
}

void appendNode(File& file, const PlacedNode& placed, const std::vector<glm::dmat4>& file_from_node,
                Scene& scene) {
    const auto index = static_cast<size_t>(placed.node);
    const tinygltf::Node& node = file.model.nodes[index];
    const std::string where = label("node", index, node.name);
    const glm::dmat4 world_from_file = glm::translate(glm::dmat4(1.0), -scene.origin);
    const glm::dmat4 world_from_node = world_from_file * placed.file_from_node;
    if (node.mesh != -1) {
        file.at(file.model.meshes, node.mesh, where, "mesh");
        Pose pose{.world_from_mesh = world_from_node, .weights = morphWeights(file, node)};
        if (node.skin != -1) {
            pose.world_from_joint = jointTransforms(file, node.skin, file_from_node, where);
            for (glm::dmat4& joint : pose.world_from_joint) {
                joint = world_from_file * joint;
            }
        }
        for (const glm::dmat4& node_from_instance : instancesOf(file, node, where)) {
            pose.world_from_mesh = world_from_node * node_from_instance;
            appendMesh(file, node.mesh, pose, scene);
        }
    }
    if (node.camera != -1) {
        appendCamera(file, node, world_from_node, where, scene);
    }
    if (node.extensions.count("KHR_lights_punctual") > 0) {
        appendLight(file, node, world_from_node, where, scene);
    }
}

}  // namespace

int shownScene(const File& file) {
    return file.model.scenes.empty() ? -1 : std::max(file.model.defaultScene, 0);
}

std::string firstName(const std::string& own, const std::string& node, const char* kind,
                      size_t index) {
    return !own.empty()    ? oneLine(own)
           : !node.empty() ? oneLine(node)
                           : fmt::format("{} {}", kind, index);
}

void appendNodes(File& file, Scene& scene) {
    const std::vector<PlacedNode> all = placedNodes(file);
    // Joints of a skin; those outside of the scene stand at the origin.
    std::vector<glm::dmat4> file_from_node(file.model.nodes.size(), glm::dmat4(1.0));
    for (const PlacedNode& placed : all) {
        file_from_node[static_cast<size_t>(placed.node)] = placed.file_from_node;
    }
    for (const PlacedNode& placed : all) {
        appendNode(file, placed, file_from_node, scene);
    }
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

}  // namespace sheen::gltf
