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
vec3 specularAt(const Receivers& receivers, const SplatBuffer& splat, size_t i) {
    const vec3 albedo = receivers.specularAlbedo(i);
    const vec4& sum = splat.irradiance.pixels[i];
    const vec3 said = receivers.orders[i] > shared::DIFFUSE_ORDER
                          ? receivers.lobes.scale[i] * vec3(splat.specular.pixels[i]) / sum.w
                          : albedo * vec3(sum) / (kPi * sum.w);
    const vec4 missed = splat.missed.pixels.empty() ? vec4(0.0f) : splat.missed.pixels[i];
    return missed.w > 0.0f ? said + albedo * vec3(missed) / missed.w : said;
}

template <class T>
Image<T> imageOf(const Receivers& receivers, const std::vector<T>& values) {
    Image<T> image;
    image.width = receivers.image.width;
    image.height = receivers.image.height;
    image.pixels = values;
    return image;
}

void fillGeometry(const Receivers& receivers, Frame& frame) {
    frame.albedo = imageOf(receivers, receivers.diffuse);
    frame.normal = imageOf(receivers, receivers.normals);
    frame.position = imageOf(receivers, receivers.positions);
    frame.roughness = imageOf(receivers, receivers.roughness);
    frame.depth = Image<float>(receivers.image.width, receivers.image.height, kInfinity);
    for (size_t i = 0; i < frame.depth.pixels.size(); ++i) {
        if (receivers.seen(i)) {
            frame.depth.pixels[i] = receivers.image.depthOf(receivers.positions[i]);
        }
    }
}

}  // namespace

Image<vec3> cachedSpecular(const Receivers& receivers, const SplatBuffer& splat) {
    Image<vec3> specular(receivers.image.width, receivers.image.height);
    for (size_t i = 0; i < specular.pixels.size(); ++i) {
        if (receivers.isCorrected(i) && splat.irradiance.pixels[i].w > 0.0f) {
            specular.pixels[i] = specularAt(receivers, splat, i);
        }
    }
    return specular;
}

ComposeCounts compose(const Receivers& receivers, const SplatBuffer& splat,
                      const Image<vec3>& by_rays, bool geometry, Frame& frame) {
    const int width = receivers.image.width;
    const int height = receivers.image.height;
    for (Image<vec3>* image : {&frame.direct, &frame.indirect, &frame.indirect_diffuse}) {
        *image = Image<vec3>(width, height);
    }
    frame.emission = !receivers.emission.empty() ? imageOf(receivers, receivers.emission)
                     : geometry                  ? Image<vec3>(width, height)
                                                 : Image<vec3>();
    if (geometry) {
        fillGeometry(receivers, frame);
    }
    frame.weight = Image<float>(width, height);
    frame.primitive = imageOf(receivers, receivers.triangles);
    std::atomic<int> nonfinite = 0;
    std::atomic<int> negative = 0;
    parallelFor(height, [&](int y) {
        for (size_t i = receivers.image.index(0, y); i < receivers.image.index(0, y + 1); ++i) {
            if (!receivers.seen(i)) {
                continue;
            }
            const vec3& direct = receivers.direct[i];
            frame.direct.pixels[i] = finite(direct) ? direct : vec3(0.0f);
            nonfinite += finite(direct) ? 0 : 1;
            const vec4& sum = splat.irradiance.pixels[i];
            frame.weight.pixels[i] = sum.w;
            if (sum.w <= 0.0f) {
                continue;
            }
            const vec3 irradiance = vec3(sum) / sum.w;
            vec3 specular(0.0f);
            if (receivers.by_rays[i] != 0) {
                specular = by_rays.pixels[i];
            } else if (!receivers.irradiance_only) {
                specular = specularAt(receivers, splat, i);
            }
            vec3 diffuse = receivers.diffuse[i] * irradiance / kPi;
            if (!finite(diffuse) || !finite(specular)) {
                ++nonfinite;
                diffuse = specular = vec3(0.0f);
            }
            const vec3 indirect = diffuse + specular;
            if (indirect.x < 0.0f || indirect.y < 0.0f || indirect.z < 0.0f) {
                ++negative;
            }
            frame.indirect.pixels[i] = glm::max(indirect, vec3(0.0f));
            frame.indirect_diffuse.pixels[i] = diffuse;
        }
    });
    return {.nonfinite = nonfinite, .negative = negative};
}

}  // namespace sheen
