// integrateHemisphere() on light with closed forms, its gradients against finite differences.
#include <gtest/gtest.h>

#include <functional>

#include "gather/integrate.h"
#include "sh/projection.h"
#include "test_scenes.h"

namespace sheen {
namespace {

// What an eye sees in a direction (unit, world space): radiance and, in w, distance (0: nothing).
using Look = std::function<vec4(const vec3&)>;

// Texels are as wide as an eighth of the plane's unit: what lies on an edge is weighted by the
// whole texel's mean cosine.
constexpr float kIrradianceError = 0.025f;
// 128 texels a side place an edge to half a texel, and the gradient takes distances at their
// centres.
constexpr float kGradientError = 0.1f;
constexpr float kShGradientError = 0.12f;
// The same, and a corner is taken to be as near as the nearest of its four texels.
constexpr float kCurvatureError = 0.1f;
// A smooth light, quadrature of a hemisphere by texels.
constexpr float kRotationError = 0.02f;

std::vector<vec4> render(const Hemisphere& h, const mat3& frame, const Look& look, int samples) {
    std::vector<vec4> texels(static_cast<size_t>(h.texelCount()));
    for (const HemisphereFace& face : h.faces) {
        for (int j = 0; j < face.height; ++j) {
            for (int i = 0; i < face.width; ++i) {
                const auto t = static_cast<size_t>((face.y + j) * h.width + face.x + i);
                vec3 sum(0.0f);
                for (int k = 0; k < samples * samples; ++k) {
                    const float du =
                        (static_cast<float>(k % samples) + 0.5f) / static_cast<float>(samples);
                    const float dv =
                        (static_cast<float>(k / samples) + 0.5f) / static_cast<float>(samples);
                    const float u =
                        2.0f * (static_cast<float>(i) + du) / static_cast<float>(face.width) - 1.0f;
                    const float v =
                        2.0f * (static_cast<float>(j) + dv) / static_cast<float>(face.height) -
                        1.0f;
                    sum += vec3(
                        look(frame * glm::normalize(face.forward + u * face.right + v * face.up)));
                }
                texels[t] = vec4(sum / static_cast<float>(samples * samples),
                                 look(frame * h.directions[t]).w);
            }
        }
    }
    return texels;
}

GatheredRecord integrate(const Hemisphere& h, const RecordSite& site, const Look& look,
                         int samples = 1) {
    ProjectionMatrices projections;
    projections.prepare(h, {&site, 1});
    return integrateHemisphere(h, {.light = render(h, tangentFrame(site.normal), look, samples)},
                               projections.of(site.order), site);
}

RecordSite siteWith(const vec3& normal, int order) {
    return {
        .position = vec3(1, 2, 3), .normal = normal, .geometric_normal = normal, .order = order};
}

const HemisphereParams kKinds[] = {
    {.kind = HemisphereKind::kBorder, .size = 32, .extent = 3.0f},
    {.kind = HemisphereKind::kPlane, .size = 32, .extent = 4.0f},
    {.kind = HemisphereKind::kLarsen, .size = 17, .extent = 2.0f},
    {.kind = HemisphereKind::kHemicube, .size = 16},
};

TEST(IntegrateHemisphere, UniformRadianceAtAnyDepthsHasNoGradient) {
    Random random(1);
    for (const HemisphereParams& params : kKinds) {
        const Hemisphere h = makeHemisphere(params);
        for (int order : {shared::DIFFUSE_ORDER, 3, 6}) {
            const GatheredRecord g =
                integrate(h, siteWith(random.direction(), order), [&](const vec3&) {
                    const float depth = std::pow(10.0f, random.uniform(-4.0f, 4.0f));
                    return vec4(0.7f, 1.3f, 20.0f, depth);
                });
            for (const vec3& v :
                 {g.record.translation_r, g.record.translation_g, g.record.translation_b}) {
                EXPECT_EQ(glm::length(v), 0.0f);
            }
            EXPECT_EQ(g.curvature, 0.0f);
            const ShLayout layout = shLayout(order);
            ASSERT_EQ(g.sh.size(), static_cast<size_t>(order > 0 ? layout.size() : 0));
            for (size_t k = static_cast<size_t>(layout.gradientFirst(0)); k < g.sh.size(); ++k) {
                EXPECT_EQ(g.sh[k], 0.0f) << k;
            }
            if (params.kind != HemisphereKind::kPlane) {
                EXPECT_NEAR(g.record.irradiance.x, 0.7f * kPi, 0.7f * kPi * 1e-3f);
            }
            // And no direction to turn to.
            EXPECT_NEAR(glm::length(g.record.rotation_b), 0.0f, 20.0f * 1e-3f);
        }
    }
}

TEST(IntegrateHemisphere, HarmonicMeanDistance) {
    Random random(2);
    for (const HemisphereParams& params : kKinds) {
        const Hemisphere h = makeHemisphere(params);
        for (float depth : {1e-4f, 1.0f, 1e5f}) {
            const GatheredRecord dome =
                integrate(h, siteWith(random.direction(), 0),
                          [=](const vec3&) { return vec4(1, 1, 1, depth); });
            EXPECT_NEAR(dome.record.radius, depth, 1e-4f * depth);
        }
        // Half the directions at distance 1, half at nothing: the mean of 1/r is 1/2.
        const GatheredRecord half = integrate(h, siteWith(vec3(0, 0, 1), 0), [](const vec3& d) {
            return vec4(1, 1, 1, d.x > 0.0f ? 1.0f : 0.0f);
        });
        if (h.width % 2 == 0) {
            EXPECT_NEAR(half.record.radius, 2.0f, 1e-3f);
        }
    }
}

TEST(IntegrateHemisphere, NothingSeen) {
    for (const HemisphereParams& params : kKinds) {
        const Hemisphere h = makeHemisphere(params);
        const GatheredRecord g =
            integrate(h, siteWith(vec3(0, 1, 0), 4), [](const vec3&) { return vec4(0.0f); });
        EXPECT_EQ(g.record.radius, kInfinity);
        EXPECT_EQ(g.record.irradiance, vec3(0.0f));
        EXPECT_EQ(g.record.translation_g, vec3(0.0f));
        for (float c : g.sh) {
            EXPECT_EQ(c, 0.0f);
        }
    }
}

TEST(IntegrateHemisphere, HostileTexelsStayFinite) {
    Random random(3);
    for (const HemisphereParams& params : kKinds) {
        const Hemisphere h = makeHemisphere(params);
        const GatheredRecord g = integrate(h, siteWith(random.direction(), 5), [&](const vec3&) {
            const float pick = random.uniform(0.0f, 1.0f);
            const float depth = pick < 0.3f ? 0.0f : (pick < 0.6f ? 1e-6f : 1e20f);
            return vec4(random.uniform(0.0f, 65504.0f), 0.0f, 1e-30f, depth);
        });
        const Record& r = g.record;
        EXPECT_GT(r.radius, 0.0f);
        for (const vec3& v :
             {r.irradiance, r.rotation_r, r.rotation_b, r.translation_r, r.translation_b}) {
            EXPECT_TRUE(std::isfinite(glm::dot(v, vec3(1.0f))));
        }
        for (float c : g.sh) {
            ASSERT_TRUE(std::isfinite(c));
        }
    }
}

TEST(IntegrateHemisphere, RecordSaysWhereItIs) {
    const Hemisphere h = makeHemisphere({.size = 8});
    Random random(4);
    const RecordSite site = siteWith(random.direction(), 4);
    const GatheredRecord g = integrate(h, site, [](const vec3& d) { return vec4(d * d, 1.0f); });
    EXPECT_EQ(g.record.position, site.position);
    EXPECT_EQ(g.record.normal, site.normal);
    EXPECT_EQ(g.record.order, 4);
    EXPECT_EQ(g.record.tangent, tangentFrame(site.normal)[0]);
    EXPECT_NEAR(glm::dot(g.record.translation_r, site.normal), 0.0f, 1e-5f);
    EXPECT_NEAR(glm::dot(g.record.rotation_r, site.normal), 0.0f, 1e-5f);
}

// An infinite ceiling at z = 1 and a rectangle in front of it, seen from (x, y, 0) upward.
struct Ceiling {
    float rectangle_height;
    float inside, outside;  // radiances of the rectangle and of the ceiling
    vec2 lower{0.2f, -0.5f}, upper{1.1f, 0.6f};

    Look from(const vec2& eye) const {
        return [*this, eye](const vec3& d) {
            if (d.z <= 0.0f) {
                return vec4(0.0f);
            }
            const vec2 q = eye + vec2(d) * (rectangle_height / d.z);
            const bool in = q.x > lower.x && q.x < upper.x && q.y > lower.y && q.y < upper.y;
            return vec4(vec3(in ? inside : outside), (in ? rectangle_height : 1.0f) / d.z);
        };
    }
    // Closed form.
    float irradiance(const vec2& eye) const {
        const vec2 l = (lower - eye) / rectangle_height;
        const vec2 u = (upper - eye) / rectangle_height;
        return kPi * outside + (inside - outside) * shared::planeCosine(l.x, l.y, u.x, u.y);
    }
    vec2 gradient(const vec2& eye) const {
        constexpr float kStep = 0.01f;
        const vec2 dx(kStep, 0), dy(0, kStep);
        return vec2(irradiance(eye + dx) - irradiance(eye - dx),
                    irradiance(eye + dy) - irradiance(eye - dy)) /
               (2.0f * kStep);
    }
    // Greatest second derivative in any direction, in magnitude.
    float curvature(const vec2& eye) const {
        constexpr float kStep = 0.05f;
        float greatest = 0.0f;
        for (int k = 0; k < 180; ++k) {
            const float angle = kPi / 180.0f * static_cast<float>(k);
            const vec2 d = kStep * vec2(std::cos(angle), std::sin(angle));
            greatest = std::max(greatest, std::abs(irradiance(eye + d) + irradiance(eye - d) -
                                                   2.0f * irradiance(eye)) /
                                              (kStep * kStep));
        }
        return greatest;
    }
};

// What the record sees where every surface is level, with the planes rays would tell of and
// without.
GatheredRecord integrateLevel(const Hemisphere& h, const Look& look, bool planes) {
    const RecordSite site = siteWith(vec3(0, 0, 1), 0);
    const mat3 frame = tangentFrame(site.normal);
    SeenTexels seen{.light = render(h, frame, look, 1)};
    for (size_t t = 0; planes && t < seen.light.size(); ++t) {
        const float height = seen.light[t].w * h.directions[t].z;
        seen.planes.push_back(height > 0.0f ? vec3(0, 0, 1.0f / height) : vec3(0.0f));
    }
    return integrateHemisphere(h, seen, {}, site);
}

// A light in the ceiling; an occluder nearer than the ceiling (the nearer surface decides how fast
// the edge moves); a light nearer than the ceiling.
const Ceiling kCeilings[] = {{1.0f, 5.0f, 0.0f}, {0.5f, 0.0f, 1.0f}, {0.4f, 3.0f, 1.0f}};

TEST(TranslationGradient, IrradianceAgainstTheClosedForm) {
    const Hemisphere coarse =
        makeHemisphere({.kind = HemisphereKind::kBorder, .size = 64, .extent = 4.0f});
    // Texels see one surface each, as when they are rasterised: a texel that averages two would
    // have an edge move at the farther one's rate.
    const Hemisphere fine =
        makeHemisphere({.kind = HemisphereKind::kBorder, .size = 128, .extent = 4.0f});
    const RecordSite site = siteWith(vec3(0, 0, 1), 0);
    for (const Ceiling& ceiling : kCeilings) {
        for (const vec2& eye :
             {vec2(0.0f), vec2(-0.4f, 0.3f), vec2(1.0f, 0.5f), vec2(0.7f, -0.1f)}) {
            EXPECT_NEAR(integrate(coarse, site, ceiling.from(eye), 6).record.irradiance.x,
                        ceiling.irradiance(eye), kIrradianceError * ceiling.irradiance(eye));
            const vec2 expected = ceiling.gradient(eye);
            for (bool planes : {false, true}) {
                const vec2 found(
                    integrateLevel(fine, ceiling.from(eye), planes).record.translation_g);
                EXPECT_LT(glm::length(found - expected), kGradientError * glm::length(expected))
                    << "rectangle at " << ceiling.rectangle_height << " eye " << eye.x << " "
                    << eye.y << " found " << found.x << " " << found.y << " expected " << expected.x
                    << " " << expected.y << " planes " << planes;
            }
        }
    }
}

TEST(TranslationGradient, HemicubeAgreesWithTheClosedForm) {
    const Hemisphere cube = makeHemisphere({.kind = HemisphereKind::kHemicube, .size = 96});
    for (const Ceiling& ceiling : kCeilings) {
        const vec2 eye(-0.3f, 0.2f);
        for (bool planes : {false, true}) {
            const GatheredRecord g = integrateLevel(cube, ceiling.from(eye), planes);
            EXPECT_LT(glm::length(vec2(g.record.translation_r) - ceiling.gradient(eye)),
                      kGradientError * glm::length(ceiling.gradient(eye)))
                << planes;
        }
    }
}

TEST(Curvature, AgainstTheClosedForm) {
    for (const HemisphereParams& params :
         {HemisphereParams{.kind = HemisphereKind::kBorder, .size = 128, .extent = 4.0f},
          HemisphereParams{.kind = HemisphereKind::kHemicube, .size = 96}}) {
        const Hemisphere h = makeHemisphere(params);
        for (const Ceiling& ceiling : kCeilings) {
            for (const vec2& eye : {vec2(0.6f, 0.0f), vec2(-0.4f, 0.3f), vec2(1.0f, 0.5f)}) {
                const float expected = ceiling.curvature(eye);
                for (bool planes : {false, true}) {
                    EXPECT_NEAR(integrateLevel(h, ceiling.from(eye), planes).curvature, expected,
                                kCurvatureError * expected)
                        << "rectangle at " << ceiling.rectangle_height << " eye " << eye.x
                        << " planes " << planes;
                }
            }
        }
    }
}

// The foot of a wall: an eye on the wall x = 0 sees, from a height, the floor y = 0, whose light is
// 1 + kSlope x as far as the wall x = 1, which is dark. No ceiling; no end along z.
struct Foot {
    static constexpr float kSlope = 4.0f;
    float height;

    bool seesFloor(const vec3& d) const { return d.y < -height * d.x; }
    vec4 look(const vec3& d) const {
        if (seesFloor(d)) {
            const float distance = -height / d.y;
            return vec4(vec3(1.0f + kSlope * distance * d.x), distance);
        }
        return vec4(vec3(0.0f), d.x > 0.0f ? 1.0f / d.x : 0.0f);
    }
    vec3 plane(const vec3& d) const {
        return seesFloor(d) ? vec3(0, -1.0f / height, 0) : vec3(d.x > 0.0f ? 1.0f : 0.0f, 0, 0);
    }
    // The strip as far as x has the form factor (1 - h / sqrt(x^2 + h^2)) / 2; its change, times
    // light, summed, and the derivative of that by h.
    float gradient() const {
        const double h = height;
        const double s = 1.0 / std::sqrt(1.0 + h * h);
        const double even = -s + h * h * s * s * s;
        const double sloping = std::asinh(1.0 / h) - 2.0 * s + h * h * s * s * s;
        return static_cast<float>(0.5 * kPi * (even + kSlope * sloping));
    }
};

TEST(TranslationGradient, IsBoundedAtTheFootOfAWall) {
    // About as many texels as the program has. Near the floor ever more of it lies in one texel,
    // and of a gradient that grows like the logarithm of the height a part is found. By the nearer
    // distance of two texels it would be -61 at 0.001, -8900 at 1e-5.
    constexpr float kFootError = 0.15f;
    constexpr float kLeastPart = 0.35f;
    const Hemisphere h = makeHemisphere({.kind = HemisphereKind::kHemicube, .size = 20});
    const RecordSite site = siteWith(vec3(1, 0, 0), 0);
    const mat3 frame = tangentFrame(site.normal);
    for (float height : {0.3f, 0.1f, 0.03f, 0.01f, 1e-3f, 1e-5f}) {
        const Foot foot{height};
        SeenTexels seen{.light = render(
                            h, frame, [&](const vec3& d) { return foot.look(d); }, 6)};
        for (const vec3& d : h.directions) {
            seen.planes.push_back(foot.plane(frame * d) * frame);
        }
        const vec3 found = integrateHemisphere(h, seen, {}, site).record.translation_g;
        const float expected = foot.gradient();
        if (height >= 0.1f) {
            EXPECT_NEAR(found.y, expected, kFootError * std::abs(expected)) << height;
        } else {
            EXPECT_GT(found.y, kLeastPart * expected) << height;
            EXPECT_LT(found.y, expected) << height;
        }
        EXPECT_NEAR(found.z, 0.0f, 1e-3f) << height;
    }
}

TEST(TranslationGradient, SphericalHarmonicsAgainstFiniteDifferences) {
    const int order = kShGradientOrder;  // whose fit the gradients are
    const Hemisphere h =
        makeHemisphere({.kind = HemisphereKind::kBorder, .size = 64, .extent = 4.0f});
    const ShLayout layout = shLayout(order);
    const float step = 0.04f;
    for (const Ceiling& ceiling : kCeilings) {
        const vec2 eye(-0.2f, 0.1f);
        const RecordSite site = siteWith(vec3(0, 0, 1), order);
        const GatheredRecord g = integrate(h, site, ceiling.from(eye), 6);
        for (int axis = 0; axis < 2; ++axis) {
            vec2 d(0.0f);
            d[axis] = step;
            const GatheredRecord after = integrate(h, site, ceiling.from(eye + d), 6);
            const GatheredRecord before = integrate(h, site, ceiling.from(eye - d), 6);
            double error2 = 0.0, size2 = 0.0;
            for (int k = 0; k < layout.gradientCoefficients(); ++k) {
                const auto i = static_cast<size_t>(k);
                const float expected = (after.sh[i] - before.sh[i]) / (2.0f * step);
                const float found = g.sh[static_cast<size_t>(layout.gradientFirst(axis) + k)];
                error2 += std::pow(found - expected, 2);
                size2 += std::pow(expected, 2);
            }
            EXPECT_LT(std::sqrt(error2), kShGradientError * std::sqrt(size2) + 0.03)
                << "rectangle at " << ceiling.rectangle_height << " axis " << axis << " of size "
                << std::sqrt(size2);
        }
    }
}

TEST(TranslationGradient, ScalesWithTheScene) {
    // Lengths times s: gradients over s, irradiance and its rotation as they were.
    const Hemisphere h =
        makeHemisphere({.kind = HemisphereKind::kBorder, .size = 32, .extent = 3.0f});
    const Look look = kCeilings[1].from(vec2(0.1f));
    const GatheredRecord one = integrate(h, siteWith(vec3(0, 0, 1), 3), look);
    for (float s : {1e-3f, 1e3f}) {
        const GatheredRecord other = integrate(h, siteWith(vec3(0, 0, 1), 3), [&](const vec3& d) {
            const vec4 v = look(d);
            return vec4(vec3(v), s * v.w);
        });
        EXPECT_EQ(other.record.irradiance, one.record.irradiance);
        EXPECT_NEAR(other.record.radius, s * one.record.radius, 1e-5f * s * one.record.radius);
        EXPECT_NEAR(s * other.record.translation_r.x, one.record.translation_r.x,
                    1e-4f * std::abs(one.record.translation_r.x));
        EXPECT_NEAR(s * s * other.curvature, one.curvature, 1e-4f * one.curvature);
        const size_t k = static_cast<size_t>(shLayout(3).gradientFirst(0));
        EXPECT_NEAR(s * other.sh[k], one.sh[k], 1e-4f * std::abs(one.sh[k]));
    }
}

TEST(RotationVector, PredictsIrradianceOnTiltedNormals) {
    const Hemisphere h = makeHemisphere({.kind = HemisphereKind::kHemicube, .size = 32});
    Random random(6);
    for (int trial = 0; trial < 5; ++trial) {
        const vec3 n = random.direction();
        const vec3 toward = glm::normalize(n + 0.7f * random.direction());
        // Light that fades before the horizon, so that tilting brings no new light.
        const auto look = [&](const vec3& d) {
            const float c = glm::dot(d, toward);
            return vec4(vec3(c > 0.8f ? 4.0f * (c - 0.8f) : 0.0f), 1.0f);
        };
        const GatheredRecord at = integrate(h, siteWith(n, 0), look, 3);
        for (float degrees : {3.0f, 8.0f}) {
            const vec3 axis = glm::normalize(glm::cross(n, random.direction()));
            const vec3 side = glm::cross(axis, n);
            const float angle = glm::radians(degrees);
            const vec3 tilted = std::cos(angle) * n + std::sin(angle) * side;
            const GatheredRecord there = integrate(h, siteWith(tilted, 0), look, 3);
            const vec3 predicted = shared::recordIrradiance(at.record, at.record.position, tilted);
            // Second order in the tilt: 1 - cos.
            EXPECT_NEAR(predicted.x, there.record.irradiance.x,
                        (kRotationError + 1.0f - std::cos(angle)) * at.record.irradiance.x)
                << degrees;
        }
    }
}

TEST(ShCoefficients, AreInWorldSpace) {
    const Hemisphere h =
        makeHemisphere({.kind = HemisphereKind::kBorder, .size = 32, .extent = 4.0f});
    Random random(7);
    for (int order : {2, 4, 8}) {
        const vec3 n = random.direction();
        // Smooth light whose horizon continues below: turned with the normal.
        const mat3 frame = tangentFrame(n);
        const auto light = [&](const vec3& d) {
            return 1.0f + 0.5f * glm::dot(d, frame[0]) - 0.25f * glm::dot(d, frame[1]);
        };
        const GatheredRecord g = integrate(
            h, siteWith(n, order),
            [&](const vec3& d) { return vec4(light(d), 2.0f * light(d), 0.0f, 1.0f); }, 2);
        const ShLayout layout = shLayout(order);
        for (int i = 0; i < 50; ++i) {
            const vec3 d = random.direction(n);
            const shared::ShVector y = shared::shBasis(d, order);
            float red = 0.0f, green = 0.0f;
            for (int k = 0; k < layout.coefficients(); ++k) {
                red += g.sh[static_cast<size_t>(k)] * y.c[k];
                green += g.sh[static_cast<size_t>(layout.coefficients() + k)] * y.c[k];
            }
            EXPECT_NEAR(red, light(d), 0.08f) << "order " << order;
            EXPECT_NEAR(green, 2.0f * red, 1e-3f);
        }
        for (int k = 0; k < layout.coefficients(); ++k) {
            EXPECT_EQ(g.sh[static_cast<size_t>(2 * layout.coefficients() + k)], 0.0f);
        }
    }
}

}  // namespace
}  // namespace sheen
