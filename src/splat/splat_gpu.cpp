// Passes of instanced quads with floating-point blending: one for irradiance, one for each group of
// coefficients of the specular lobes (shared/lobe.glsl). Classes are compared by the depth test.
#include <algorithm>
#include <cstring>
#include <functional>

#include "cache/served.h"
#include "core/error.h"
#include "core/parallel.h"
#include "gl/program.h"
#include "splat/splat.h"

namespace sheen {
namespace {

using glm::uvec4;

// vec4s that the largest pass, that of the first group, hands from a quad's vertices to its
// fragments: its values and the weight's parameters. OpenGL promises 15; what runs 4.5 has 30.
constexpr int kVaryings = 3 + 3 * shared::LOBE_FIRST_GROUP / 4 + 14 + 1;

// What lies in texture buffers must fit: reads beyond their end are silently zero.
void checkTexels(size_t bytes, const char* what) {
    GLint limit = 0;
    gl::glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
    const size_t texels = bytes / sizeof(vec4);
    if (texels > static_cast<size_t>(limit)) {
        throwEnvironment(
            "OpenGL: {} take {} texels where a buffer holds {}; render a smaller image", what,
            texels, limit);
    }
}

// Draws records of at least an order onto pixels of at least that order.
struct Pass {
    const char* fragment;
    std::vector<std::string> defines;
    int least_order;
    int values;  // vec4s a quad carries
    std::function<void(const Record&, vec4*)> fill;
};

Pass irradiancePass(bool missed) {
    constexpr int kRecordValues = sizeof(Record) / sizeof(vec4);
    return {.fragment = "splat/irradiance.frag",
            .defines = {fmt::format("VALUES {}", kRecordValues),
                        fmt::format("MISSED {}", missed ? 1 : 0)},
            .least_order = shared::DIFFUSE_ORDER,
            .values = kRecordValues,
            .fill = [](const Record& k, vec4* to) { std::memcpy(to, &k, sizeof(Record)); }};
}

// Coefficients as convolve() in specular.frag takes them: of every eight the even ones, then the
// odd ones.
void copyCoefficients(const float* from, int count, vec4* to) {
    for (int i = 0; i < count; ++i) {
        to[i / 8 * 2 + i % 2][i % 8 / 2] = from[i];
    }
}

Pass specularPass(const RecordCache& cache, int group) {
    static_assert(kShGradientOrder == 3, "specular.frag has nine gradients");
    static_assert(shared::LOBE_FIRST_GROUP == 16 && shared::LOBE_NEXT_GROUP == 24,
                  "specular.frag has as many coefficients");
    const int first = shared::lobeGroupFirst(group);
    const int size = shared::lobeGroupFirst(group + 1) - first;
    const int head = group == 0 ? 3 : 2;
    const int values = head + 3 * size / 4 + (group == 0 ? 14 : 0);
    int least_order = shared::DIFFUSE_ORDER + 1;
    while (least_order * least_order <= first) {
        ++least_order;
    }
    const auto fill = [=, &cache](const Record& k, vec4* to) {
        const float* sh = &cache.sh[static_cast<size_t>(k.sh_first)];
        const ShLayout layout = shLayout(k.order);
        to[0] = vec4(k.position, k.radius);
        to[1] = vec4(k.normal, first / 8);
        if (group == 0) {
            to[2] = vec4(k.tangent, 0.0f);
        }
        to += head;
        for (int c = 0; c < 3; ++c, to += size / 4) {
            copyCoefficients(sh + c * layout.coefficients() + first,
                             std::min(size, layout.coefficients() - first), to);
        }
        for (int c = 0; c < 6 && group == 0; ++c) {
            const float* from =
                sh + layout.gradientFirst(c / 3) + c % 3 * layout.gradientCoefficients();
            copyCoefficients(from, std::min(8, layout.gradientCoefficients()), to + 2 * c);
            if (layout.gradientCoefficients() > 8) {
                to[12 + c / 3][c % 3] = from[8];
            }
        }
    };
    return {
        .fragment = "splat/specular.frag",
        .defines = {fmt::format("VALUES {}", values), fmt::format("GROUP {}", std::min(group, 1))},
        .least_order = least_order,
        .values = values,
        .fill = fill};
}

// The depth test passes where a quad's depth is greater than the pixel's: a record's class serves
// its own and lower ones. Depths lie half a class apart, and whom nothing serves is at 1.
float classDepth(float order) { return (order + 1.0f) / (shared::SH_MAX_ORDER + 2.0f); }

Image<float> pixelDepths(const PixelClasses& classes, int least_order) {
    Image<float> depths(classes.orders.width, classes.orders.height, 1.0f);
    for (size_t i = 0; i < depths.pixels.size(); ++i) {
        const int order = classes.orders.pixels[i];
        if (order >= least_order) {
            depths.pixels[i] = classDepth(static_cast<float>(order) - 0.5f);
        }
    }
    return depths;
}

// Corners of the records' quads in clip space.
std::vector<vec4> clipBounds(const GBuffer& gbuffer, const RecordCache& cache,
                             const WeightParams& weight) {
    constexpr int kGrain = 64;
    const vec4 size(gbuffer.width, gbuffer.height, gbuffer.width, gbuffer.height);
    std::vector<vec4> bounds(cache.records.size());
    parallelFor(
        static_cast<int>(bounds.size()),
        [&](int i) {
            const auto k = static_cast<size_t>(i);
            const PixelRect r = reachedBounds(gbuffer, cache.records[k], weight);
            bounds[k] = vec4(r.x0, r.y0, r.x1, r.y1) / size * 2.0f - 1.0f;
        },
        kGrain);
    return bounds;
}

struct Quads {
    int count = 0;
    std::vector<vec4> data;  // see quad.vert
};

Quads makeQuads(const Pass& pass, const RecordCache& cache, const std::vector<vec4>& bounds) {
    Quads quads;
    for (size_t i = 0; i < bounds.size(); ++i) {
        const Record& k = cache.records[i];
        if (k.order < pass.least_order) {
            continue;
        }
        const size_t first = quads.data.size();
        quads.data.resize(first + 2 + static_cast<size_t>(pass.values));
        quads.data[first] = bounds[i];
        quads.data[first + 1].x = classDepth(static_cast<float>(k.order));
        pass.fill(k, &quads.data[first + 2]);
        ++quads.count;
    }
    return quads;
}

// Normals beside the texels at which lobes begin.
Image<uvec4> packNormals(const GBuffer& gbuffer, const PixelLobes& lobes) {
    Image<uvec4> packed(gbuffer.width, gbuffer.height);
    parallelFor(gbuffer.height, [&](int y) {
        for (int x = 0; x < gbuffer.width; ++x) {
            packed.at(x, y) = uvec4(glm::floatBitsToUint(vec3(gbuffer.normal.at(x, y))),
                                    std::max(lobes.first.at(x, y), 0) / 8);
        }
    });
    return packed;
}

// Sums to splat into, with the pixels' classes as their depths.
struct Target {
    std::vector<gl::Texture> sums;
    gl::Texture depth;
    gl::Framebuffer framebuffer;

    Target(int width, int height, int count)
        : depth(gl::makeTexture2d(GL_DEPTH_COMPONENT32F, width, height)) {
        std::vector<GLuint> colors;
        for (int i = 0; i < count; ++i) {
            sums.push_back(gl::makeTexture2d(GL_RGBA32F, width, height));
            colors.push_back(sums.back().name());
        }
        framebuffer = gl::makeFramebuffer(colors, depth.name());
        const float zero[4] = {};
        for (int i = 0; i < count; ++i) {
            gl::glClearNamedFramebufferfv(framebuffer.name(), GL_COLOR, i, zero);
        }
    }

    Image<vec4> read(int sum, int width, int height) const {
        using namespace gl;
        Image<vec4> image(width, height);
        glNamedFramebufferReadBuffer(framebuffer.name(),
                                     GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(sum));
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        glReadPixels(0, 0, image.width, image.height, GL_RGBA, GL_FLOAT, image.pixels.data());
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        return image;
    }
};

void drawPass(const Pass& pass, const gl::Program& program, const PixelClasses& classes,
              const Quads& quads, const Target& target) {
    using namespace gl;
    const Image<float> depths = pixelDepths(classes, pass.least_order);
    glTextureSubImage2D(target.depth.name(), 0, 0, 0, depths.width, depths.height,
                        GL_DEPTH_COMPONENT, GL_FLOAT, depths.pixels.data());
    checkTexels(quads.data.size() * sizeof(vec4), "records");
    const Buffer buffer = makeBuffer(std::span<const vec4>(quads.data));
    const gl::Texture texture = makeBufferTexture(GL_RGBA32F, buffer);
    glBindTextureUnit(0, texture.name());
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.name());
    program.use();
    glDrawArraysInstancedBaseInstance(GL_TRIANGLE_STRIP, 0, 4, quads.count, 0);
}

}  // namespace

void checkSplat(gl::WorkerPool& pool, const PixelLobes& lobes) {
    pool.runOnFirst([&] {
        const auto check_components = [](GLenum what, int needed) {
            GLint components = 0;
            gl::glGetIntegerv(what, &components);
            if (components < needed) {
                throwEnvironment(
                    "OpenGL: {} components from vertices to fragments where splatting "
                    "takes {}",
                    components, needed);
            }
        };
        check_components(GL_MAX_VARYING_COMPONENTS, 4 * kVaryings);
        check_components(GL_MAX_FRAGMENT_INPUT_COMPONENTS, 4 * kVaryings);
        check_components(GL_MAX_VERTEX_OUTPUT_COMPONENTS, 4 * (kVaryings + 1));  // gl_Position
        checkTexels(lobes.steps.size() * sizeof(int16_t), "the lobes of glossy pixels");
    });
}

SplatBuffer splatGpu(gl::WorkerPool& pool, const GBuffer& gbuffer, const PixelClasses& classes,
                     const PixelLobes& lobes, const RecordCache& cache,
                     const WeightParams& weight) {
    using namespace gl;
    const int width = gbuffer.width;
    const int height = gbuffer.height;
    if (cache.records.empty()) {
        return {Image<vec4>(width, height), Image<vec4>(width, height), {}};
    }
    const std::vector<int>& orders = classes.orders.pixels;
    const int greatest_order = *std::max_element(orders.begin(), orders.end());
    const bool missed =
        std::any_of(cache.records.begin(), cache.records.end(),
                    [](const Record& k) { return shared::recordMissed(k) != vec3(0.0f); });
    std::vector<Pass> passes = {irradiancePass(missed)};
    for (int i = 0;
         greatest_order > shared::DIFFUSE_ORDER && i < shared::lobeGroups(greatest_order); ++i) {
        passes.push_back(specularPass(cache, i));
    }
    const std::vector<vec4> bounds = clipBounds(gbuffer, cache, weight);
    Image<uvec4> normals = packNormals(gbuffer, lobes);
    SplatBuffer result;
    pool.runOnFirst([&] {
        const gl::Texture position_texture = makeTexture2d(GL_RGBA32F, width, height);
        const gl::Texture normal_texture = makeTexture2d(GL_RGBA32UI, width, height);
        glTextureSubImage2D(position_texture.name(), 0, 0, 0, width, height, GL_RGBA, GL_FLOAT,
                            gbuffer.position.pixels.data());
        glTextureSubImage2D(normal_texture.name(), 0, 0, 0, width, height, GL_RGBA_INTEGER,
                            GL_UNSIGNED_INT, normals.pixels.data());
        normals = {};
        const Buffer lobe_buffer = makeBuffer(std::span<const int16_t>(lobes.steps));
        const gl::Texture lobe_texture = makeBufferTexture(GL_RGBA32I, lobe_buffer);
        const auto bind = [](GLuint unit, const gl::Texture& texture, GLenum format) {
            glBindImageTexture(unit, texture.name(), 0, GL_FALSE, 0, GL_READ_ONLY, format);
        };
        bind(0, position_texture, GL_RGBA32F);
        bind(1, normal_texture, GL_RGBA32UI);
        bind(2, lobe_texture, GL_RGBA32I);
        const gl::Texture material_texture = makeTexture2d(GL_R32I, width, height);
        glTextureSubImage2D(material_texture.name(), 0, 0, 0, width, height, GL_RED_INTEGER, GL_INT,
                            classes.materials.pixels.data());
        bind(3, material_texture, GL_R32I);
        const Target irradiance(width, height, missed ? 2 : 1);
        const Target specular(width, height, 1);
        const VertexArray empty = makeVertexArray();
        glBindVertexArray(empty.name());
        glViewport(0, 0, width, height);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_FALSE);
        Program program;
        std::vector<std::string> program_defines;
        for (const Pass& pass : passes) {
            if (pass.defines != program_defines) {
                program = Program("splat/quad.vert", pass.fragment, pass.defines);
                program.set("weight", vec4(weight.accuracy, weight.normal_weight, weight.slab,
                                           gbuffer.pixel_angle));
                program_defines = pass.defines;
            }
            drawPass(pass, program, classes, makeQuads(pass, cache, bounds),
                     pass.least_order == shared::DIFFUSE_ORDER ? irradiance : specular);
        }
        glDepthMask(GL_TRUE);
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_BLEND);
        result = {irradiance.read(0, width, height), specular.read(0, width, height),
                  missed ? irradiance.read(1, width, height) : Image<vec4>()};
    });
    return result;
}

}  // namespace sheen
