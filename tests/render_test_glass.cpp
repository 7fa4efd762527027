// Glass: what passes it, in which colour, and that all passes and the reference agree.
#include <gtest/gtest.h>

#include "metrics/compare.h"
#include "test_glass.h"
#include "test_light.h"
#include "test_reference.h"
#include "test_render.h"

namespace sheen {
namespace {

constexpr int kSize = 16;
// Of the table of lobes' albedos.
constexpr float kTableError = 0.01f;

// A white floor under two panes of coloured glass; a sun straight down.
struct StainedPanes {
    static constexpr float kSun = 2.0f;
    vec3 upper{0.9f, 0.5f, 0.2f}, lower{0.4f, 1.0f, 0.5f};
    Scene scene;

    StainedPanes() {
        const uint32_t floor = addMaterial(scene, diffuseParams(vec3(0.5f)));
        addQuad(scene, vec3(-4, 0, -4), vec3(0, 0, 8), vec3(8, 0, 0), floor);
        addQuad(scene, vec3(-4, 2, -4), vec3(0, 0, 8), vec3(8, 0, 0), addGlass(scene, upper));
        addQuad(scene, vec3(-4, 1, -4), vec3(0, 0, 8), vec3(8, 0, 0), addGlass(scene, lower));
        scene.lights.push_back(directionalLight(vec3(0, -1, 0), vec3(kSun)));
        scene.cameras.push_back(lookAt(vec3(0.1f, 4.0f, 0.2f), vec3(0.0f, 0.0f, 0.0f)));
    }
    vec3 passBoth() const { return 0.96f * 0.96f * upper * lower; }
};

// What passes at each angle is what Fresnel's reflection leaves: of white glass, all of that.
TEST(Glass, PassesWhatItDoesNotReflectAtEachAngle) {
    Scene scene;
    const vec3 color(1.0f, 0.5f, 0.25f);
    addQuad(scene, vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), addGlass(scene, color));
    for (const float cosine : {1.0f, 0.7f, 0.4f, 0.2f}) {
        const float reflected = glm::mix(0.04f, 1.0f, shared::schlickWeight(cosine));
        for (const float side : {-1.0f, 1.0f}) {
            const vec3 along(std::sqrt(1.0f - cosine * cosine), 0.0f, side * cosine);
            const Crossing crossing = crossingAt(scene, 0, vec3(0.5f, 0.25f, 0.25f), along);
            EXPECT_LT(maxAbs(crossing.passes - (1.0f - reflected) * color), kTableError)
                << "cosine " << cosine;
            EXPECT_NEAR(crossing.chance, reflected, kTableError);
            EXPECT_EQ(crossing.meets, 1.0f);
        }
    }
}

TEST(Glass, ColoursTheSunOnItsWayDownAndUp) {
    const StainedPanes panes;
    const vec3 once = panes.passBoth();
    const vec3 expected = once * once * (0.5f / kPi * StainedPanes::kSun);
    const Frame by_records = renderFrame(panes.scene, smallRender(9, 9)).frame;
    const Frame by_paths = renderReference(panes.scene, smallParams(panes.scene, 9, 4)).frame;
    for (const Frame* frame : {&by_records, &by_paths}) {
        // In a corner: in the middle the panes mirror the sun.
        EXPECT_LT(maxAbs(frame->direct.at(0, 0) - expected), 4.0f * kTableError * maxAbs(expected));
    }
}

// Rays meet glass by chance: on average what they find counts as if each met and passed it.
TEST(Glass, WeighsRaysThatMeetItOrPass) {
    const StainedPanes panes;
    const Tracer tracer(panes.scene);
    constexpr int kRays = 20000;
    Random random(3);
    std::vector<vec3> directions;
    for (int i = 0; i < kRays; ++i) {
        directions.push_back(glm::normalize(vec3(0, -8, 0) + random.direction()));
    }
    std::vector<Hit> hits(kRays);
    const vec3 eye(0.3f, 3, 0.4f);
    tracer.meet({.origin = eye, .directions = directions}, hits.data());
    vec3 floor(0.0f);
    float upper = 0.0f;
    for (const Hit& hit : hits) {
        const uint32_t material = panes.scene.materials_of[hit.triangle];
        floor += material == 0 ? hit.weight / float{kRays} : vec3(0.0f);
        upper += material == 1 ? hit.weight.y / float{kRays} : 0.0f;
    }
    EXPECT_LT(maxAbs(floor - panes.passBoth()), 0.01f);
    EXPECT_NEAR(upper, 1.0f, 5.0f / std::sqrt(0.13f * kRays)) << "it is met by a chance of 0.136";
    const Way ways[] = {{.start = eye, .direction = vec3(0, -1, 0), .length = 2.9f}};
    EXPECT_LT(maxAbs(tracer.passing(ways)[0] - panes.passBoth()), kTableError);
}

// A room with a pane of glass before the camera, one under the light, and a block that absorbs.
Scene glazedRoom(bool by_lamp) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    const uint32_t red = addMaterial(scene, diffuseParams(vec3(0.7f, 0.1f, 0.1f)));
    const uint32_t green = addGlass(scene, vec3(0.3f, 0.9f, 0.4f));
    const uint32_t blue = addGlass(scene, vec3(0.3f, 0.4f, 0.9f), 0.5f);
    addBox(scene, vec3(-1), vec3(1), {red, white, white, white, white, white}, true);
    addQuad(scene, vec3(-0.6f, -0.8f, 0.2f), vec3(0.9f, 0, 0.2f), vec3(0, 1.2f, 0), green);
    addQuad(scene, vec3(-0.8f, 0.3f, -0.8f), vec3(0, 0, 1.0f), vec3(1.1f, 0, 0), blue);
    const uint32_t amber = addGlass(scene, vec3(0.95f));
    scene.materials[amber].absorption = vec3(0.2f, 1.0f, 3.0f);
    addBox(scene, vec3(-0.2f, -1.0f, -0.5f), vec3(0.4f, -0.5f, 0.1f), amber, false);
    if (by_lamp) {
        addQuad(scene, vec3(-0.3f, 0.98f, -0.3f), vec3(0.6f, 0, 0), vec3(0, 0, 0.6f),
                addMaterial(scene, diffuseParams(vec3(0.0f), vec3(4.0f))));
    } else {
        scene.lights.push_back(pointLight(vec3(0.5f, 0.7f, 0.2f), vec3(0.5f)));
    }
    scene.cameras.push_back(lookAt(vec3(0.4f, 0.1f, 0.95f), vec3(-0.1f, -0.2f, -0.5f)));
    return scene;
}

// But for caustics, which are a layer of their own in either: the highlight of a light in glass is
// in few of a record's rays, and in hardly any path.
TEST(Glass, IsLitAndShowsWhatIsBehindAsByTheReference) {
    for (const bool by_lamp : {false, true}) {
        const Scene scene = glazedRoom(by_lamp);
        ReferenceParams paths = smallParams(scene, kSize, 512);
        paths.caustics_apart = true;
        const ReferenceResult truth = renderReference(scene, paths);
        RenderParams params = smallRender(kSize, kSize);
        params.caustics = 50'000;
        const Frame frame = renderFrame(scene, params).frame;
        const Comparison direct =
            errorOf(frame, truth.frame, &Frame::direct, &Frame::direct_variance);
        const Comparison indirect =
            errorOf(frame, truth.frame, &Frame::indirect, &Frame::indirect_variance);
        EXPECT_LT(direct.rel_rmse, by_lamp ? 0.03 : 0.005);
        EXPECT_LT(std::abs(direct.bias), 0.01);
        // Images of lamps in smooth glass keep grain, and so do paths.
        EXPECT_LT(indirect.rel_rmse, by_lamp ? 0.1 : 0.02);
        EXPECT_LT(std::abs(indirect.bias), by_lamp ? 0.02 : 0.005);
    }
}

// A slab of glass that absorbs, of that thickness, over a white floor under a sun straight down.
Scene slab(float thickness, const vec3& absorption, bool single_sided) {
    Scene scene;
    const uint32_t floor = addMaterial(scene, diffuseParams(vec3(0.5f)));
    const uint32_t glass = addGlass(scene, vec3(1.0f));
    scene.materials[glass].absorption = absorption;
    scene.materials[glass].single_sided = single_sided;
    addQuad(scene, vec3(-4, 0, -4), vec3(0, 0, 8), vec3(8, 0, 0), floor);
    addBox(scene, vec3(-3, 1, -3), vec3(3, 1 + thickness, 3), glass, false);
    scene.lights.push_back(directionalLight(vec3(0, -1, 0), vec3(2.0f)));
    scene.cameras.push_back(lookAt(vec3(0.1f, 6.0f, 0.2f), vec3(0.0f, 0.0f, 0.0f)));
    return scene;
}

// Beer's law, on the sun's way down and the camera's: of single-sided bodies too, whose backs
// cameras do not see.
TEST(Glass, AbsorbsOverTheWayThroughIt) {
    constexpr float kHighlight = 3e-5f;  // of the sun in the glass, far from its middle
    const vec3 absorption(0.1f, 0.8f, 2.0f);
    for (const bool single_sided : {false, true}) {
        for (const float thickness : {0.5f, 1.5f}) {
            const Scene scene = slab(thickness, absorption, single_sided);
            const float surfaces = std::pow(0.96f, single_sided ? 3.0f : 4.0f);
            const vec3 eye(scene.cameras.front().world_from_camera[3]);
            for (const Frame& frame : {renderFrame(scene, smallRender(9, 9)).frame,
                                       renderReference(scene, smallParams(scene, 9, 4)).frame}) {
                const float cosine = glm::normalize(eye - frame.position.at(2, 2)).y;
                const float way = thickness * (1.0f + 1.0f / cosine);
                const vec3 expected = 0.5f / kPi * 2.0f * surfaces * glm::exp(-way * absorption);
                for (int c = 0; c < 3; ++c) {
                    EXPECT_NEAR(frame.direct.at(2, 2)[c], expected[c],
                                0.01f * expected[c] + kHighlight)
                        << "thickness " << thickness;
                }
            }
        }
    }
}

// Rays that begin or end in a body have no more of it on their way than they travel.
TEST(Glass, AbsorbsWhatBeginsOrEndsInIt) {
    const vec3 absorption(0.5f, 1.0f, 2.0f);
    const Scene scene = slab(1.0f, absorption, false);
    const Tracer tracer(scene);
    const RayScene rays(scene);
    const auto expect = [&](const vec3& from, const vec3& direction, float length, float inside) {
        const float surfaces = inside == 1.0f ? 0.96f * 0.96f : 0.96f;
        const vec3 expected = surfaces * glm::exp(-inside * absorption);
        const Way way{.start = from, .direction = direction, .length = length};
        EXPECT_LT(maxAbs(tracer.passing({&way, 1})[0] - expected), kTableError);
        EXPECT_LT(maxAbs(rays.passing({from, direction, length}) - expected), kTableError);
    };
    const vec3 down(0, -1, 0);
    expect(vec3(0.3f, 3.0f, 0.2f), down, 2.5f, 1.0f);
    expect(vec3(0.3f, 3.0f, 0.2f), down, 1.25f, 0.25f);
    expect(vec3(0.3f, 1.75f, 0.2f), down, 1.5f, 0.75f);
    expect(vec3(0.3f, 1.75f, 0.2f), -down, kInfinity, 0.25f);
}

// A path that sees all of a pixel starts on one of its surfaces by chance.
TEST(Glass, IsTheSameOfAPixelsAreaAsOfItsMiddle) {
    const StainedPanes panes;
    ReferenceParams params = smallParams(panes.scene, 3, 4096);
    const ReferenceResult middle = renderReference(panes.scene, params);
    params.pixel_area = true;
    const ReferenceResult area = renderReference(panes.scene, params);
    const size_t corner = 0;
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(area.frame.direct.pixels[corner][c], middle.frame.direct.pixels[corner][c],
                    7.0f * std::sqrt(area.frame.direct_variance.pixels[corner][c]) +
                        0.01f * middle.frame.direct.pixels[corner][c]);
    }
}

}  // namespace
}  // namespace sheen
