// The scene on the GPU, as every drawing stage reads it: clusters of triangles to rasterise, packed
// triangles, materials, textures and lights to shade. Triangle indices of this room are in cluster
// order.
#pragma once

#include <vector>

#include "gl/objects.h"
#include "gl/program.h"
#include "gl/worker_pool.h"
#include "raster/clusters.h"
#include "raster/view.h"
#include "scene/scene.h"

namespace sheen {

/// Where a triangle lies: a point of it and its normal, whose length is twice its area.
struct TrianglePlane {
    vec3 point, normal;
};

struct GpuScene {
    std::vector<Cluster> clusters;
    int light_count = 0;
    gl::Buffer positions;
    std::vector<uint32_t> indices;  ///< into positions, three a triangle
    gl::Buffer triangles;
    std::vector<uint32_t> triangle_of;  ///< of each of the scene's triangles, at the finest level
    std::vector<uint32_t> scene_triangles;  ///< that each triangle is or came from
    gl::Buffer corners;  ///< colours and second coordinates of the triangles' corners
    bool has_corners = false;
    gl::Buffer materials;
    gl::Buffer texels;
    gl::Buffer lights;
    gl::Buffer albedo_table;
    // Shadow maps, filled by renderShadowMaps(): one layer a view.
    gl::Texture shadow_maps;
    gl::Buffer shadow_views;
    int shadow_resolution = 0;
    std::vector<TrianglePlane> planes;  ///< of all triangles, for records to know what they see
    bool textured = false;              ///< whether some material is
    bool lambertian = false;            ///< whether all materials are
};

/// Packs and uploads `scene`; runs on a worker's context.
GpuScene uploadScene(const Scene& scene);

/// Makes the scene's shadow maps: six views for a point light or a wide spot, one for a spot, and
/// of a directional light one for each of the boxes `near`, each within the next, and for the
/// scene's bounds. (Each point is looked up in the least that holds it.)
void renderShadowMaps(gl::WorkerPool& pool, const Scene& scene, GpuScene& gpu,
                      const std::vector<Bounds>& near = {});

/// Draws clusters into views; belongs to one worker, whose context is current.
class ClusterDrawer {
  public:
    ClusterDrawer() = default;
    /// `fragment`: the fragment shader under shaders/.
    ClusterDrawer(const GpuScene& gpu, const char* fragment);
    /// Sets the views that draw() names by index, and finds what each may see: every cluster in its
    /// frustum, at the coarsest level whose error is seen at an angle of at most `tolerance`
    /// radians; 0: the finest.
    void setViews(const GpuScene& gpu, std::span<const View> views, float tolerance = 0.0f);
    /// Draws one view into the current framebuffer and viewport, in one call: a draw a cluster
    /// would cost more than copying indices does.
    void draw(int index);

  private:
    gl::Program program_;
    GLint view_rows_ = -1;  // where uniforms are: looking names up takes as long as a small draw
    GLint first_drawn_ = -1;
    gl::VertexArray vertex_array_;
    std::vector<View> views_;
    gl::Buffer index_buffer_;
    gl::Buffer triangle_buffer_;        // which triangle each drawn one is
    std::vector<int> first_triangles_;  // of each view, and the end of the last
};

/// Defines that every shader including raster/direct.glsl needs; `taps` of the shadow filter: 1
/// or 4.
std::vector<std::string> shadingDefines(const GpuScene& gpu, int taps);
/// Binds the buffers and textures that raster/direct.glsl reads and sets its uniforms.
void bindShading(const GpuScene& gpu, const gl::Program& program);

}  // namespace sheen
