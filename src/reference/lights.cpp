#include "reference/lights.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "reference/sobol.h"

namespace sheen {
namespace {

// A way to a lamp ends this fraction short of it, so that the lamp does not hide itself.
constexpr float kWayShare = 1.0f - 1e-5f;

float sumOf(const vec3& v) { return v.x + v.y + v.z; }

struct Barycentric {
    float u = 0.0f;  // of the second vertex
    float v = 0.0f;  // of the third
};

// Uniform over the triangle. [PJH23, 6.5.4]
Barycentric uniformPoint(const vec2& u) {
    const float root = std::sqrt(u.x);
    return {root * (1.0f - u.y), root * u.y};
}

float areaOf(const Scene& scene, uint32_t triangle) {
    const uvec3& t = scene.triangles[triangle];
    const glm::dvec3 p0(scene.positions[t.x]);
    return static_cast<float>(0.5 * glm::length(glm::cross(glm::dvec3(scene.positions[t.y]) - p0,
                                                           glm::dvec3(scene.positions[t.z]) - p0)));
}

// The last i whose cumulative share is at most u, never an empty one.
template <class T>
size_t pick(const T* shares, size_t count, T u) {
    const T* const above = std::upper_bound(shares, shares + count + 1, u);
    return static_cast<size_t>(
        std::clamp<ptrdiff_t>(above - shares - 1, 0, static_cast<ptrdiff_t>(count) - 1));
}

// Where u lies within what pick() chose.
template <class T>
float within(const T* shares, size_t i, T u) {
    return std::min(static_cast<float>((u - shares[i]) / (shares[i + 1] - shares[i])), kBelowOne);
}

}  // namespace

Lamps::Lamps(const Scene& scene) : scene_(scene) {
    std::vector<double> powers;
    double total = 0.0;
    for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
        if (!scene.materials[scene.materials_of[i]].emits()) {
            continue;
        }
        const double power = static_cast<double>(areaOf(scene, i)) * sumOf(meanEmission(scene, i));
        if (power > 0.0) {
            triangles_.push_back(i);
            powers.push_back(power);
            total += power;
        }
    }
    if (triangles_.empty()) {
        return;
    }
    densities_.assign(scene.triangles.size(), 0.0f);
    shares_.push_back(0.0);
    double sum = 0.0;
    for (size_t lamp = 0; lamp < powers.size(); ++lamp) {
        sum += powers[lamp];
        shares_.push_back(sum / total);
        densities_[triangles_[lamp]] = static_cast<float>((shares_[lamp + 1] - shares_[lamp]) /
                                                          areaOf(scene, triangles_[lamp]));
    }
}

LightChoice Lamps::choose(const vec3& from, const vec2& u) const {
    const size_t lamp = pick<double>(shares_.data(), triangles_.size(), u.x);
    const uint32_t triangle = triangles_[lamp];
    const Barycentric at = uniformPoint({within<double>(shares_.data(), lamp, u.x), u.y});
    const uvec3& t = scene_.triangles[triangle];
    const vec3 barycentric(1.0f - at.u - at.v, at.u, at.v);
    const vec3 way = barycentric.x * scene_.positions[t.x] + barycentric.y * scene_.positions[t.y] +
                     barycentric.z * scene_.positions[t.z] - from;
    const float distance = glm::length(way);
    const vec3 n = glm::cross(scene_.positions[t.y] - scene_.positions[t.x],
                              scene_.positions[t.z] - scene_.positions[t.x]);
    const float cosine = std::abs(glm::dot(n, way)) / (glm::length(n) * distance);
    LightChoice choice;
    if (distance > 0.0f && cosine > 0.0f) {
        choice.way = {
            .origin = from, .direction = way / distance, .distance = distance * kWayShare};
        choice.radiance =
            coverageAt(scene_, triangle, barycentric) * emissionAt(scene_, triangle, barycentric);
        choice.pdf = densities_[triangle] * distance * distance / cosine;
    }
    return choice;
}

float Lamps::pdf(uint32_t triangle, const Surface& s, const vec3& from) const {
    if (!contains(triangle)) {
        return 0.0f;
    }
    const vec3 way = s.position - from;
    const float cosine = std::abs(glm::dot(s.n_g, s.wo));
    return cosine > 0.0f ? densities_[triangle] * glm::dot(way, way) / cosine : 0.0f;
}

Sky::Sky(const Environment& environment) : environment_(environment) {
    const Image<vec3>& texels = environment.texels;
    if (texels.empty()) {
        return;
    }
    const int width = texels.width, height = texels.height;
    for (int y = 0; y <= height; ++y) {
        cosines_.push_back(std::cos(glm::pi<double>() * y / height));
    }
    // What of a texel's place neighbours show, as lookups are bilinear: an eighth on either side.
    const auto smooth = [&](int x, int y) {
        constexpr float kSide = 1.0f / 8.0f, kMiddle = 6.0f / 8.0f;
        const int left = (x + width - 1) % width, right = (x + 1) % width;
        return kSide * sumOf(texels.at(left, y)) + kMiddle * sumOf(texels.at(x, y)) +
               kSide * sumOf(texels.at(right, y));
    };
    rows_.push_back(0.0);
    columns_.reserve(static_cast<size_t>(width + 1) * static_cast<size_t>(height));
    std::vector<double> sums(static_cast<size_t>(width) + 1);
    for (int y = 0; y < height; ++y) {
        const int above = std::max(y - 1, 0), below = std::min(y + 1, height - 1);
        for (int x = 0; x < width; ++x) {
            const double mean = (smooth(x, above) + 6.0 * smooth(x, y) + smooth(x, below)) / 8.0;
            const auto i = static_cast<size_t>(x);
            sums[i + 1] = sums[i] + mean;
        }
        const double sum = sums.back();
        for (size_t i = 0; i < sums.size(); ++i) {
            columns_.push_back(static_cast<float>(sum > 0.0 ? sums[i] / sum : 0.0));
        }
        const auto row = static_cast<size_t>(y);
        rows_.push_back(rows_[row] + sum * (cosines_[row] - cosines_[row + 1]));
    }
    total_ = rows_.back();
    for (double& share : rows_) {
        share = total_ > 0.0 ? share / total_ : 0.0;
    }
}

float Sky::pdfOf(int x, int y) const {
    const auto row = static_cast<size_t>(y);
    const int width = environment_.texels.width;
    const float* const columns = &columns_[row * static_cast<size_t>(width + 1)];
    const double solid_angle =
        2.0 * glm::pi<double>() / width * (cosines_[row] - cosines_[row + 1]);
    return static_cast<float>((rows_[row + 1] - rows_[row]) * (columns[x + 1] - columns[x]) /
                              solid_angle);
}

LightChoice Sky::choose(const vec3& from, const vec2& u) const {
    const auto width = static_cast<size_t>(environment_.texels.width);
    const size_t y = pick<double>(rows_.data(), rows_.size() - 1, u.y);
    const float* const columns = &columns_[y * (width + 1)];
    const size_t x = pick<float>(columns, width, u.x);
    // Within the texel uniformly over its solid angle.
    const double cosine = glm::mix(cosines_[y], cosines_[y + 1],
                                   static_cast<double>(within<double>(rows_.data(), y, u.y)));
    const vec2 at(
        (static_cast<float>(x) + within<float>(columns, x, u.x)) / static_cast<float>(width),
        static_cast<float>(std::acos(glm::clamp(cosine, -1.0, 1.0))) / kPi);
    LightChoice choice;
    choice.way = {
        .origin = from, .direction = environment_.directionFromImage(at), .distance = kInfinity};
    choice.radiance = environment_.radiance(choice.way.direction);
    choice.pdf = pdfOf(static_cast<int>(x), static_cast<int>(y));
    return choice;
}

float Sky::pdf(const vec3& wi) const {
    const ivec2 size(environment_.texels.width, environment_.texels.height);
    const ivec2 texel = glm::min(ivec2(environment_.imageFromDirection(wi) * vec2(size)), size - 1);
    return pdfOf(texel.x, texel.y);
}

}  // namespace sheen
