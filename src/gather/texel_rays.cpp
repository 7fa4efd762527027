#include "gather/texel_rays.h"

#include <algorithm>
#include <cmath>

#include "rays/jitter.h"

namespace sheen {
namespace {

// Rays are cast in the order of blocks of texels, which are seen in similar directions.
constexpr int kBlockWidth = 4;
constexpr int kBlockHeight = Tracer::kPacket / kBlockWidth;

// Steps of the R2 sequence, whose points fill a square evenly, however many there are [Rob18].
constexpr vec2 kSpread(0.7548777f, 0.5698403f);

// A texel gets a ray more for each average texel's worth of light that it varies by: for a given
// number of rays a sum's variance is least where each texel has them in proportion to its standard
// deviation [Ney34].
constexpr float kMostRays = 64.0f;

// Where in its texel a ray goes through. The others are spread evenly over it from a random place
// on [Rob18].
vec2 placeInTexel(const Hemisphere& h, size_t texel, int number, uint32_t seed) {
    if (number == 0) {
        return randomPlace(seed, static_cast<uint32_t>(texel));
    }
    const auto texels = static_cast<size_t>(h.texelCount());
    const vec2 start = randomPlace(seed, static_cast<uint32_t>(texels + texel));
    return glm::fract(start + static_cast<float>(number - 1) * kSpread);
}

}  // namespace

std::span<const float> weightsFor(const Hemisphere& h, int order) {
    return order == shared::DIFFUSE_ORDER ? h.cosines : h.solid_angles;
}

std::vector<float> relativeLight(std::span<const vec4> texels, std::span<const float> weights) {
    std::vector<float> light(texels.size());
    float sum = 0.0f;
    for (size_t t = 0; t < texels.size(); ++t) {
        light[t] = (texels[t].x + texels[t].y + texels[t].z) * weights[t];
        sum += light[t];
    }
    const float scale = static_cast<float>(texels.size()) / sum;
    if (!std::isfinite(scale)) {
        return std::vector<float>(texels.size());  // dark, or nearly
    }
    for (float& l : light) {
        l *= scale;
    }
    return light;
}

std::vector<float> contrastsOfNeighbours(const Hemisphere& h, std::span<const float> light) {
    std::vector<float> least(light.size(), kInfinity);
    std::vector<float> most(light.size(), 0.0f);
    const auto heed = [&](uint32_t t, uint32_t neighbour) {
        least[t] = std::min(least[t], light[neighbour]);
        most[t] = std::max(most[t], light[neighbour]);
    };
    for (const HemisphereWall& wall : h.walls) {
        heed(wall.a, wall.b);
        heed(wall.b, wall.a);
    }
    for (size_t t = 0; t < light.size(); ++t) {
        most[t] = std::max(most[t] - least[t], 0.0f);
    }
    return most;
}

std::vector<uint8_t> raysMore(std::span<const float> contrasts) {
    std::vector<uint8_t> more(contrasts.size());
    std::transform(contrasts.begin(), contrasts.end(), more.begin(), [](float contrast) {
        return static_cast<uint8_t>(contrast >= kLeastContrast ? std::min(contrast, kMostRays)
                                                               : 0.0f);
    });
    return more;
}

void TexelRays::reserve(size_t count) {
    directions.reserve(count);
    solid_angles.reserve(count);
    of.reserve(count);
    numbers.reserve(count);
    sets.reserve(count);
}

void TexelRays::add(const vec3& direction, float solid_angle, size_t texel, int number,
                    size_t set) {
    if (glm::dot(direction, n_g) > 0.0f) {
        directions.push_back(direction);
        solid_angles.push_back(solid_angle);
        of.push_back(texel);
        numbers.push_back(static_cast<uint8_t>(number));
        sets.push_back(static_cast<uint8_t>(set));
    }
}

std::vector<vec4> TexelRays::cast(const OutgoingLight& light, const vec3& eye,
                                  bool without_caustics, vec3* planes, Hit* hits) const {
    std::vector<vec4> seen(directions.size());
    light.cast({.origin = eye,
                .directions = directions,
                .solid_angles = solid_angles,
                .sets = sets,
                .without_caustics = without_caustics},
               seen.data(), planes, hits);
    return seen;
}

std::vector<FaceDirections> directionsOfFaces(const Hemisphere& h, const mat3& frame) {
    std::vector<FaceDirections> faces;
    for (const HemisphereFace& face : h.faces) {
        faces.emplace_back(face, frame);
    }
    return faces;
}

vec3 texelRay(const Hemisphere& h, std::span<const FaceDirections> faces, size_t texel, int number,
              uint32_t seed) {
    const int x = static_cast<int>(texel) % h.width;
    const int y = static_cast<int>(texel) / h.width;
    size_t f = 0;
    const auto within = [&](const HemisphereFace& face) {
        return x >= face.x && x < face.x + face.width && y >= face.y && y < face.y + face.height;
    };
    while (!within(h.faces[f])) {
        ++f;
    }
    return faces[f].direction(x - h.faces[f].x, y - h.faces[f].y,
                              placeInTexel(h, texel, number, seed));
}

// Neighbours, which decide how many more there are of a texel, are of other sets: did their chance
// depend on the texel's, light would be lost or won.
TexelRays raysThroughTexels(const Hemisphere& h, std::span<const FaceDirections> faces,
                            const vec3& n_g, uint32_t seed) {
    TexelRays rays{.n_g = n_g};
    rays.reserve(static_cast<size_t>(h.texelCount()));
    for (size_t f = 0; f < faces.size(); ++f) {
        const HemisphereFace& face = h.faces[f];
        for (int y0 = 0; y0 < face.height; y0 += kBlockHeight) {
            for (int x0 = 0; x0 < face.width; x0 += kBlockWidth) {
                for (int y = y0; y < std::min(y0 + kBlockHeight, face.height); ++y) {
                    for (int x = x0; x < std::min(x0 + kBlockWidth, face.width); ++x) {
                        const size_t t = texelOf(h, face, x, y);
                        const vec3 direction =
                            faces[f].direction(x, y, placeInTexel(h, t, 0, seed));
                        const size_t set = 2 * f + static_cast<size_t>((x + y) % 2);
                        rays.add(direction, h.solid_angles[t], t, 0, set);
                    }
                }
            }
        }
    }
    return rays;
}

TexelRays raysWhereLightChanges(const Hemisphere& h, std::span<const FaceDirections> faces,
                                const vec3& n_g, uint32_t seed, std::span<const uint8_t> more) {
    TexelRays rays{.n_g = n_g};
    rays.reserve(2 * more.size());
    for (size_t f = 0; f < faces.size(); ++f) {
        const HemisphereFace& face = h.faces[f];
        for (int y = 0; y < face.height; ++y) {
            for (int x = 0; x < face.width; ++x) {
                const size_t t = texelOf(h, face, x, y);
                const float solid_angle = h.solid_angles[t] / static_cast<float>(1 + more[t]);
                for (int k = 1; k <= more[t]; ++k) {
                    const vec3 direction = faces[f].direction(x, y, placeInTexel(h, t, k, seed));
                    rays.add(direction, solid_angle, t, k, 0);
                }
            }
        }
    }
    return rays;
}

void addRays(std::span<const size_t> of, std::span<const vec4> seen, std::span<const uint8_t> more,
             std::span<vec4> texels) {
    const auto inverse = [](float distance) { return distance > 0.0f ? 1.0f / distance : 0.0f; };
    for (vec4& texel : texels) {
        texel.w = inverse(texel.w);
    }
    for (size_t i = 0; i < of.size(); ++i) {
        texels[of[i]] += vec4(vec3(seen[i]), inverse(seen[i].w));
    }
    for (size_t t = 0; t < texels.size(); ++t) {
        texels[t] /= static_cast<float>(1 + more[t]);
        texels[t].w = inverse(texels[t].w);
    }
}

}  // namespace sheen
