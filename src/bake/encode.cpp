#include "bake/encode.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bake/dilate.h"
#include "core/parallel.h"
#include "image/png.h"
#include "rays/surface_point.h"

namespace sheen {
namespace {

// By clipping to it and rounding to 255 steps, over the texels with light of their own.
double squaredError(const Lightmap& map, const Image<vec3>& light, double intensity) {
    const double step = intensity / 255.0;
    double sum = 0.0;
    for (size_t i = 0; i < light.pixels.size(); ++i) {
        for (int c = 0; c < 3 && map.receivers.seen(i); ++c) {
            const double over = std::max(light.pixels[i][c] - intensity, 0.0);
            sum += over * over + step * step / 12.0;
        }
    }
    return sum;
}

double bestIntensity(const Lightmap& map, const Image<vec3>& light) {
    constexpr int kSteps = 40;  // four to the factor 2
    double most = 0.0;
    for (size_t i = 0; i < light.pixels.size(); ++i) {
        if (map.receivers.seen(i)) {
            const vec3& c = light.pixels[i];
            most = std::max<double>(most, std::max({c.x, c.y, c.z}));
        }
    }
    double best = most, least = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= kSteps && most > 0.0; ++k) {
        const double intensity = most * std::exp2(-0.25 * k);
        const double error = squaredError(map, light, intensity);
        if (error < least) {
            least = error;
            best = intensity;
        }
    }
    return best > 0.0 ? best : 1.0;
}

}  // namespace

EncodedLight encodeIrradiance(const Lightmap& map, const Image<vec3>& irradiance) {
    const double intensity = bestIntensity(map, irradiance);
    Image<vec3> scaled = irradiance;
    for (vec3& c : scaled.pixels) {
        c /= static_cast<float>(intensity);
    }
    const Image<Rgb8> bytes = bytesFromDisplay(scaled);
    EncodedLight encoded{.pngs = {}, .intensity = static_cast<float>(intensity)};
    for (int page = 0; page < map.atlas.pages; ++page) {
        encoded.pngs.push_back(pngBytes(pageOf(map.atlas, bytes, page)));
    }
    return encoded;
}

EncodedLight encodeUnlit(const Scene& scene, const Lightmap& map, const Image<vec3>& irradiance) {
    const Receivers& receivers = map.receivers;
    Image<vec3> radiance(irradiance.width, irradiance.height);
    Image<vec3> coverage(irradiance.width, irradiance.height, vec3(1.0f));
    parallelFor(irradiance.height, [&](int y) {
        for (int x = 0; x < irradiance.width; ++x) {
            const size_t i = receivers.image.index(x, y);
            if (!receivers.seen(i)) {
                continue;
            }
            const uint32_t triangle = receivers.triangles[i];
            const vec3 at = barycentricOf(scene, triangle, receivers.positions[i]);
            const MaterialParams material = materialAt(scene, triangle, at);
            const Layers layers = layersAt(scene, triangle, at);
            Brdf brdf =
                underLayers(shared::makeBrdf(material, 1.0f, brdfAlbedo(1.0f, material.roughness)),
                            layers, 1.0f, 1.0f);
            brdf.diffuse += coatAlbedo(layers, 1.0f);
            const vec3 specular = specularAlbedo(1.0f, material.roughness, brdf.f0, brdf.f90);
            const vec3 sent =
                (brdf.diffuse + specular) * irradiance.pixels[i] / kPi + material.emission;
            // What glass sends is not dimmed by how much of the light it lets pass.
            const Crossing crossing = crossingAt(
                scene, triangle, at, -geometricNormal(scene, static_cast<int>(triangle)));
            coverage.pixels[i] = vec3(crossing.chance);
            radiance.pixels[i] = crossing.chance > 0.0f ? crossing.weightOfMeeting() * sent : sent;
        }
    });
    dilate(map, radiance);
    dilate(map, coverage);
    Image<float> alpha(irradiance.width, irradiance.height);
    std::transform(coverage.pixels.begin(), coverage.pixels.end(), alpha.pixels.begin(),
                   [](const vec3& c) { return c.x; });
    const Image<Rgb8> colors = displayImage(radiance, std::nullopt, toSrgb(ToneCurve::kNone));
    const bool opaque =
        std::all_of(alpha.pixels.begin(), alpha.pixels.end(), [](float a) { return a == 1.0f; });
    EncodedLight encoded;
    for (int page = 0; page < map.atlas.pages; ++page) {
        const Image<Rgb8> own = pageOf(map.atlas, colors, page);
        encoded.pngs.push_back(opaque ? pngBytes(own)
                                      : pngBytes(own, pageOf(map.atlas, alpha, page)));
    }
    return encoded;
}

LightmapFile lightmapFileOf(const std::string& source, const Atlas& atlas) {
    const auto size = static_cast<float>(atlas.size);
    LightmapFile file;
    file.source = source;
    file.corners = atlas.corners;
    file.page_of = atlas.page_of;
    file.of_file = atlas.of_file;
    file.pngs.resize(static_cast<size_t>(atlas.pages));
    for (size_t i = 0; i < file.corners.size(); ++i) {
        for (vec2& corner : file.corners[i]) {
            corner.y -= size * static_cast<float>(file.page_of[i]);
            corner /= size;
        }
    }
    return file;
}

}  // namespace sheen
