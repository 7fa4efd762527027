// Texel footprints and walls of every way to see the hemisphere, against closed forms.
#include "hemisphere/hemisphere.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <stdexcept>

#include "test_scenes.h"

namespace sheen {
namespace {

constexpr double kSumError = 1e-4;  // design, section 3
// Walls are integrated in few pieces, footprints in 2 x 2; relative to the texel's solid angle.
constexpr double kWallError = 0.03;

double sum(const std::vector<float>& values) {
    double total = 0.0;
    for (float v : values) {
        total += v;
    }
    return total;
}

std::vector<HemisphereParams> variants() {
    std::vector<HemisphereParams> all;
    for (int size : {2, 3, 8, 17, 32, 64, 128}) {
        for (HemisphereKind kind :
             {HemisphereKind::kBorder, HemisphereKind::kPlane, HemisphereKind::kLarsen}) {
            for (float extent : {1.0f, 2.0f, 3.0f, 5.0f}) {
                all.push_back({.kind = kind, .size = size, .extent = extent});
            }
        }
        all.push_back({.kind = HemisphereKind::kHemicube, .size = size});
    }
    return all;
}

std::string name(const HemisphereParams& p) {
    return "kind " + std::to_string(static_cast<int>(p.kind)) + " size " + std::to_string(p.size) +
           " extent " + std::to_string(p.extent);
}

TEST(Hemisphere, SolidAnglesAndCosinesSumToTheirClosedForms) {
    for (const HemisphereParams& params : variants()) {
        SCOPED_TRACE(name(params));
        const Hemisphere h = makeHemisphere(params);
        const float e = params.extent;
        switch (params.kind) {
            case HemisphereKind::kBorder:
            case HemisphereKind::kHemicube:
                EXPECT_NEAR(sum(h.solid_angles), 2.0 * M_PI, 2.0 * M_PI * kSumError);
                EXPECT_NEAR(sum(h.cosines), M_PI, M_PI * kSumError);
                break;
            case HemisphereKind::kPlane:
                EXPECT_NEAR(sum(h.solid_angles), shared::planeSolidAngle(-e, -e, e, e), 1e-3);
                EXPECT_NEAR(sum(h.cosines), shared::planeCosine(-e, -e, e, e), 1e-3);
                EXPECT_LT(sum(h.cosines), M_PI);
                break;
            case HemisphereKind::kLarsen:
                EXPECT_NEAR(sum(h.cosines), M_PI, M_PI * kSumError);
                EXPECT_NEAR(sum(h.solid_angles),
                            M_PI * shared::planeSolidAngle(-e, -e, e, e) /
                                shared::planeCosine(-e, -e, e, e),
                            1e-3);
                EXPECT_LT(sum(h.solid_angles), 2.0 * M_PI);
                break;
        }
        double x = 0.0, y = 0.0;
        for (const vec2& m : h.moments) {
            x += m.x;
            y += m.y;
        }
        EXPECT_NEAR(x, 0.0, kSumError);
        EXPECT_NEAR(y, 0.0, kSumError);
        for (size_t t = 0; t < h.solid_angles.size(); ++t) {
            ASSERT_GT(h.solid_angles[t], 0.0f) << t;
            ASSERT_GE(h.cosines[t], 0.0f) << t;
            ASSERT_NEAR(glm::length(h.directions[t]), 1.0f, 1e-5f);
            ASSERT_GT(h.directions[t].z, 0.0f);
        }
    }
}

TEST(Hemisphere, FurnaceIrradianceIsPi) {
    // Constant radiance L from everywhere: irradiance pi L, whatever the resolution.
    for (const HemisphereParams& params : variants()) {
        if (params.kind != HemisphereKind::kPlane) {
            const Hemisphere h = makeHemisphere(params);
            float irradiance = 0.0f;  // summed in single precision, as the gather does
            for (float c : h.cosines) {
                irradiance += c * 3.0f;
            }
            EXPECT_NEAR(irradiance, 3.0 * M_PI, 3.0 * M_PI * kSumError) << name(params);
        }
    }
}

TEST(Hemisphere, ABrightRingAtThePlanesBorderIsNeitherLostNorDoubled) {
    // Light from a ring of directions theta to theta + 12 degrees, moved across the border of a
    // plane of extent 3 (71.6 to 76.7 degrees) and out of it. Border texels stretch what the plane
    // sees last to the horizon, so a ring beside the border counts too much or not at all: by no
    // more than the whole strip's irradiance, pi cos^2(71.6), which is 31% of a ring's there.
    constexpr float kWidth = 12.0f;
    for (HemisphereKind kind : {HemisphereKind::kBorder, HemisphereKind::kHemicube}) {
        const Hemisphere h = makeHemisphere({.kind = kind, .size = 64, .extent = 3.0f});
        const double strip = kind == HemisphereKind::kBorder ? M_PI * 0.1 : 0.0;
        for (float theta : {40.0f, 60.0f, 66.0f, 70.0f, 74.0f, 78.0f}) {
            const float upper = std::cos(glm::radians(theta));
            const float lower = std::cos(glm::radians(theta + kWidth));
            double irradiance = 0.0;
            for (size_t t = 0; t < h.cosines.size(); ++t) {
                const float z = h.directions[t].z;
                irradiance += z <= upper && z > lower ? h.cosines[t] : 0.0f;
            }
            const double expected = M_PI * (upper * upper - lower * lower);
            // A texel of 64 is 1 to 4 degrees wide: both edges of the ring are that uncertain.
            EXPECT_NEAR(irradiance, expected, 0.1 * expected + strip)
                << "kind " << static_cast<int>(kind) << " theta " << theta;
        }
    }
}

TEST(HemisphereClosedForms, EqualNumericIntegrals) {
    Random random(1);
    for (int trial = 0; trial < 20; ++trial) {
        const float x0 = random.uniform(-4.0f, 3.0f), y0 = random.uniform(-4.0f, 3.0f);
        const float x1 = x0 + random.uniform(0.05f, 2.0f), y1 = y0 + random.uniform(0.05f, 2.0f);
        constexpr int kSteps = 200;
        double solid_angle = 0.0, cosine = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            for (int j = 0; j < kSteps; ++j) {
                const double x = x0 + (x1 - x0) * (i + 0.5) / kSteps;
                const double y = y0 + (y1 - y0) * (j + 0.5) / kSteps;
                const double r2 = 1.0 + x * x + y * y;
                const double area = (x1 - x0) * (y1 - y0) / (kSteps * kSteps);
                solid_angle += area / (r2 * std::sqrt(r2));
                cosine += area / (r2 * r2);
            }
        }
        // Differences of four arc tangents of order one.
        EXPECT_NEAR(shared::planeSolidAngle(x0, y0, x1, y1), solid_angle, 1e-5);
        EXPECT_NEAR(shared::planeCosine(x0, y0, x1, y1), cosine, 1e-5);
    }
    // The whole plane is the hemisphere.
    EXPECT_NEAR(shared::planeSolidAngle(-1e4f, -1e4f, 1e4f, 1e4f), 2.0 * M_PI, 1e-3);
    EXPECT_NEAR(shared::planeCosine(-1e4f, -1e4f, 1e4f, 1e4f), M_PI, 1e-3);
}

TEST(HemisphereClosedForms, BorderCosineIsWhereThePlaneEnds) {
    for (float h : {0.5f, 1.0f, 3.0f}) {
        for (int i = 0; i < 360; i += 5) {
            const float phi = glm::radians(static_cast<float>(i));
            const float x = std::cos(phi), y = std::sin(phi);
            const float scale = h / std::max(std::abs(x), std::abs(y));
            const vec3 edge = glm::normalize(vec3(scale * x, scale * y, 1.0f));
            EXPECT_NEAR(shared::borderCosine(phi, h), edge.z, 1e-6f);
        }
    }
}

TEST(Hemisphere, StripAndPlaneTogetherAreTheHemisphere) {
    // The strip's closed forms: integral of top over phi, and of half its square.
    for (float e : {1.0f, 2.0f, 4.0f}) {
        double solid_angle = 0.0, cosine = 0.0;
        constexpr int kSteps = 20000;
        for (int i = 0; i < kSteps; ++i) {
            const double top =
                shared::borderCosine(2.0f * kPi * (static_cast<float>(i) + 0.5f) / kSteps, e);
            solid_angle += top * 2.0 * M_PI / kSteps;
            cosine += 0.5 * top * top * 2.0 * M_PI / kSteps;
        }
        EXPECT_NEAR(solid_angle + shared::planeSolidAngle(-e, -e, e, e), 2.0 * M_PI, 1e-4);
        EXPECT_NEAR(cosine + shared::planeCosine(-e, -e, e, e), M_PI, 1e-4);
    }
}

TEST(Hemisphere, DirectionsLieInsideTheirTexels) {
    for (const HemisphereParams& params : variants()) {
        const Hemisphere h = makeHemisphere(params);
        std::vector<int> owners(static_cast<size_t>(h.texelCount()));
        for (const HemisphereFace& face : h.faces) {
            const mat3 inverse = glm::inverse(mat3(face.right, face.up, face.forward));
            for (int j = 0; j < face.height; ++j) {
                for (int i = 0; i < face.width; ++i) {
                    const auto t = static_cast<size_t>((face.y + j) * h.width + face.x + i);
                    ++owners[t];
                    const vec3 c = inverse * h.directions[t];
                    ASSERT_GT(c.z, 0.0f);
                    const float x = (0.5f * c.x / c.z + 0.5f) * static_cast<float>(face.width);
                    const float y = (0.5f * c.y / c.z + 0.5f) * static_cast<float>(face.height);
                    ASSERT_NEAR(x, static_cast<float>(i) + 0.5f, 1e-2f) << name(params);
                    ASSERT_NEAR(y, static_cast<float>(j) + 0.5f, 1e-2f) << name(params);
                }
            }
        }
        for (int count : owners) {
            ASSERT_EQ(count, 1) << name(params);
        }
    }
}

TEST(Hemisphere, FootprintsAddUpToTheTexel) {
    for (const HemisphereParams& params : variants()) {
        if (params.size > 32 || params.kind == HemisphereKind::kLarsen) {
            continue;
        }
        const Hemisphere h = makeHemisphere(params);
        for (int t = 0; t < h.texelCount(); ++t) {
            double solid_angle = 0.0;
            for (const FootprintSample& s : footprint(h, t)) {
                ASSERT_NEAR(glm::length(s.direction), 1.0f, 1e-5f);
                ASSERT_GE(s.direction.z, 0.0f);
                solid_angle += s.solid_angle;
            }
            ASSERT_NEAR(solid_angle, h.solid_angles[static_cast<size_t>(t)], 1e-5) << name(params);
        }
    }
}

TEST(Hemisphere, HorizonIsDividedAmongItsTexels) {
    for (const HemisphereParams& params : variants()) {
        const Hemisphere h = makeHemisphere(params);
        double total = 0.0;
        int count = 0;
        for (size_t t = 0; t < h.at_horizon.size(); ++t) {
            if (h.at_horizon[t] == 0) {
                continue;
            }
            ++count;
            const vec2 az = h.azimuths[t];
            ASSERT_LT(az.x, az.y);
            total += az.y - az.x;
            // The texel's own azimuth lies in its share.
            float own = std::atan2(h.directions[t].y, h.directions[t].x) - az.x;
            own -= 2.0f * kPi * std::floor(own / (2.0f * kPi));
            ASSERT_LE(own, az.y - az.x + 1e-5f) << name(params);
        }
        const bool reaches =
            params.kind == HemisphereKind::kBorder || params.kind == HemisphereKind::kHemicube;
        EXPECT_NEAR(total, reaches ? 2.0 * M_PI : 0.0, 1e-4) << name(params);
        if (params.kind == HemisphereKind::kBorder) {
            EXPECT_EQ(count, params.size == 2 ? 4 : 4 * (params.size - 1)) << name(params);
        }
    }
}

TEST(HemisphereWalls, EveryInnerEdgeIsOneWall) {
    for (int size = 2; size <= 130; ++size) {
        for (float extent : {1.0f, 3.0f}) {
            const Hemisphere h =
                makeHemisphere({.kind = HemisphereKind::kBorder, .size = size, .extent = extent});
            EXPECT_EQ(h.walls.size(), static_cast<size_t>(2 * size * (size - 1)))
                << "size " << size;
        }
        const Hemisphere h = makeHemisphere({.kind = HemisphereKind::kHemicube, .size = size});
        const int s = h.params.size;  // even
        EXPECT_EQ(s, size + size % 2);
        const int half = s / 2;
        const int top = 2 * s * (s - 1);
        const int side = half * (s - 1) + s * (half - 1);
        const int between = 4 * s + 4 * half;
        EXPECT_EQ(h.walls.size(), static_cast<size_t>(top + 4 * side + between)) << "size " << size;
        std::set<std::pair<uint32_t, uint32_t>> pairs;
        for (const HemisphereWall& wall : h.walls) {
            EXPECT_NE(wall.a, wall.b);
            pairs.insert({std::min(wall.a, wall.b), std::max(wall.a, wall.b)});
        }
        // No two texels share more than one edge.
        EXPECT_EQ(pairs.size(), h.walls.size()) << "size " << size;
    }
}

TEST(HemisphereWalls, MirroredTexelsHaveMirroredWalls) {
    const Hemisphere h =
        makeHemisphere({.kind = HemisphereKind::kBorder, .size = 12, .extent = 3.0f});
    std::map<std::pair<uint32_t, uint32_t>, HemisphereWall> walls;
    for (const HemisphereWall& wall : h.walls) {
        walls[{wall.a, wall.b}] = wall;
        // Swapping the two texels turns the wall about.
        walls[{wall.b, wall.a}] = {wall.b, wall.a, -wall.motion, -wall.cosine_motion};
    }
    const auto mirrored = [&](uint32_t t) {
        const uint32_t s = static_cast<uint32_t>(h.width);
        return t / s * s + (s - 1 - t % s);
    };
    for (const HemisphereWall& wall : h.walls) {
        const auto other = walls.find({mirrored(wall.a), mirrored(wall.b)});
        ASSERT_NE(other, walls.end());
        EXPECT_NEAR(other->second.motion.x, -wall.motion.x, 1e-6f);
        EXPECT_NEAR(other->second.motion.y, wall.motion.y, 1e-6f);
        EXPECT_NEAR(other->second.cosine_motion.x, -wall.cosine_motion.x, 1e-6f);
        EXPECT_NEAR(other->second.cosine_motion.y, wall.cosine_motion.y, 1e-6f);
        // From a to b.
        const vec3 step = h.directions[wall.b] - h.directions[wall.a];
        EXPECT_GT(glm::dot(wall.motion, vec2(step)), 0.0f);
    }
}

// The divergence theorem on the sphere: with the outward normal m of a region's boundary in the
// tangent plane of the sphere, the integral of f m over the boundary is that of
// grad f - 2 f d over the region. Its xy part misses the horizon, where m points down.
TEST(HemisphereWalls, ClosedBoundariesSatisfyTheDivergenceTheorem) {
    for (const HemisphereParams& params :
         {HemisphereParams{.kind = HemisphereKind::kBorder, .size = 12, .extent = 3.0f},
          HemisphereParams{.kind = HemisphereKind::kBorder, .size = 9, .extent = 1.5f},
          HemisphereParams{.kind = HemisphereKind::kBorder, .size = 32, .extent = 4.0f},
          HemisphereParams{.kind = HemisphereKind::kHemicube, .size = 12}}) {
        SCOPED_TRACE(name(params));
        const Hemisphere h = makeHemisphere(params);
        const auto count = static_cast<size_t>(h.texelCount());
        std::vector<vec2> motion(count, vec2(0.0f)), cosine_motion(count, vec2(0.0f));
        for (const HemisphereWall& wall : h.walls) {
            motion[wall.a] += wall.motion;
            motion[wall.b] -= wall.motion;
            cosine_motion[wall.a] += wall.cosine_motion;
            cosine_motion[wall.b] -= wall.cosine_motion;
        }
        for (size_t t = 0; t < count; ++t) {
            // f = 1: -2 integral of d.  f = z: integral of (0, 0, 1) - 3 z d.
            vec2 first(0.0f), second(0.0f);
            float solid_angle = 0.0f;
            for (const FootprintSample& s : footprint(h, static_cast<int>(t))) {
                first -= 2.0f * s.solid_angle * vec2(s.direction);
                second -= 3.0f * s.solid_angle * s.direction.z * vec2(s.direction);
                solid_angle += s.solid_angle;
            }
            EXPECT_NEAR(glm::length(motion[t] - first), 0.0, kWallError * solid_angle) << t;
            EXPECT_NEAR(glm::length(cosine_motion[t] - second), 0.0, kWallError * solid_angle) << t;
        }
    }
}

TEST(Hemisphere, RefusesNonsense) {
    EXPECT_THROW(makeHemisphere({.size = 1}), std::logic_error);
    EXPECT_THROW(makeHemisphere({.size = 0}), std::logic_error);
    EXPECT_THROW(makeHemisphere({.extent = 0.0f}), std::logic_error);
    EXPECT_THROW(makeHemisphere({.extent = -1.0f}), std::logic_error);
    EXPECT_THROW(makeHemisphere({.extent = std::nanf("")}), std::logic_error);
}

}  // namespace
}  // namespace sheen
