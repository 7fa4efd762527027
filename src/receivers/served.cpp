#include "receivers/served.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

// A sphere's slab before a camera, along one axis of the image.
struct Slab {
    double x = 0, z = 0;                 // of the sphere's centre: aside, ahead
    double radius = 0, half_height = 0;  // of the sphere, of the slab
    double normal_x = 0, normal_z = 0;

    // A plane through the eye, x = s z, has all of the slab on one side where the centre's distance
    // from it is at least the slab's support along the plane's normal (1, -s): a disc's and half
    // the height's.
    bool outside(double s, double sign) const {
        const double along = normal_x - s * normal_z;
        const double support = radius * std::sqrt(std::max(1.0 + s * s - along * along, 0.0)) +
                               half_height * std::abs(along);
        return sign * (s * z - x) >= support;
    }
    // From the sphere's bound toward the centre, as long as the slab stays outside.
    double tightened(double bound, double sign) const {
        constexpr int kSteps = 5;
        double inner = x / z;
        for (int i = 0; i < kSteps && half_height < radius; ++i) {
            const double middle = 0.5 * (inner + bound);
            (outside(middle, sign) ? bound : inner) = middle;
        }
        return bound;
    }
};

}  // namespace

PixelRect slabBounds(const PixelGrid& image, const vec3& center, float radius, const vec3& normal,
                     float half_height) {
    const View& view = image.view;
    // Double precision: where the sphere almost reaches the eye's plane the tangents are small
    // differences of large numbers.
    const glm::dvec3 d = glm::dvec3(center) - glm::dvec3(view.origin);
    const double r = radius;
    // The view of a part of an image leans: across it lies what is left of its forward axis without
    // its parts along the image's axes.
    const glm::dvec3 right(view.right), up(view.up);
    const double aside_x = glm::dot(glm::dvec3(view.forward), right) / glm::dot(right, right);
    const double aside_y = glm::dot(glm::dvec3(view.forward), up) / glm::dot(up, up);
    const glm::dvec3 across = glm::dvec3(view.forward) - aside_x * right - aside_y * up;
    const double z_axis_length = glm::length(across);
    const glm::dvec3 forward = across / z_axis_length;
    const double z = glm::dot(forward, d);
    if (z < -r) {
        return {};
    }
    // Per image axis: the two planes through the eye that touch the sphere, [MM13].
    const auto range = [&](const glm::dvec3& axis, double leaning, int size, int& low, int& high) {
        const double scale = glm::length(axis) / z_axis_length;
        const glm::dvec3 aside = glm::normalize(axis);
        const double x = glm::dot(aside, d);
        const double tangent2 = x * x + z * z - r * r;
        low = 0;
        high = size;
        if (z <= 1.0001 * r || tangent2 <= 0.0) {
            return;  // the sphere reaches behind the eye's plane: no bound on this axis
        }
        const double root = r * std::sqrt(tangent2);
        const double denominator = z * z - r * r;
        const Slab slab = {.x = x,
                           .z = z,
                           .radius = r,
                           .half_height = half_height,
                           .normal_x = glm::dot(glm::dvec3(normal), aside),
                           .normal_z = glm::dot(glm::dvec3(normal), forward)};
        const double s0 = slab.tightened((x * z - root) / denominator, -1.0) / scale - leaning;
        const double s1 = slab.tightened((x * z + root) / denominator, 1.0) / scale - leaning;
        const auto pixel = [size](double s) {
            const double at = (0.5 * s + 0.5) * size;
            return std::isnan(at) ? -1.0 : std::clamp(at, -1.0, size + 1.0);  // no number: nowhere
        };
        // A pixel counts where its centre may lie inside; one more on each side for rounding.
        low = std::clamp(static_cast<int>(std::floor(pixel(s0) - 0.5)), 0, size);
        high = std::clamp(static_cast<int>(std::ceil(pixel(s1) + 0.5)), 0, size);
    };
    PixelRect rect;
    range(right, aside_x, image.width, rect.x0, rect.x1);
    range(up, aside_y, image.height, rect.y0, rect.y1);
    if (rect.x0 >= rect.x1 || rect.y0 >= rect.y1) {
        return {};
    }
    return rect;
}

// recordWeight() is above 0 only where |d| / R + sqrt(k_n t) < a and |d.(n + n_k)| / 2 <= c a R,
// with t = 1 - n.n_k = |n - n_k|^2 / 2. Of d.n_k = d.(n + n_k) / 2 - d.(n - n_k) / 2 the second
// part is at most |d| sqrt(t / 2) < |d| (a - |d| / R) / sqrt(2 k_n), which is greatest in the
// middle of the reach.
PixelRect servedBounds(const PixelGrid& image, const Record& record, const WeightParams& weight) {
    const float reach = weight.accuracy * record.radius;
    const float tilted = weight.accuracy * reach / (4.0f * std::sqrt(2.0f * weight.normal_weight));
    return slabBounds(image, record.position, reach, record.normal, weight.slab * reach + tilted);
}

PixelRect reachedBounds(const Receivers& receivers, const Record& record,
                        const WeightParams& weight) {
    constexpr float kRounding = 1e-5f;  // of another compiler's recordWeight()
    const PixelRect served = servedBounds(receivers.image, record, weight);
    const float reach = (1.0f + kRounding) * weight.accuracy * record.radius;
    const auto reached = [&](int x, int y) {
        const size_t i = receivers.image.index(x, y);
        const vec3 d = receivers.positions[i] - record.position;
        return glm::dot(d, d) < reach * reach && receivers.seen(i);
    };
    PixelRect rect{served.x1, served.y1, served.x0, served.y0};
    for (int y = served.y0; y < served.y1; ++y) {
        int first = served.x0;
        while (first < served.x1 && !reached(first, y)) {
            ++first;
        }
        if (first == served.x1) {
            continue;
        }
        int end = served.x1;
        while (end > rect.x1 && !reached(end - 1, y)) {
            --end;
        }
        rect = {std::min(rect.x0, first), std::min(rect.y0, y), std::max(rect.x1, end), y + 1};
    }
    return rect.x0 < rect.x1 ? rect : PixelRect{};
}

}  // namespace sheen
