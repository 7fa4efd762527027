#include "gl/program.h"
#include "splat/splat.h"

namespace sheen {
namespace {

// How a pass draws: which pixels, and which records may serve them.
void drawPass(const gl::Program& program, const GBuffer& gbuffer, const WeightParams& weight,
              int records) {
    using namespace gl;
    program.use();
    program.set("image_size", vec2(gbuffer.width, gbuffer.height));
    program.set("pixel_angle", gbuffer.pixel_angle);
    program.set("accuracy", weight.accuracy);
    program.set("normal_weight", weight.normal_weight);
    program.set("slab", weight.slab);
    glDrawArraysInstancedBaseInstance(GL_TRIANGLE_STRIP, 0, 4, records, 0);
}

}  // namespace

SplatBuffer splatGpu(gl::WorkerPool& pool, const GBuffer& gbuffer, const PixelClasses& classes,
                     const PixelLobes& lobes, const RecordCache& cache,
                     const WeightParams& weight) {
    using namespace gl;
    const int width = gbuffer.width;
    const int height = gbuffer.height;
    SplatBuffer result{Image<vec4>(width, height), Image<vec4>(width, height)};
    Image<vec4> normals = gbuffer.normal;
    bool any_glossy = false;
    for (size_t i = 0; i < normals.pixels.size(); ++i) {
        normals.pixels[i].w = static_cast<float>(classes.orders.pixels[i]);
        any_glossy |= classes.orders.pixels[i] > shared::DIFFUSE_ORDER;
    }
    std::vector<glm::ivec4> rects;
    std::vector<glm::ivec4> glossy_rects;  // of records without harmonics an empty rectangle
    for (const Record& r : cache.records) {
        const PixelRect b = servedBounds(gbuffer, r, weight);
        rects.emplace_back(b.x0, b.y0, b.x1, b.y1);
        glossy_rects.push_back(r.order > shared::DIFFUSE_ORDER ? rects.back() : glm::ivec4(0));
    }
    const auto records = static_cast<int>(cache.records.size());
    pool.runOnFirst([&] {
        if (records == 0) {
            return;
        }
        const Buffer record_buffer = makeBuffer(std::span<const Record>(cache.records));
        const Buffer rect_buffer = makeBuffer(std::span<const glm::ivec4>(rects));
        const Buffer glossy_rect_buffer = makeBuffer(std::span<const glm::ivec4>(glossy_rects));
        const Buffer sh_buffer = makeBuffer(std::span<const float>(cache.sh));
        const Buffer lobe_buffer = makeBuffer(std::span<const float>(lobes.coefficients));
        const auto upload = [&](GLenum internal, GLenum format, GLenum type, const void* data) {
            gl::Texture texture = makeTexture2d(internal, width, height);
            glTextureSubImage2D(texture.name(), 0, 0, 0, width, height, format, type, data);
            return texture;
        };
        const gl::Texture positions =
            upload(GL_RGBA32F, GL_RGBA, GL_FLOAT, gbuffer.position.pixels.data());
        const gl::Texture normal = upload(GL_RGBA32F, GL_RGBA, GL_FLOAT, normals.pixels.data());
        const gl::Texture first =
            upload(GL_R32I, GL_RED_INTEGER, GL_INT, lobes.first.pixels.data());
        const gl::Texture irradiance = makeTexture2d(GL_RGBA32F, width, height);
        const gl::Texture specular = makeTexture2d(GL_RGBA32F, width, height);
        const GLuint targets[] = {irradiance.name(), specular.name()};
        const Framebuffer framebuffer = makeFramebuffer(targets, 0);
        const VertexArray empty = makeVertexArray();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        glViewport(0, 0, width, height);
        const float zero[4] = {};
        glClearNamedFramebufferfv(framebuffer.name(), GL_COLOR, 0, zero);
        glClearNamedFramebufferfv(framebuffer.name(), GL_COLOR, 1, zero);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        glBindVertexArray(empty.name());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, record_buffer.name());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, rect_buffer.name());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, sh_buffer.name());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, lobe_buffer.name());
        glBindTextureUnit(0, positions.name());
        glBindTextureUnit(1, normal.name());
        glBindTextureUnit(2, first.name());
        const Program diffuse("splat/splat.vert", "splat/splat.frag", {"GLOSSY 0"});
        drawPass(diffuse, gbuffer, weight, records);
        Program glossy;
        if (any_glossy) {
            glossy = Program("splat/splat.vert", "splat/splat.frag",
                             {"GLOSSY 1", fmt::format("SH_GRADIENT_ORDER {}", kShGradientOrder)});
            glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, glossy_rect_buffer.name());
            drawPass(glossy, gbuffer, weight, records);
        }
        glDisable(GL_BLEND);
        Image<vec4>* images[] = {&result.irradiance, &result.specular};
        for (int i = 0; i < 2; ++i) {
            glNamedFramebufferReadBuffer(framebuffer.name(),
                                         GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i));
            glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, images[i]->pixels.data());
        }
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    });
    return result;
}

}  // namespace sheen
