#include "library/arrays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "core/directions.h"
#include "core/error.h"
#include "image/png.h"
#include "scene/gltf_edit.h"

namespace sheen::library {
namespace {

using Json = nlohmann::json;

constexpr int kFloat = 5126, kUnsigned = 5125;  // glTF's component types
constexpr int kMostTexels = 16384;              // along a side of an image

template <class... Args>
[[noreturn]] void fail(const std::string& where, fmt::format_string<Args...> what, Args&&... args) {
    throwInput("{}: {}: {}", kArrays, where, fmt::format(what, std::forward<Args>(args)...));
}

std::string labelOf(const char* kind, size_t index, const char* name) {
    return name == nullptr || *name == '\0' ? fmt::format("{} {}", kind, index)
                                            : fmt::format("{} {} ({})", kind, index, oneLine(name));
}

std::string nameOf(const char* name) { return name == nullptr ? "" : oneLine(name); }

template <class T>
std::span<const T> listOf(const T* data, size_t count, const char* what) {
    if (data == nullptr && count > 0) {
        fail(what, "NULL, but there should be {}", count);
    }
    return {data, count};
}

void checkFinite(std::span<const float> values, const std::string& where, const char* what) {
    for (size_t i = 0; i < values.size(); ++i) {
        if (!std::isfinite(values[i])) {
            fail(where, "number {} of its {} is not finite", i, what);
        }
    }
}

vec3 vectorOf(const float (&v)[3], const std::string& where, const char* what) {
    checkFinite(v, where, what);
    return {v[0], v[1], v[2]};
}

Json jsonOf(const vec3& v) { return {v.x, v.y, v.z}; }

// Columns: the axes and the origin of what a node holds.
Json matrixOf(const mat3& axes, const vec3& origin) {
    Json matrix = Json::array();
    for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row) {
            matrix.push_back(axes[column][row]);
        }
        matrix.push_back(0);
    }
    for (const float value : {origin.x, origin.y, origin.z, 1.0f}) {
        matrix.push_back(value);
    }
    return matrix;
}

// A glTF document and its buffer.
class Writer {
  public:
    std::string write(const sheen_arrays& arrays) {
        document_["asset"]["version"] = "2.0";
        document_["scene"] = 0;
        document_["scenes"][0] = Json::object();
        const auto materials = listOf(arrays.materials, arrays.material_count, "materials");
        for (size_t i = 0; i < materials.size(); ++i) {
            addMaterial(materials[i], labelOf("material", i, materials[i].name));
        }
        addDefaultMaterial();
        const auto meshes = listOf(arrays.meshes, arrays.mesh_count, "meshes");
        for (size_t i = 0; i < meshes.size(); ++i) {
            addMesh(meshes[i], labelOf("mesh", i, meshes[i].name));
        }
        const auto lights = listOf(arrays.lights, arrays.light_count, "lights");
        for (size_t i = 0; i < lights.size(); ++i) {
            addLight(lights[i], fmt::format("light {}", i));
        }
        const auto cameras = listOf(arrays.cameras, arrays.camera_count, "cameras");
        for (size_t i = 0; i < cameras.size(); ++i) {
            addCamera(cameras[i], labelOf("camera", i, cameras[i].name));
        }
        return glb();
    }

  private:
    void addNode(Json node) {
        document_["scenes"][0]["nodes"].push_back(document_["nodes"].size());
        document_["nodes"].push_back(std::move(node));
    }

    void use(const char* extension) {
        Json& used = document_["extensionsUsed"];
        if (std::find(used.begin(), used.end(), extension) == used.end()) {
            used.push_back(extension);
        }
    }

    size_t addView(const void* data, size_t size) {
        buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
        Json& views = document_["bufferViews"];
        views.push_back({{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", size}});
        buffer_.append(static_cast<const char*>(data), size);
        return views.size() - 1;
    }

    size_t addAccessor(const void* data, size_t size, int type, const char* shape, size_t count) {
        Json& accessors = document_["accessors"];
        accessors.push_back({{"bufferView", addView(data, size)},
                             {"componentType", type},
                             {"type", shape},
                             {"count", count}});
        return accessors.size() - 1;
    }

    size_t addFloats(const float* data, size_t count, size_t components, const std::string& where,
                     const char* what) {
        checkFinite({data, count * components}, where, what);
        return addAccessor(data, count * components * sizeof(float), kFloat,
                           components == 3 ? "VEC3" : "VEC2", count);
    }

    // Index of its texture, the same for each use.
    size_t addImage(const sheen_image& image, const std::string& where) {
        const auto known = textures_.find(&image);
        if (known != textures_.end()) {
            return known->second;
        }
        if (image.rgba == nullptr || image.width < 1 || image.height < 1 ||
            image.width > kMostTexels || image.height > kMostTexels) {
            fail(where, "an image is NULL or not of 1..{} texels a side", kMostTexels);
        }
        Image<Rgb8> colors(image.width, image.height);
        Image<float> alpha(image.width, image.height);
        for (size_t i = 0; i < colors.pixels.size(); ++i) {
            const uint8_t* texel = image.rgba + 4 * i;
            colors.pixels[i] = {texel[0], texel[1], texel[2]};
            alpha.pixels[i] = static_cast<float>(texel[3]) / 255.0f;
        }
        const std::string png = pngBytes(colors, alpha);
        Json& images = document_["images"];
        images.push_back(
            {{"bufferView", addView(png.data(), png.size())}, {"mimeType", "image/png"}});
        document_["textures"].push_back({{"source", images.size() - 1}});
        return textures_[&image] = images.size() - 1;
    }

    void setTexture(const sheen_image* image, Json& object, const char* key,
                    const std::string& where) {
        if (image != nullptr) {
            object[key]["index"] = addImage(*image, where);
        }
    }

    void addMaterial(const sheen_material& from, const std::string& where) {
        const vec3 color = vectorOf(from.base_color, where, "base colour");
        const vec3 emission = vectorOf(from.emission, where, "emission");
        checkFinite(std::array{from.metallic, from.roughness}, where, "metallic and roughness");
        Json to = {{"name", nameOf(from.name)}, {"doubleSided", from.single_sided == 0}};
        Json& pbr = to["pbrMetallicRoughness"];
        pbr["baseColorFactor"] = {color.x, color.y, color.z, 1};
        pbr["metallicFactor"] = from.metallic;
        pbr["roughnessFactor"] = from.roughness;
        setTexture(from.color_image, pbr, "baseColorTexture", where);
        setTexture(from.metallic_roughness_image, pbr, "metallicRoughnessTexture", where);
        setTexture(from.normal_image, to, "normalTexture", where);
        setTexture(from.emission_image, to, "emissiveTexture", where);
        const float strength = std::max({emission.x, emission.y, emission.z});
        if (glm::any(glm::lessThan(emission, vec3(0.0f)))) {
            fail(where, "its emission is negative");
        }
        if (strength > 0.0f) {  // glTF has factors up to 1
            const char* const kExtension = "KHR_materials_emissive_strength";
            use(kExtension);
            to["emissiveFactor"] = jsonOf(emission / strength);
            to["extensions"][kExtension]["emissiveStrength"] = strength;
        }
        document_["materials"].push_back(std::move(to));
    }

    void addDefaultMaterial() {
        document_["materials"].push_back(
            {{"name", "default"},
             {"doubleSided", true},
             {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}});
    }

    void addMesh(const sheen_mesh& from, const std::string& where) {
        const auto materials = static_cast<int>(document_["materials"].size()) - 1;
        if (from.material < -1 || from.material >= materials) {
            fail(where, "has material {}, of which there are {}", from.material, materials);
        }
        if (from.vertex_count == 0 || from.triangle_count == 0) {
            return;  // nothing to see
        }
        if (from.positions == nullptr) {
            fail(where, "its positions are NULL");
        }
        Json primitive = {{"material", from.material < 0 ? materials : from.material}};
        Json& attributes = primitive["attributes"];
        attributes["POSITION"] =
            addFloats(from.positions, from.vertex_count, 3, where, "positions");
        if (from.normals != nullptr) {
            attributes["NORMAL"] = addFloats(from.normals, from.vertex_count, 3, where, "normals");
        }
        if (from.uvs != nullptr) {
            attributes["TEXCOORD_0"] =
                addFloats(from.uvs, from.vertex_count, 2, where, "texture coordinates");
        }
        const size_t corners = 3 * from.triangle_count;
        if (from.indices == nullptr) {
            if (corners != from.vertex_count) {
                fail(where, "has {} vertices and no indices, where its {} triangles need {}",
                     from.vertex_count, from.triangle_count, corners);
            }
        } else {
            for (size_t i = 0; i < corners; ++i) {
                if (from.indices[i] >= from.vertex_count) {
                    fail(where, "triangle {} refers to vertex {}, of which there are {}", i / 3,
                         from.indices[i], from.vertex_count);
                }
            }
            primitive["indices"] =
                addAccessor(from.indices, corners * sizeof(uint32_t), kUnsigned, "SCALAR", corners);
        }
        document_["meshes"].push_back({{"name", nameOf(from.name)}, {"primitives", {primitive}}});
        addNode({{"mesh", document_["meshes"].size() - 1}});
    }

    void addLight(const sheen_light& from, const std::string& where) {
        const char* const kExtension = "KHR_lights_punctual";
        const vec3 intensity = vectorOf(from.intensity, where, "intensity");
        const float strength = std::max({intensity.x, intensity.y, intensity.z});
        if (glm::any(glm::lessThan(intensity, vec3(0.0f)))) {
            fail(where, "its intensity is negative");
        }
        if (!(strength > 0.0f)) {
            return;  // it is out
        }
        Json light = {{"color", jsonOf(intensity / strength)}, {"intensity", strength}};
        vec3 direction(0.0f, 0.0f, -1.0f);
        if (from.kind != SHEEN_POINT_LIGHT) {
            direction = vectorOf(from.direction, where, "direction");
            if (!(glm::length(direction) > 0.0f)) {
                fail(where, "its direction is zero");
            }
        }
        switch (from.kind) {
            case SHEEN_POINT_LIGHT:
                light["type"] = "point";
                break;
            case SHEEN_DIRECTIONAL_LIGHT:
                light["type"] = "directional";
                break;
            case SHEEN_SPOT_LIGHT:
                light["type"] = "spot";
                checkFinite(std::array{from.inner_cone, from.outer_cone}, where, "cones");
                light["spot"] = {{"innerConeAngle", from.inner_cone},
                                 {"outerConeAngle", from.outer_cone}};
                break;
            default:
                fail(where, "its kind is {}, which is none", static_cast<int>(from.kind));
        }
        use(kExtension);
        Json& lights = document_["extensions"][kExtension]["lights"];
        lights.push_back(std::move(light));
        // Shines along -z.
        addNode({{"matrix", matrixOf(tangentFrame(-glm::normalize(direction)),
                                     from.kind == SHEEN_DIRECTIONAL_LIGHT
                                         ? vec3(0.0f)
                                         : vectorOf(from.position, where, "position"))},
                 {"extensions", {{kExtension, {{"light", lights.size() - 1}}}}}});
    }

    void addCamera(const sheen_camera& from, const std::string& where) {
        const vec3 position = vectorOf(from.position, where, "position");
        const vec3 back = position - vectorOf(from.look_at, where, "point to look at");
        vec3 up = vectorOf(from.up, where, "up direction");
        up = up == vec3(0.0f) ? vec3(0.0f, 1.0f, 0.0f) : glm::normalize(up);
        constexpr float kLeast = 0.1f, kMost = 179.0f;
        if (!(from.fov >= kLeast && from.fov <= kMost)) {
            fail(where, "its field of view is {} degrees; it must be in {}..{}", from.fov, kLeast,
                 kMost);
        }
        const vec3 right = glm::cross(up, back);
        if (!(glm::length(right) > 1e-4f * glm::length(back))) {
            fail(where, "looks at itself, or along its up direction; turn one of them");
        }
        const vec3 x = glm::normalize(right);
        const vec3 z = glm::normalize(back);
        document_["cameras"].push_back(
            {{"type", "perspective"},
             {"name", nameOf(from.name)},
             {"perspective", {{"yfov", glm::radians(from.fov)}, {"znear", 1e-3f}}}});
        addNode({{"camera", document_["cameras"].size() - 1},
                 {"matrix", matrixOf({x, glm::cross(z, x), z}, position)}});
    }

    std::string glb() {
        buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
        if (!buffer_.empty()) {
            document_["buffers"].push_back({{"byteLength", buffer_.size()}});
        }
        std::string text = document_.dump(-1, ' ', false, Json::error_handler_t::replace);
        text.resize((text.size() + 3) / 4 * 4, ' ');
        if (gltf::kGlbHeaders + text.size() + buffer_.size() >
            std::numeric_limits<uint32_t>::max()) {
            fail("meshes", "take more than 4 GiB with their images; split the scene");
        }
        return gltf::glbBeginning(text, buffer_.size()) + buffer_;
    }

    Json document_;
    std::string buffer_;
    std::map<const sheen_image*, size_t> textures_;
};

}  // namespace

std::string glbOf(const sheen_arrays& arrays) { return Writer().write(arrays); }

}  // namespace sheen::library
