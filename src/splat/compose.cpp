#include <atomic>
#include <cmath>

#include "core/parallel.h"
#include "splat/splat.h"

namespace sheen {
namespace {

bool finite(const vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// By the records; their weights must have a sum above zero. In the diffuse class the lobe acts as a
// cosine of the same albedo, but for what that misses.
vec3 specularAt(const GBuffer& gbuffer, const PixelClasses& classes, const PixelLobes& lobes,
                const SplatBuffer& splat, int x, int y) {
    const vec3 albedo = specularAlbedo(gbuffer, y * gbuffer.width + x);
    const vec4& sum = splat.irradiance.at(x, y);
    const vec3 said = classes.orders.at(x, y) > shared::DIFFUSE_ORDER
                          ? lobes.scale.at(x, y) * vec3(splat.specular.at(x, y)) / sum.w
                          : albedo * vec3(sum) / (kPi * sum.w);
    const vec4 missed = splat.missed.pixels.empty() ? vec4(0.0f) : splat.missed.at(x, y);
    return missed.w > 0.0f ? said + albedo * vec3(missed) / missed.w : said;
}

void fillGeometry(const GBuffer& gbuffer, Frame& frame) {
    for (Image<vec3>* image : {&frame.albedo, &frame.normal, &frame.position}) {
        *image = Image<vec3>(gbuffer.width, gbuffer.height);
    }
    frame.roughness = Image<float>(gbuffer.width, gbuffer.height);
    frame.depth = Image<float>(gbuffer.width, gbuffer.height, kInfinity);
    for (int i = 0; i < gbuffer.width * gbuffer.height; ++i) {
        if (gbuffer.seen(i)) {
            const auto pixel = static_cast<size_t>(i);
            frame.albedo.pixels[pixel] = vec3(gbuffer.diffuse.pixels[pixel]);
            frame.normal.pixels[pixel] = vec3(gbuffer.normal.pixels[pixel]);
            frame.position.pixels[pixel] = vec3(gbuffer.position.pixels[pixel]);
            frame.roughness.pixels[pixel] = gbuffer.normal.pixels[pixel].w;
            frame.depth.pixels[pixel] = gbuffer.position.pixels[pixel].w;
        }
    }
}

}  // namespace

Image<vec3> cachedSpecular(const GBuffer& gbuffer, const PixelClasses& classes,
                           const PixelLobes& lobes, const SplatBuffer& splat) {
    Image<vec3> specular(classes.orders.width, classes.orders.height);
    for (int y = 0; y < specular.height; ++y) {
        for (int x = 0; x < specular.width; ++x) {
            if (classes.isCorrected(x, y) && splat.irradiance.at(x, y).w > 0.0f) {
                specular.at(x, y) = specularAt(gbuffer, classes, lobes, splat, x, y);
            }
        }
    }
    return specular;
}

ComposeCounts compose(const GBuffer& gbuffer, const PixelClasses& classes, const PixelLobes& lobes,
                      const SplatBuffer& splat, const Image<vec3>& by_rays,
                      const ComposeParams& params, Frame& frame) {
    const int width = gbuffer.width;
    const int height = gbuffer.height;
    for (Image<vec3>* image : {&frame.direct, &frame.indirect, &frame.indirect_diffuse}) {
        *image = Image<vec3>(width, height);
    }
    frame.emission = !gbuffer.emission.empty() ? gbuffer.emission
                     : params.geometry         ? Image<vec3>(width, height)
                                               : Image<vec3>();
    if (params.geometry) {
        fillGeometry(gbuffer, frame);
    }
    frame.weight = Image<float>(width, height);
    frame.primitive = gbuffer.primitive;
    std::atomic<int> nonfinite = 0;
    std::atomic<int> negative = 0;
    parallelFor(height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            if (!gbuffer.seen(y * width + x)) {
                continue;
            }
            const vec4 diffuse = gbuffer.diffuse.at(x, y);
            const vec3 direct = gbuffer.direct.at(x, y);
            frame.direct.at(x, y) = finite(direct) ? direct : vec3(0.0f);
            nonfinite += finite(direct) ? 0 : 1;
            const vec4 sum = splat.irradiance.at(x, y);
            frame.weight.at(x, y) = sum.w;
            if (sum.w <= 0.0f) {
                continue;
            }
            const vec3 irradiance = vec3(sum) / sum.w;
            vec3 specular(0.0f);
            if (classes.by_rays.at(x, y) != 0) {
                specular = by_rays.at(x, y);
            } else if (!params.irradiance_only) {
                specular = specularAt(gbuffer, classes, lobes, splat, x, y);
            }
            vec3 diffuse_part = vec3(diffuse) * irradiance / kPi;
            if (!finite(diffuse_part) || !finite(specular)) {
                ++nonfinite;
                diffuse_part = specular = vec3(0.0f);
            }
            const vec3 indirect = diffuse_part + specular;
            if (indirect.x < 0.0f || indirect.y < 0.0f || indirect.z < 0.0f) {
                ++negative;
            }
            frame.indirect.at(x, y) = glm::max(indirect, vec3(0.0f));
            frame.indirect_diffuse.at(x, y) = diffuse_part;
        }
    });
    return {.nonfinite = nonfinite, .negative = negative};
}

}  // namespace sheen
