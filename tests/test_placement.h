// Placement with made-up gathers for receivers made by hand: a floor that recedes to the horizon.
#pragma once

#include <gtest/gtest.h>

#include <cstring>

#include "cache/fill.h"
#include "image/frame.h"
#include "receivers/receivers.h"
#include "receivers/served.h"
#include "test_scenes.h"

namespace sheen {

constexpr int kWidth = 72, kHeight = 48;

struct Stage {
    Scene scene;
    Receivers receivers;
};

/// The floor y = 0 up to a wall at z = -3, the sky above it; `order_left` and `order_right` are the
/// classes of the two halves of the image.
inline Stage makeStage(int order_left, int order_right, float scale = 1.0f) {
    Stage stage;
    addQuad(stage.scene, vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -12),
            addMaterial(stage.scene, diffuseParams(vec3(0.5f))));
    stage.scene = scaled(stage.scene, scale);
    const Camera camera = lookAt(scale * vec3(0, 1, 2), scale * vec3(0, 0.3f, 0));
    Receivers& r = stage.receivers;
    r.image = pixelGrid(camera, kWidth, kHeight);
    r.positions = r.normals = r.diffuse = r.f0 = std::vector<vec3>(kWidth * kHeight);
    r.footprints = r.f90 = r.roughness = std::vector<float>(kWidth * kHeight);
    r.triangles.resize(kWidth * kHeight, kNoPrimitive);
    r.orders.resize(kWidth * kHeight, kNoOrder);
    r.by_rays.resize(kWidth * kHeight);
    r.materials.resize(kWidth * kHeight);
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const CameraRay ray =
                cameraRay(camera, kWidth, kHeight, static_cast<float>(x), static_cast<float>(y));
            const float t = -ray.origin.y / ray.direction.y;
            const vec3 p = ray.origin + t * ray.direction;
            if (t <= 0.0f || p.z < -3.0f * scale) {
                continue;
            }
            const size_t i = r.image.index(x, y);
            r.positions[i] = p;
            r.footprints[i] = r.image.depthOf(p) * r.image.pixel_angle;
            r.normals[i] = vec3(0, 1, 0);
            r.roughness[i] = 1.0f;
            r.triangles[i] = 0;
            r.orders[i] = static_cast<int8_t>(x < kWidth / 2 ? order_left : order_right);
            ++r.counts.seen;
        }
    }
    return stage;
}

/// A gather that says the same of every site but its place: `change` alters it.
using Change = std::function<void(const RecordSite&, GatheredRecord&)>;

class MadeUpGatherer : public Gatherer {
  public:
    explicit MadeUpGatherer(const Change& change) : change_(change) {}

    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) override {
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
            change_(site, g);
            results.push_back(std::move(g));
        }
        return results;
    }

  private:
    const Change change_;
};

inline const Change kNoChange = [](const RecordSite&, GatheredRecord&) {};

inline Placement place(const Stage& stage, const PlacementParams& params,
                       const Change& change = kNoChange, RecordField* field = nullptr) {
    RecordField own;
    Receivers receivers = stage.receivers;
    receivers.lobes = buildLobes(receivers);
    MadeUpGatherer gatherer(change);
    return placeRecords(stage.scene, receivers, params, gatherer, field != nullptr ? *field : own,
                        true);
}

/// What the pixels' weights sum to as records serve, against the limit that placement keeps in
/// fixed point.
inline void expectCovered(const Stage& stage, const PlacementParams& params,
                          const Placement& placement) {
    EXPECT_EQ(placement.uncovered, 0);
    const WeightParams weight = params.servingWeight();
    for (size_t i = 0; i < kWidth * kHeight; ++i) {
        double sum = 0.0;
        for (const Record& r : placement.cache.records) {
            if (serves(r.order, stage.receivers.orders[i])) {
                sum += weightAt(stage.receivers, i, r, weight);
            }
        }
        if (stage.receivers.seen(i)) {
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
    return stage.receivers.image.depthOf(r.position) * stage.receivers.image.pixel_angle;
}

}  // namespace sheen
