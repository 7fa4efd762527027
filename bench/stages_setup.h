// What the stage benchmarks run on: scenes of every size, OpenGL workers, images to place records
// in.
#pragma once

#include <memory>
#include <string>

#include "accuracy_sites.h"
#include "cache/fill.h"
#include "light/scattered_once.h"
#include "raster/gpu_scene.h"
#include "receivers/receivers.h"
#include "reference/ray_scene.h"

namespace sheen::bench {

/// A scene of scenes/, each of its triangles cut into `cuts` squared.
struct SceneChoice {
    const char* name;
    const char* file;
    int cuts = 1;
};
/// The Cornell box of 30 triangles.
constexpr SceneChoice kCornell = {"cornell", "cornell_diffuse"};
/// The same box in more and more triangles, so that nothing else changes.
constexpr SceneChoice kBySize[] = {kCornell,
                                   {"cornell_1K", "cornell_diffuse", 6},
                                   {"cornell_5K", "cornell_diffuse", 13},
                                   {"cornell_70K", "cornell_diffuse", 48},
                                   {"cornell_1M", "cornell_diffuse", 183}};
constexpr SceneChoice kGlossyCornell = {"cornell_glossy", "cornell_glossy"};
/// Scenes whose triangles were not cut from larger ones.
constexpr SceneChoice kStatue = {"venus", "venus_glossy"};
constexpr SceneChoice kAtrium = {"atrium", "atrium"};

/// A scene to gather in, at points that its cameras see.
struct GatherScene {
    explicit GatherScene(const SceneChoice& choice, Scene made);

    BenchScene scene;
    ScatteredOnce light;  ///< by cells
    RayScene yardstick;
};

/// What the camera sees of a scene, 512 x 512.
struct View512 {
    Scene scene;
    GBuffer gbuffer;
};

/// Records at every pixel that needs one, as many as asked for within some percent, without a
/// gather: what they hold is made up.
struct MadeUpRecords {
    MadeUpRecords(const View512& view, int order, int count);

    Placement place(RecordField& field) const;

    const View512& view;
    Receivers receivers;  ///< all of one order
    PlacementParams params;
    RecordField field;
    Placement placement;
};

/// Makes what benchmarks ask for and keeps the last of each kind, so that the runs of one benchmark
/// share it.
class Setup {
  public:
    /// `folder`: scenes/. `gl_workers`: contexts of all OpenGL in this process, whose rasteriser
    /// has threadCount() threads.
    Setup(std::string folder, int gl_workers);
    ~Setup();
    Setup(const Setup&) = delete;

    gl::WorkerPool& pool();
    Scene load(const SceneChoice& choice) const;
    const GatherScene& gatherScene(const SceneChoice& choice);
    /// With its surfaces lit.
    const GpuScene& gpuScene(const SceneChoice& choice);
    /// In a view of the glossy Cornell box.
    const MadeUpRecords& madeUpRecords(int order, int count);

  private:
    const View512& glossyView();

    std::string folder_;
    int gl_workers_;
    std::unique_ptr<gl::WorkerPool> pool_;
    std::string gather_name_, gpu_name_;
    std::unique_ptr<GatherScene> gather_;
    std::unique_ptr<View512> view_;
    std::unique_ptr<MadeUpRecords> made_up_;
    std::pair<int, int> made_up_for_;  // order and count
    GpuScene gpu_;
};

/// Add the benchmarks of these stages; `setup` must outlive them.
void registerStartup(Setup& setup);
void registerGather(Setup& setup);
void registerImage(Setup& setup);

}  // namespace sheen::bench
