#include "gather/motion.h"

#include <cmath>

#include "core/error.h"
#include "gather/face_directions.h"

namespace sheen {
namespace {

// A texel's distance is a mean over what it shows, of which a ray through its middle is a part.
constexpr float kSameDistance = 0.1f;

// Fills each gap with the value of the texel nearest to it, in steps from texel to texel, that is
// `known`; of several the one that comes first.
void fillGaps(const Hemisphere& h, std::vector<uint8_t>& known, std::vector<uint8_t>& gaps,
              std::vector<vec4>& texels) {
    std::vector<std::pair<uint32_t, uint32_t>> filled;  // from, to
    do {
        filled.clear();
        for (const HemisphereWall& wall : h.walls) {
            for (const auto& [from, to] : {std::pair(wall.a, wall.b), std::pair(wall.b, wall.a)}) {
                if (known[from] != 0 && gaps[to] != 0) {
                    filled.emplace_back(from, to);
                }
            }
        }
        for (const auto& [from, to] : filled) {
            if (gaps[to] != 0) {
                texels[to] = texels[from];
                known[to] = 1;
                gaps[to] = 0;
            }
        }
    } while (!filled.empty());
}

// The texel that a direction from a record meets; none below its horizon.
std::optional<size_t> texelToward(const Hemisphere& h, std::span<const FaceDirections> faces,
                                  const vec3& direction) {
    for (size_t f = 0; f < faces.size(); ++f) {
        if (const auto place = faces[f].meet(direction)) {
            const HemisphereFace& face = h.faces[f];
            const ivec2 texel = glm::min(ivec2(*place), ivec2(face.width - 1, face.height - 1));
            return texelOf(h, face, texel.x, texel.y);
        }
    }
    return std::nullopt;
}

}  // namespace

vec3 Motion::Moving::at(const Hit& hit) const {
    const vec3* corners = &scene.positions[3 * static_cast<size_t>(hit.triangle)];
    return (1.0f - hit.u - hit.v) * corners[0] + hit.u * corners[1] + hit.v * corners[2];
}

std::vector<uint8_t> movedTriangles(const Scene& scene, std::span<const vec3> positions) {
    SHEEN_CHECK_EQ(positions.size(), scene.positions.size());
    const auto moved = [&](uint32_t vertex) {
        return positions[vertex] != scene.positions[vertex];
    };
    std::vector<uint8_t> result;
    for (const uvec3& t : scene.triangles) {
        result.push_back(moved(t.x) || moved(t.y) || moved(t.z) ? 1 : 0);
    }
    return result;
}

Motion::Motion(const Scene& scene, std::span<const vec3> next)
    : moves_(movedTriangles(scene, next)) {
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        if (moves_[i] == 0) {
            continue;
        }
        const uvec3& t = scene.triangles[i];
        const auto base = static_cast<uint32_t>(now_.scene.positions.size());
        for (int corner = 0; corner < 3; ++corner) {
            now_.scene.positions.push_back(scene.positions[t[corner]]);
            then_.scene.positions.push_back(next[t[corner]]);
        }
        now_.scene.triangles.emplace_back(base, base + 1, base + 2);
    }
    then_.scene.triangles = now_.scene.triangles;
    if (!now_.scene.triangles.empty()) {
        now_.tracer = std::make_unique<Tracer>(now_.scene);
        then_.tracer = std::make_unique<Tracer>(then_.scene);
    }
}

std::optional<std::vector<vec4>> Motion::reproject(const Hemisphere& h, const RecordSite& site,
                                                   std::span<const vec4> light) const {
    if (!any()) {
        return std::nullopt;
    }
    const mat3 frame = tangentFrame(site.normal, 0.0f);
    const vec3 eye = site.eye();
    std::vector<vec3> directions(light.size());
    for (size_t t = 0; t < light.size(); ++t) {
        directions[t] = frame * h.directions[t];
    }
    const Rays rays{.origin = eye, .directions = directions};
    std::vector<Hit> hits(light.size());
    now_.tracer->meet(rays, hits.data());

    // What moves, and its mean radiance.
    std::vector<uint8_t> moving(light.size()), still(light.size());
    vec3 sum(0.0f);
    float count = 0.0f;
    for (size_t t = 0; t < light.size(); ++t) {
        const float distance = hits[t].distance;
        moving[t] = hits[t].found() && std::abs(distance - light[t].w) <= kSameDistance * distance;
        still[t] = moving[t] == 0;
        sum += moving[t] != 0 ? vec3(light[t]) : vec3(0.0f);
        count += moving[t] != 0 ? 1.0f : 0.0f;
    }
    if (count == 0.0f) {
        return std::nullopt;
    }
    then_.tracer->meet(rays, hits.data());
    std::vector<FaceDirections> faces;
    for (const HemisphereFace& face : h.faces) {
        faces.emplace_back(face, frame);
    }
    std::vector<vec4> later(light.begin(), light.end());
    std::vector<uint8_t> gaps = moving;
    for (size_t t = 0; t < light.size(); ++t) {
        const Hit& hit = hits[t];
        const bool hidden = moving[t] == 0 && light[t].w > 0.0f && light[t].w <= hit.distance;
        if (!hit.found() || hidden || !(glm::dot(directions[t], site.geometric_normal) > 0.0f)) {
            continue;
        }
        // What is not seen of it now shines as what is.
        const std::optional<size_t> seen = texelToward(h, faces, now_.at(hit) - eye);
        const vec3 radiance = seen && moving[*seen] != 0 ? vec3(light[*seen]) : sum / count;
        later[t] = vec4(radiance, hit.distance);
        gaps[t] = 0;
        still[t] = 0;  // it does not fill gaps
    }
    fillGaps(h, still, gaps, later);
    return later;
}

}  // namespace sheen
