// Writing a file anew with a lightmap. Buffers are packed into one, images that lie beside the file
// are taken into it; meshes that are shown more than once become several, vertices at which pieces
// of the atlas part become two, and primitives that are on several of its pages one for each, with
// a material of its own. Based on: the glTF 2.0 specification; MOZ_lightmap as Hubs and three.js
// read it.
#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/memory.h"
#include "scene/gltf_edit.h"
#include "scene/gltf_parts.h"
#include "scene/lightmap_file.h"

namespace sheen {
namespace gltf {
namespace {

// A triangle's corner: the primitive's vertex and its place in the atlas.
using Corner = std::tuple<uint32_t, float, float>;

class Writer {
  public:
    Writer(const Scene& scene, const LightmapFile& lightmap)
        : scene_(scene),
          lightmap_(lightmap),
          file_{.path = lightmap.source, .model = {}, .notes = {}} {
        parse(file_);
        document_ = Json::parse(jsonOf(lightmap.source));
    }

    // All of what is to be written.
    void make() {
        takeBuffers();
        takeImages();
        chooseSet();
        const std::vector<int> textures = addTextures();
        for (size_t i = 0; i < scene_.sources.size();) {
            size_t end = i;
            while (end < scene_.sources.size() &&
                   scene_.sources[end].node == scene_.sources[i].node) {
                ++end;
            }
            rewriteNode(i, end);
            i = end;
        }
        if (!anyCompressedMesh()) {
            forgetExtension(document_, kMeshCompression);
        }
        for (const auto& [of, material] : materials_) {
            setMaterial(arrayIn(document_, "materials")[material],
                        textures[static_cast<size_t>(of.second)]);
        }
        useExtension(document_, lightmap_.unlit ? "KHR_materials_unlit" : "MOZ_lightmap");
        if (lightmap_.lights_baked) {
            dropExtension(document_, "nodes", "KHR_lights_punctual");
        }
        if (!scene_.environment.empty()) {
            dropExtension(document_, "scenes", "EXT_lights_image_based");
        }
        bytes_.resize((bytes_.size() + 3) / 4 * 4);
        document_["buffers"] = Json::array({{{"byteLength", bytes_.size()}}});
        text_ = document_.dump();
        text_.resize((text_.size() + 3) / 4 * 4, ' ');
        checkSize(bytes_.size());
    }

    void write(const std::string& path) const { writeGlb(path, text_, bytes_); }

  private:
    // Of what the buffer is to hold, before it does.
    void checkSize(uint64_t bytes) const {
        if (kGlbHeaders + text_.size() + bytes > std::numeric_limits<uint32_t>::max()) {
            throwInput(
                "{}: with a lightmap it has more than 4 GiB, which .glb cannot hold; split "
                "the scene",
                lightmap_.source);
        }
        if (bytes > bytes_.capacity()) {
            checkMemory({.bytes = 2 * bytes}, lightmap_.source, "split the scene");
        }
    }

    // Appends bytes as a view of their own; its index.
    size_t addView(const void* data, size_t size) {
        checkSize(uint64_t{bytes_.size()} + 8 + size);
        bytes_.resize((bytes_.size() + 7) / 8 * 8);
        Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
        const auto* first = static_cast<const unsigned char*>(data);
        bytes_.insert(bytes_.end(), first, first + size);
        Json& views = arrayIn(document_, "bufferViews");
        views.push_back(std::move(view));
        return views.size() - 1;
    }

    // Each view's bytes, decompressed, one after the other: those of views that overlap more than
    // once.
    void takeBuffers() {
        Json views = arrayIn(document_, "bufferViews");
        uint64_t size = 0;
        for (size_t i = 0; i < views.size(); ++i) {
            size += 8 + bufferViewBytes(file_, static_cast<int>(i), "bufferViews").size;
        }
        checkSize(size);
        bytes_.reserve(size);
        document_["bufferViews"] = Json::array();
        for (size_t i = 0; i < views.size(); ++i) {
            const ByteSpan bytes = bufferViewBytes(file_, static_cast<int>(i), "bufferViews");
            const size_t view = addView(bytes.data, bytes.size);
            Json& own = document_["bufferViews"][view];
            for (const auto& [key, value] : views[i].items()) {
                if (!own.contains(key)) {
                    own[key] = value;
                }
            }
            for (const char* name : kCompressions) {
                if (own.contains("extensions")) {
                    own["extensions"].erase(name);
                }
            }
        }
        for (const char* name : kCompressions) {
            forgetExtension(document_, name);
        }
    }

    void takeImages() {
        Json& images = arrayIn(document_, "images");
        for (size_t i = 0; i < images.size() && i < file_.images.size(); ++i) {
            const FileBytes& content = file_.images[i].content;
            if (file_.images[i].buffer_view >= 0 || content.bytes.empty()) {
                continue;  // there already, or nowhere
            }
            const size_t view = addView(content.bytes.data(), content.bytes.size());
            images[i].erase("uri");
            images[i]["bufferView"] = view;
            if (!images[i].contains("mimeType")) {
                images[i]["mimeType"] = mediaTypeOf(content.bytes);
            }
        }
    }

    // The second set of coordinates or, where materials have textures by that, the next one that no
    // mesh has.
    void chooseSet() {
        set_ = 1;
        if (lightmap_.of_file || lightmap_.unlit ||
            !usesLaterSets(arrayIn(document_, "materials"))) {
            return;
        }
        std::set<std::string> names;
        for (const tinygltf::Mesh& mesh : file_.model.meshes) {
            for (const tinygltf::Primitive& primitive : mesh.primitives) {
                for (const auto& [name, accessor] : primitive.attributes) {
                    names.insert(name);
                }
            }
        }
        while (names.count(setName()) > 0) {
            ++set_;
        }
        constexpr int kMostSets = 16;
        if (set_ >= kMostSets) {
            file_.fail("meshes", "have {} sets of texture coordinates; leave out those unused",
                       set_);
        }
    }
    std::string setName() const { return fmt::format("TEXCOORD_{}", set_); }

    // One a page.
    std::vector<int> addTextures() {
        constexpr int kLinear = 9729, kClampToEdge = 33071;
        Json& samplers = arrayIn(document_, "samplers");
        samplers.push_back({{"magFilter", kLinear},
                            {"minFilter", kLinear},
                            {"wrapS", kClampToEdge},
                            {"wrapT", kClampToEdge}});
        Json& images = arrayIn(document_, "images");
        Json& textures = arrayIn(document_, "textures");
        std::vector<int> added;
        for (const std::string& png : lightmap_.pngs) {
            const size_t view = addView(png.data(), png.size());
            images.push_back(
                {{"name", "lightmap"}, {"bufferView", view}, {"mimeType", "image/png"}});
            textures.push_back({{"name", "lightmap"},
                                {"sampler", samplers.size() - 1},
                                {"source", images.size() - 1}});
            added.push_back(static_cast<int>(textures.size()) - 1);
        }
        return added;
    }

    // The mesh of a node whose triangles are those of sources first to end.
    void rewriteNode(size_t first, size_t end) {
        const auto node = static_cast<size_t>(scene_.sources[first].node);
        const std::string where = label("node", node, file_.model.nodes[node].name);
        if (scene_.sources[end - 1].instance > 0) {
            file_.fail(where,
                       "EXT_mesh_gpu_instancing: instances share their coordinates and can have no "
                       "lightmap; export them as nodes");
        }
        Json& meshes = document_["meshes"];
        const auto own = static_cast<size_t>(file_.model.nodes[node].mesh);
        Json mesh = meshes[own];
        for (size_t i = first; i < end; ++i) {
            const Scene::Source& source = scene_.sources[i];
            const size_t last = i + 1 < scene_.sources.size() ? scene_.sources[i + 1].first_triangle
                                                              : scene_.triangles.size();
            rewritePrimitives(mesh["primitives"], static_cast<size_t>(source.primitive),
                              source.first_triangle, last, where);
        }
        const auto& nodes = file_.model.nodes;
        const auto shows = [&](const tinygltf::Node& n) { return n.mesh == static_cast<int>(own); };
        if (std::count_if(nodes.begin(), nodes.end(), shows) == 1) {
            meshes[own] = std::move(mesh);
            return;
        }
        document_["nodes"][node]["mesh"] = meshes.size();
        meshes.push_back(std::move(mesh));
    }

    // What a primitive has on its first page takes its place; what it has on others follows last.
    void rewritePrimitives(Json& primitives, size_t primitive, size_t first, size_t end,
                           const std::string& where) {
        std::map<int, std::vector<size_t>> triangles_of;  // by page; none where all is left out
        for (size_t i = first; i < end; ++i) {
            triangles_of[lightmap_.page_of[i]].push_back(i);
        }
        const Json source = primitives[primitive];
        size_t at = primitive;
        for (const auto& [page, triangles] : triangles_of) {
            primitives[at] = source;
            rewritePrimitive(primitives[at], triangles, page, where);
            at = primitives.size();
        }
    }

    void rewritePrimitive(Json& primitive, const std::vector<size_t>& triangles, int page,
                          const std::string& where) {
        std::map<Corner, uint32_t> vertex_of;
        std::vector<uint32_t> sources, indices;
        std::vector<float> coordinates;
        for (const size_t i : triangles) {
            const uvec4& corners = scene_.source_corners[i];
            for (const int c : {0, corners.w != 0 ? 2 : 1, corners.w != 0 ? 1 : 2}) {
                const vec2& uv = lightmap_.corners[i][static_cast<size_t>(c)];
                const auto [found, is_new] = vertex_of.emplace(
                    Corner(corners[c], uv.x, uv.y), static_cast<uint32_t>(sources.size()));
                if (is_new) {
                    sources.push_back(corners[c]);
                    coordinates.insert(coordinates.end(), {uv.x, uv.y});
                }
                indices.push_back(found->second);
            }
        }
        Json& attributes = primitive["attributes"];
        if (lightmap_.unlit) {
            attributes.erase("COLOR_0");
        }
        for (auto& [name, accessor] : attributes.items()) {
            accessor = addGathered(accessor, sources, where);
        }
        for (Json& target : arrayIn(primitive, "targets")) {
            target.erase(setName());
            for (auto& [name, accessor] : target.items()) {
                accessor = addGathered(accessor, sources, where);
            }
        }
        if (primitive["targets"].empty()) {
            primitive.erase("targets");
        }
        fillSets(attributes, sources.size());
        attributes[setName()] = addAccessor(coordinates.data(), 2 * sizeof(float), sources.size(),
                                            TINYGLTF_COMPONENT_TYPE_FLOAT, "VEC2");
        primitive["indices"] = addAccessor(indices.data(), sizeof(uint32_t), indices.size(),
                                           TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, "SCALAR");
        primitive.erase("mode");
        if (primitive.contains("extensions")) {
            primitive["extensions"].erase(kMeshCompression);
        }
        if (!primitive.contains("material")) {
            primitive["material"] = defaultMaterial();
        }
        const int material = indexFrom(primitive["material"], where, "material");
        if (static_cast<size_t>(material) >= document_["materials"].size()) {
            file_.fail(where, "has no material {}; export the file again", material);
        }
        primitive["material"] = materialOn(material, page);
    }

    // A material has one lightmap: that of the first page which it is found on is the file's own,
    // that of any other a copy.
    size_t materialOn(int material, int page) {
        const auto [found, is_new] =
            materials_.emplace(std::pair(material, page), static_cast<size_t>(material));
        const auto any = materials_.lower_bound({material, 0});
        const bool shared =
            std::next(any) != materials_.end() && std::next(any)->first.first == material;
        if (is_new && shared) {
            Json& materials = document_["materials"];
            found->second = materials.size();
            materials.push_back(Json(materials[static_cast<size_t>(material)]));
        }
        return found->second;
    }

    // Sets are numbered without gaps: zeros where a mesh lacks one before the lightmap's, which is
    // what its textures are looked up by in any case.
    void fillSets(Json& attributes, size_t count) {
        std::optional<size_t> zeros;
        for (int set = 0; set < set_; ++set) {
            const std::string name = fmt::format("TEXCOORD_{}", set);
            if (attributes.contains(name)) {
                continue;
            }
            if (!zeros) {
                const std::vector<vec2> values(count, vec2(0.0f));
                zeros = addAccessor(values.data(), sizeof(vec2), count,
                                    TINYGLTF_COMPONENT_TYPE_FLOAT, "VEC2");
            }
            attributes[name] = *zeros;
        }
    }

    // Those that no node shows stay as they are.
    bool anyCompressedMesh() {
        for (const Json& mesh : arrayIn(document_, "meshes")) {
            for (const Json& primitive : mesh["primitives"]) {
                if (primitive.contains("extensions") &&
                    primitive["extensions"].contains(kMeshCompression)) {
                    return true;
                }
            }
        }
        return false;
    }

    int indexFrom(const Json& value, const std::string& where, const char* kind) const {
        const int64_t index = value.is_number_integer() ? value.get<int64_t>() : -1;
        if (index < 0 || index > std::numeric_limits<int>::max()) {
            file_.fail(where, "{} {} is no index; export the file again", kind, value.dump());
        }
        return static_cast<int>(index);
    }

    int defaultMaterial() {
        if (default_material_ < 0) {
            Json& materials = arrayIn(document_, "materials");
            default_material_ = static_cast<int>(materials.size());
            materials.push_back({{"name", "default"}});
        }
        return default_material_;
    }

    size_t addAccessor(const void* data, size_t element_size, size_t count, int component_type,
                       const char* type) {
        const size_t view = addView(data, element_size * count);
        Json& accessors = arrayIn(document_, "accessors");
        accessors.push_back({{"bufferView", view},
                             {"componentType", component_type},
                             {"count", count},
                             {"type", type}});
        return accessors.size() - 1;
    }

    // An accessor of the elements of another one, in that order.
    size_t addGathered(const Json& from, const std::vector<uint32_t>& elements,
                       const std::string& where) {
        const int accessor = indexFrom(from, where, "accessor");
        const std::vector<double> numbers = readNumbers(file_, accessor, where);
        const auto components = static_cast<size_t>(accessorComponents(file_, accessor, where));
        const int type = file_.model.accessors[static_cast<size_t>(accessor)].componentType;
        const auto size =
            static_cast<size_t>(tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(type)));
        if (type < TINYGLTF_COMPONENT_TYPE_BYTE || type > TINYGLTF_COMPONENT_TYPE_FLOAT) {
            file_.fail(where, "accessor {}: componentType {} is none that vertices have", accessor,
                       type);
        }
        const size_t last = *std::max_element(elements.begin(), elements.end());
        if (numbers.size() / components <= last) {
            file_.fail(where,
                       "accessor {} has {} elements, but the primitive has a vertex {}; export the "
                       "file again",
                       accessor, numbers.size() / components, last);
        }
        // Elements of vertices begin at multiples of four.
        const size_t stride = (size * components + 3) / 4 * 4;
        std::vector<unsigned char> bytes(stride * elements.size());
        std::vector<double> least(components, std::numeric_limits<double>::infinity());
        std::vector<double> most(components, -std::numeric_limits<double>::infinity());
        for (size_t i = 0; i < elements.size(); ++i) {
            for (size_t c = 0; c < components; ++c) {
                const double value = numbers[elements[i] * components + c];
                least[c] = std::min(least[c], value);
                most[c] = std::max(most[c], value);
                storeNumber(value, type, &bytes[i * stride + c * size]);
            }
        }
        const Json old = document_["accessors"][static_cast<size_t>(accessor)];
        const size_t result = addAccessor(bytes.data(), stride, elements.size(), type,
                                          old["type"].get<std::string>().c_str());
        Json& own = document_["accessors"][result];
        document_["bufferViews"].back()["byteStride"] = stride;
        if (old.contains("normalized")) {
            own["normalized"] = old["normalized"];
        }
        if (old.contains("min")) {
            own["min"] = least;
            own["max"] = most;
        }
        return result;
    }

    void setMaterial(Json& material, int texture) {
        const Json use = {{"index", texture}, {"texCoord", set_}};
        if (!lightmap_.unlit) {
            if (material.contains("extensions") &&
                material["extensions"].contains("KHR_materials_unlit")) {
                material["extensions"].erase("MOZ_lightmap");
                return;  // no light changes it
            }
            Json extension = use;
            extension["intensity"] = lightmap_.intensity;
            if (!lightmap_.lights_baked) {
                extension["extras"] = {{"direct", false}};  // as the loader asks
            }
            material["extensions"]["MOZ_lightmap"] = std::move(extension);
            return;
        }
        for (const char* name :
             {"emissiveTexture", "emissiveFactor", "normalTexture", "occlusionTexture"}) {
            material.erase(name);
        }
        material["extensions"] = {{"KHR_materials_unlit", Json::object()}};
        material["pbrMetallicRoughness"] = {
            {"baseColorTexture", use}, {"metallicFactor", 0}, {"roughnessFactor", 1}};
    }

    static constexpr const char* kMeshCompression = "KHR_draco_mesh_compression";
    static constexpr const char* kCompressions[] = {"EXT_meshopt_compression",
                                                    "KHR_meshopt_compression"};

    const Scene& scene_;
    const LightmapFile& lightmap_;
    File file_;
    Json document_;
    std::vector<unsigned char> bytes_;
    std::string text_;
    int set_ = 1;
    int default_material_ = -1;
    std::map<std::pair<int, int>, size_t> materials_;  // by that of the file and page
};

Writer madeOf(const Scene& scene, const LightmapFile& lightmap) {
    SHEEN_CHECK_EQ(scene.source_corners.size(), scene.triangles.size());
    SHEEN_CHECK_EQ(lightmap.corners.size(), scene.triangles.size());
    SHEEN_CHECK_EQ(lightmap.page_of.size(), scene.triangles.size());
    try {
        Writer writer(scene, lightmap);
        writer.make();
        return writer;
    } catch (const Json::exception& error) {
        // What the loader has no use for it does not look at.
        throwInput("{}: some part of it is not as glTF has it, {}; export it again",
                   lightmap.source, error.what());
    }
}

}  // namespace
}  // namespace gltf

void checkLightmapped(const Scene& scene, const LightmapFile& lightmap) {
    gltf::madeOf(scene, lightmap);
}

void writeLightmapped(const std::string& path, const Scene& scene, const LightmapFile& lightmap) {
    gltf::madeOf(scene, lightmap).write(path);
}

}  // namespace sheen
