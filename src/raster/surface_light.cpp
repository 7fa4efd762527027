// Lights every surface once, so that gathering a record fetches instead of shading.
#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>

#include "core/parallel.h"
#include "raster/gpu_scene.h"

namespace sheen {
namespace {

constexpr int64_t kTexelBudget = 1 << 20;  // of level 0, all triangles together
constexpr int kMaxLog2Size = 8;
constexpr int kTargetWidth = 1024;

// Texels a side, as a power of two, that make a triangle's texels no longer than `length`.
int log2SizeFor(float longest_edge, float length) {
    const float wanted = std::log2(std::max(longest_edge / length, 1.0f));
    return std::min(static_cast<int>(std::ceil(wanted)), kMaxLog2Size);
}

uvec4 packSides(const vec4& front, const vec4& back) {
    const vec4 f = glm::min(front, vec4(65504.0f));
    const vec4 b = glm::min(back, vec4(65504.0f));
    return {glm::packHalf2x16({f.x, f.y}), glm::packHalf2x16({f.z, b.x}),
            glm::packHalf2x16({b.y, b.z}), 0u};
}

// Level 0 of one triangle and all levels above it, packed in place.
void packLevels(const LitTriangle& t, const vec4* front, const vec4* back, uvec4* out) {
    int size = 1 << t.log2_size;
    std::vector<vec4> f(front, front + size * size);
    std::vector<vec4> b(back, back + size * size);
    for (int level = 0; level <= t.log2_size; ++level) {
        uvec4* first = out + shared::surfaceLightLevelFirst(t.log2_size, level);
        for (int i = 0; i < size * size; ++i) {
            first[i] = packSides(f[static_cast<size_t>(i)], b[static_cast<size_t>(i)]);
        }
        // Average the four texels below by how much of each lies on the triangle.
        size /= 2;
        for (std::vector<vec4>* side : {&f, &b}) {
            std::vector<vec4> next(static_cast<size_t>(size) * size);
            for (int y = 0; y < size; ++y) {
                for (int x = 0; x < size; ++x) {
                    vec4 sum(0.0f);
                    for (int k = 0; k < 4; ++k) {
                        const vec4& texel = (*side)[static_cast<size_t>((2 * y + k / 2) * 2 * size +
                                                                        2 * x + k % 2)];
                        sum += vec4(vec3(texel) * texel.w, texel.w);
                    }
                    const float scale = sum.w > 0.0f ? 1.0f / sum.w : 0.0f;
                    next[static_cast<size_t>(y) * size + x] =
                        vec4(vec3(sum) * scale, 0.25f * sum.w);
                }
            }
            *side = std::move(next);
        }
    }
}

}  // namespace

std::vector<LitTriangle> layOutSurfaceLight(const Scene& scene, const ClusteredMesh& mesh) {
    std::vector<LitTriangle> lit;
    std::vector<float> longest;
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const uvec3& v = mesh.triangles[i];
        const uint32_t t = mesh.scene_triangles[i];
        const MaterialParams& m = scene.materials[scene.materials_of[t]].params;
        LitTriangle triangle{};
        triangle.p0 = scene.positions[v.x];
        triangle.p1 = scene.positions[v.y];
        triangle.p2 = scene.positions[v.z];
        triangle.lambertian = m.metallic == 0.0f && m.specular == 0.0f ? 1 : 0;
        longest.push_back(std::max({glm::length(triangle.p1 - triangle.p0),
                                    glm::length(triangle.p2 - triangle.p0),
                                    glm::length(triangle.p2 - triangle.p1)}));
        lit.push_back(triangle);
    }
    if (lit.empty()) {
        return lit;
    }
    // The finest texel length whose texels fit the budget; a triangle has at least one.
    float length = scene.bounds.size() / 4096.0f;
    for (int64_t texels = kTexelBudget + 1; texels > kTexelBudget; length *= 1.25f) {
        texels = 0;
        int64_t least = 0;
        for (size_t i = 0; i < lit.size(); ++i) {
            lit[i].log2_size = lit[i].lambertian != 0 ? log2SizeFor(longest[i], length) : 0;
            texels += int64_t{1} << (2 * lit[i].log2_size);
            ++least;
        }
        if (texels == least) {
            break;
        }
    }
    uint32_t first = 0;
    for (LitTriangle& t : lit) {
        t.first = first;
        first += shared::surfaceLightLevelFirst(t.log2_size, t.log2_size) + 1u;
    }
    return lit;
}

void lightSurfaces(gl::WorkerPool& pool, GpuScene& gpu) {
    using namespace gl;
    std::vector<uint32_t> owners;  // of the texels of level 0: triangle + 1
    std::vector<uint32_t> firsts;
    for (size_t i = 0; i < gpu.lit_triangles.size(); ++i) {
        firsts.push_back(static_cast<uint32_t>(owners.size()));
        const size_t count = size_t{1} << (2 * gpu.lit_triangles[i].log2_size);
        owners.insert(owners.end(), count, static_cast<uint32_t>(i + 1));
    }
    const int rows_total = static_cast<int>((owners.size() + kTargetWidth - 1) / kTargetWidth);
    owners.resize(static_cast<size_t>(rows_total) * kTargetWidth);
    std::vector<vec4> front(owners.size());
    std::vector<vec4> back(owners.size());
    pool.runOnFirst([&] {
        // Chunks of rows, so that the targets stay small; each knows where it starts.
        constexpr int kChunkRows = 128;
        const Program program("raster/fullscreen.vert", "raster/surface_light.frag",
                              shadingDefines(4));
        const gl::Texture owner = makeTexture2d(GL_R32UI, kTargetWidth, kChunkRows);
        const gl::Texture sides[] = {makeTexture2d(GL_RGBA32F, kTargetWidth, kChunkRows),
                                     makeTexture2d(GL_RGBA32F, kTargetWidth, kChunkRows)};
        const GLuint names[] = {sides[0].name(), sides[1].name()};
        const Framebuffer framebuffer = makeFramebuffer(names, 0);
        const VertexArray empty = makeVertexArray();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        bindShading(gpu, program);
        program.set("target_width", kTargetWidth);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, gpu.lit_triangle_buffer.name());
        glBindTextureUnit(1, owner.name());
        glBindVertexArray(empty.name());
        for (int row = 0; row < rows_total; row += kChunkRows) {
            const int rows = std::min(kChunkRows, rows_total - row);
            const size_t first = static_cast<size_t>(row) * kTargetWidth;
            glTextureSubImage2D(owner.name(), 0, 0, 0, kTargetWidth, rows, GL_RED_INTEGER,
                                GL_UNSIGNED_INT, &owners[first]);
            program.set("first_row", row);
            glViewport(0, 0, kTargetWidth, rows);
            drawFullscreen();
            vec4* targets[] = {&front[first], &back[first]};
            for (int i = 0; i < 2; ++i) {
                glNamedFramebufferReadBuffer(framebuffer.name(),
                                             GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i));
                glReadPixels(0, 0, kTargetWidth, rows, GL_RGBA, GL_FLOAT, targets[i]);
            }
        }
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    });
    size_t texels = 0;
    if (!gpu.lit_triangles.empty()) {
        const LitTriangle& last = gpu.lit_triangles.back();
        texels = last.first + shared::surfaceLightLevelFirst(last.log2_size, last.log2_size) + 1u;
    }
    std::vector<uvec4> packed(texels);
    parallelFor(
        static_cast<int>(gpu.lit_triangles.size()),
        [&](int i) {
            const LitTriangle& t = gpu.lit_triangles[static_cast<size_t>(i)];
            const uint32_t first = firsts[static_cast<size_t>(i)];
            packLevels(t, &front[first], &back[first], &packed[t.first]);
        },
        64);
    pool.runOnFirst([&] { gpu.surface_light = makeBuffer(std::span<const uvec4>(packed)); });
}

}  // namespace sheen
