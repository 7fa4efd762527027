#include "render/render.h"

#include <algorithm>
#include <cmath>

#include "reference/reference.h"

namespace sheen {
namespace {

void countPixels(RenderResult& result) {
    const Frame& frame = result.frame;
    const Image<vec3> seen = beauty(frame);
    for (size_t i = 0; i < seen.pixels.size(); ++i) {
        const vec3& pixel = seen.pixels[i];
        const bool finite =
            std::isfinite(pixel.x) && std::isfinite(pixel.y) && std::isfinite(pixel.z);
        result.stats.nonfinite_pixels += finite ? 0 : 1;
        result.stats.pixels_geometry += frame.primitive.pixels[i] == kNoPrimitive ? 0 : 1;
    }
}

RenderResult renderByReference(const Scene& scene, const RenderParams& params) {
    ReferenceResult reference = renderReference(scene, {.width = params.width,
                                                        .height = params.height,
                                                        .camera = findCamera(scene, params.camera),
                                                        .bounces = params.bounces,
                                                        .spp = params.spp,
                                                        .seed = params.seed,
                                                        .quiet = params.quiet});
    RenderResult result;
    result.frame = std::move(reference.frame);
    result.stats.seconds.trace = reference.seconds;
    result.stats.mrays_per_second = reference.mrays_per_second;
    countPixels(result);
    return result;
}

}  // namespace

RenderResult renderFrame(const Scene& scene, const RenderParams& params) {
    switch (params.method) {
        case Method::kReference:
            return renderByReference(scene, params);
        case Method::kRadiance:
        case Method::kIrradiance:
            break;
    }
    throw std::logic_error("this method is not built yet");
}

}  // namespace sheen
