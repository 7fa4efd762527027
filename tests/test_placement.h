// Placement with made-up gathers on a G-buffer made by hand: a floor that recedes to the horizon.
#pragma once

#include <gtest/gtest.h>

#include <cstring>

#include "cache/lobes.h"
#include "cache/pixel_light.h"
#include "cache/placement.h"
#include "cache/served.h"
#include "image/frame.h"
#include "test_scenes.h"

namespace sheen {

constexpr int kWidth = 72, kHeight = 48;

struct Stage {
    Scene scene;
    GBuffer gbuffer;
    PixelClasses classes;
};

/// The floor y = 0 up to a wall at z = -3, the sky above it; `order_left` and `order_right` are the
/// classes of the two halves of the image.
inline Stage makeStage(int order_left, int order_right, float scale = 1.0f) {
    Stage stage;
    addQuad(stage.scene, vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -12),
            addMaterial(stage.scene, diffuseParams(vec3(0.5f))));
    stage.scene = scaled(stage.scene, scale);
    const Camera camera = lookAt(scale * vec3(0, 1, 2), scale * vec3(0, 0.3f, 0));
    GBuffer& g = stage.gbuffer;
    g.width = kWidth;
    g.height = kHeight;
    g.view = cameraView(camera, kWidth, kHeight);
    g.pixel_angle = 2.0f * std::tan(0.5f * camera.y_fov) / kHeight;
    g.position = g.normal = g.diffuse = Image<vec4>(kWidth, kHeight);
    g.f0 = Image<vec3>(kWidth, kHeight);
    g.primitive = Image<uint32_t>(kWidth, kHeight, kNoPrimitive);
    stage.classes.orders = Image<int>(kWidth, kHeight, kNoOrder);
    stage.classes.by_rays = Image<uint8_t>(kWidth, kHeight);
    stage.classes.materials = Image<int>(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const CameraRay ray =
                cameraRay(camera, kWidth, kHeight, static_cast<float>(x), static_cast<float>(y));
            const float t = -ray.origin.y / ray.direction.y;
            const vec3 p = ray.origin + t * ray.direction;
            if (t <= 0.0f || p.z < -3.0f * scale) {
                continue;
            }
            g.position.at(x, y) = vec4(p, glm::dot(g.view.dual_forward, p - ray.origin));
            g.normal.at(x, y) = vec4(0, 1, 0, 1);
            g.primitive.at(x, y) = 0;
            stage.classes.orders.at(x, y) = x < kWidth / 2 ? order_left : order_right;
            ++stage.classes.geometry;
        }
    }
    return stage;
}

/// A gather that says the same of every site but its place: `change` alters it.
using Change = std::function<void(const RecordSite&, GatheredRecord&)>;

inline GatherFunction makeGather(const Change& change) {
    return [change](std::span<const RecordSite> sites) {
        std::vector<GatheredRecord> results;
        for (const RecordSite& site : sites) {
            GatheredRecord g;
            g.record.position = site.position;
            g.record.normal = site.normal;
            g.record.tangent = tangentFrame(site.normal)[0];
            g.record.order = site.order;
            g.record.irradiance = vec3(1.0f, 2.0f, 3.0f);
            g.record.radius = 1.0f;
            if (site.order > 0) {
                g.sh.assign(static_cast<size_t>(shLayout(site.order).size()), 0.5f);
            }
            change(site, g);
            results.push_back(std::move(g));
        }
        return results;
    };
}

inline const Change kNoChange = [](const RecordSite&, GatheredRecord&) {};

inline Placement place(const Stage& stage, const PlacementParams& params,
                       const Change& change = kNoChange, RecordField* field = nullptr) {
    RecordField own;
    return placeRecords(stage.scene, stage.gbuffer, stage.classes,
                        buildLobes(stage.gbuffer, stage.classes), params, makeGather(change), true,
                        field != nullptr ? *field : own);
}

/// What the pixels' weights sum to as records serve, against the limit that placement keeps in
/// fixed point.
inline void expectCovered(const Stage& stage, const PlacementParams& params,
                          const Placement& placement) {
    EXPECT_EQ(placement.uncovered, 0);
    const WeightParams weight = params.servingWeight();
    for (int i = 0; i < kWidth * kHeight; ++i) {
        const auto pixel = static_cast<size_t>(i);
        const vec4 p = stage.gbuffer.position.pixels[pixel];
        double sum = 0.0;
        for (const Record& r : placement.cache.records) {
            if (serves(r.order, stage.classes.orders.pixels[pixel])) {
                sum += shared::recordWeight(weight, r.position, r.normal, r.radius, vec3(p),
                                            vec3(stage.gbuffer.normal.pixels[pixel]),
                                            p.w * stage.gbuffer.pixel_angle);
            }
        }
        if (stage.gbuffer.seen(i)) {
            // Each record's share is rounded to 1/4096.
            ASSERT_GT(sum, shared::MIN_WEIGHT_SUM - 0.005) << "pixel " << i;
        }
    }
}

inline void expectSame(const Placement& a, const Placement& b) {
    ASSERT_EQ(a.cache.records.size(), b.cache.records.size());
    EXPECT_EQ(std::memcmp(a.cache.records.data(), b.cache.records.data(),
                          a.cache.records.size() * sizeof(Record)),
              0);
    EXPECT_EQ(a.cache.sh, b.cache.sh);
}

/// What a record's pixel covers at its distance.
inline float footprintOf(const Stage& stage, const Record& r) {
    const vec3 d = r.position - stage.gbuffer.view.origin;
    return glm::dot(stage.gbuffer.view.dual_forward, d) * stage.gbuffer.pixel_angle;
}

}  // namespace sheen
