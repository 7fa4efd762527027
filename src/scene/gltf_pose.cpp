// Meshes in their first pose: morphed by the weights that are stored, and skinned to joints where
// their nodes stand.
#include <glm/gtc/type_ptr.hpp>

#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

// What is left of a vertex's joints when a set of four each has been read.
struct JointSet {
    std::vector<float> joints, weights;  // [vertex][4]
};

JointSet readJointSet(const File& file, const tinygltf::Primitive& source, int set, size_t count,
                      const std::string& where) {
    JointSet result;
    const auto read = [&](const std::string& name, Integers integers) {
        const auto found = source.attributes.find(name);
        std::vector<float> values;
        if (found != source.attributes.end()) {
            values = readFloats(file, found->second, 4, integers, where + ", " + name);
            if (values.size() != 4 * count) {
                file.fail(where, "{} has {} elements and POSITION {}; export the file again", name,
                          values.size() / 4, count);
            }
        }
        return values;
    };
    result.joints = read(fmt::format("JOINTS_{}", set), Integers::kAny);
    result.weights = read(fmt::format("WEIGHTS_{}", set), Integers::kNormalizedUnsigned);
    return result;
}

}  // namespace

std::vector<double> morphWeights(const File& file, const tinygltf::Node& node) {
    const tinygltf::Mesh& mesh = file.model.meshes[static_cast<size_t>(node.mesh)];
    return node.weights.empty() ? mesh.weights : node.weights;
}

void addMorphTargets(const File& file, const tinygltf::Primitive& source, const char* attribute,
                     const std::vector<double>& weights, size_t components, std::span<float> values,
                     const std::string& where) {
    for (size_t i = 0; i < std::min(source.targets.size(), weights.size()); ++i) {
        const auto found = source.targets[i].find(attribute);
        if (weights[i] == 0.0 || found == source.targets[i].end()) {
            continue;
        }
        const std::string target = fmt::format("{}, target {}, {}", where, i, attribute);
        const std::vector<float> offsets =
            readFloats(file, found->second, 3, Integers::kAny, target);
        if (offsets.size() / 3 != values.size() / components) {
            file.fail(target, "its length differs from the mesh's; export the file again");
        }
        for (size_t k = 0; k < offsets.size(); ++k) {
            values[k / 3 * components + k % 3] += static_cast<float>(weights[i] * offsets[k]);
        }
    }
}

std::vector<glm::dmat4> jointTransforms(const File& file, int skin,
                                        const std::vector<glm::dmat4>& file_from_node,
                                        const std::string& where) {
    const tinygltf::Skin& source = file.at(file.model.skins, skin, where, "skin");
    const std::string skin_where = label("skin", static_cast<size_t>(skin), source.name);
    std::vector<float> inverses;
    if (source.inverseBindMatrices != -1) {
        inverses = readFloats(file, source.inverseBindMatrices, 16, Integers::kNo, skin_where);
        if (inverses.size() < 16 * source.joints.size()) {
            file.fail(skin_where, "it has {} joints and {} inverse bind matrices; export it again",
                      source.joints.size(), inverses.size() / 16);
        }
    }
    std::vector<glm::dmat4> transforms;
    for (size_t i = 0; i < source.joints.size(); ++i) {
        file.at(file.model.nodes, source.joints[i], skin_where, "node");
        const glm::dmat4 joint_from_mesh =
            inverses.empty() ? glm::dmat4(1.0) : glm::dmat4(glm::make_mat4(&inverses[16 * i]));
        transforms.push_back(file_from_node[static_cast<size_t>(source.joints[i])] *
                             joint_from_mesh);
    }
    return transforms;
}

std::vector<glm::dmat4> skinnedTransforms(const File& file, const tinygltf::Primitive& source,
                                          const std::vector<glm::dmat4>& joints, size_t count,
                                          const std::string& where) {
    std::vector<glm::dmat4> transforms;
    std::vector<double> sums(count, 0.0);
    for (int set = 0;; ++set) {
        const JointSet read = readJointSet(file, source, set, count, where);
        if (read.joints.empty() || read.weights.empty()) {
            break;
        }
        transforms.resize(count, glm::dmat4(0.0));
        for (size_t i = 0; i < 4 * count; ++i) {
            const double weight = read.weights[i];
            if (!(weight > 0.0)) {
                continue;
            }
            const float joint = read.joints[i];
            if (!(joint >= 0.0f) || !(joint < static_cast<float>(joints.size()))) {
                file.fail(where, "joint {} is out of range: its skin has {}; export the file again",
                          joint, joints.size());
            }
            transforms[i / 4] += weight * joints[static_cast<size_t>(joint)];
            sums[i / 4] += weight;
        }
    }
    for (size_t i = 0; i < transforms.size(); ++i) {
        if (sums[i] > 0.0) {
            transforms[i] /= sums[i];
        } else if (!joints.empty()) {
            transforms[i] = joints[0];
        }
    }
    return transforms;
}

}  // namespace sheen::gltf
