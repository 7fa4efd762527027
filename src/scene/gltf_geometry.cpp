// Meshes: primitives become triangles in world space, with what is broken in them mended or left
// out and counted.
#include <algorithm>
#include <cmath>

#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

constexpr uint32_t kUnused = ~0u;
// Scene::triangleCount() is an int and vertices are indexed by 32 bits.
constexpr size_t kMaxTriangles = size_t{1} << 30;

// A primitive before it is cleaned; arrays are [vertex] and [triangle].
struct Primitive {
    std::vector<vec3> positions;
    std::vector<vec3> normals;  // empty: flat
    std::vector<vec2> uvs;      // empty: zero
    std::vector<vec2> second_uvs, lightmap_uvs;
    std::vector<vec4> colors;  // empty: white
    std::vector<vec4> tangents;
    std::vector<uvec3> triangles;
    std::vector<bool> mirrored;  // [vertex]: whose triangles are turned round
};

std::vector<uvec3> trianglesOf(const std::vector<uint32_t>& index, int mode) {
    std::vector<uvec3> triangles;
    if (index.size() < 3) {
        return triangles;
    }
    switch (mode) {
        case TINYGLTF_MODE_TRIANGLE_STRIP:
            for (size_t i = 0; i + 2 < index.size(); ++i) {
                // Every second triangle is turned round, so that all face one way.
                const size_t odd = i % 2;
                triangles.emplace_back(index[i], index[i + 1 + odd], index[i + 2 - odd]);
            }
            break;
        case TINYGLTF_MODE_TRIANGLE_FAN:
            for (size_t i = 0; i + 2 < index.size(); ++i) {
                triangles.emplace_back(index[i + 1], index[i + 2], index[0]);
            }
            break;
        default:
            for (size_t i = 0; i + 2 < index.size(); i += 3) {
                triangles.emplace_back(index[i], index[i + 1], index[i + 2]);
            }
    }
    return triangles;
}

template <class V>
std::vector<V> asVectors(const std::vector<float>& values) {
    constexpr int kComponents = V::length();
    std::vector<V> result(values.size() / kComponents);
    for (size_t i = 0; i < result.size(); ++i) {
        for (int c = 0; c < kComponents; ++c) {
            result[i][c] = values[i * kComponents + static_cast<size_t>(c)];
        }
    }
    return result;
}

// Linear light and alpha; alpha 1 where there is none.
std::vector<vec4> readColors(File& file, int accessor, const std::string& where) {
    const bool opaque = accessorComponents(file, accessor, where) == 3;
    const std::vector<float> values =
        readFloats(file, accessor, opaque ? 3 : 4, Integers::kNormalizedUnsigned, where);
    std::vector<vec4> colors;
    if (opaque) {
        for (const vec3& color : asVectors<vec3>(values)) {
            colors.emplace_back(color, 1.0f);
        }
    } else {
        colors = asVectors<vec4>(values);
    }
    int64_t mended = 0;
    for (vec4& color : colors) {
        // NaN becomes 0.
        const vec4 clamped = glm::min(glm::max(vec4(0.0f), color), vec4(1.0f));
        mended += clamped == color ? 0 : 1;
        color = clamped;
    }
    if (mended > 0) {
        file.notes.add("vertex colour out of range and clamped", mended);
    }
    return colors;
}

// Those of the file, or, where it has none, one after the other.
std::vector<uint32_t> indicesOf(File& file, const tinygltf::Primitive& source, size_t count,
                                const std::string& where) {
    std::vector<uint32_t> indices;
    if (source.indices != -1) {
        indices = readIndices(file, source.indices, count, where + ", indices");
    } else {
        indices.resize(count);
        for (size_t i = 0; i < count; ++i) {
            indices[i] = static_cast<uint32_t>(i);
        }
    }
    if (source.mode == TINYGLTF_MODE_TRIANGLES && indices.size() % 3 != 0) {
        file.notes.add(
            "index list that is no multiple of three: its last, incomplete triangle left out");
    }
    return indices;
}

Primitive readPrimitive(File& file, const tinygltf::Primitive& source,
                        const std::vector<double>& weights, const LightmapUse& lightmap,
                        const std::string& where) {
    const Integers quantized = file.uses("KHR_mesh_quantization") ? Integers::kAny : Integers::kNo;
    const auto attribute = [&](const std::string& name) {
        const auto found = source.attributes.find(name);
        return found == source.attributes.end() ? -1 : found->second;
    };
    const auto check_count = [&](const std::string& name, size_t count, size_t expected) {
        if (count != expected) {
            file.fail(where, "{} has {} elements and POSITION {}; export the file again", name,
                      count, expected);
        }
    };

    Primitive primitive;
    if (source.attributes.count("POSITION") == 0) {
        file.notes.add("primitive without positions left out");
        return primitive;
    }
    primitive.positions = asVectors<vec3>(
        readFloats(file, attribute("POSITION"), 3, quantized, where + ", POSITION"));
    const size_t count = primitive.positions.size();
    const auto read = [&](const std::string& name, auto& values, Integers integers) {
        if (source.attributes.count(name) == 0) {
            return;
        }
        using Vector = typename std::decay_t<decltype(values)>::value_type;
        values = asVectors<Vector>(readFloats(file, attribute(name), Vector::length(), integers,
                                              fmt::format("{}, {}", where, name)));
        check_count(name, values.size(), count);
    };
    read("NORMAL", primitive.normals, quantized);
    const Integers of_uvs =
        quantized == Integers::kAny ? Integers::kAny : Integers::kNormalizedUnsigned;
    read("TEXCOORD_0", primitive.uvs, of_uvs);
    read("TEXCOORD_1", primitive.second_uvs, of_uvs);
    if (lightmap.texture.used()) {
        read(fmt::format("TEXCOORD_{}", lightmap.file_set), primitive.lightmap_uvs, of_uvs);
    }
    if (source.attributes.count("COLOR_0") > 0) {
        primitive.colors = readColors(file, attribute("COLOR_0"), where + ", COLOR_0");
        check_count("COLOR_0", primitive.colors.size(), count);
    }
    read("TANGENT", primitive.tangents, quantized);
    primitive.triangles = trianglesOf(indicesOf(file, source, count, where), source.mode);
    const auto morph = [&](const char* name, auto& values) {
        if (!values.empty()) {
            const auto components = static_cast<size_t>(values[0].length());
            addMorphTargets(file, source, name, weights, components,
                            {&values[0][0], values.size() * components}, where);
        }
    };
    morph("POSITION", primitive.positions);
    morph("NORMAL", primitive.normals);
    morph("TANGENT", primitive.tangents);
    return primitive;
}

// A transform to world space of what a vertex has.
struct Placement {
    glm::dmat4 world;
    glm::dmat3 linear, cofactor;
    double determinant;

    explicit Placement(const glm::dmat4& world_from_mesh)
        : world(world_from_mesh), linear(world_from_mesh), determinant(glm::determinant(linear)) {
        // Normals go by the inverse transpose; the cofactor matrix has its direction (times the
        // determinant) and exists for singular transforms, too.
        cofactor = {glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                    glm::cross(linear[0], linear[1])};
    }
    bool mirrors() const { return determinant < 0.0; }
    vec3 position(const vec3& p) const { return vec3(glm::dvec3(world * glm::dvec4(p, 1.0))); }
    vec3 normal(const vec3& n) const {
        return unit((mirrors() ? -1.0 : 1.0) * (cofactor * glm::dvec3(n)));
    }
    vec4 tangent(const vec4& t) const {
        return vec4(unit(linear * glm::dvec3(t)), (t.w < 0.0f) == mirrors() ? 1.0f : -1.0f);
    }

  private:
    static vec3 unit(const glm::dvec3& v) {
        const double length = glm::length(v);
        return length > 0.0 && std::isfinite(length) ? vec3(v / length) : vec3(0.0f);
    }
};

// By one transform, or by one for each vertex.
void transform(Primitive& primitive, const glm::dmat4& world_from_mesh,
               const std::vector<glm::dmat4>& of_vertices) {
    Placement placement(world_from_mesh);
    std::vector<bool>& mirrored = primitive.mirrored;
    mirrored.assign(primitive.positions.size(), placement.mirrors());
    for (size_t i = 0; i < primitive.positions.size(); ++i) {
        if (!of_vertices.empty()) {
            placement = Placement(of_vertices[i]);
            mirrored[i] = placement.mirrors();
        }
        primitive.positions[i] = placement.position(primitive.positions[i]);
        if (!primitive.normals.empty()) {
            primitive.normals[i] = placement.normal(primitive.normals[i]);
        }
        if (!primitive.tangents.empty()) {
            primitive.tangents[i] = placement.tangent(primitive.tangents[i]);
        }
    }
    for (uvec3& t : primitive.triangles) {
        if (mirrored[t.x]) {
            std::swap(t.y, t.z);
        }
    }
}

vec3 crossOf(const Primitive& primitive, const uvec3& t) {
    const vec3& p = primitive.positions[t.x];
    return glm::cross(primitive.positions[t.y] - p, primitive.positions[t.z] - p);
}

// Whether two corners are one, as at a sphere's poles: such a triangle is left out without a word,
// since its neighbours close the surface.
bool isCollapsed(const Primitive& primitive, const uvec3& t) {
    constexpr float kOnePoint = 1e-12f;  // of the longest edge, squared
    float shortest = kInfinity;
    float longest = 0.0f;
    for (int corner = 0; corner < 3; ++corner) {
        const vec3 edge = primitive.positions[t[(corner + 1) % 3]] - primitive.positions[t[corner]];
        const float length2 = glm::dot(edge, edge);
        shortest = std::min(shortest, length2);
        longest = std::max(longest, length2);
    }
    return shortest <= kOnePoint * longest;
}

// Leaves out triangles whose geometric normal does not exist in float arithmetic.
void dropDegenerate(File& file, Primitive& primitive) {
    size_t kept = 0;
    int64_t non_finite = 0;
    int64_t no_area = 0;
    for (const uvec3& t : primitive.triangles) {
        if (!finite(primitive.positions[t.x]) || !finite(primitive.positions[t.y]) ||
            !finite(primitive.positions[t.z])) {
            ++non_finite;
            continue;
        }
        const vec3 n = crossOf(primitive, t);
        const float length2 = glm::dot(n, n);
        if (!(length2 >= std::numeric_limits<float>::min()) || !std::isfinite(length2)) {
            no_area += isCollapsed(primitive, t) ? 0 : 1;
            continue;
        }
        primitive.triangles[kept++] = t;
    }
    const bool all_flat = kept == 0 && non_finite == 0 && !primitive.triangles.empty();
    primitive.triangles.resize(kept);
    if (non_finite > 0) {
        file.notes.add("triangle with coordinates that are not finite left out", non_finite);
    }
    if (all_flat) {
        file.notes.add("mesh without area left out: is its node scaled to zero?");
    } else if (no_area > 0) {
        file.notes.add("triangle without area left out", no_area);
    }
}

// A zero or non-finite normal becomes that of the triangles around its vertex.
void mendNormals(File& file, Primitive& primitive) {
    if (primitive.normals.empty()) {
        return;
    }
    std::vector<vec3> around(primitive.normals.size(), vec3(0.0f));
    std::vector<bool> used(primitive.normals.size(), false);
    for (const uvec3& t : primitive.triangles) {
        const vec3 n = glm::normalize(crossOf(primitive, t));
        for (int corner = 0; corner < 3; ++corner) {
            const uint32_t vertex = t[corner];
            used[vertex] = true;
            // Opposite faces would cancel: the first then counts alone.
            const vec3 sum = around[vertex] + n;
            around[vertex] = glm::dot(sum, sum) > 1e-6f ? sum : around[vertex];
        }
    }
    int64_t mended = 0;
    for (size_t i = 0; i < primitive.normals.size(); ++i) {
        if (used[i] && (!finite(primitive.normals[i]) || primitive.normals[i] == vec3(0.0f))) {
            primitive.normals[i] = glm::normalize(around[i]);
            ++mended;
        }
    }
    if (mended > 0) {
        file.notes.add("normal that was zero or not finite replaced by the geometric one", mended);
    }
}

// What no mesh has had before, those before lack.
void fillWhatWasLacking(const Primitive& primitive, Scene& scene) {
    if (!primitive.second_uvs.empty()) {
        scene.second_uvs.resize(scene.positions.size(), vec2(0.0f));
    }
    if (!primitive.lightmap_uvs.empty()) {
        scene.lightmap_uvs.resize(scene.positions.size(), vec2(0.0f));
    }
    if (!primitive.colors.empty()) {
        scene.colors.resize(scene.positions.size(), vec4(1.0f));
    }
    if (!primitive.tangents.empty()) {
        scene.tangents.resize(scene.positions.size(), vec4(0.0f));
    }
}

void append(File& file, const Primitive& primitive, uint32_t material, Scene& scene) {
    if (scene.triangles.size() + primitive.triangles.size() > kMaxTriangles) {
        file.fail("meshes", "more than {} triangles; split or simplify the scene", kMaxTriangles);
    }
    std::vector<uint32_t> scene_vertex(primitive.positions.size(), kUnused);
    int64_t bad_uvs = 0;
    const auto uv_of = [&](const std::vector<vec2>& uvs, uint32_t vertex) {
        const vec2 uv = uvs.empty() ? vec2(0.0f) : uvs[vertex];
        const bool bad = !std::isfinite(uv.x) || !std::isfinite(uv.y);
        bad_uvs += bad ? 1 : 0;
        return bad ? vec2(0.0f) : uv;
    };
    fillWhatWasLacking(primitive, scene);
    const bool with_tangents = !primitive.tangents.empty() || !scene.tangents.empty();
    const bool with_second_uvs = !primitive.second_uvs.empty() || !scene.second_uvs.empty();
    const bool with_lightmap = !primitive.lightmap_uvs.empty() || !scene.lightmap_uvs.empty();
    const bool with_colors = !primitive.colors.empty() || !scene.colors.empty();
    const auto add_vertex = [&](uint32_t vertex, const vec3& normal) {
        const auto index = static_cast<uint32_t>(scene.positions.size());
        scene.positions.push_back(primitive.positions[vertex]);
        scene.normals.push_back(normal);
        scene.uvs.push_back(uv_of(primitive.uvs, vertex));
        if (with_second_uvs) {
            scene.second_uvs.push_back(uv_of(primitive.second_uvs, vertex));
        }
        if (with_lightmap) {
            scene.lightmap_uvs.push_back(uv_of(primitive.lightmap_uvs, vertex));
        }
        if (with_colors) {
            scene.colors.push_back(primitive.colors.empty() ? vec4(1.0f)
                                                            : primitive.colors[vertex]);
        }
        if (with_tangents) {
            scene.tangents.push_back(primitive.tangents.empty() ? vec4(0.0f)
                                                                : primitive.tangents[vertex]);
        }
        scene.bounds.add(primitive.positions[vertex]);
        return index;
    };
    for (const uvec3& t : primitive.triangles) {
        uvec3 triangle;
        const vec3 flat = glm::normalize(crossOf(primitive, t));
        for (int corner = 0; corner < 3; ++corner) {
            const uint32_t vertex = t[corner];
            if (primitive.normals.empty()) {
                triangle[corner] = add_vertex(vertex, flat);
                continue;
            }
            if (scene_vertex[vertex] == kUnused) {
                scene_vertex[vertex] = add_vertex(vertex, primitive.normals[vertex]);
            }
            triangle[corner] = scene_vertex[vertex];
        }
        scene.triangles.push_back(triangle);
        scene.materials_of.push_back(material);
        if (file.keeps_sources) {
            scene.source_corners.emplace_back(t, primitive.mirrored[t.x] ? 1 : 0);
        }
    }
    if (bad_uvs > 0) {
        file.notes.add("texture coordinate that was not finite set to zero", bad_uvs);
    }
}

}  // namespace

void appendMesh(File& file, int mesh_index, const Pose& pose, Scene& scene) {
    const tinygltf::Mesh& mesh = file.model.meshes[static_cast<size_t>(mesh_index)];
    const auto default_material = static_cast<uint32_t>(scene.materials.size() - 1);
    bool named = false;
    for (size_t i = 0; i < mesh.primitives.size(); ++i) {
        const tinygltf::Primitive& source = mesh.primitives[i];
        const std::string where = fmt::format(
            "{}, primitive {}", label("mesh", static_cast<size_t>(mesh_index), mesh.name), i);
        if (source.mode >= TINYGLTF_MODE_POINTS && source.mode < TINYGLTF_MODE_TRIANGLES) {
            file.notes.add("points and lines are not supported: primitive left out");
            continue;
        }
        if (source.mode < 0 || source.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
            file.fail(where, "mode {} is unknown; use triangles (4)", source.mode);
        }
        uint32_t material = default_material;
        if (const int own = materialOf(file, source, where); own != -1) {
            file.at(file.model.materials, own, where, "material");
            material = static_cast<uint32_t>(own);
        }
        LightmapUse& lightmap = scene.materials[material].lightmap;
        Primitive primitive = readPrimitive(file, source, pose.weights, lightmap, where);
        if (!primitive.positions.empty() && primitive.lightmap_uvs.empty()) {
            lightmap = {};  // what the material has is of no use
        }
        for (const TextureUse& use : scene.materials[material].textures) {
            if (use.used() && (use.uv_set == 0 ? primitive.uvs : primitive.second_uvs).empty()) {
                file.notes.add(fmt::format(
                    "textured mesh without TEXCOORD_{}: one colour of the texture all over",
                    use.uv_set));
            }
        }
        std::vector<glm::dmat4> skinned;
        if (!pose.world_from_joint.empty()) {
            skinned = skinnedTransforms(file, source, pose.world_from_joint,
                                        primitive.positions.size(), where);
        }
        transform(primitive, pose.world_from_mesh, skinned);
        dropDegenerate(file, primitive);
        mendNormals(file, primitive);
        const bool mapped = scene.materials[material].tangentTexture().used();
        if (!mapped || primitive.normals.empty()) {
            primitive.tangents.clear();  // flat normals are not those that tangents were made for
        }
        const size_t first_triangle = scene.triangles.size();
        if (!named) {
            named = true;
            const auto node = static_cast<size_t>(pose.node);
            scene.objects.push_back(
                {static_cast<uint32_t>(first_triangle),
                 firstName(file.model.nodes[node].name, mesh.name, "node", node)});
        }
        if (file.keeps_sources) {
            scene.sources.push_back({.first_triangle = static_cast<uint32_t>(first_triangle),
                                     .node = pose.node,
                                     .primitive = static_cast<int>(i),
                                     .instance = pose.instance});
        }
        append(file, primitive, material, scene);
        if (mapped && primitive.tangents.empty()) {
            makeTangents(scene, first_triangle);
        }
    }
}

}  // namespace sheen::gltf
