// Rendering small scenes in tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "metrics/compare.h"
#include "render/render.h"
#include "test_scenes.h"

namespace sheen {

constexpr GatherRoad kRoads[] = {GatherRoad::kRays, GatherRoad::kRaster};

/// Root mean square of the difference of two images' luminance over the mean of the second's.
inline double relativeRms(const Image<vec3>& a, const Image<vec3>& b) {
    EXPECT_EQ(a.pixels.size(), b.pixels.size());
    double squares = 0.0, sum = 0.0;
    for (size_t i = 0; i < std::min(a.pixels.size(), b.pixels.size()); ++i) {
        const double d = luminance(a.pixels[i]) - luminance(b.pixels[i]);
        squares += d * d;
        sum += luminance(b.pixels[i]);
    }
    const auto n = static_cast<double>(b.pixels.size());
    return std::sqrt(squares / n) / (sum / n);
}

/// In messages of failed tests.
inline const char* nameOf(GatherRoad road) {
    return road == GatherRoad::kRays ? "by rays" : "by raster";
}

inline RenderParams smallRender(int width, int height, Method method = Method::kRadiance,
                                GatherRoad road = GatherRoad::kRays) {
    RenderParams params;
    params.method = method;
    params.gather_road = road;
    params.width = width;
    params.height = height;
    params.bounces = 1;
    params.caustics = 0;  // as the reference has them unless told otherwise
    params.gather.size = 32;
    params.all_layers = true;
    params.quiet = true;
    return params;
}

/// A closed room with a box in it whose every surface emits `emission` and has `material`.
inline Scene glowingRoom(MaterialParams material, const vec3& emission) {
    Scene scene;
    material.emission = emission;
    const uint32_t m = addMaterial(scene, material);
    addBox(scene, vec3(-1), vec3(1), m, true);
    addBox(scene, vec3(-0.6f, -1.0f, -0.5f), vec3(0.0f, -0.4f, 0.1f), m, false);
    scene.cameras.push_back(lookAt(vec3(0.1f, 0.1f, 0.95f), vec3(0.0f, -0.5f, -0.3f)));
    return scene;
}

/// A scene in which the same light `radiance` arrives from everywhere and each surface has
/// `material`: a box under a sky or, where records rasterise and know none, in a glowing room.
inline Scene furnace(const MaterialParams& material, const vec3& radiance, GatherRoad road) {
    if (road == GatherRoad::kRaster) {
        return glowingRoom(material, radiance);
    }
    Scene scene;
    addBox(scene, vec3(-0.6f, -1.0f, -0.5f), vec3(0.3f, -0.4f, 0.1f), addMaterial(scene, material),
           false);
    scene.environment.texels = Image<vec3>(1, 1, radiance);
    scene.cameras.push_back(lookAt(vec3(0.1f, 0.1f, 0.95f), vec3(-0.1f, -0.7f, -0.2f)));
    return scene;
}

/// Of a layer, by the reference's and its variance.
inline Comparison errorOf(const Frame& test, const Frame& reference, Image<vec3> Frame::*layer,
                          Image<vec3> Frame::*variance) {
    return compareImages({.test = test.*layer,
                          .reference = reference.*layer,
                          .reference_variance = &(reference.*variance),
                          .test_primitive = &test.primitive,
                          .reference_primitive = &reference.primitive});
}

}  // namespace sheen
