// Passes of instanced quads with floating-point blending: one for irradiance, one for each group of
// coefficients of the specular lobes (shared/lobe.glsl). Classes are compared by the depth test. A
// large image is drawn in bands of rows: what OpenGL holds of it is then as much as of a small one.
#include <algorithm>
#include <cstring>
#include <functional>
#include <optional>
#include <span>

#include "core/error.h"
#include "core/parallel.h"
#include "gl/program.h"
#include "receivers/served.h"
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

Pass irradiancePass(bool missed, bool bumps) {
    constexpr int kRecordValues = sizeof(Record) / sizeof(vec4);
    return {.fragment = "splat/irradiance.frag",
            .defines = {fmt::format("VALUES {}", kRecordValues),
                        fmt::format("MISSED {}", missed ? 1 : 0),
                        fmt::format("BUMPS {}", bumps ? 1 : 0)},
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

// Rows [first, first + rows) of the image, and the coefficients of their lobes, which lie in a row.
struct Band {
    int first = 0;
    int rows = 0;
    std::span<const int16_t> steps;
    int first_step = 0;
};

std::vector<Band> makeBands(const Receivers& receivers, int band_pixels) {
    const Lobes& lobes = receivers.lobes;
    const int width = receivers.image.width;
    const int height = receivers.image.height;
    const int rows = std::clamp(band_pixels / std::max(width, 1), 1, std::max(height, 1));
    std::vector<Band> bands;
    for (int y = 0; y < height; y += rows) {
        bands.push_back({y, std::min(rows, height - y), {}, 0});
    }
    size_t end = lobes.steps.size();
    for (auto band = bands.rbegin(); band != bands.rend(); ++band) {
        const auto from = lobes.first.begin() + std::ptrdiff_t{band->first} * width;
        const auto to = from + std::ptrdiff_t{band->rows} * width;
        const auto glossy = std::find_if(from, to, [](int first) { return first >= 0; });
        const size_t begin = glossy == to ? end : static_cast<size_t>(*glossy);
        band->first_step = static_cast<int>(begin);
        band->steps = std::span(lobes.steps).subspan(begin, end - begin);
        end = begin;
    }
    return bands;
}

Image<float> pixelDepths(const Receivers& receivers, const Band& band, int least_order) {
    Image<float> depths(receivers.image.width, band.rows, 1.0f);
    const int8_t* orders = &receivers.orders[receivers.image.index(0, band.first)];
    for (size_t i = 0; i < depths.pixels.size(); ++i) {
        if (orders[i] >= least_order) {
            depths.pixels[i] = classDepth(static_cast<float>(orders[i]) - 0.5f);
        }
    }
    return depths;
}

// The pixels that records may reach.
std::vector<PixelRect> reachedByAll(const Receivers& receivers, const RecordCache& cache,
                                    const WeightParams& weight) {
    constexpr int kGrain = 64;
    std::vector<PixelRect> reached(cache.records.size());
    parallelFor(
        static_cast<int>(reached.size()),
        [&](int i) {
            const auto k = static_cast<size_t>(i);
            reached[k] = reachedBounds(receivers, cache.records[k], weight);
        },
        kGrain);
    return reached;
}

struct Quads {
    int count = 0;
    std::vector<vec4> data;  // see quad.vert
};

// Those that reach into the band, with corners in the clip space of the whole image.
Quads makeQuads(const Pass& pass, const RecordCache& cache, const std::vector<PixelRect>& reached,
                const Band& band, const ivec2& size) {
    const vec4 sizes(size.x, size.y, size.x, size.y);
    Quads quads;
    for (size_t i = 0; i < reached.size(); ++i) {
        const Record& k = cache.records[i];
        const PixelRect& r = reached[i];
        if (k.order < pass.least_order || r.y1 <= band.first || r.y0 >= band.first + band.rows) {
            continue;
        }
        const size_t first = quads.data.size();
        quads.data.resize(first + 2 + static_cast<size_t>(pass.values));
        quads.data[first] = vec4(r.x0, r.y0, r.x1, r.y1) / sizes * 2.0f - 1.0f;
        quads.data[first + 1].x = classDepth(static_cast<float>(k.order));
        pass.fill(k, &quads.data[first + 2]);
        ++quads.count;
    }
    return quads;
}

// What packed(receiver) makes of those of a band.
template <class Packed, class F>
Image<Packed> pack(const PixelGrid& image, const Band& band, const F& packed) {
    Image<Packed> result(image.width, band.rows);
    parallelFor(band.rows, [&](int row) {
        const size_t first = image.index(0, band.first + row);
        for (int x = 0; x < image.width; ++x) {
            result.at(x, row) = packed(first + static_cast<size_t>(x));
        }
    });
    return result;
}

// What fragments read of the pixels in a band.
struct Source {
    gl::Texture positions, normals, lobes, materials;
    std::optional<gl::Texture> bumps;
    gl::Buffer lobe_buffer;

    Source(const Receivers& receivers, const Band& band)
        : positions(gl::makeTexture2d(GL_RGBA32F, receivers.image.width, band.rows)),
          normals(gl::makeTexture2d(GL_RGBA32UI, receivers.image.width, band.rows)),
          materials(gl::makeTexture2d(GL_R32I, receivers.image.width, band.rows)),
          lobe_buffer(gl::makeBuffer(band.steps)) {
        lobes = gl::makeBufferTexture(GL_RGBA32I, lobe_buffer);
        const auto upload = [&](GLuint unit, const gl::Texture& texture, GLenum format,
                                GLenum layout, GLenum type, const void* data) {
            gl::glTextureSubImage2D(texture.name(), 0, 0, 0, receivers.image.width, band.rows,
                                    layout, type, data);
            bind(unit, texture, format);
        };
        const PixelGrid& image = receivers.image;
        const auto place = [&](size_t i) {
            return vec4(receivers.positions[i], receivers.footprints[i]);
        };
        upload(0, positions, GL_RGBA32F, GL_RGBA, GL_FLOAT,
               pack<vec4>(image, band, place).pixels.data());
        const auto normal = [&](size_t i) {
            const int lobe = std::max(receivers.lobes.first[i] - band.first_step, 0) / 8;
            return uvec4(glm::floatBitsToUint(receivers.normals[i]), lobe);
        };
        upload(1, normals, GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
               pack<uvec4>(image, band, normal).pixels.data());
        bind(2, lobes, GL_RGBA32I);
        upload(3, materials, GL_R32I, GL_RED_INTEGER, GL_INT,
               &receivers.materials[image.index(0, band.first)]);
        if (!receivers.mapped_normals.empty()) {
            const auto bump = [&](size_t i) { return vec4(receivers.mapped_normals[i], 0.0f); };
            bumps = gl::makeTexture2d(GL_RGBA32F, receivers.image.width, band.rows);
            upload(4, *bumps, GL_RGBA32F, GL_RGBA, GL_FLOAT,
                   pack<vec4>(image, band, bump).pixels.data());
        }
    }

  private:
    static void bind(GLuint unit, const gl::Texture& texture, GLenum format) {
        gl::glBindImageTexture(unit, texture.name(), 0, GL_FALSE, 0, GL_READ_ONLY, format);
    }
};

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

    void read(int sum, const Band& band, Image<vec4>& image) const {
        using namespace gl;
        glNamedFramebufferReadBuffer(framebuffer.name(),
                                     GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(sum));
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        glReadPixels(0, 0, image.width, band.rows, GL_RGBA, GL_FLOAT, &image.at(0, band.first));
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    }
};

void drawPass(const gl::Program& program, const Image<float>& depths, const Quads& quads,
              const Target& target) {
    using namespace gl;
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

// Draws all passes onto a band after the other.
class Splatter {
  public:
    Splatter(const Receivers& receivers, const RecordCache& cache, const WeightParams& weight)
        : receivers_(receivers),
          cache_(cache),
          weight_(weight),
          missed_(
              std::any_of(cache.records.begin(), cache.records.end(),
                          [](const Record& k) { return shared::recordMissed(k) != vec3(0.0f); })),
          passes_{irradiancePass(missed_, !receivers.mapped_normals.empty())},
          reached_(reachedByAll(receivers, cache, weight)) {
        const int greatest_order =
            *std::max_element(receivers.orders.begin(), receivers.orders.end());
        for (int i = 0;
             greatest_order > shared::DIFFUSE_ORDER && i < shared::lobeGroups(greatest_order);
             ++i) {
            passes_.push_back(specularPass(cache, i));
        }
    }

    SplatBuffer run(int band_pixels) {
        const auto whole = [&](bool wanted) {
            return wanted ? Image<vec4>(receivers_.image.width, receivers_.image.height)
                          : Image<vec4>();
        };
        SplatBuffer result{whole(true), whole(passes_.size() > 1), whole(missed_)};
        gl::glEnable(GL_BLEND);
        gl::glBlendFunc(GL_ONE, GL_ONE);
        gl::glEnable(GL_DEPTH_TEST);
        gl::glDepthMask(GL_FALSE);
        for (const Band& band : makeBands(receivers_, band_pixels)) {
            draw(band, result);
        }
        gl::glDepthMask(GL_TRUE);
        gl::glDisable(GL_DEPTH_TEST);
        gl::glDisable(GL_BLEND);
        return result;
    }

  private:
    void draw(const Band& band, SplatBuffer& result) {
        const ivec2 size(receivers_.image.width, receivers_.image.height);
        const Source source(receivers_, band);
        const Target irradiance(size.x, band.rows, missed_ ? 2 : 1);
        std::optional<Target> specular;
        if (passes_.size() > 1) {
            specular.emplace(size.x, band.rows, 1);
        }
        const gl::VertexArray empty = gl::makeVertexArray();
        gl::glBindVertexArray(empty.name());
        gl::glViewport(0, -band.first, size.x, size.y);
        for (const Pass& pass : passes_) {
            const Quads quads = makeQuads(pass, cache_, reached_, band, size);
            drawPass(programOf(pass), pixelDepths(receivers_, band, pass.least_order), quads,
                     pass.least_order == shared::DIFFUSE_ORDER ? irradiance : *specular);
        }
        irradiance.read(0, band, result.irradiance);
        if (specular) {
            specular->read(0, band, result.specular);
        }
        if (missed_) {
            irradiance.read(1, band, result.missed);
        }
    }

    // All but the first group's are the same.
    const gl::Program& programOf(const Pass& pass) {
        auto found = std::find_if(programs_.begin(), programs_.end(),
                                  [&](const auto& known) { return known.first == pass.defines; });
        if (found == programs_.end()) {
            gl::Program program("splat/quad.vert", pass.fragment, pass.defines);
            program.set("weight", vec3(weight_.accuracy, weight_.normal_weight, weight_.slab));
            programs_.emplace_back(pass.defines, std::move(program));
            found = std::prev(programs_.end());
        }
        return found->second;
    }

    const Receivers& receivers_;
    const RecordCache& cache_;
    const WeightParams& weight_;
    const bool missed_;
    std::vector<Pass> passes_;
    const std::vector<PixelRect> reached_;
    std::vector<std::pair<std::vector<std::string>, gl::Program>> programs_;
};

}  // namespace

void checkSplat(gl::WorkerPool& pool, const Receivers& receivers) {
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
        for (const Band& band : makeBands(receivers, kBandPixels)) {
            checkTexels(band.steps.size_bytes(), "the lobes of glossy pixels");
        }
    });
}

SplatBuffer splatGpu(gl::WorkerPool& pool, const Receivers& receivers, const RecordCache& cache,
                     const WeightParams& weight, int band_pixels) {
    if (cache.records.empty()) {
        return {Image<vec4>(receivers.image.width, receivers.image.height), {}, {}};
    }
    SplatBuffer result;
    pool.runOnFirst([&] { result = Splatter(receivers, cache, weight).run(band_pixels); });
    return result;
}

}  // namespace sheen
