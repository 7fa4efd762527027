#include "render/shared_frame.h"

#include <memory>
#include <optional>
#include <utility>

#include "core/bytes.h"
#include "core/error.h"
#include "gather/ray_gather.h"
#include "gather/shared_gather.h"
#include "light/element_light.h"
#include "light/illumination_cut.h"

namespace sheen {
namespace {

// The light that rays see: bounds that its cells are made for, and what is kept of more bounces.
std::string lightOf(const SceneState& state, const ViewState& view) {
    ByteWriter out;
    out.put(state.near);
    if (view.again) {
        view.again->writeKept(out);
    }
    return out.bytes();
}

// Makes gatherers of what the first rank tells; the light anew where that is another one.
class Served {
  public:
    Served(const Scene& scene, const RenderParams& params)
        : params_(params), tracer_(scene), lights_(tracer_) {}

    std::unique_ptr<Gatherer> gatherer(const std::string& told) {
        ByteReader in(told);
        const auto hemisphere = in.get<HemisphereParams>();
        const bool without_caustics = in.get<bool>();
        see(in.get<std::string>());
        const OutgoingLight& light = again_ ? static_cast<const OutgoingLight&>(*again_) : *once_;
        return std::make_unique<RayGatherer>(light, hemisphere, without_caustics);
    }

  private:
    void see(std::string light) {
        if (once_ && light == light_) {
            return;
        }
        light_ = std::move(light);
        ByteReader in(light_);
        const auto near = in.get<std::vector<Bounds>>();
        again_.reset();
        once_.emplace(tracer_, &lights_, near);
        if (params_.bounces == 1) {
            return;
        }
        std::unique_ptr<const KeptLight> kept;
        if (params_.kept_by == KeptBy::kPhotons) {
            kept = std::make_unique<PhotonLight>(in);
        } else {
            kept = std::make_unique<ElementLight>(in);
        }
        again_.emplace(*once_, std::move(kept), near, params_.bounces);
    }

    const RenderParams& params_;
    const Tracer tracer_;
    const SceneLights lights_;
    std::string light_;
    std::optional<ScatteredOnce> once_;
    std::optional<ScatteredAgain> again_;
};

}  // namespace

std::string toldOf(const SceneState& state, const ViewState& view,
                   const HemisphereParams& hemisphere) {
    ByteWriter out;
    out.put(hemisphere);
    out.put(view.caustics_apart);
    out.put(lightOf(state, view));
    return out.bytes();
}

void checkShared(const RenderParams& params) {
    const bool by_records =
        params.method == Method::kRadiance || params.method == Method::kIrradiance;
    if (params.method == Method::kLightmap) {
        throwUsage(
            "--method lightmap, by which a file with lightmaps is shown, is not shared out over "
            "ranks; choose radiance, or run it without mpirun");
    }
    if (!by_records || params.gather_road != GatherRoad::kRays) {
        throwUsage(
            "{}: only records that are gathered by rays are shared out over ranks; run it without "
            "mpirun",
            by_records ? "--gather" : "--method");
    }
}

void serveFrame(const Scene& scene, const RenderParams& params, const RankedJob& job) {
    Served served(scene, params);
    serveGathers(job, [&](const std::string& told) { return served.gatherer(told); });
}

}  // namespace sheen
