// The GPU side of a scene for tests: workers, upload, shadow maps, surface light.
#pragma once

#include "raster/gbuffer.h"
#include "raster/gpu_scene.h"

namespace sheen {

/// Owns a scene on the GPU; frees it on a worker's context.
class TestStage {
  public:
    explicit TestStage(const Scene& scene, int workers = 2) : scene_(scene), pool(workers) {
        pool.runOnFirst([&] { gpu = uploadScene(scene_); });
        renderShadowMaps(pool, scene_, gpu);
    }
    ~TestStage() {
        pool.runOnFirst([&] { gpu = {}; });
    }
    GBuffer gbuffer(const Camera& camera, int width, int height) {
        GBuffer g = renderGBuffer(Tracer(scene_), camera, width, height);
        lightGBuffer(pool, gpu, g);
        return g;
    }
    GBuffer gbuffer(int width, int height) {
        return gbuffer(scene_.cameras.front(), width, height);
    }

  private:
    const Scene scene_;

  public:
    gl::WorkerPool pool;
    GpuScene gpu;
};

}  // namespace sheen
