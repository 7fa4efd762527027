// Caustics by photons, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "core/bounces.h"
#include "core/parallel.h"
#include "light/photon_tracer.h"
#include "test_scenes.h"

namespace sheen {
namespace {

std::vector<Photon> traceCaustics(const Tracer& tracer, const SceneLights& lights,
                                  const SeenSpace& seen, int count, int bounces) {
    return tracePhotons(tracer, lights, {.caustics = true, .seen = &seen, .bounces = bounces},
                        count);
}

// Of about 400 alike photons a point, 1.2 / sqrt(400), and what the choice of their number adds.
constexpr double kNoise = 0.08;

// Points of a floor at y = 0, and what photons say arrives there.
struct Floor {
    const Scene& scene;
    std::vector<vec3> points;

    std::vector<vec3> irradiance(int photons, int bounces = kAllBounces) const {
        const Tracer tracer(scene);
        const SceneLights lights(tracer);
        const SeenSpace space(points);
        const PhotonMap map(traceCaustics(tracer, lights, space, photons, bounces), space.reach());
        std::vector<vec3> found;
        for (const vec3& p : points) {
            const SurfaceSide side{.position = p,
                                   .n_g = vec3(0, 1, 0),
                                   .toward_viewer = vec3(0, 1, 0),
                                   .offset = 1e-4f};
            found.push_back(map.at(tracer, side, vec3(0, 1, 0), nullptr).irradiance);
        }
        return found;
    }
};

// Root mean square of errors, and their mean, over the mean of what is expected.
struct Error {
    double rms = 0.0;
    double bias = 0.0;
};
Error errorOf(const std::vector<vec3>& found, const std::vector<vec3>& points,
              const std::function<double(const vec3&)>& expected) {
    double squares = 0.0, difference = 0.0, sum = 0.0;
    for (size_t i = 0; i < points.size(); ++i) {
        const double e = expected(points[i]);
        sum += e;
        difference += found[i].y - e;
        squares += (found[i].y - e) * (found[i].y - e);
    }
    const auto n = static_cast<double>(points.size());
    return {std::sqrt(squares / n) / (sum / n), difference / sum};
}

std::vector<vec3> grid(const vec2& lower, const vec2& upper, int side) {
    std::vector<vec3> points;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const vec2 u = (vec2(i, j) + 0.5f) / static_cast<float>(side);
            const vec2 xz = glm::mix(lower, upper, u);
            points.emplace_back(xz.x, 0.0f, xz.y);
        }
    }
    return points;
}

uint32_t mirrorOf(Scene& scene) { return addMaterial(scene, glossyParams(vec3(1.0f), 1.0f, 0.0f)); }

void addFloor(Scene& scene) {
    addQuad(scene, vec3(-4, 0, -4), vec3(0, 0, 8), vec3(8, 0, 0),
            addMaterial(scene, diffuseParams(vec3(0.5f))));
}

constexpr vec3 kLight(-1.0f, 1.5f, 0.2f);
constexpr float kMirrorTop = 1.2f;

// A floor, a point light, and a mirror that stands on the floor at x = 0 and ends at kMirrorTop.
Scene mirrorOnFloor() {
    Scene scene;
    addFloor(scene);
    addQuad(scene, vec3(0, 0, -3), vec3(0, 0, 6), vec3(0, kMirrorTop, 0), mirrorOf(scene));
    scene.lights.push_back(pointLight(kLight, vec3(10.0f)));
    return scene;
}

// What its mirror image sends, where that is seen in the mirror.
double ofMirrorImage(const vec3& p) {
    const vec3 image(-kLight.x, kLight.y, kLight.z);
    const vec3 way = image - p;
    const double d2 = glm::dot(way, way);
    const float height = p.y + way.y * (-p.x / way.x);
    return height < kMirrorTop ? 10.0 * way.y / (d2 * std::sqrt(d2)) : 0.0;
}

TEST(Caustics, AMirrorShowsThePointLightAgain) {
    const Scene scene = mirrorOnFloor();
    // Not across the edge of what the mirror lights, but as near to the mirror as a wall may stand.
    const Floor floor{scene, grid(vec2(-2.5f, -0.8f), vec2(-0.02f, 0.8f), 24)};
    const Error error = errorOf(floor.irradiance(200'000), floor.points, ofMirrorImage);
    EXPECT_LT(error.rms, kNoise);
    EXPECT_LT(std::abs(error.bias), 0.01);
    // Nothing has two bounces here, and one is one.
    EXPECT_EQ(floor.irradiance(10'000), floor.irradiance(10'000, 1));
}

TEST(Caustics, MorePhotonsMeanLessError) {
    const Scene scene = mirrorOnFloor();
    // The edge lies at x = -4: beyond it is nothing.
    const Floor floor{scene, grid(vec2(-3.9f, -0.8f), vec2(-0.1f, 0.8f), 24)};
    double before = errorOf(floor.irradiance(4'000), floor.points, ofMirrorImage).rms;
    for (const int photons : {32'000, 256'000}) {
        const double after = errorOf(floor.irradiance(photons), floor.points, ofMirrorImage).rms;
        EXPECT_LT(after, 0.7 * before) << photons;
        before = after;
    }
}

// Light that falls straight down on a ball leaves it, where it meets it at an angle of a to its
// top, at an angle of 2 a.
TEST(Caustics, AMirrorBallSpreadsSunlight) {
    constexpr double kRadius = 0.5, kHeight = 1.0;
    Scene scene;
    addFloor(scene);
    addSphere(scene, vec3(0, kHeight, 0), kRadius, 96, mirrorOf(scene));
    scene.lights.push_back(directionalLight(vec3(0, -1, 0), vec3(3.0f)));
    const auto radiusAt = [&](double a) {
        const double down = (kHeight + kRadius * std::cos(a)) / -std::cos(2.0 * a);
        return kRadius * std::sin(a) + down * std::sin(2.0 * a);
    };
    const auto expected = [&](const vec3& p) {
        const double r = glm::length(p);
        double low = 0.25 * kPi + 1e-6, high = 0.5 * kPi;
        for (int step = 0; step < 60; ++step) {
            const double middle = 0.5 * (low + high);
            (radiusAt(middle) > r ? low : high) = middle;
        }
        constexpr double kStep = 1e-5;
        const double slope = (radiusAt(low + kStep) - radiusAt(low - kStep)) / (2.0 * kStep);
        return 3.0 * kRadius * kRadius * std::sin(low) * std::cos(low) / (r * -slope);
    };
    const Floor floor{scene, grid(vec2(0.5f, -0.8f), vec2(2.5f, 0.8f), 24)};
    const Error error = errorOf(floor.irradiance(200'000), floor.points, expected);
    EXPECT_LT(error.rms, kNoise);
    EXPECT_LT(std::abs(error.bias), 0.015);
}

// Between two mirrors there is a row of images.
TEST(Caustics, MirrorsShowMirrors) {
    Scene scene;
    addFloor(scene);
    const uint32_t mirror = mirrorOf(scene);
    addQuad(scene, vec3(0, 0, -4), vec3(0, 0, 8), vec3(0, 6, 0), mirror);
    addQuad(scene, vec3(-2, 0, 4), vec3(0, 0, -8), vec3(0, 6, 0), mirror);
    scene.lights.push_back(pointLight(vec3(-1, 1.5f, 0), vec3(10.0f)));
    const auto expected = [](const vec3& p) {
        double sum = 0.0;
        for (int image = -3; image <= 3; ++image) {
            const vec3 way = vec3(-1.0f + 2.0f * static_cast<float>(image), 1.5f, 0) - p;
            sum += image == 0 ? 0.0 : 10.0 * way.y / std::pow(glm::length(way), 3.0f);
        }
        return sum;
    };
    const Floor floor{scene, grid(vec2(-1.9f, -0.5f), vec2(-0.1f, 0.5f), 16)};
    const Error error = errorOf(floor.irradiance(200'000, 3), floor.points, expected);
    EXPECT_LT(error.rms, 2.0 * kNoise);  // photons of near and far images differ in power
    EXPECT_LT(std::abs(error.bias), 0.025);
}

TEST(Caustics, DoNotDependOnThreads) {
    const Scene scene = mirrorOnFloor();
    const Floor floor{scene, grid(vec2(-2.5f, -0.8f), vec2(-0.1f, 0.8f), 8)};
    const int threads = threadCount();
    setThreadCount(1);
    const std::vector<vec3> alone = floor.irradiance(20'000);
    setThreadCount(4);
    EXPECT_EQ(floor.irradiance(20'000), alone);
    setThreadCount(threads);
}

TEST(Caustics, AreNoneWithoutSpecularSurfacesOrLight) {
    constexpr int kPhotons = 20'000;
    Scene scene = mirrorOnFloor();
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const SeenSpace space(std::vector<vec3>{vec3(-1, 0, 0), vec3(-2, 0, 0)});
    EXPECT_FALSE(traceCaustics(tracer, lights, space, kPhotons, kAllBounces).empty());
    EXPECT_TRUE(traceCaustics(tracer, lights, SeenSpace(std::vector<vec3>()), kPhotons, kAllBounces)
                    .empty());
    EXPECT_TRUE(traceCaustics(tracer, lights, space, kPhotons, 0).empty());
    scene.lights.clear();
    EXPECT_TRUE(traceCaustics(tracer, lights, space, kPhotons, kAllBounces).empty());
    Scene rough = mirrorOnFloor();
    rough.materials.back().params.roughness = 0.5f;
    const Tracer in_rough(rough);
    EXPECT_TRUE(traceCaustics(in_rough, lights, space, kPhotons, kAllBounces).empty());
}

// Whatever the scene's unit.
TEST(Caustics, AreTheSameAtAnyScale) {
    const Scene scene = mirrorOnFloor();
    const Floor floor{scene, grid(vec2(-2.5f, -0.8f), vec2(-0.1f, 0.8f), 8)};
    const std::vector<vec3> expected = floor.irradiance(20'000);
    for (const float scale : {0x1p-10f, 0x1p10f}) {
        const Scene other = scaled(scene, scale);
        Floor moved{other, floor.points};
        for (vec3& p : moved.points) {
            p *= scale;
        }
        const std::vector<vec3> found = moved.irradiance(20'000);
        for (size_t i = 0; i < found.size(); ++i) {
            EXPECT_NEAR(found[i].y, expected[i].y, 0.02 * expected[i].y);
        }
    }
}

// Photons that find next to nothing, or a light a hair off a mirror, end all the same.
TEST(Caustics, EndWhateverPilotsFind) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    addQuad(scene, vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2), white);
    addQuad(scene, vec3(1, 0, 1), vec3(0, 2, 0), vec3(0, 0, -2),
            addMaterial(scene, glossyParams(vec3(0.9f), 1.0f, 0.0f)));
    const std::vector<vec3> points = grid(vec2(-0.9f), vec2(0.9f), 4);
    PunctualLight light{};
    light.kind = shared::LIGHT_SPOT;  // a spot of a few centimetres on the mirror
    light.position = vec3(0, 1, 0);
    light.direction = vec3(1, 0, 0);
    light.intensity = vec3(1.0f);
    light.cos_outer = 0.9998f;
    light.spot_scale = 1.0f / (1.0f - light.cos_outer);
    light.spot_offset = -light.cos_outer * light.spot_scale;
    PunctualLight near = light;
    near.kind = shared::LIGHT_POINT;
    near.position = vec3(1.0f - 1e-4f, 1, 0);
    near.cos_outer = -1.0f;
    near.spot_scale = 0.0f;
    near.spot_offset = 1.0f;
    for (const PunctualLight& l : {light, near}) {
        scene.lights = {l};
        for (const int photons : {1, 8, 1000}) {
            for (const vec3& found : (Floor{scene, points}.irradiance(photons))) {
                EXPECT_TRUE(finite(found));
            }
        }
    }
}

}  // namespace
}  // namespace sheen
