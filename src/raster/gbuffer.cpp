#include "raster/gbuffer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "image/frame.h"
#include "rays/jitter.h"
#include "rays/refraction.h"
#include "rays/surface_point.h"

namespace sheen {
namespace {

// Writes what a pixel of an image of `height` rows sees by a camera's ray. A surface at the eye
// itself has no depth and is not seen.
void writePixel(const Scene& scene, const Camera& camera, int height, const CameraRay& ray,
                const Sight::Part& part, size_t i, GBuffer& g) {
    const Hit& hit = part.hit;
    SurfacePoint p = surfacePoint(scene, hit.triangle, hit.u, hit.v, -part.direction, hit.distance);
    const float way = part.before + hit.distance;
    const float depth =
        g.image.depthOf(part.bent() ? ray.origin + way * ray.direction : p.position);
    if (!(depth > 0.0f)) {
        return;
    }
    p.footprint = pixelFootprint(camera, height, p.position, p.n_g);
    const MaterialParams material = materialAt(scene, p.triangle, p.barycentric, p.footprint);
    const Layers layers = layersAt(scene, p.triangle, p.barycentric, p.footprint);
    const ShadingNormals normals =
        normalsAt(scene, p.triangle, p.barycentric, p.n_g, p.wo, p.footprint);
    Scatterer surface = underLayersAt(p, material, layers, normals);
    if (part.leaving > 0.0f) {
        surface.brdf = fromWithin(surface.brdf, material.roughness, part.leaving);
    }
    g.position.pixels[i] = p.position;
    g.depth.pixels[i] = depth;
    g.normal.pixels[i] = normals.smooth;
    if (!g.mapped_normal.empty()) {
        g.mapped_normal.pixels[i] = normals.mapped;
    }
    g.diffuse.pixels[i] = surface.brdf.diffuse;
    g.f0.pixels[i] = surface.brdf.f0;
    g.f90.pixels[i] = surface.brdf.f90;
    g.roughness.pixels[i] = material.roughness;
    if (!g.emission.empty()) {
        g.emission.pixels[i] = material.emission;
    }
    if (!g.coat.empty()) {
        g.coat.pixels[i] = layers.coat;
        g.coat_roughness.pixels[i] = layers.coat_roughness;
    }
    if (!g.coat_normal.empty()) {
        g.coat_normal.pixels[i] = normals.coat;
    }
    if (part.bent()) {
        g.eye.pixels[i] = p.position - way * part.direction;
    }
    g.primitive.pixels[i] = hit.triangle;
}

// The depth that all but a few of the nearest pixels lie beyond; 0 where nothing is seen.
float nearestDepth(const GBuffer& gbuffer) {
    constexpr size_t kFew = 100;  // one of so many
    std::vector<float> depths;
    for (const float depth : gbuffer.depth.pixels) {
        if (depth > 0.0f) {
            depths.push_back(depth);
        }
    }
    if (depths.empty()) {
        return 0.0f;
    }
    const auto few = depths.begin() + static_cast<ptrdiff_t>(depths.size() / kFew);
    std::nth_element(depths.begin(), few, depths.end());
    return *few;
}

bool contains(const Bounds& box, const vec3& p) {
    return glm::all(glm::lessThanEqual(box.lower, p)) && glm::all(glm::lessThanEqual(p, box.upper));
}

// A box about the same centre whose sides are longer by this share of the box's size.
Bounds grown(const Bounds& box, float share) {
    const float step = 0.5f * share * box.size();
    return {.lower = box.lower - step, .upper = box.upper + step};
}

// Where in what rough glass makes of a ray one goes that starts at that place of the image, told
// from the first pixel's corner: elsewhere for each place of a pixel, and likewise for each pixel.
vec2 lobePlace(const Camera& camera, const vec2& place) {
    const ivec2 pixel = ivec2(glm::floor(place)) + camera.window.first;
    const uint32_t number =
        pcgHash(static_cast<uint32_t>(pixel.x)) + static_cast<uint32_t>(pixel.y);
    return glm::fract(glm::fract(place) + randomPlace(number, 0));
}

// What rays see of a veil through place(x, y) of an image of that size, in pixels from the first
// one's middle. `blurred`: by rough glass.
template <class Place>
GBuffer render(const Tracer& tracer, const Camera& camera, const PixelGrid& image,
               const ivec2& size, int veil, bool blurred, const Place& place) {
    const Scene& scene = tracer.scene();
    const int width = image.width;
    const int height = image.height;
    GBuffer result;
    result.image = image;
    for (Image<vec3>* layer :
         {&result.position, &result.normal, &result.diffuse, &result.f0, &result.direct}) {
        *layer = Image<vec3>(width, height);
    }
    for (Image<float>* layer : {&result.depth, &result.f90, &result.roughness}) {
        *layer = Image<float>(width, height);
    }
    if (std::any_of(scene.materials.begin(), scene.materials.end(),
                    [](const Material& m) { return m.emits(); }) ||
        scene.environment.shows()) {
        result.emission = Image<vec3>(width, height);
    }
    if (!scene.tangents.empty()) {
        result.mapped_normal = Image<vec3>(width, height);
    }
    if (std::any_of(scene.materials.begin(), scene.materials.end(),
                    [](const Material& m) { return m.layers.coat > 0.0f; })) {
        result.coat = Image<float>(width, height);
        result.coat_roughness = Image<float>(width, height);
    }
    if (std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) {
            return m.layers.coat > 0.0f && m.coat_normal_texture.used();
        })) {
        result.coat_normal = Image<vec3>(width, height);
    }
    result.primitive = Image<uint32_t>(width, height, kNoPrimitive);
    if (std::any_of(scene.materials.begin(), scene.materials.end(),
                    [](const Material& m) { return m.blended; })) {
        result.share = Image<vec3>(width, height);
    }
    if (std::any_of(scene.materials.begin(), scene.materials.end(),
                    [&](const Material& m) { return bendsRays(m, blurred); })) {
        result.eye = Image<vec3>(width, height, image.view.origin);
    }
    std::vector<int> veils(static_cast<size_t>(height), 0);  // by row
    parallelFor(height, [&](int y) {
        int& most = veils[static_cast<size_t>(y)];
        for (int x = 0; x < width; ++x) {
            const vec2 at = place(x, y);
            const CameraRay ray = cameraRay(camera, size.x, size.y, at.x, at.y);
            const Sight sight = tracer.seeAlone(
                ray.origin, ray.direction,
                blurred ? std::make_optional(lobePlace(camera, at + 0.5f)) : std::nullopt);
            most = std::max(most, sight.veil_count);
            const Sight::Part part = sight.part(veil);
            if (!result.share.empty()) {
                result.share.at(x, y) = part.share;
            }
            if (part.hit.found()) {
                writePixel(scene, camera, size.y, ray, part, image.index(x, y), result);
            } else if (veil == 0 && scene.environment.shows()) {
                result.emission.at(x, y) = scene.environment.radiance(part.direction);
            }
        }
    });
    result.veils = height > 0 ? *std::max_element(veils.begin(), veils.end()) : 0;
    return result;
}

}  // namespace

GBuffer renderGBuffer(const Tracer& tracer, const Camera& camera, int width, int height, int veil) {
    return render(tracer, camera, pixelGrid(camera, width, height), {width, height}, veil, false,
                  [](int x, int y) { return vec2(x, y); });
}

GBuffer renderSamples(const Tracer& tracer, const Camera& camera, const ivec2& size,
                      std::span<const vec2> places, int columns, int veil) {
    SHEEN_CHECK_EQ(places.size() % static_cast<size_t>(columns), 0u);
    PixelGrid packed = pixelGrid(camera, size.x, size.y);
    packed.width = columns;
    packed.height = static_cast<int>(places.size()) / columns;
    return render(tracer, camera, packed, size, veil, true,
                  [&](int x, int y) { return places[packed.index(x, y)] - 0.5f; });
}

std::vector<Bounds> nearBoxes(const Scene& scene, const GBuffer& gbuffer) {
    constexpr float kNear = 8.0f;    // what is seen no farther off than this, over the nearest
    constexpr float kAround = 1.0f;  // by what of its size a box grows for what records see
    constexpr float kStep = 4.0f;    // and to find the next
    constexpr float kLarger = 2.0f;  // of a box that is worth having besides
    const float farthest = kNear * nearestDepth(gbuffer);
    Bounds box;
    for (size_t i = 0; i < gbuffer.position.pixels.size(); ++i) {
        const float depth = gbuffer.depth.pixels[i];
        if (depth > 0.0f && depth <= farthest) {
            box.add(gbuffer.position.pixels[i]);
        }
    }
    const auto held_by = [&](const Bounds& around) {
        Bounds held = box;
        const auto hold = [&](const vec3& p) {
            if (contains(around, p)) {
                held.add(p);
            }
        };
        for (size_t i = 0; i < gbuffer.position.pixels.size(); ++i) {
            if (gbuffer.depth.pixels[i] > 0.0f) {
                hold(gbuffer.position.pixels[i]);
            }
        }
        std::for_each(scene.positions.begin(), scene.positions.end(), hold);
        return held;
    };
    std::vector<Bounds> boxes;
    Bounds around = grown(box, kAround);
    while (box.size() > 0.0f && kLarger * box.size() < scene.bounds.size() &&
           !(contains(around, scene.bounds.lower) && contains(around, scene.bounds.upper))) {
        const Bounds held = held_by(around);
        if (kLarger * held.size() < scene.bounds.size() &&
            (boxes.empty() || held.size() > kLarger * box.size())) {
            boxes.push_back(held);
            box = held;
        }
        around = grown(around, kStep);
    }
    return boxes;
}

void lightGBuffer(gl::WorkerPool& pool, const GpuScene& gpu, GBuffer& gbuffer) {
    using namespace gl;
    const int width = gbuffer.image.width;
    const int height = gbuffer.image.height;
    // As shaders number them, from 1 on.
    Image<uint32_t> triangles(width, height, 0);
    for (size_t i = 0; i < triangles.pixels.size(); ++i) {
        if (gbuffer.primitive.pixels[i] != kNoPrimitive) {
            triangles.pixels[i] = gpu.triangle_of[gbuffer.primitive.pixels[i]] + 1;
        }
    }
    pool.runOnFirst([&] {
        const gl::Texture visibility = makeTexture2d(GL_R32UI, width, height);
        glTextureSubImage2D(visibility.name(), 0, 0, 0, width, height, GL_RED_INTEGER,
                            GL_UNSIGNED_INT, triangles.pixels.data());
        const gl::Texture direct = makeTexture2d(GL_RGBA32F, width, height);
        const GLuint name = direct.name();
        const Framebuffer framebuffer = makeFramebuffer({&name, 1}, 0);
        const Program program("raster/fullscreen.vert", "raster/gbuffer.frag",
                              shadingDefines(gpu, 4));
        const VertexArray empty = makeVertexArray();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        glViewport(0, 0, width, height);
        bindShading(gpu, program);
        program.set("image_size", vec2(width, height));
        glBindTextureUnit(1, visibility.name());
        const Buffer views = makeBuffer(std::span<const View>(&gbuffer.image.view, 1));
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, views.name());
        glBindVertexArray(empty.name());
        drawFullscreen();
        glReadPixels(0, 0, width, height, GL_RGB, GL_FLOAT, gbuffer.direct.pixels.data());
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    });
}

}  // namespace sheen
