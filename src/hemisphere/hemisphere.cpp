#include "hemisphere/hemisphere.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"

namespace sheen {
namespace {

constexpr int kStripSteps = 8;  // azimuths a border texel's strip is integrated over, at least
constexpr float kStripStep = 0.035f;  // their greatest width, radians
constexpr int kFootprintSide = 2;     // pieces along a side of an ordinary texel
constexpr int kWallSteps = 4;         // pieces a wall's cosine is integrated over
constexpr float kTwoPi = 2.0f * kPi;

// Rectangle of a texel on its face's plane, in the coordinates of planeSolidAngle().
struct TexelRect {
    float u0, v0, u1, v1;  // in [-1, 1]
};

TexelRect texelRect(const HemisphereFace& face, int i, int j) {
    const auto edge = [](int k, int n) {
        return 2.0f * static_cast<float>(k) / static_cast<float>(n) - 1.0f;
    };
    return {edge(i, face.width), edge(j, face.height), edge(i + 1, face.width),
            edge(j + 1, face.height)};
}

vec3 faceDirection(const HemisphereFace& face, float u, float v) {
    return glm::normalize(face.forward + u * face.right + v * face.up);
}

std::vector<HemisphereFace> makeFaces(const HemisphereParams& p) {
    const int s = p.size;
    if (p.kind != HemisphereKind::kHemicube) {
        return {{.right = {p.extent, 0, 0},
                 .up = {0, p.extent, 0},
                 .forward = {0, 0, 1},
                 .x = 0,
                 .y = 0,
                 .width = s,
                 .height = s}};
    }
    std::vector<HemisphereFace> faces = {{.right = {1, 0, 0},
                                          .up = {0, 1, 0},
                                          .forward = {0, 0, 1},
                                          .x = 0,
                                          .y = 0,
                                          .width = s,
                                          .height = s}};
    const vec3 sides[] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    for (int i = 0; i < 4; ++i) {
        // The upper half of a cube's side: heights 0 to 1 over the tangent plane.
        const vec3 up(0, 0, 0.5f);
        faces.push_back({.right = glm::cross(vec3(0, 0, 1), sides[i]),
                         .up = up,
                         .forward = sides[i] + up,
                         .x = 0,
                         .y = s + i * (s / 2),
                         .width = s,
                         .height = s / 2});
    }
    return faces;
}

// Integral of cos(theta) over a rectangle of any face: the sum over its edges, each a great
// circle's arc, of half the arc times the z of its plane's normal. [Lambert 1760]
float rectCosine(const HemisphereFace& face, const TexelRect& r) {
    const vec2 corners[] = {{r.u0, r.v0}, {r.u1, r.v0}, {r.u1, r.v1}, {r.u0, r.v1}};
    const auto direction = [&](int k) {
        const glm::dvec2 c(corners[k % 4]);
        return glm::normalize(glm::dvec3(face.forward) + c.x * glm::dvec3(face.right) +
                              c.y * glm::dvec3(face.up));
    };
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) {
        const glm::dvec3 normal = glm::cross(direction(k), direction(k + 1));
        const double sine = glm::length(normal);
        sum += 0.5 * std::atan2(sine, glm::dot(direction(k), direction(k + 1))) * normal.z / sine;
    }
    return static_cast<float>(std::abs(sum));
}

bool onBorder(const HemisphereFace& face, int i, int j) {
    return i == 0 || j == 0 || i == face.width - 1 || j == face.height - 1;
}

// Azimuths between which a border texel of the stretched plane reaches the horizon.
vec2 borderAzimuths(const HemisphereFace& face, int i, int j) {
    const TexelRect r = texelRect(face, i, j);
    const vec2 center(0.5f * (r.u0 + r.u1), 0.5f * (r.v0 + r.v1));
    const float middle = std::atan2(center.y, center.x);
    float low = 0.0f;
    float high = 0.0f;
    for (const vec2 corner :
         {vec2(r.u0, r.v0), vec2(r.u1, r.v0), vec2(r.u0, r.v1), vec2(r.u1, r.v1)}) {
        const float limit = 1.0f - 1e-6f;
        if (std::abs(corner.x) < limit && std::abs(corner.y) < limit) {
            continue;  // an inner corner
        }
        float delta = std::atan2(corner.y, corner.x) - middle;
        delta -= kTwoPi * std::round(delta / kTwoPi);
        low = std::min(low, delta);
        high = std::max(high, delta);
    }
    return {middle + low, middle + high};
}

// Even, so that no step straddles the corner in the middle of a corner texel's azimuths.
int stripSteps(const vec2& azimuths) {
    return std::max(kStripSteps,
                    2 * static_cast<int>(std::ceil(0.5f * (azimuths.y - azimuths.x) / kStripStep)));
}

// The strip of a border texel, from the plane's edge to the horizon, in pieces.
void appendStrip(const HemisphereFace& face, const vec2& azimuths,
                 std::vector<FootprintSample>& out) {
    const float extent = face.right.x;
    const int steps = stripSteps(azimuths);
    const float step = (azimuths.y - azimuths.x) / static_cast<float>(steps);
    constexpr int kHeights = 4;
    for (int k = 0; k < steps; ++k) {
        const float phi = azimuths.x + (static_cast<float>(k) + 0.5f) * step;
        const float top = shared::borderCosine(phi, extent);
        for (int i = 0; i < kHeights; ++i) {
            // Equal slices of height z are equal solid angles.
            const float z = top * (static_cast<float>(i) + 0.5f) / kHeights;
            const float s = std::sqrt(1.0f - z * z);
            out.push_back({{s * std::cos(phi), s * std::sin(phi), z}, step * top / kHeights});
        }
    }
}

const HemisphereFace& faceOf(const Hemisphere& h, int texel, int& i, int& j) {
    const int x = texel % h.width;
    const int y = texel / h.width;
    for (const HemisphereFace& face : h.faces) {
        if (y >= face.y && y < face.y + face.height && x >= face.x && x < face.x + face.width) {
            i = x - face.x;
            j = y - face.y;
            return face;
        }
    }
    checkFailed(__FILE__, __LINE__, "texel outside every face");
}

// Cosine weight of a texel of the top face, whose part of the plane has a closed form; the cosine
// of the strip from there down to the horizon is half of cos^2.
float topCosine(const Hemisphere& h, size_t texel, const HemisphereFace& face, const TexelRect& r) {
    const float e = face.right.x;
    float cosine = shared::planeCosine(r.u0 * e, r.v0 * e, r.u1 * e, r.v1 * e);
    if (h.at_horizon[texel] != 0) {
        const vec2 az = h.azimuths[texel];
        const int steps = stripSteps(az);
        const float step = (az.y - az.x) / static_cast<float>(steps);
        for (int k = 0; k < steps; ++k) {
            const float phi = az.x + (static_cast<float>(k) + 0.5f) * step;
            const float top = shared::borderCosine(phi, e);
            cosine += 0.5f * top * top * step;
        }
    }
    return cosine;
}

// What a plane leaves out is spread over it.
void spreadOverPlane(Hemisphere& h) {
    float coverage = 0.0f;
    for (float c : h.cosines) {
        coverage += c / kPi;
    }
    for (size_t t = 0; t < h.cosines.size(); ++t) {
        h.solid_angles[t] /= coverage;
        h.cosines[t] /= coverage;
        h.moments[t] /= coverage;
    }
}

void fillTexels(Hemisphere& h) {
    const size_t count = static_cast<size_t>(h.texelCount());
    h.directions.resize(count);
    h.solid_angles.resize(count);
    h.cosines.resize(count);
    h.moments.resize(count);
    h.at_horizon.resize(count);
    h.azimuths.resize(count);
    for (int texel = 0; texel < h.texelCount(); ++texel) {
        int i = 0;
        int j = 0;
        const HemisphereFace& face = faceOf(h, texel, i, j);
        const TexelRect r = texelRect(face, i, j);
        const auto index = static_cast<size_t>(texel);
        h.directions[index] = faceDirection(face, 0.5f * (r.u0 + r.u1), 0.5f * (r.v0 + r.v1));
        const bool side = face.forward.z < 0.75f;
        if (h.params.kind == HemisphereKind::kBorder && onBorder(face, i, j)) {
            h.at_horizon[index] = 1;
            h.azimuths[index] = borderAzimuths(face, i, j);
        } else if (side && j == 0) {
            const vec3 a = faceDirection(face, r.u0, -1.0f);
            const vec3 b = faceDirection(face, r.u1, -1.0f);
            const float first = std::atan2(a.y, a.x);
            float delta = std::atan2(b.y, b.x) - first;
            delta -= kTwoPi * std::round(delta / kTwoPi);
            h.at_horizon[index] = 1;
            h.azimuths[index] = {std::min(first, first + delta), std::max(first, first + delta)};
        }
        float solid_angle = 0.0f;
        vec2 moment(0.0f);
        for (const FootprintSample& s : footprint(h, texel)) {
            solid_angle += s.solid_angle;
            moment += s.solid_angle * vec2(s.direction);
        }
        h.solid_angles[index] = solid_angle;
        h.cosines[index] = side ? rectCosine(face, r) : topCosine(h, index, face, r);
        h.moments[index] = moment;
    }
    if (h.params.kind == HemisphereKind::kLarsen) {
        spreadOverPlane(h);
    }
}

// Lambert's edge term: half the angle between two directions times the cosine of the normal of
// their plane. The cosine-weighted solid angle of a polygon is its sum over the edges. [WH92]
double edgeTerm(const glm::dvec3& d0, const glm::dvec3& d1) {
    const glm::dvec3 normal = glm::cross(d0, d1);
    const double sine = glm::length(normal);
    return 0.5 * std::atan2(sine, glm::dot(d0, d1)) * normal.z / sine;
}

// Second derivatives xx, xy, yy of the edge term by the motion of the eye, for an edge whose
// corners are at distances r0 and r1. From t the corners are seen at d0 - t / r0 and d1 - t / r1,
// so it is a quadratic form of 1 / r0 and 1 / r1, whose three matrices are found by differences:
// central, in double precision, exact to 1e-6. [SJJ12] has closed forms.
void edgeBend(const glm::dvec3& d0, const glm::dvec3& d1, double scale, vec3 (&bend)[3]) {
    constexpr double kStep = 1e-3;
    const glm::dvec3 axes[2] = {{kStep, 0.0, 0.0}, {0.0, kStep, 0.0}};
    const double middle = edgeTerm(d0, d1);
    const auto second = [&](const glm::dvec3& u0, const glm::dvec3& u1) {
        return edgeTerm(d0 + u0, d1 + u1) + edgeTerm(d0 - u0, d1 - u1) - 2.0 * middle;
    };
    int k = 0;
    for (const auto& [i, j] : {std::pair(0, 0), std::pair(0, 1), std::pair(1, 1)}) {
        const glm::dvec3 u = 0.5 * (axes[i] + axes[j]);
        const glm::dvec3 v = 0.5 * (axes[i] - axes[j]);
        // The mixed derivative is the form at u less the form at v.
        const bool mixed = i != j;
        const auto form = [&](double w0, double w1) {
            return second(w0 * u, w1 * u) - (mixed ? second(w0 * v, w1 * v) : 0.0);
        };
        const double first = form(1.0, 0.0);
        const double last = form(0.0, 1.0);
        const double both = form(1.0, 1.0) - first - last;
        bend[0][k] += static_cast<float>(scale * first / (kStep * kStep));
        bend[1][k] += static_cast<float>(scale * both / (kStep * kStep));
        bend[2][k] += static_cast<float>(scale * last / (kStep * kStep));
        ++k;
    }
}

// Adds the arc d0-d1 to a wall whose normal points from direction a to direction b. [WH92]
void addArc(const vec3& d0, const vec3& d1, const vec3& a, const vec3& b, HemisphereWall& wall,
            vec3 (&bend)[3]) {
    const vec3 normal = glm::cross(d0, d1);
    const float sine = glm::length(normal);
    if (sine < 1e-9f) {
        return;
    }
    vec3 m = normal / sine;
    if (glm::dot(m, b - a) < 0.0f) {
        m = -m;
    }
    const float arc = std::atan2(sine, glm::dot(d0, d1));
    float cosine = 0.0f;
    for (int k = 0; k < kWallSteps; ++k) {
        const float t = (static_cast<float>(k) + 0.5f) / kWallSteps;
        cosine += glm::normalize(glm::mix(d0, d1, t)).z / kWallSteps;
    }
    wall.motion += arc * vec2(m);
    wall.cosine_motion += arc * std::max(cosine, 0.0f) * vec2(m);
    // The solid angle that passes from b to a grows with a's: its edge terms count walls whose
    // normal points inward.
    const double inward = glm::dot(normal, b - a) < 0.0f ? 1.0 : -1.0;
    edgeBend(glm::dvec3(d0), glm::dvec3(d1), inward, bend);
}

vec3 horizonBelow(const vec3& d) {
    const float length = std::sqrt(d.x * d.x + d.y * d.y);
    return {d.x / length, d.y / length, 0.0f};
}

// Projected onto the cube, corners are multiples of 2 / size: far from where rounding to 2^-14
// decides, so that two faces' corners, which differ in the last bits, agree.
uint64_t cornerKey(const vec3& d) {
    const vec3 on_cube = d / std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    const auto q = [](float v) { return static_cast<uint64_t>(std::lround(v * 16384.0f) + 16384); };
    return (q(on_cube.x) << 42) | (q(on_cube.y) << 21) | q(on_cube.z);
}

// An edge of a texel.
struct Edge {
    uint32_t texel;
    vec3 d0, d1;
    bool outer0, outer1;  // whether the corner lies on the stretched plane's outer boundary
};

// The wall between a texel and the one that an edge is of; which corners it has is not said.
HemisphereWall makeWall(const Hemisphere& h, uint32_t texel, const Edge& edge) {
    HemisphereWall wall{.a = texel, .b = edge.texel};
    const vec3& a = h.directions[wall.a];
    const vec3& b = h.directions[wall.b];
    addArc(edge.d0, edge.d1, a, b, wall, wall.cosine_bend);
    // A wall that ends on the stretched boundary goes on to the horizon, at the distance of the
    // corner it ends on.
    const auto extend = [&](const vec3& d, vec3& bend) {
        vec3 all[3] = {};
        addArc(d, horizonBelow(d), a, b, wall, all);
        bend += all[0] + all[1] + all[2];
    };
    if (edge.outer0) {
        extend(edge.d0, wall.cosine_bend[0]);
    }
    if (edge.outer1) {
        extend(edge.d1, wall.cosine_bend[2]);
    }
    return wall;
}

// Walls are the edges that two texels share, on one face or across two: corners are matched by
// direction. The outer edges of the whole layout belong to one texel only and are no walls.
void fillWalls(Hemisphere& h) {
    std::map<uint64_t, uint32_t> corners;
    const auto cornerOf = [&](uint64_t key) {
        return corners.try_emplace(key, static_cast<uint32_t>(corners.size())).first->second;
    };
    const bool stretched = h.params.kind == HemisphereKind::kBorder;
    std::map<std::pair<uint64_t, uint64_t>, Edge> open;
    for (int texel = 0; texel < h.texelCount(); ++texel) {
        int i = 0;
        int j = 0;
        const HemisphereFace& face = faceOf(h, texel, i, j);
        const TexelRect r = texelRect(face, i, j);
        const vec2 corners[] = {{r.u0, r.v0}, {r.u1, r.v0}, {r.u1, r.v1}, {r.u0, r.v1}};
        for (int k = 0; k < 4; ++k) {
            const vec2 c0 = corners[k];
            const vec2 c1 = corners[(k + 1) % 4];
            const auto outer = [stretched](const vec2& c) {
                return stretched && std::max(std::abs(c.x), std::abs(c.y)) > 1.0f - 1e-6f;
            };
            const Edge edge{static_cast<uint32_t>(texel), faceDirection(face, c0.x, c0.y),
                            faceDirection(face, c1.x, c1.y), outer(c0), outer(c1)};
            const uint64_t key0 = cornerKey(edge.d0);
            const uint64_t key1 = cornerKey(edge.d1);
            const std::pair key(std::min(key0, key1), std::max(key0, key1));
            const auto found = open.find(key);
            if (found == open.end()) {
                open.emplace(key, edge);
                continue;
            }
            HemisphereWall wall = makeWall(h, found->second.texel, edge);
            wall.corners[0] = cornerOf(key0);
            wall.corners[1] = cornerOf(key1);
            h.walls.push_back(wall);
            open.erase(found);
        }
    }
    h.corners = static_cast<int>(corners.size());
}

}  // namespace

std::vector<FootprintSample> footprint(const Hemisphere& h, int texel) {
    int i = 0;
    int j = 0;
    const HemisphereFace& face = faceOf(h, texel, i, j);
    const TexelRect r = texelRect(face, i, j);
    std::vector<FootprintSample> samples;
    // The plane of the face: its distance, and where the rectangle lies on it.
    const vec3 axis = glm::normalize(glm::cross(face.right, face.up));
    const float distance = std::abs(glm::dot(face.forward, axis));
    const float area = glm::length(glm::cross(face.right, face.up));
    const float du = (r.u1 - r.u0) / kFootprintSide;
    const float dv = (r.v1 - r.v0) / kFootprintSide;
    float sum = 0.0f;
    for (int y = 0; y < kFootprintSide; ++y) {
        for (int x = 0; x < kFootprintSide; ++x) {
            const vec3 d = face.forward +
                           (r.u0 + (static_cast<float>(x) + 0.5f) * du) * face.right +
                           (r.v0 + (static_cast<float>(y) + 0.5f) * dv) * face.up;
            const float length2 = glm::dot(d, d);
            const float solid_angle = area * du * dv * distance / (length2 * std::sqrt(length2));
            samples.push_back({d / std::sqrt(length2), solid_angle});
            sum += solid_angle;
        }
    }
    // Scale the pieces to the exact solid angle: foot point of the face's plane, closed form.
    const vec3 unit_right = glm::normalize(face.right);
    const vec3 unit_up = glm::normalize(face.up);
    const float cu = glm::dot(face.forward, unit_right) / distance;
    const float cv = glm::dot(face.forward, unit_up) / distance;
    const float su = glm::length(face.right) / distance;
    const float sv = glm::length(face.up) / distance;
    const float exact =
        shared::planeSolidAngle(cu + r.u0 * su, cv + r.v0 * sv, cu + r.u1 * su, cv + r.v1 * sv);
    for (FootprintSample& s : samples) {
        s.solid_angle *= exact / sum;
    }
    const auto index = static_cast<size_t>(texel);
    if (h.params.kind == HemisphereKind::kBorder && h.at_horizon[index] != 0) {
        appendStrip(face, h.azimuths[index], samples);
    }
    return samples;
}

Hemisphere makeHemisphere(const HemisphereParams& params) {
    SHEEN_CHECK(params.size >= 2 && params.extent > 0.0f);
    Hemisphere h;
    h.params = params;
    if (params.kind == HemisphereKind::kHemicube) {
        h.params.size += params.size % 2;  // the side faces are half as high
    }
    h.faces = makeFaces(h.params);
    h.width = h.params.size;
    h.height = h.faces.back().y + h.faces.back().height;
    fillTexels(h);
    fillWalls(h);
    return h;
}

}  // namespace sheen
