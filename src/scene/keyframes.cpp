#include "scene/keyframes.h"

#include <algorithm>
#include <glm/gtc/quaternion.hpp>

#include "core/error.h"

namespace sheen {
namespace {

using Values = std::vector<double>;

// Parts of what a key of a cubic spline has.
constexpr size_t kTangentIn = 0, kValue = 1, kTangentOut = 2, kParts = 3;

const double* partOf(const Keyframes& keys, size_t key, size_t part) {
    const bool cubic = keys.interpolation == Interpolation::kCubicSpline;
    return &keys.values[(cubic ? kParts * key + part : key) * keys.width];
}

Values valueOf(const Keyframes& keys, size_t key) {
    const double* value = partOf(keys, key, kValue);
    return Values(value, value + keys.width);
}

glm::dquat quaternion(const double* q) { return {q[3], q[0], q[1], q[2]}; }

Values numbers(const glm::dquat& q) { return {q.x, q.y, q.z, q.w}; }

// Between a key and the next, `s` of the way; of two opposite quaternions, which are one rotation,
// the nearer one counts.
Values linear(const Keyframes& keys, size_t key, double s) {
    const double* a = partOf(keys, key, kValue);
    const double* b = partOf(keys, key + 1, kValue);
    if (keys.rotation) {
        return numbers(glm::normalize(
            glm::slerp(glm::normalize(quaternion(a)), glm::normalize(quaternion(b)), s)));
    }
    Values result(keys.width);
    for (size_t i = 0; i < keys.width; ++i) {
        result[i] = glm::mix(a[i], b[i], s);
    }
    return result;
}

// Likewise; tangents are per second, so that they are scaled by the time between the keys.
Values cubic(const Keyframes& keys, size_t key, double s) {
    const double step = keys.times[key + 1] - keys.times[key];
    const double s2 = s * s, s3 = s2 * s;
    const double* a = partOf(keys, key, kValue);
    const double* leave = partOf(keys, key, kTangentOut);
    const double* b = partOf(keys, key + 1, kValue);
    const double* arrive = partOf(keys, key + 1, kTangentIn);
    Values result(keys.width);
    for (size_t i = 0; i < keys.width; ++i) {
        result[i] = (2.0 * s3 - 3.0 * s2 + 1.0) * a[i] + (s3 - 2.0 * s2 + s) * step * leave[i] +
                    (3.0 * s2 - 2.0 * s3) * b[i] + (s3 - s2) * step * arrive[i];
    }
    return result;
}

}  // namespace

std::vector<double> valueAt(const Keyframes& keys, double seconds) {
    const bool cubic_spline = keys.interpolation == Interpolation::kCubicSpline;
    SHEEN_CHECK(!keys.times.empty());
    SHEEN_CHECK_EQ(keys.values.size(),
                   keys.times.size() * keys.width * (cubic_spline ? kParts : 1));
    const auto next = std::upper_bound(keys.times.begin(), keys.times.end(), seconds);
    Values value;
    if (next == keys.times.begin()) {
        value = valueOf(keys, 0);
    } else if (next == keys.times.end()) {
        value = valueOf(keys, keys.times.size() - 1);
    } else {
        const auto key = static_cast<size_t>(next - keys.times.begin()) - 1;
        const double s = (seconds - keys.times[key]) / (keys.times[key + 1] - keys.times[key]);
        switch (keys.interpolation) {
            case Interpolation::kStep:
                value = valueOf(keys, key);
                break;
            case Interpolation::kLinear:
                value = linear(keys, key, s);
                break;
            case Interpolation::kCubicSpline:
                value = cubic(keys, key, s);
        }
        // A spline of rotations may pass through zero, which is none: the key before then holds.
        if (keys.rotation && !(glm::length(quaternion(value.data())) > 0.0)) {
            value = valueOf(keys, key);
        }
    }
    return keys.rotation ? numbers(glm::normalize(quaternion(value.data()))) : value;
}

}  // namespace sheen
