// Blended surfaces: what is seen through them, what light passes them, and that all passes agree.
#include <gtest/gtest.h>

#include "light/light_cells.h"
#include "metrics/compare.h"
#include "test_light.h"
#include "test_reference.h"
#include "test_render.h"

namespace sheen {
namespace {

constexpr int kSize = 16;

uint32_t addVeil(Scene& scene, const vec3& albedo, float alpha) {
    const uint32_t material = addMaterial(scene, diffuseParams(albedo));
    scene.materials[material].blended = true;
    scene.materials[material].alpha = alpha;
    return material;
}

// A floor under two panes of alpha 0.1 and 0.4, seen from above; a sun straight down.
struct Panes {
    static constexpr float kFloor = 0.5f, kUpper = 0.8f, kLower = 0.2f;
    static constexpr float kSun = 2.0f;
    Scene scene;

    Panes() {
        const uint32_t floor = addMaterial(scene, diffuseParams(vec3(kFloor)));
        const uint32_t upper = addVeil(scene, vec3(kUpper), 0.1f);
        const uint32_t lower = addVeil(scene, vec3(kLower), 0.4f);
        addQuad(scene, vec3(-4, 0, -4), vec3(0, 0, 8), vec3(8, 0, 0), floor);
        addQuad(scene, vec3(-4, 2, -4), vec3(0, 0, 8), vec3(8, 0, 0), upper);
        addQuad(scene, vec3(-4, 1, -4), vec3(0, 0, 8), vec3(8, 0, 0), lower);
        scene.lights.push_back(directionalLight(vec3(0, -1, 0), vec3(kSun)));
        scene.cameras.push_back(lookAt(vec3(0.1f, 4.0f, 0.2f), vec3(0.0f, 0.0f, 0.0f)));
    }
};

// Light that is scattered once, of each in turn: what arrives there, and what of that comes back.
constexpr float kExpected =
    Panes::kSun / kPi *
    (0.1f * Panes::kUpper + 0.9f * 0.9f * (0.4f * Panes::kLower + 0.6f * 0.6f * Panes::kFloor));

TEST(Veils, SunPassesThemOnItsWayDownAndUp) {
    const Scene scene = Panes().scene;
    const Frame by_records = renderFrame(scene, smallRender(8, 8)).frame;
    const Frame by_paths = renderReference(scene, smallParams(scene, 8, 4)).frame;
    for (const Frame* frame : {&by_records, &by_paths}) {
        for (const vec3& direct : frame->direct.pixels) {
            EXPECT_NEAR(direct.y, kExpected, 1e-4f);
        }
        EXPECT_LT(frame->position.at(4, 4).y, 0.01f) << "what lies behind all of them is seen";
    }
}

// A frame beside a pane, before nothing: what they stop covers the image, however they meet in a
// pixel; and of several panes the nearest is shown.
TEST(Veils, CoverWhatTheyStopBeforeNothing) {
    constexpr float kAlpha = 0.3f;
    Scene scene;
    const uint32_t frame = addMaterial(scene, diffuseParams(vec3(0.5f)));
    const uint32_t pane = addVeil(scene, vec3(0.5f), kAlpha);
    const uint32_t behind = addVeil(scene, vec3(0.5f), kAlpha);
    addQuad(scene, vec3(-9, -9, 0), vec3(9.03f, 0, 0), vec3(0, 18, 0), frame);
    addQuad(scene, vec3(0.03f, -9, 0), vec3(9, 0, 0), vec3(0, 18, 0), pane);
    addQuad(scene, vec3(0.03f, -9, -1), vec3(9, 0, 0), vec3(0, 18, 0), behind);
    scene.lights.push_back(directionalLight(vec3(0, 0, -1), vec3(1.0f)));
    scene.cameras.push_back(lookAt(vec3(0, 0, 4), vec3(0.0f)));
    const float panes = 1.0f - (1.0f - kAlpha) * (1.0f - kAlpha);
    for (const int aa : {1, 16}) {
        RenderParams params = smallRender(8, 8);
        params.aa = aa;
        ReferenceParams by_paths = smallParams(scene, 8, 64);
        by_paths.pixel_area = aa > 1;
        for (const Frame& f :
             {renderFrame(scene, params).frame, renderReference(scene, by_paths).frame}) {
            const Image<float> covered = alpha(f);
            EXPECT_NEAR(covered.at(1, 4), 1.0f, 1e-6f) << "aa " << aa;
            EXPECT_NEAR(covered.at(6, 4), panes, 1e-5f) << "aa " << aa;
            EXPECT_GE(covered.at(4, 4), panes - 1e-5f) << "aa " << aa;
            EXPECT_EQ(f.primitive.at(6, 4) / 2, 1u) << "the nearest pane is shown, aa " << aa;
        }
    }
}

TEST(Veils, StopTheirShareOfRaysAndLight) {
    const Scene scene = Panes().scene;
    const Tracer tracer(scene);
    const Way down{.start = vec3(0.3f, 3, 0.4f), .direction = vec3(0, -1, 0), .length = 2.5f};
    Way to_floor = down;
    to_floor.length = 3.5f;
    const Way ways[] = {down, to_floor, {}};
    const Tracer::Shares shares = tracer.passing(ways);
    EXPECT_NEAR(shares[0].y, 0.9f * 0.6f, 1e-6f);
    EXPECT_EQ(shares[1], vec3(0.0f));
    EXPECT_EQ(shares[2], vec3(0.0f)) << "not asked";

    const Sight sight = tracer.seeAlone(down.start, down.direction);
    ASSERT_EQ(sight.veil_count, 2);
    EXPECT_NEAR(sight.veils[1].share.y, 0.9f * 0.4f, 1e-6f);
    EXPECT_NEAR(sight.ground.share.y, 0.9f * 0.6f, 1e-6f);
    EXPECT_NEAR(sight.ground.hit.distance, 3.0f, 1e-5f);

    constexpr int kRays = 20000;
    Random random(3);
    std::vector<vec3> directions;
    for (int i = 0; i < kRays; ++i) {
        directions.push_back(glm::normalize(vec3(0, -4, 0) + random.direction()));
    }
    std::vector<Hit> hits(kRays);
    tracer.meet({.origin = down.start, .directions = directions}, hits.data());
    int counts[3] = {};
    for (const Hit& hit : hits) {
        ++counts[scene.materials_of[hit.triangle]];
    }
    EXPECT_NEAR(counts[1], 0.1 * kRays, 5 * std::sqrt(0.09 * kRays));
    EXPECT_NEAR(counts[2], 0.36 * kRays, 5 * std::sqrt(0.23 * kRays));
}

TEST(Veils, LightCellsBehindThemAreNeitherLitNorHidden) {
    const Scene scene = Panes().scene;
    const LitScene exact(scene);
    const LitByCells by_cells(scene);
    const vec3 direction(0, -1, 0);
    const float solid_angle = 1e-2f;
    const Rays down{.origin = vec3(0.3f, 0.5f, 0.4f),
                    .directions = {&direction, 1},
                    .solid_angles = {&solid_angle, 1}};
    vec4 seen[2];
    exact.light.cast(down, &seen[0]);
    by_cells.light.cast(down, &seen[1]);
    EXPECT_NEAR(seen[0].x, 0.9f * 0.6f * Panes::kFloor * Panes::kSun / kPi, 1e-5f);
    EXPECT_NEAR(seen[1].x, seen[0].x, 1e-5f);
}

// A room lit by a lamp or by a point light, a pane before the camera and one under the lights.
Scene veiledRoom(bool by_lamp) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    const uint32_t red = addMaterial(scene, diffuseParams(vec3(0.7f, 0.1f, 0.1f)));
    const uint32_t glass = addVeil(scene, vec3(0.1f, 0.6f, 0.2f), 0.3f);
    const uint32_t cloth = addVeil(scene, vec3(0.5f, 0.5f, 0.7f), 0.6f);
    addBox(scene, vec3(-1), vec3(1), {red, white, white, white, white, white}, true);
    addQuad(scene, vec3(-0.6f, -0.8f, 0.2f), vec3(0.9f, 0, 0.2f), vec3(0, 1.2f, 0), glass);
    addQuad(scene, vec3(-0.8f, 0.3f, -0.8f), vec3(0, 0, 1.0f), vec3(1.1f, 0, 0), cloth);
    if (by_lamp) {
        addQuad(scene, vec3(-0.3f, 0.98f, -0.3f), vec3(0.6f, 0, 0), vec3(0, 0, 0.6f),
                addMaterial(scene, diffuseParams(vec3(0.0f), vec3(4.0f))));
    } else {
        scene.lights.push_back(pointLight(vec3(0.5f, 0.7f, 0.2f), vec3(0.5f)));
    }
    scene.cameras.push_back(lookAt(vec3(0.4f, 0.1f, 0.95f), vec3(-0.1f, -0.2f, -0.5f)));
    return scene;
}

struct Errors {
    Comparison direct, indirect;
    double estimate;
};

Errors againstReference(const Scene& scene, int spp) {
    const ReferenceResult truth = renderReference(scene, smallParams(scene, kSize, spp));
    const RenderResult result = renderFrame(scene, smallRender(kSize, kSize));
    return {
        .direct = errorOf(result.frame, truth.frame, &Frame::direct, &Frame::direct_variance),
        .indirect = errorOf(result.frame, truth.frame, &Frame::indirect, &Frame::indirect_variance),
        .estimate = result.stats.estimated_rel_rmse};
}

TEST(Veils, AreLitAndShowWhatIsBehindAsByTheReference) {
    const Errors errors = againstReference(veiledRoom(false), 512);
    EXPECT_LT(errors.direct.rel_rmse, 0.005);
    EXPECT_LT(errors.indirect.rel_rmse, 0.03);
    EXPECT_LT(std::abs(errors.indirect.bias), 0.01);
    EXPECT_GT(errors.estimate, 0.2 * errors.indirect.rel_rmse);
    EXPECT_LT(errors.estimate, 0.1);
}

TEST(Veils, LetTheLightOfLampsPass) {
    const Errors errors = againstReference(veiledRoom(true), 64);
    EXPECT_LT(errors.direct.rel_rmse, 0.03);
    EXPECT_LT(std::abs(errors.direct.bias), 0.01);
}

TEST(Veils, InFrontOfNothingCoverTheirPixels) {
    Scene scene;
    addQuad(scene, vec3(-1, -1.1f, 0.25f), vec3(2, 0, 0), vec3(0, 2, 0),
            addVeil(scene, vec3(0.5f), 0.5f));
    scene.lights.push_back(directionalLight(vec3(0, 0, -1), vec3(kPi)));
    scene.cameras.push_back(lookAt(vec3(0, 0, 4), vec3(0)));
    const Frame frame = renderFrame(scene, smallRender(9, 9)).frame;
    const Frame truth = renderReference(scene, smallParams(scene, 9, 4)).frame;
    for (const Frame* seen : {&frame, &truth}) {
        EXPECT_NE(seen->primitive.at(4, 4), kNoPrimitive);
        EXPECT_EQ(seen->primitive.at(0, 0), kNoPrimitive);
        EXPECT_NEAR(seen->direct.at(4, 4).x, 0.25f, 1e-5f);
    }
}

}  // namespace
}  // namespace sheen
