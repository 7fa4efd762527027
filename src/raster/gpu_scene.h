// The scene on the GPU, as every drawing stage reads it: clusters of triangles to rasterise, packed
// triangles, materials, textures and lights to shade. Triangle indices of this room are in cluster
// order; `scene_triangle` leads back to the Scene.
#pragma once

#include <vector>

#include "gl/objects.h"
#include "gl/program.h"
#include "gl/worker_pool.h"
#include "raster/clusters.h"
#include "raster/view.h"
#include "scene/scene.h"

namespace sheen::shared {
using namespace glm;
#include "shared/surface_light.glsl"
}  // namespace sheen::shared

namespace sheen {

using shared::LitTriangle;
static_assert(sizeof(LitTriangle) == 3 * 16);

struct GpuScene {
    std::vector<Cluster> clusters;
    int light_count = 0;
    gl::Buffer positions;
    gl::Buffer indices;
    gl::Buffer identity;  ///< 0, 1, 2 ...: names a draw's first triangle through baseInstance
    gl::Buffer triangles;
    gl::Buffer materials;
    gl::Buffer texels;
    gl::Buffer lights;
    gl::Buffer albedo_table;
    // Shadow maps, filled by renderShadowMaps(): one layer a view.
    gl::Texture shadow_maps;
    gl::Buffer shadow_views;
    int shadow_resolution = 0;
    // Light that surfaces scatter, filled by lightSurfaces().
    std::vector<LitTriangle> lit_triangles;
    gl::Buffer lit_triangle_buffer;
    gl::Buffer surface_light;  ///< front and back radiance as halves, see gather/lambert.frag
};

/// Packs and uploads `scene`; runs on a worker's context.
GpuScene uploadScene(const Scene& scene);

/// Makes the scene's shadow maps: six views for a point light or a wide spot, one for a spot and
/// for a directional light, whose view covers the scene's bounds.
void renderShadowMaps(gl::WorkerPool& pool, const Scene& scene, GpuScene& gpu);

/// Shares the texels for surface light out among the triangles of all levels of detail.
std::vector<LitTriangle> layOutSurfaceLight(const Scene& scene, const ClusteredMesh& mesh);

/// Lights every surface once: what each texel of each triangle scatters diffusely, on both sides,
/// with mip levels. Records fetch it instead of shading what they see. Needs the shadow maps.
void lightSurfaces(gl::WorkerPool& pool, GpuScene& gpu);

/// Draws clusters into views; belongs to one worker, whose context is current.
class ClusterDrawer {
  public:
    ClusterDrawer() = default;
    /// `fragment`: the fragment shader under shaders/.
    ClusterDrawer(const GpuScene& gpu, const char* fragment);
    /// Uploads the views that draw() names by index.
    void setViews(std::span<const View> views);
    /// Draws what `views[index]` may see of `gpu` into the current framebuffer and viewport, each
    /// cluster at the coarsest level whose error is seen at an angle of at most `tolerance`
    /// radians; 0: the finest.
    void draw(const GpuScene& gpu, int index, float tolerance = 0.0f);

  private:
    struct DrawCommand {
        uint32_t count, instance_count, first_index;
        int32_t base_vertex;
        uint32_t base_instance;
    };
    gl::Program program_;
    gl::VertexArray vertex_array_;
    gl::Buffer view_buffer_;
    gl::Buffer command_buffer_;
    std::vector<View> views_;
    std::vector<DrawCommand> commands_;
};

/// Defines that every shader including raster/direct.glsl needs; `taps` of the shadow filter: 1
/// or 4.
std::vector<std::string> shadingDefines(int taps);
/// Binds the buffers and textures that raster/direct.glsl reads and sets its uniforms.
void bindShading(const GpuScene& gpu, const gl::Program& program);

}  // namespace sheen
