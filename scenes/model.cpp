#include "scenes/model.h"

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace sheen::scenes {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kPositionSteps = 65536.0;  // a metre
constexpr double kNormalSteps = 4096.0;
constexpr double kUvSteps = 4096.0;
constexpr double kNumberSteps = 1e6;
constexpr double kKeySteps = 1048576.0;  // of times, places and rotations that move

constexpr int kFloat = 5126;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

// Adding zero turns -0 into 0: which of the two a sum gives depends on the order of its terms.
double rounded(double value, double steps = kNumberSteps) {
    return std::round(value * steps) / steps + 0.0;
}

template <class Vector>
Json jsonOf(const Vector& v) {
    Json array = Json::array();
    for (int c = 0; c < v.length(); ++c) {
        array.push_back(rounded(v[c]));
    }
    return array;
}

void setPose(Json& node, const dvec3& translation, const dquat& rotation) {
    node["translation"] = jsonOf(translation);
    // A quaternion and its negative are one rotation: choose by sign, so that rounding cannot.
    const dquat q = rotation.w < -1e-9 ? -rotation : rotation;
    node["rotation"] = {rounded(q.x), rounded(q.y), rounded(q.z), rounded(q.w)};
}

class Encoder {
  public:
    explicit Encoder(const Model& model) : model_(model) {}

    std::vector<uint8_t> encode() {
        json_["asset"] = {{"version", "2.0"}, {"generator", "Sheen make_scenes"}};
        json_["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_specular",
                                   "KHR_materials_emissive_strength"};
        addCameras();
        addLights();
        addMaterials();
        for (const Object& object : model_.objects) {
            addObject(object);
        }
        addMotions();
        Json roots = Json::array();
        for (size_t i = 0; i < json_["nodes"].size(); ++i) {
            roots.push_back(i);
        }
        json_["scene"] = 0;
        json_["scenes"] = Json::array({{{"nodes", roots}}});
        json_["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
        return assemble();
    }

  private:
    int addView(size_t offset, int target) {
        Json view = {
            {"buffer", 0}, {"byteOffset", offset}, {"byteLength", binary_.size() - offset}};
        if (target != 0) {
            view["target"] = target;
        }
        json_["bufferViews"].push_back(view);
        binary_.resize((binary_.size() + 3) / 4 * 4, 0);
        return static_cast<int>(json_["bufferViews"].size()) - 1;
    }

    template <class T>
    void write(T value) {
        const size_t offset = binary_.size();
        binary_.resize(offset + sizeof(T));
        std::memcpy(binary_.data() + offset, &value, sizeof(T));
    }

    template <class Vector>
    int addVertices(const std::vector<Vector>& values, double steps, const char* type,
                    bool with_bounds) {
        const size_t offset = binary_.size();
        Vector lower(1e30);
        Vector upper(-1e30);
        for (const Vector& value : values) {
            for (int c = 0; c < value.length(); ++c) {
                const auto number = static_cast<float>(rounded(value[c], steps));
                lower[c] = std::min(lower[c], static_cast<double>(number));
                upper[c] = std::max(upper[c], static_cast<double>(number));
                write(number);
            }
        }
        Json accessor = {{"bufferView", addView(offset, kArrayBuffer)},
                         {"componentType", kFloat},
                         {"count", values.size()},
                         {"type", type}};
        if (with_bounds) {
            Json lower_json = Json::array();
            Json upper_json = Json::array();
            for (int c = 0; c < lower.length(); ++c) {
                lower_json.push_back(lower[c]);
                upper_json.push_back(upper[c]);
            }
            accessor["min"] = lower_json;
            accessor["max"] = upper_json;
        }
        json_["accessors"].push_back(accessor);
        return static_cast<int>(json_["accessors"].size()) - 1;
    }

    // Of an animation's samplers: vectors as rounded numbers.
    template <class Vector>
    int addKeys(const std::vector<Vector>& values, const char* type) {
        const int accessor = addVertices(values, kKeySteps, type, values[0].length() == 1);
        json_["bufferViews"].back().erase("target");
        return accessor;
    }

    size_t nodeCalled(const std::string& name) const {
        for (size_t i = 0; i < json_["nodes"].size(); ++i) {
            if (json_["nodes"][i]["name"] == name) {
                return i;
            }
        }
        SHEEN_CHECK(false);
        return 0;
    }

    void addMotions() {
        Json samplers = Json::array(), channels = Json::array();
        for (const Motion& motion : model_.motions) {
            std::vector<glm::dvec1> times;
            std::vector<dvec3> positions;
            std::vector<glm::dvec4> rotations;
            for (const Motion::Key& key : motion.keys) {
                times.emplace_back(key.seconds);
                positions.push_back(key.position);
                const dquat& q = key.rotation;
                rotations.emplace_back(q.x, q.y, q.z, q.w);
            }
            const int input = addKeys(times, "SCALAR");
            const auto add = [&](const char* path, int output) {
                channels.push_back(
                    {{"sampler", samplers.size()},
                     {"target", {{"node", nodeCalled(motion.name)}, {"path", path}}}});
                samplers.push_back({{"input", input}, {"output", output}});
            };
            add("translation", addKeys(positions, "VEC3"));
            add("rotation", addKeys(rotations, "VEC4"));
        }
        if (!channels.empty()) {
            json_["animations"] =
                Json::array({{{"name", "motion"}, {"channels", channels}, {"samplers", samplers}}});
        }
    }

    int addIndices(const Mesh& mesh) {
        const size_t offset = binary_.size();
        const bool is_short = mesh.positions.size() < 65535;
        for (const uint32_t index : mesh.indices) {
            SHEEN_CHECK(index < mesh.positions.size());
            if (is_short) {
                write(static_cast<uint16_t>(index));
            } else {
                write(index);
            }
        }
        json_["accessors"].push_back({{"bufferView", addView(offset, kElementArrayBuffer)},
                                      {"componentType", is_short ? kUnsignedShort : kUnsignedInt},
                                      {"count", mesh.indices.size()},
                                      {"type", "SCALAR"}});
        return static_cast<int>(json_["accessors"].size()) - 1;
    }

    void addObject(const Object& object) {
        const Mesh& mesh = object.mesh;
        Json attributes = {{"POSITION", addVertices(mesh.positions, kPositionSteps, "VEC3", true)}};
        if (!mesh.normals.empty()) {
            SHEEN_CHECK_EQ(mesh.normals.size(), mesh.positions.size());
            attributes["NORMAL"] = addVertices(mesh.normals, kNormalSteps, "VEC3", false);
        }
        const MaterialSpec& material = model_.materials[static_cast<size_t>(object.material)];
        if (material.texture >= 0 || material.normal_texture >= 0) {
            SHEEN_CHECK_EQ(mesh.uvs.size(), mesh.positions.size());
            attributes["TEXCOORD_0"] = addVertices(mesh.uvs, kUvSteps, "VEC2", false);
        }
        const Json primitive = {{"attributes", attributes},
                                {"indices", addIndices(mesh)},
                                {"material", object.material}};
        json_["meshes"].push_back(
            {{"name", object.name}, {"primitives", Json::array({primitive})}});
        const size_t index = json_["meshes"].size() - 1;
        for (const dmat4& placement : object.placements) {
            Json node = {{"name", object.name}, {"mesh", index}};
            if (placement != dmat4(1.0)) {
                setPose(node, dvec3(placement[3]), glm::quat_cast(glm::dmat3(placement)));
            }
            json_["nodes"].push_back(node);
        }
    }

    void addCameras() {
        for (const CameraSpec& camera : model_.cameras) {
            const size_t index = json_["cameras"].size();
            json_["cameras"].push_back(
                {{"name", camera.name},
                 {"type", "perspective"},
                 {"perspective", {{"yfov", rounded(camera.y_fov)}, {"znear", 0.01}}}});
            Json node = {{"name", camera.name}, {"camera", index}};
            setPose(node, camera.position, lookRotation(camera.target - camera.position));
            json_["nodes"].push_back(node);
        }
    }

    void addLights() {
        if (model_.lights.empty()) {
            return;
        }
        Json lights = Json::array();
        for (const LightSpec& light : model_.lights) {
            Json node = {{"name", light.name}};
            setPose(node, light.position,
                    light.type == "point" ? dquat(1, 0, 0, 0)
                                          : lookRotation(light.target - light.position));
            node["extensions"]["KHR_lights_punctual"]["light"] = lights.size();
            json_["nodes"].push_back(node);
            Json entry = {{"name", light.name},
                          {"type", light.type},
                          {"color", jsonOf(light.color)},
                          {"intensity", rounded(light.intensity)}};
            if (light.type == "spot") {
                entry["spot"] = {{"innerConeAngle", rounded(light.inner_cone)},
                                 {"outerConeAngle", rounded(light.outer_cone)}};
            }
            lights.push_back(entry);
        }
        json_["extensions"]["KHR_lights_punctual"]["lights"] = lights;
    }

    void addMaterials() {
        for (const MaterialSpec& material : model_.materials) {
            Json pbr = {{"baseColorFactor", jsonOf(glm::dvec4(material.base_color, 1.0))},
                        {"metallicFactor", rounded(material.metallic)},
                        {"roughnessFactor", rounded(material.roughness)}};
            if (material.texture >= 0) {
                pbr["baseColorTexture"]["index"] = material.texture;
            }
            Json json = {
                {"name", material.name}, {"doubleSided", true}, {"pbrMetallicRoughness", pbr}};
            if (material.normal_texture >= 0) {
                json["normalTexture"]["index"] = material.normal_texture;
            }
            if (material.specular != 1.0) {
                json["extensions"]["KHR_materials_specular"]["specularFactor"] = material.specular;
            }
            if (material.specular_color != 1.0) {
                json["extensions"]["KHR_materials_specular"]["specularColorFactor"] =
                    jsonOf(dvec3(material.specular_color));
            }
            const double strength =
                std::max({material.emission.x, material.emission.y, material.emission.z});
            if (strength > 0.0) {
                json["emissiveFactor"] = jsonOf(material.emission / strength);
                json["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] =
                    rounded(strength);
            }
            json_["materials"].push_back(json);
        }
        for (size_t i = 0; i < model_.textures.size(); ++i) {
            const size_t offset = binary_.size();
            binary_.insert(binary_.end(), model_.textures[i].begin(), model_.textures[i].end());
            json_["images"].push_back(
                {{"bufferView", addView(offset, 0)}, {"mimeType", "image/png"}});
            json_["textures"].push_back({{"source", i}});
        }
    }

    // The file: header, JSON chunk padded with spaces, binary chunk.
    std::vector<uint8_t> assemble() {
        std::string text = json_.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const std::vector<uint8_t> payload = std::move(binary_);
        binary_ = {'g', 'l', 'T', 'F'};
        write(uint32_t{2});
        write(static_cast<uint32_t>(12 + 8 + text.size() + 8 + payload.size()));
        write(static_cast<uint32_t>(text.size()));
        write(uint32_t{0x4E4F534A});
        binary_.insert(binary_.end(), text.begin(), text.end());
        write(static_cast<uint32_t>(payload.size()));
        write(uint32_t{0x004E4942});
        binary_.insert(binary_.end(), payload.begin(), payload.end());
        return std::move(binary_);
    }

    const Model& model_;
    Json json_;
    std::vector<uint8_t> binary_;
};

}  // namespace

dquat lookRotation(const dvec3& direction) {
    const dvec3 back = -glm::normalize(direction);
    const dvec3 helper = std::abs(back.y) > 0.999 ? dvec3(0, 0, 1) : dvec3(0, 1, 0);
    const dvec3 right = glm::normalize(glm::cross(helper, back));
    return glm::quat_cast(glm::dmat3(right, glm::cross(back, right), back));
}

double roughnessFromAlpha(double alpha) { return std::sqrt(alpha); }

void Mesh::append(const Mesh& other, const dmat4& transform) {
    const auto first = static_cast<uint32_t>(positions.size());
    const glm::dmat3 linear(transform);
    const bool mirrored = glm::determinant(linear) < 0.0;
    for (const dvec3& p : other.positions) {
        positions.push_back(dvec3(transform * glm::dvec4(p, 1.0)));
    }
    for (const dvec3& n : other.normals) {
        normals.push_back(linear * n);
    }
    uvs.insert(uvs.end(), other.uvs.begin(), other.uvs.end());
    for (size_t i = 0; i < other.indices.size(); i += 3) {
        indices.push_back(first + other.indices[i]);
        indices.push_back(first + other.indices[i + (mirrored ? 2 : 1)]);
        indices.push_back(first + other.indices[i + (mirrored ? 1 : 2)]);
    }
}

int Model::add(MaterialSpec material) {
    materials.push_back(std::move(material));
    return static_cast<int>(materials.size()) - 1;
}

void Model::add(std::string name, Mesh mesh, int material, std::vector<dmat4> placements) {
    objects.push_back({std::move(name), std::move(mesh), material, std::move(placements)});
}

std::vector<uint8_t> encodeGlb(const Model& model) { return Encoder(model).encode(); }

}  // namespace sheen::scenes
