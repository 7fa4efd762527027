// Interpolation between keys, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "scene/keyframes.h"

namespace sheen {
namespace {

constexpr double kKeyRounding = 1e-12;

using Values = std::vector<double>;

void expectNear(const Values& found, const Values& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < found.size(); ++i) {
        EXPECT_NEAR(found[i], expected[i], kKeyRounding) << "number " << i;
    }
}

// About y by an angle.
Values turn(double angle) { return {0.0, std::sin(angle / 2), 0.0, std::cos(angle / 2)}; }

Values joined(const std::vector<Values>& parts) {
    Values all;
    for (const Values& part : parts) {
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

TEST(Keyframes, StepsHoldUntilTheNextKey) {
    const Keyframes keys{.times = {1.0, 2.0, 4.0},
                         .values = {10, 11, 20, 21, 40, 41},
                         .width = 2,
                         .interpolation = Interpolation::kStep};
    expectNear(valueAt(keys, 1.0), {10, 11});
    expectNear(valueAt(keys, 1.999), {10, 11});
    expectNear(valueAt(keys, 2.0), {20, 21});
    expectNear(valueAt(keys, 3.9), {20, 21});
    expectNear(valueAt(keys, 4.0), {40, 41});
}

TEST(Keyframes, LinesBetweenKeys) {
    const Keyframes keys{.times = {1.0, 3.0, 4.0}, .values = {0, 8, 4}};
    expectNear(valueAt(keys, 1.5), {2});
    expectNear(valueAt(keys, 3.0), {8});
    expectNear(valueAt(keys, 3.75), {5});
}

TEST(Keyframes, BeforeTheFirstAndAfterTheLastKeyItStands) {
    for (const Interpolation how : {Interpolation::kStep, Interpolation::kLinear}) {
        const Keyframes keys{.times = {1.0, 2.0}, .values = {5, 7}, .interpolation = how};
        expectNear(valueAt(keys, -100.0), {5});
        expectNear(valueAt(keys, 0.999), {5});
        expectNear(valueAt(keys, 2.001), {7});
        expectNear(valueAt(keys, 1e9), {7});
    }
    const Keyframes spline{.times = {1.0, 2.0},
                           .values = {100, 5, 100, 100, 7, 100},
                           .interpolation = Interpolation::kCubicSpline};
    expectNear(valueAt(spline, 0.5), {5});
    expectNear(valueAt(spline, 2.5), {7});
}

TEST(Keyframes, OneKeyIsAConstant) {
    const Keyframes keys{.times = {1.0}, .values = {3}};
    for (const double seconds : {0.0, 1.0, 2.0}) {
        expectNear(valueAt(keys, seconds), {3});
    }
}

TEST(Keyframes, RotationsTurnAtConstantSpeed) {
    const Keyframes keys{.times = {2.0, 4.0},
                         .values = joined({turn(0.3), turn(2.3)}),
                         .width = 4,
                         .rotation = true};
    for (const double s : {0.0, 0.1, 0.25, 0.5, 0.9, 1.0}) {
        expectNear(valueAt(keys, 2.0 + 2.0 * s), turn(0.3 + 2.0 * s));
    }
}

TEST(Keyframes, RotationsTakeTheShorterWay) {
    // The second quaternion's negative is the same rotation: 0.2 to 1.0, and not round the back.
    Values far = turn(1.0);
    for (double& number : far) {
        number = -number;
    }
    const Keyframes keys{
        .times = {0.0, 1.0}, .values = joined({turn(0.2), far}), .width = 4, .rotation = true};
    expectNear(valueAt(keys, 0.5), turn(0.6));
}

TEST(Keyframes, ASplineIsTheCubicItsTangentsAreOf) {
    // p(t) = 2 t^3 - 3 t^2 + t + 4, over a step of 2.5 s, by its values and its slopes per second.
    const auto p = [](double t) { return 2 * t * t * t - 3 * t * t + t + 4; };
    const auto slope = [](double t) { return 6 * t * t - 6 * t + 1; };
    const double from = 0.5, to = 3.0;
    const Keyframes keys{.times = {from, to},
                         .values = {99, p(from), slope(from), slope(to), p(to), 99},
                         .interpolation = Interpolation::kCubicSpline};
    for (const double t : {0.5, 0.7, 1.0, 1.75, 2.9, 3.0}) {
        EXPECT_NEAR(valueAt(keys, t)[0], p(t), 1e-9) << t;
    }
}

TEST(Keyframes, SplinesOfRotationsAreUnit) {
    const Values still(4, 0.0);
    const Keyframes keys{.times = {0.0, 2.0},
                         .values = joined({still, turn(0.0), still, still, turn(1.0), still}),
                         .width = 4,
                         .interpolation = Interpolation::kCubicSpline,
                         .rotation = true};
    for (const double t : {0.0, 0.3, 1.0, 1.7, 2.0}) {
        const Values q = valueAt(keys, t);
        EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1.0, kKeyRounding);
    }
    expectNear(valueAt(keys, 1.0), turn(0.5));  // half way by symmetry
}

}  // namespace
}  // namespace sheen
