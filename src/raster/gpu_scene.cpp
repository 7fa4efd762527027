#include "raster/gpu_scene.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cstring>
#include <glm/gtc/packing.hpp>

#include "scene/brdf_albedo.h"

namespace sheen {
namespace {

// Layouts of shaders/raster/surface.glsl.
struct PackedTriangle {
    vec3 p0;
    uint32_t material;
    vec3 p1;
    float uv0_x;
    vec3 p2;
    float uv0_y;
    vec3 n0;
    float uv1_x;
    vec3 n1;
    float uv1_y;
    vec3 n2;
    float uv2_x;
    float uv2_y;
    uint32_t pad1;
    float lod_error;
    float pad;
};
static_assert(sizeof(PackedTriangle) == 7 * 16);

struct PackedTexture {
    shared::TextureTransform transform;
    int uv_set;
    int first;
    int levels;
    int nearest;
    glm::ivec2 size;
    glm::ivec2 wrap;
    glm::ivec2 pad;
};
static_assert(sizeof(PackedTexture) == 4 * 16);
struct PackedMaterial {
    MaterialParams params;
    int unlit;
    float normal_scale;
    int pad[2];
    PackedTexture textures[shared::TEXTURE_USES + 1];  // the last: the normal's
};
static_assert(sizeof(PackedMaterial) == (5 + 4 * (shared::TEXTURE_USES + 1)) * 16);
struct PackedCorner {
    vec4 color;
    vec4 tangent;
    vec2 second_uv;
    vec2 pad;
};
static_assert(sizeof(PackedCorner) == 3 * 16);
static_assert(sizeof(PunctualLight) == 4 * 16);

std::vector<PackedTriangle> packTriangles(const Scene& scene, const ClusteredMesh& mesh) {
    std::vector<PackedTriangle> packed;
    packed.reserve(mesh.triangles.size());
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const uvec3& v = mesh.triangles[i];
        const uint32_t t = mesh.scene_triangles[i];
        packed.push_back({.p0 = scene.positions[v.x],
                          .material = scene.materials_of[t],
                          .p1 = scene.positions[v.y],
                          .uv0_x = scene.uvs[v.x].x,
                          .p2 = scene.positions[v.z],
                          .uv0_y = scene.uvs[v.x].y,
                          .n0 = scene.normals[v.x],
                          .uv1_x = scene.uvs[v.y].x,
                          .n1 = scene.normals[v.y],
                          .uv1_y = scene.uvs[v.y].y,
                          .n2 = scene.normals[v.z],
                          .uv2_x = scene.uvs[v.z].x,
                          .uv2_y = scene.uvs[v.z].y,
                          .pad1 = 0,
                          .lod_error = 0.0f,
                          .pad = 0.0f});
    }
    return packed;
}

std::vector<TrianglePlane> planesOf(const std::vector<PackedTriangle>& triangles) {
    std::vector<TrianglePlane> planes;
    planes.reserve(triangles.size());
    for (const PackedTriangle& t : triangles) {
        planes.push_back({t.p0, glm::cross(t.p1 - t.p0, t.p2 - t.p0)});
    }
    return planes;
}

// What most scenes' corners have not: [triangle][corner], empty where none has.
std::vector<PackedCorner> packCorners(const Scene& scene, const ClusteredMesh& mesh) {
    std::vector<PackedCorner> packed;
    if (scene.colors.empty() && scene.second_uvs.empty() && scene.tangents.empty()) {
        return packed;
    }
    packed.reserve(3 * mesh.triangles.size());
    for (const uvec3& t : mesh.triangles) {
        for (int corner = 0; corner < 3; ++corner) {
            const uint32_t v = t[corner];
            packed.push_back(
                {.color = scene.colors.empty() ? vec4(1.0f) : scene.colors[v],
                 .tangent = scene.tangents.empty() ? vec4(0.0f) : scene.tangents[v],
                 .second_uv = scene.second_uvs.empty() ? vec2(0.0f) : scene.second_uvs[v],
                 .pad = vec2(0.0f)});
        }
    }
    return packed;
}

// Appends a texture's levels as halves, and returns how many they are.
int appendLevels(const Scene& scene, const Texture& texture, std::vector<uvec2>& texels) {
    const TextureImage& image = scene.images[static_cast<size_t>(texture.image)];
    const int levels = image.levels(texture.srgb);
    for (int i = 0; i < levels; ++i) {
        for (const vec4& c : linearTexels(image.level(texture.srgb, i), texture.srgb)) {
            texels.emplace_back(glm::packHalf2x16({c.r, c.g}), glm::packHalf2x16({c.b, c.a}));
        }
    }
    return levels;
}

// Where an image's levels lie among the texels.
struct LevelChain {
    int first, levels;
};

PackedTexture packTexture(const Scene& scene, const TextureUse& use,
                          const std::vector<LevelChain>& chains) {
    PackedTexture packed{};
    packed.first = -1;
    if (use.used()) {
        const auto i = static_cast<size_t>(use.texture);
        const Texture& texture = scene.textures[i];
        const TextureImage& image = scene.images[static_cast<size_t>(texture.image)];
        packed.transform = use.transform;
        packed.uv_set = use.uv_set;
        packed.first = chains[i].first;
        packed.levels = chains[i].levels;
        packed.nearest = texture.nearest ? 1 : 0;
        packed.size = {image.width, image.height};
        packed.wrap = texture.wrap;
    }
    return packed;
}

void uploadMaterials(const Scene& scene, GpuScene& gpu) {
    std::vector<uvec2> texels;
    std::vector<LevelChain> chains;
    for (size_t i = 0; i < scene.textures.size(); ++i) {
        const Texture& texture = scene.textures[i];
        const auto same =
            std::find_if(scene.textures.begin(), scene.textures.end(), [&](const Texture& other) {
                return other.image == texture.image && other.srgb == texture.srgb;
            });
        const auto first_same = static_cast<size_t>(same - scene.textures.begin());
        if (first_same < i) {
            chains.push_back(chains[first_same]);
            continue;
        }
        const auto first = static_cast<int>(texels.size());
        chains.push_back({.first = first, .levels = appendLevels(scene, texture, texels)});
    }
    std::vector<PackedMaterial> materials;
    for (const Material& material : scene.materials) {
        PackedMaterial packed{};
        packed.params = material.params;
        packed.unlit = material.unlit ? 1 : 0;
        for (size_t use = 0; use < material.textures.size(); ++use) {
            packed.textures[use] = packTexture(scene, material.textures[use], chains);
        }
        packed.normal_scale = material.normal_scale;
        packed.textures[shared::TEXTURE_USES] = packTexture(scene, material.normal_texture, chains);
        materials.push_back(packed);
    }
    gpu.materials = gl::makeBuffer(std::span<const PackedMaterial>(materials));
    gpu.texels = gl::makeBuffer(std::span<const uvec2>(texels));
}

}  // namespace

GpuScene uploadScene(const Scene& scene) {
    GpuScene gpu;
    gpu.light_count = static_cast<int>(scene.lights.size());
    ClusteredMesh mesh = buildClusters(scene);
    gpu.clusters = mesh.clusters;
    // The visibility pass needs only positions: vertices that share one become one.
    std::vector<uint32_t> indices;
    indices.reserve(mesh.triangles.size() * 3);
    for (const uvec3& t : mesh.triangles) {
        indices.insert(indices.end(), {t.x, t.y, t.z});
    }
    std::vector<vec3> positions;
    if (!indices.empty()) {
        std::vector<uint32_t> remap(scene.positions.size());
        positions.resize(meshopt_generateVertexRemap(remap.data(), indices.data(), indices.size(),
                                                     scene.positions.data(), scene.positions.size(),
                                                     sizeof(vec3)));
        meshopt_remapVertexBuffer(positions.data(), scene.positions.data(), scene.positions.size(),
                                  sizeof(vec3), remap.data());
        meshopt_remapIndexBuffer(indices.data(), indices.data(), indices.size(), remap.data());
    }
    std::vector<PackedTriangle> packed = packTriangles(scene, mesh);
    gpu.triangle_of.resize(scene.triangles.size());
    for (const Cluster& cluster : mesh.clusters) {
        const LevelOfDetail& finest = cluster.levels[0];
        for (uint32_t i = finest.first; i < finest.first + finest.count; ++i) {
            gpu.triangle_of[mesh.scene_triangles[i]] = i;
        }
        for (const LevelOfDetail& level : cluster.levels) {
            for (uint32_t i = level.first; i < level.first + level.count; ++i) {
                packed[i].lod_error = level.error;
            }
        }
    }
    gpu.scene_triangles = std::move(mesh.scene_triangles);
    gpu.planes = planesOf(packed);
    gpu.textured = std::any_of(scene.materials.begin(), scene.materials.end(),
                               [](const Material& m) { return m.textured(); });
    gpu.lambertian = std::all_of(scene.materials.begin(), scene.materials.end(), [](const auto& m) {
        return m.params.metallic == 0.0f && m.params.specular == 0.0f;
    });
    gpu.positions = gl::makeBuffer(std::span<const vec3>(positions));
    gpu.indices = std::move(indices);
    gpu.triangles = gl::makeBuffer(std::span<const PackedTriangle>(packed));
    const std::vector<PackedCorner> corners = packCorners(scene, mesh);
    gpu.has_corners = !corners.empty();
    gpu.corners = gl::makeBuffer(std::span<const PackedCorner>(corners));
    gpu.lights = gl::makeBuffer(std::span<const PunctualLight>(scene.lights));
    gpu.albedo_table = gl::makeBuffer(std::span<const float>(
        brdfAlbedoTable(), 2 * shared::ALBEDO_TABLE_MU * shared::ALBEDO_TABLE_ROUGHNESS));
    uploadMaterials(scene, gpu);
    return gpu;
}

ClusterDrawer::ClusterDrawer(const GpuScene& gpu, const char* fragment)
    : program_("raster/visibility.vert", fragment),
      view_rows_(program_.location("rows")),
      first_drawn_(program_.location("first_drawn")),
      vertex_array_(gl::makeVertexArray()) {
    using namespace gl;
    const GLuint array = vertex_array_.name();
    glVertexArrayVertexBuffer(array, 0, gpu.positions.name(), 0, sizeof(vec3));
    glVertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(array, 0, 0);
    glEnableVertexArrayAttrib(array, 0);
    index_buffer_ = makeBuffer(std::span<const uint32_t>());
    triangle_buffer_ = makeBuffer(std::span<const uint32_t>());
    glVertexArrayElementBuffer(array, index_buffer_.name());
}

void ClusterDrawer::setViews(const GpuScene& gpu, std::span<const View> views, float tolerance) {
    std::vector<uint32_t> indices;
    std::vector<uint32_t> triangles;
    first_triangles_.clear();
    for (const View& view : views) {
        first_triangles_.push_back(static_cast<int>(triangles.size()));
        for (const Cluster& cluster : gpu.clusters) {
            if (!sphereInView(view, cluster.center, cluster.radius)) {
                continue;
            }
            const float distance = glm::length(cluster.center - view.origin) - cluster.radius;
            const LevelOfDetail* level = &cluster.levels[0];
            for (const LevelOfDetail& coarser : cluster.levels) {
                if (coarser.error <= tolerance * distance) {
                    level = &coarser;
                }
            }
            const auto first = gpu.indices.begin() + 3 * static_cast<ptrdiff_t>(level->first);
            indices.insert(indices.end(), first, first + 3 * static_cast<ptrdiff_t>(level->count));
            for (uint32_t i = level->first; i < level->first + level->count; ++i) {
                triangles.push_back(i);
            }
        }
    }
    first_triangles_.push_back(static_cast<int>(triangles.size()));
    views_.assign(views.begin(), views.end());
    gl::refillBuffer(index_buffer_, std::span<const uint32_t>(indices));
    gl::refillBuffer(triangle_buffer_, std::span<const uint32_t>(triangles));
}

void ClusterDrawer::draw(int index) {
    using namespace gl;
    const int first = first_triangles_[static_cast<size_t>(index)];
    const int count = first_triangles_[static_cast<size_t>(index) + 1] - first;
    if (count == 0) {
        return;
    }
    program_.use();
    glProgramUniform4fv(program_.name(), view_rows_, sizeof(View) / sizeof(vec4),
                        &views_[static_cast<size_t>(index)].origin.x);
    glProgramUniform1i(program_.name(), first_drawn_, first);
    glBindVertexArray(vertex_array_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, triangle_buffer_.name());
    glDrawElements(GL_TRIANGLES, 3 * count, GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(static_cast<uintptr_t>(first) * 12));
}

void bindShading(const GpuScene& gpu, const gl::Program& program) {
    using namespace gl;
    program.use();
    program.set("light_count", gpu.light_count);
    program.set("shadow_resolution", static_cast<float>(gpu.shadow_resolution));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, gpu.triangles.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, gpu.materials.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, gpu.texels.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, gpu.lights.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, gpu.albedo_table.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, gpu.shadow_views.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, gpu.corners.name());
    glBindTextureUnit(0, gpu.shadow_maps.name());
}

}  // namespace sheen
