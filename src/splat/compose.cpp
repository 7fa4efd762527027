#include <atomic>
#include <cmath>

#include "core/parallel.h"
#include "splat/splat.h"

namespace sheen {
namespace {

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

// What arrives at a receiver, by what its weights' sum, above zero, makes of it.
struct Arriving {
    vec3 irradiance{0.0f};
    vec3 reflected{0.0f};  // by its lobe
};

Arriving arrivingAt(const LitReceivers& lit, size_t i) {
    const Receivers& receivers = lit.receivers;
    const vec4& sum = lit.splat.irradiance.pixels[i];
    if (sum.w <= 0.0f) {
        return {};
    }
    Arriving arriving{.irradiance = vec3(sum) / sum.w};
    if (receivers.by_rays[i] != 0) {
        arriving.reflected = lit.by_rays.pixels[i];
    } else if (!receivers.irradiance_only) {
        arriving.reflected = specularAt(receivers, lit.splat, i);
    }
    return arriving;
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
            const Arriving arriving = arrivingAt({receivers, splat, by_rays}, i);
            vec3 specular = arriving.reflected;
            vec3 diffuse = receivers.diffuse[i] * arriving.irradiance / kPi;
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

ComposeCounts blendEdges(const Edges& edges, const LitReceivers& pixels, const LitReceivers& strays,
                         Frame& frame) {
    frame.coverage = alpha(frame);
    std::atomic<int> nonfinite{0};
    const auto set = [&nonfinite](vec3& layer, const vec3& value) {
        const bool sound = finite(value);
        layer = sound ? value : vec3(0.0f);
        nonfinite += sound ? 0 : 1;
    };
    constexpr int kGrain = 64;
    parallelFor(
        static_cast<int>(edges.pixels.size()),
        [&](int k) {
            const auto edge = static_cast<size_t>(k);
            const EdgePixel& mean = edges.pixels[edge];
            vec3 diffuse(0.0f);
            vec3 specular(0.0f);
            for (size_t s = mean.first_share; s < edges.endOfShares(edge); ++s) {
                const EdgeShare& share = edges.shares[s];
                const bool stray = share.receiver >= edges.first_stray;
                const LitReceivers& lit = stray ? strays : pixels;
                const auto i =
                    static_cast<size_t>(share.receiver - (stray ? edges.first_stray : 0));
                const Arriving arriving = arrivingAt(lit, i);
                diffuse += share.diffuse * arriving.irradiance / kPi;
                specular += share.specular * arriving.reflected /
                            glm::max(lit.receivers.specularAlbedo(i), vec3(1e-12f));
            }
            const size_t i = mean.pixel;
            frame.coverage.pixels[i] = mean.coverage;
            set(frame.direct.pixels[i], mean.direct);
            set(frame.indirect.pixels[i], glm::max(diffuse + specular, vec3(0.0f)));
            set(frame.indirect_diffuse.pixels[i], diffuse);
            if (!frame.emission.empty()) {
                set(frame.emission.pixels[i], mean.emission);
            }
        },
        kGrain);
    for (size_t k = 0; k < edges.pixels.size(); ++k) {
        const EdgePixel& mean = edges.pixels[k];
        for (size_t s = mean.first_seen; s < edges.endOfSeen(k); ++s) {
            frame.fragments.push_back({static_cast<uint32_t>(mean.pixel), edges.seen[s].triangle,
                                       edges.seen[s].coverage});
        }
    }
    return {.nonfinite = nonfinite};
}

}  // namespace sheen
