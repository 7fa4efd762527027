// The whole flow from a scene to a frame.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cache/placement_params.h"
#include "cache/record_field.h"
#include "core/bounces.h"
#include "core/ranks.h"
#include "core/timer.h"
#include "gl/context.h"
#include "glossy/specular_rays.h"
#include "hemisphere/hemisphere.h"
#include "image/frame.h"
#include "render/gather_road.h"
#include "scene/scene.h"

namespace sheen {

/// What keeps light of more bounces than one for what rays meet.
enum class KeptBy { kElements, kPhotons };

enum class Method { kRadiance, kIrradiance, kReference, kOctree, kDenoised, kHints, kLightmap };

/// Everything that changes the image. Defaults were chosen by measurement
/// (docs/decisions/placement.md).
struct RenderParams {
    Method method = Method::kRadiance;
    int width = 512;
    int height = 512;
    std::string camera;  ///< name or index; empty: the scene's first
    /// A camera that is none of the scene's; `camera` is then not used.
    std::optional<Camera> view = {};
    /// The image that these pixels are a part of; none: all of it (render/crop.h).
    Camera::Window window = {};
    /// Samples of a pixel with edges, a power of two. 1: each pixel shows its middle, as studies
    /// measure it. More: radiance and irradiance by rays; the reference, whose every path then has
    /// a place of its own in the pixel.
    int aa = 1;
    // The cached methods; of these the octree heeds the accuracy and, as rings of rays,
    // gather.size.
    PlacementParams placement{.min_pixels = 0.0f};  ///< min_pixels 0: by the accuracy
    /// Above 0: rendered at finer and finer accuracies, in several passes, until the image's error
    /// is at most this by the upper end of its estimate; placement.accuracy is not used.
    double target_error = 0;
    /// Above 0: likewise, from an accuracy of 2 on, as far as fits into so many seconds of wall
    /// time from the call on. The image then depends on the machine. The first pass is always
    /// finished.
    double time_limit = 0;
    int sh_order = 0;  ///< 0: chosen per material
    GatherRoad gather_road = GatherRoad::kRays;
    gl::Backend gl = gl::kDefaultBackend;
    /// size 0: by the accuracy; extent 0: by the kind
    HemisphereParams gather{.size = 0, .extent = 0.0f};
    SpecularParams specular;
    /// So often light is scattered, at the most, on its way to where it is indirect light.
    int bounces = kAllBounces;
    KeptBy kept_by = KeptBy::kElements;
    int photons = 150'000;  ///< that start, for what is kept by them
    /// Photons by which it is found what specular surfaces make of lights (Frame::caustic); more
    /// are better. 0: that is part of the indirect light. The reference, which has no photons,
    /// keeps it apart as well. No cost where a scene has no such surfaces.
    int caustics = 1'000'000;
    /// Of radiance hints: about so many in each volume. They heed sh_order too: 2 or 3, 0 is 3.
    int hints = 4096;
    // The path tracer, plain and denoised.
    int spp = 256;  ///< paths a pixel, over all replicates
    uint32_t seed = 0;
    bool all_layers = false;  ///< also make the layers of `--layers all`
    bool quiet = false;       ///< no progress
};

/// SH order a material was given; 0: diffuse, 0 as well where no pixel of the frame sees it.
struct MaterialOrder {
    std::string material;
    int order = 0;
};

/// Wall-clock seconds of each stage, over all passes. `total` and `write` are filled in by the
/// program.
struct StageSeconds {
    double total = 0, load = 0, gbuffer = 0, shadow = 0, bounces = 0, placement = 0, gather = 0,
           project = 0, splat = 0, caustics = 0, compose = 0, trace = 0, denoise = 0, write = 0;
};
/// Those that make up the total, in the order they run.
struct Stage {
    const char* name;
    double StageSeconds::*seconds;
};
constexpr Stage kStages[] = {
    {"load", &StageSeconds::load},           {"gbuffer", &StageSeconds::gbuffer},
    {"shadow", &StageSeconds::shadow},       {"bounces", &StageSeconds::bounces},
    {"placement", &StageSeconds::placement}, {"gather", &StageSeconds::gather},
    {"project", &StageSeconds::project},     {"splat", &StageSeconds::splat},
    {"caustics", &StageSeconds::caustics},   {"compose", &StageSeconds::compose},
    {"trace", &StageSeconds::trace},         {"denoise", &StageSeconds::denoise},
    {"write", &StageSeconds::write}};

/// What the program prints and writes as --json.
struct RenderStats {
    int records = 0;
    int records_reused = 0;       ///< of these, from former frames
    int records_renewed = 0;      ///< of those, gathered anew at their places
    int records_of_clusters = 0;  ///< of the records, of clusters (SitesBy::kKMeans)
    StageSeconds seconds;
    int pixels_geometry = 0;   ///< pixels that see geometry
    int pixels_uncovered = 0;  ///< of these, without any record
    int nonfinite_pixels = 0;
    int negative_pixels = 0;  ///< clamped at compose
    /// Of the indirect layer, as records and probes tell (estimateError()); NaN where they cannot:
    /// where they meet no light, and for methods without them.
    double estimated_rel_rmse = std::numeric_limits<double>::quiet_NaN();
    double estimate_low = std::numeric_limits<double>::quiet_NaN();
    double estimate_high = std::numeric_limits<double>::quiet_NaN();
    float accuracy = 0;           ///< that the frame was rendered with; 0 for other methods
    int gather_size = 0;          ///< likewise
    int passes = 0;               ///< more than 1 for a target error; 0 for other methods
    double diffuse_share = 0;     ///< of pixels_geometry, classified as diffuse
    double corrected_share = 0;   ///< of pixels_geometry, whose records rays correct
    double too_glossy_share = 0;  ///< of pixels_geometry, whose specular light is by rays alone
    int pixels_edges = 0;         ///< that were sampled more than once
    int edge_records = 0;         ///< for what no pixel's middle sees, in the last pass
    /// Values of light of more than one bounce that are kept, at elements or nodes of a cut, and
    /// for what share of the points that ask them none was near (ScatteredAgain).
    size_t elements = 0;
    double elements_missed_share = 0;
    size_t caustic_photons = 0;  ///< kept, on what is seen
    size_t hints = 0;            ///< radiance hints, in all volumes
    size_t lit_samples = 0;      ///< of surfaces that lights shine on, which hints ask
    std::vector<MaterialOrder> sh_order;
    std::string gl_renderer;      ///< empty where none was used
    double mrays_per_second = 0;  ///< path-traced methods only
    int spp = 0;                  ///< likewise: paths a pixel, rounded up to fill all replicates
};

struct RenderResult {
    Frame frame;
    RenderStats stats;
};

/// What the program takes for RenderParams::aa, unless told otherwise, where the method has it.
constexpr int kSmoothEdges = 16;
/// Whether the method has records.
bool usesCache(Method method);

/// Whether the method heeds RenderParams::aa.
bool smoothsEdges(Method method, GatherRoad road);

/// Whether the method heeds RenderParams::caustics.
bool findsCaustics(Method method, GatherRoad road);

/// No target error makes records finer than this.
constexpr float kFinestAccuracy = 0.03f;

/// The camera that `params` names, with their window. Usage error where there is none.
Camera viewOf(const Scene& scene, const RenderParams& params);

/// What records depend on besides the scene: those of equal recipes may stand beside each other.
std::string recordRecipe(const RenderParams& params);

struct SceneState;

/// How many rays the records of a frame will take: for few, what is made of the scene to serve them
/// is coarser.
enum class RaysWanted { kMany, kFew };

/// Renders frames of a scene, which must outlive it. What is made of the scene for the methods that
/// cache is made once, when a frame first needs it, and serves all frames of the same road.
class Session {
  public:
    /// `job`: whose ranks gather (shared_frame.h), this one being the first.
    explicit Session(const Scene& scene, RankedJob job = {}, RaysWanted rays = RaysWanted::kMany);
    ~Session();

    /// Renders one frame. Usage error where the method does not support an option or the camera
    /// does not exist; environment error without an OpenGL 4.5 context.
    RenderResult render(const RenderParams& params);

    /// Of render(), what comes before the image: records of the frame, which are then the latest
    /// of records(). For methods of records, after keepRecords(); one pass. Errors likewise.
    RenderStats gather(const RenderParams& params);

    /// From now on a frame begins with those records of former ones that it sees, as far as they
    /// were gathered by the same options (recordRecipe()): only what is missing is gathered, and
    /// light kept on surfaces serves all views. The frame then depends, within its error, on those
    /// before it. `records`: to begin with, of that recipe.
    void keepRecords(KeptRecords records = {}, std::string recipe = {});
    const KeptRecords& records() const { return kept_; }
    /// Hands them over; none are left.
    KeptRecords takeRecords() { return std::exchange(kept_, {}); }

  private:
    RenderResult renderByMethod(const RenderParams& params);
    void check(const RenderParams& params) const;
    SceneState& stateFor(const RenderParams& params, StageSeconds& seconds);
    RenderResult renderByState(const RenderParams& params, const Timer& timer, KeptRecords* kept);
    KeptRecords* keptFor(const RenderParams& params);

    const Scene& scene_;
    const RankedJob job_;
    const RaysWanted rays_;
    std::unique_ptr<SceneState> state_;
    bool keeps_ = false;
    std::string recipe_;  // of what is kept
    KeptRecords kept_;
};

/// The same of a session of its own.
RenderResult renderFrame(const Scene& scene, const RenderParams& params);

}  // namespace sheen
