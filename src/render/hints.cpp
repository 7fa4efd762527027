#include "render/hints.h"

#include <optional>

#include "core/timer.h"
#include "receivers/coats.h"
#include "render/veils.h"
#include "splat/splat.h"

namespace sheen {
namespace {

// As compose() has light that is found at each receiver.
SplatBuffer asSplat(const HintLight& light, const Receivers& receivers) {
    SplatBuffer splat;
    splat.irradiance = Image<vec4>(receivers.image.width, receivers.image.height);
    for (size_t i = 0; i < splat.irradiance.pixels.size(); ++i) {
        if (receivers.seen(i)) {
            splat.irradiance.pixels[i] = vec4(light.irradiance[i], 1.0f);
        }
    }
    return splat;
}

Image<vec3> imageOf(std::vector<vec3> values, const Receivers& receivers) {
    Image<vec3> image;
    image.width = receivers.image.width;
    image.height = receivers.image.height;
    image.pixels = std::move(values);
    return image;
}

// Behind all blended surfaces, or of the so manieth of these.
GBuffer renderView(const HintSource& lit, const RenderParams& params, int veil,
                   RenderResult& result) {
    StageSeconds& seconds = result.stats.seconds;
    const Scene& scene = lit.tracer.scene();
    const Timer see_timer;
    GBuffer gbuffer =
        renderGBuffer(lit.tracer, viewOf(scene, params), params.width, params.height, veil);
    seconds.gbuffer += see_timer.seconds();
    const Timer direct_timer;
    gbuffer.direct = directWithCoats(lit.tracer, lit.lights, gbuffer);
    seconds.shadow += direct_timer.seconds();

    if (!lit.hints) {
        const Timer fill_timer;
        HintsParams how = hintsParams(params.hints);
        how.order = params.sh_order > 0 ? params.sh_order : how.order;
        how.bounces = params.bounces;
        lit.hints.emplace(lit.tracer, how, nearBoxes(scene, gbuffer));
        lit.hints->fill(lit.lights);
        seconds.gather += fill_timer.seconds();
    }
    const Timer look_timer;
    std::optional<Receivers> coats;
    if (!gbuffer.coat.empty()) {
        coats = coatsOf(scene, gbuffer);
    }
    GBuffer sizes;
    sizes.share = std::move(gbuffer.share);
    sizes.veils = gbuffer.veils;
    Receivers receivers = fieldsOf(std::move(gbuffer));
    receivers.by_rays.assign(receivers.positions.size(), 1);  // lobes have light of their own
    HintLight light = lit.hints->at(receivers);
    if (coats) {
        const HintLight of_coats = lit.hints->at(*coats);
        for (size_t i = 0; i < light.reflected.size(); ++i) {
            light.reflected[i] += of_coats.reflected[i];
        }
    }
    seconds.splat += look_timer.seconds();
    const Timer compose_timer;
    const ComposeCounts counts =
        compose(receivers, asSplat(light, receivers),
                imageOf(std::move(light.reflected), receivers), params.all_layers, result.frame);
    seconds.compose += compose_timer.seconds();
    result.frame.weight = {};  // there are no records
    result.stats.nonfinite_pixels += counts.nonfinite;
    result.stats.negative_pixels += counts.negative;
    result.stats.pixels_uncovered += light.unseen;
    return sizes;
}

}  // namespace

GBuffer renderGroundByHints(const HintSource& source, const RenderParams& params,
                            RenderResult& result) {
    return renderView(source, params, 0, result);
}

RenderResult renderByHints(const Scene& scene, const RenderParams& params) {
    findCamera(scene, params.camera);  // before anything is made for it
    RenderResult result;
    const Timer build_timer;
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    std::optional<RadianceHints> hints;
    const HintSource lit{tracer, lights, hints};
    result.stats.seconds.gather += build_timer.seconds();
    const GBuffer ground = renderView(lit, params, 0, result);
    VeiledFrame veiled(result, ground.share);
    for (int veil = 1; veil <= ground.veils; ++veil) {
        RenderResult of_veil;
        of_veil.stats.seconds = result.stats.seconds;
        const GBuffer seen = renderView(lit, params, veil, of_veil);
        veiled.add(std::move(of_veil), seen.share);
    }
    result.stats.hints = hints->count();
    result.stats.lit_samples = hints->sampleCount();
    return result;
}

}  // namespace sheen
