#include "raster/gbuffer.h"

#include <bit>
#include <cmath>

#include "image/frame.h"

namespace sheen {
namespace {

constexpr int kTargets = 6;
constexpr uint32_t kTriangleMask = 0x3fffffffu;  // of triangleBits() in gbuffer.frag

}  // namespace

GBuffer renderGBuffer(gl::WorkerPool& pool, const Scene& scene, const GpuScene& gpu,
                      const Camera& camera, int width, int height) {
    using namespace gl;
    GBuffer result;
    result.width = width;
    result.height = height;
    result.view = cameraView(camera, width, height, nearDistance(scene));
    result.pixel_angle = 2.0f * std::tan(0.5f * camera.y_fov) / static_cast<float>(height);
    Image<vec4>* targets[kTargets] = {&result.position, &result.normal, &result.diffuse,
                                      &result.f0,       &result.direct, &result.emission};
    for (Image<vec4>* target : targets) {
        *target = Image<vec4>(width, height);
    }
    pool.runOnFirst([&] {
        const View& view = result.view;
        const gl::Texture visibility = makeTexture2d(GL_R32UI, width, height);
        const gl::Texture depth = makeTexture2d(GL_DEPTH_COMPONENT32F, width, height);
        const GLuint visibility_name = visibility.name();
        const Framebuffer first = makeFramebuffer({&visibility_name, 1}, depth.name());
        ClusterDrawer drawer(gpu, "raster/visibility.frag");
        drawer.setViews(gpu, {&view, 1});
        glViewport(0, 0, width, height);
        glBindFramebuffer(GL_FRAMEBUFFER, first.name());
        const GLuint none[4] = {0, 0, 0, 0};
        const float far_depth = 0.0f;
        glClearNamedFramebufferuiv(first.name(), GL_COLOR, 0, none);
        glClearNamedFramebufferfv(first.name(), GL_DEPTH, 0, &far_depth);
        glEnable(GL_DEPTH_TEST);
        drawer.draw(0);
        glDisable(GL_DEPTH_TEST);

        gl::Texture colors[kTargets];
        GLuint names[kTargets];
        for (int i = 0; i < kTargets; ++i) {
            colors[i] = makeTexture2d(GL_RGBA32F, width, height);
            names[i] = colors[i].name();
        }
        const Framebuffer second = makeFramebuffer(names, 0);
        const Program program("raster/fullscreen.vert", "raster/gbuffer.frag",
                              shadingDefines(gpu, 4));
        const VertexArray empty = makeVertexArray();
        glBindFramebuffer(GL_FRAMEBUFFER, second.name());
        bindShading(gpu, program);
        program.set("image_size", vec2(width, height));
        glBindTextureUnit(1, visibility.name());
        const Buffer views = makeBuffer(std::span<const View>(&view, 1));
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, views.name());
        glBindVertexArray(empty.name());
        drawFullscreen();
        for (int i = 0; i < kTargets; ++i) {
            glNamedFramebufferReadBuffer(second.name(),
                                         GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i));
            glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, targets[i]->pixels.data());
        }
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    });
    result.primitive = Image<uint32_t>(width, height, kNoPrimitive);
    for (int i = 0; i < width * height; ++i) {
        if (result.seen(i)) {
            result.primitive.pixels[static_cast<size_t>(i)] =
                std::bit_cast<uint32_t>(result.f0.pixels[static_cast<size_t>(i)].w) & kTriangleMask;
        }
    }
    return result;
}

vec3 GBuffer::geometricNormalAt(const Scene& scene, int i) const {
    const auto pixel = static_cast<size_t>(i);
    const auto triangle = static_cast<int>(primitive.pixels[pixel]);
    return shared::faceViewer(geometricNormal(scene, triangle),
                              view.origin - vec3(position.pixels[pixel]));
}

}  // namespace sheen
