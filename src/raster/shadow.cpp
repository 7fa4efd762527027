// Shadow maps of the punctual lights: made once, reused by every pixel and every record.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "raster/gpu_scene.h"

namespace sheen {
namespace {

// A spot whose cone is wider than this (60 degrees to each side) is covered by cube faces.
constexpr float kSpotCubeCosine = 0.5f;
// Memory of all shadow maps together, and as much again for those of larger boxes; the resolution
// follows from it.
constexpr int64_t kShadowBytes = int64_t{256} << 20;
constexpr int kMinResolution = 256;
constexpr int kMaxResolution = 4096;
constexpr int kMaxSunTiles = 4;
constexpr int kMinTiledResolution = 1024;  // below, kMargin is fewer texels than the filter needs
// Half the width of the shadow filter in texels, diagonally, plus a margin.
constexpr float kLiftTexelsWide = 2.2f;
constexpr float kLiftTexelsSingle = 1.5f;
// How much wider than the part it is used for a view is that has neighbours, so that the filter at
// its edge still finds texels.
constexpr float kMargin = 1.01f;

// How near a light its views begin, in steps off the surface nearest to it: what it lies on is cut
// away, however it is rounded, but never what it does not touch.
constexpr float kNearOverOffset = 4.0f;
constexpr float kTouching = 0.125f;

bool needsCube(const PunctualLight& light) {
    return light.kind == shared::LIGHT_POINT ||
           (light.kind == shared::LIGHT_SPOT && light.cos_outer < kSpotCubeCosine);
}

// Any two unit vectors that complete `forward`.
void completeFrame(const vec3& forward, vec3& right, vec3& up) {
    const vec3 helper = std::abs(forward.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0);
    right = glm::normalize(glm::cross(forward, helper));
    up = glm::cross(right, forward);
}

void appendCube(const PunctualLight& light, float near, std::vector<View>& views) {
    // In the order of cubeFace() in direct.glsl.
    const vec3 forward[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (const vec3& f : forward) {
        vec3 right;
        vec3 up;
        completeFrame(f, right, up);
        views.push_back(perspectiveView(light.position, right * kMargin, up * kMargin, f, near));
        views.back().texel_size = 2.0f * kMargin;
    }
}

void appendSpot(const PunctualLight& light, float near, std::vector<View>& views) {
    vec3 right;
    vec3 up;
    completeFrame(light.direction, right, up);
    const float cosine = light.cos_outer;
    const float tan_outer = 1.02f * std::sqrt(1.0f - cosine * cosine) / cosine + 1e-3f;
    views.push_back(
        perspectiveView(light.position, right * tan_outer, up * tan_outer, light.direction, near));
    views.back().texel_size = 2.0f * tan_outer;
}

// A box as the light sees it, in tiles x tiles views, row by row as in sunTile() in direct.glsl.
void appendBox(const PunctualLight& light, const Bounds& bounds, int tiles,
               std::vector<View>& views) {
    vec3 right;
    vec3 up;
    completeFrame(light.direction, right, up);
    const mat3 world_from_light(right, up, light.direction);
    // A box's extent along a direction is that of its edges.
    const vec3 edges = bounds.empty() ? vec3(1.0f) : bounds.upper - bounds.lower;
    const vec3 center = bounds.empty() ? vec3(0.0f) : bounds.center();
    vec3 half;
    for (int axis = 0; axis < 3; ++axis) {
        half[axis] = 0.505f * glm::dot(glm::abs(world_from_light[axis]), edges);
    }
    half = glm::max(half, std::max(0.01f * glm::length(edges), 1e-6f));  // flat scenes
    const vec2 tile = vec2(half) / static_cast<float>(tiles);
    const float margin = tiles > 1 ? kMargin : 1.0f;
    for (int y = 0; y < tiles; ++y) {
        for (int x = 0; x < tiles; ++x) {
            const vec2 offset = tile * vec2(2 * x + 1 - tiles, 2 * y + 1 - tiles);
            const vec3 origin =
                center + right * offset.x + up * offset.y - light.direction * half.z;
            views.push_back(parallelView(origin, right * (margin * tile.x), up * (margin * tile.y),
                                         light.direction * (2.0f * half.z)));
            views.back().texel_size = 2.0f * margin * std::max(tile.x, tile.y);
        }
    }
}

void appendDirectional(const PunctualLight& light, const std::vector<Bounds>& boxes, int tiles,
                       std::vector<View>& views) {
    for (size_t i = 0; i < boxes.size(); ++i) {
        const size_t first = views.size();
        appendBox(light, boxes[i], i == 0 ? tiles : 1, views);
        for (size_t view = first; view < views.size(); ++view) {
            views[view].coarser = i + 1 < boxes.size() ? static_cast<int>(views.size()) : 0;
        }
    }
}

// Where a light's views begin.
float nearOf(const PunctualLight& light, const Scene& scene, const GpuScene& gpu) {
    uint32_t nearest = 0;
    float distance = kInfinity;
    for (const Cluster& cluster : gpu.clusters) {
        if (glm::distance(cluster.center, light.position) - cluster.radius > distance) {
            continue;
        }
        const LevelOfDetail& finest = cluster.levels[0];
        for (uint32_t i = finest.first; i < finest.first + finest.count; ++i) {
            const uint32_t triangle = gpu.scene_triangles[i];
            const float to_triangle = distanceToTriangle(scene, triangle, light.position);
            if (to_triangle < distance) {
                distance = to_triangle;
                nearest = triangle;
            }
        }
    }
    if (distance == kInfinity) {
        return 1.0f;  // there is nothing to draw
    }
    const uvec3& t = scene.triangles[nearest];
    const float edge = glm::distance(scene.positions[t.x], scene.positions[t.y]);
    const float offset = surfaceOffset(scene, nearest, light.position,
                                       geometricNormal(scene, static_cast<int>(nearest)), edge);
    const float near = kNearOverOffset * offset;
    return distance < kTouching * offset ? near : std::min(near, 0.5f * distance);
}

// All views of all lights, each light told where its own begin.
std::vector<View> lightViews(const std::vector<float>& nears, const std::vector<Bounds>& boxes,
                             int sun_tiles, std::vector<PunctualLight>& lights) {
    std::vector<View> views;
    for (size_t i = 0; i < lights.size(); ++i) {
        PunctualLight& light = lights[i];
        light.first_view = static_cast<int>(views.size());
        if (light.kind == shared::LIGHT_DIRECTIONAL) {
            light.view_tiles = sun_tiles;
            appendDirectional(light, boxes, sun_tiles, views);
        } else if (needsCube(light)) {
            appendCube(light, nears[i], views);
        } else {
            appendSpot(light, nears[i], views);
        }
    }
    return views;
}

bool fits(int resolution, size_t layers) {
    return int64_t{4} * resolution * resolution * static_cast<int64_t>(layers) <= kShadowBytes;
}

// A layer of the maps for each view.
void drawMaps(const GpuScene& gpu, const std::vector<View>& views, int resolution) {
    using namespace gl;
    ClusterDrawer drawer(gpu, "raster/depth.frag");
    drawer.setViews(gpu, views);
    glEnable(GL_DEPTH_TEST);
    glViewport(0, 0, resolution, resolution);
    for (int i = 0; i < static_cast<int>(views.size()); ++i) {
        GLuint name = 0;
        glCreateFramebuffers(1, &name);
        const Framebuffer framebuffer(name);
        glNamedFramebufferTextureLayer(name, GL_DEPTH_ATTACHMENT, gpu.shadow_maps.name(), 0, i);
        glBindFramebuffer(GL_FRAMEBUFFER, name);
        const float far_depth = 0.0f;
        glClearNamedFramebufferfv(name, GL_DEPTH, 0, &far_depth);
        // What lies between the sun and a box shades it, too.
        const bool parallel = views[static_cast<size_t>(i)].kind == shared::VIEW_PARALLEL;
        (parallel ? glEnable : glDisable)(GL_DEPTH_CLAMP);
        drawer.draw(i);
        glFinish();
    }
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

}  // namespace

std::vector<std::string> shadingDefines(const GpuScene& gpu, int taps) {
    std::vector<std::string> defines = {
        fmt::format("SHADOW_TAPS {}", taps),
        fmt::format("SHADOW_LIFT_TEXELS {}", taps == 1 ? kLiftTexelsSingle : kLiftTexelsWide),
        fmt::format("SHADOW_MARGIN {}", kMargin),
        fmt::format("SPOT_CUBE_COSINE {:.1f}", kSpotCubeCosine)};
    if (gpu.textured) {
        defines.emplace_back("TEXTURED");
    }
    if (gpu.has_corners) {
        defines.emplace_back("CORNERS");
    }
    if (gpu.lambertian) {
        defines.emplace_back("LAMBERTIAN");
    }
    return defines;
}

void renderShadowMaps(gl::WorkerPool& pool, const Scene& scene, GpuScene& gpu,
                      const std::vector<Bounds>& near) {
    using namespace gl;
    std::vector<PunctualLight> lights = scene.lights;
    std::vector<float> nears(lights.size());
    parallelFor(static_cast<int>(lights.size()), [&](int i) {
        nears[static_cast<size_t>(i)] = nearOf(lights[static_cast<size_t>(i)], scene, gpu);
    });
    std::vector<Bounds> boxes = near;
    boxes.push_back(scene.bounds);
    std::vector<View> views = lightViews(nears, boxes, 1, lights);
    const auto suns = static_cast<size_t>(std::count_if(
        lights.begin(), lights.end(),
        [](const PunctualLight& light) { return light.kind == shared::LIGHT_DIRECTIONAL; }));
    const size_t larger = suns * near.size();  // views of larger boxes than the least
    int resolution = kMaxResolution;
    while (resolution > kMinResolution &&
           !(fits(resolution, views.size() - larger) && fits(resolution, larger))) {
        resolution /= 2;
    }
    // A directional light's least view covers much: what memory is left makes it finer.
    for (int tiles = 2; tiles <= kMaxSunTiles && resolution >= kMinTiledResolution; ++tiles) {
        std::vector<PunctualLight> tiled = scene.lights;
        std::vector<View> tiled_views = lightViews(nears, boxes, tiles, tiled);
        if (tiled_views.size() > views.size() && fits(resolution, tiled_views.size() - larger)) {
            lights = std::move(tiled);
            views = std::move(tiled_views);
        }
    }
    const int layers = std::max(static_cast<int>(views.size()), 1);
    if (views.empty()) {
        resolution = 1;
    }
    for (View& view : views) {
        view.texel_size /= static_cast<float>(resolution);
    }
    gpu.shadow_resolution = resolution;
    pool.runOnFirst([&] {
        gpu.lights = makeBuffer(std::span<const PunctualLight>(lights));
        gpu.shadow_views = makeBuffer(std::span<const View>(views));
        gpu.shadow_maps = makeTexture2dArray(GL_DEPTH_COMPONENT32F, resolution, resolution, layers);
        const GLuint maps = gpu.shadow_maps.name();
        glTextureParameteri(maps, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glTextureParameteri(maps, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
        glTextureParameteri(maps, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTextureParameteri(maps, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    });
    pool.runOnFirst([&] { drawMaps(gpu, views, resolution); });
}

}  // namespace sheen
