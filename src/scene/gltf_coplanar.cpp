// Surfaces of different materials in one plane: found by hashing planes, then by sweeping the
// triangles of each.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>

#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

// In front by this much of the larger triangle's extent, but of no more than a few extents of the
// smaller one, or of the largest coordinate where both are: far more than depths and hits are off,
// too little to be seen.
constexpr double kFewExtents = 8.0;
constexpr double kLiftOverExtent = 1e-5;
constexpr double kLiftOverCoordinate = 0x1p-18;
// What is farther apart than a tenth of that is apart.
constexpr double kPlaneOverLift = 0.1;
// Pairs looked at in all. Only thousands of large triangles over each other have more.
constexpr int64_t kMostPairs = 20'000'000;

struct Keyed {
    uint64_t key;
    uint32_t triangle;
};

// A triangle in its plane.
struct Flat {
    uint32_t triangle;
    std::array<glm::dvec2, 3> corners;
    glm::dvec2 lower, upper;
    double extent, farthest;  // of its box, and the largest coordinate
};

// Two triangles over each other, by their numbers.
struct Pair {
    uint32_t later, earlier;
    double lift;
};

// Equal for planes that are equal but for rounding, facing one way. (Where rounding meets a cell's
// border they differ; the steps are odd so that round numbers do not lie there.)
uint64_t planeKey(const vec3& normal, double distance_over_size) {
    constexpr double kNormalStep = 1.0 / 97.3;
    constexpr double kDistanceStep = 1.0 / 9871.3;
    uint64_t key = 0;
    const auto add = [&key](double value) {
        const auto cell = static_cast<uint64_t>(std::llround(value));
        key = (key ^ cell) * 0x9e3779b97f4a7c15u;
        key ^= key >> 29;
    };
    for (int c = 0; c < 3; ++c) {
        add(normal[c] / kNormalStep);
    }
    add(distance_over_size / kDistanceStep);
    return key;
}

std::vector<Keyed> sortByPlane(const Scene& scene) {
    const vec3 center = scene.bounds.center();
    const double size = scene.bounds.size();
    std::vector<Keyed> keyed(scene.triangles.size());
    for (size_t i = 0; i < keyed.size(); ++i) {
        const vec3 normal = geometricNormal(scene, static_cast<int>(i));
        const glm::dvec3 from_center(scene.positions[scene.triangles[i].x] - center);
        keyed[i] = {planeKey(normal, glm::dot(glm::dvec3(normal), from_center) / size),
                    static_cast<uint32_t>(i)};
    }
    std::sort(keyed.begin(), keyed.end(), [](const Keyed& a, const Keyed& b) {
        return a.key != b.key ? a.key < b.key : a.triangle < b.triangle;
    });
    return keyed;
}

bool looksAlike(const Material& a, const Material& b) {
    return a.textures == b.textures && a.normal_texture == b.normal_texture &&
           a.coat_normal_texture == b.coat_normal_texture && a.unlit == b.unlit &&
           a.masked() == b.masked() && a.blended == b.blended && a.alpha == b.alpha &&
           std::memcmp(&a.params, &b.params, sizeof(a.params)) == 0 &&
           std::memcmp(&a.layers, &b.layers, sizeof(a.layers)) == 0;
}

// Whether two triangles share more than an edge: no edge's line parts them.
bool overlap(const Flat& a, const Flat& b) {
    constexpr double kEdge = 1e-3;  // of the narrower one's width
    for (const Flat* flat : {&a, &b}) {
        for (size_t i = 0; i < 3; ++i) {
            const glm::dvec2 edge = flat->corners[(i + 1) % 3] - flat->corners[i];
            const auto interval = [&](const Flat& of) {
                std::array<double, 3> at{};
                for (size_t c = 0; c < 3; ++c) {
                    at[c] = edge.x * of.corners[c].y - edge.y * of.corners[c].x;
                }
                return std::minmax({at[0], at[1], at[2]});
            };
            const auto [a_lower, a_upper] = interval(a);
            const auto [b_lower, b_upper] = interval(b);
            const double common = std::min(a_upper, b_upper) - std::max(a_lower, b_lower);
            if (!(common > kEdge * std::min(a_upper - a_lower, b_upper - b_lower))) {
                return false;
            }
        }
    }
    return true;
}

double liftBetween(const Flat& a, const Flat& b) {
    const auto [smaller, larger] = std::minmax(a.extent, b.extent);
    return std::max(kLiftOverExtent * std::min(larger, kFewExtents * smaller),
                    kLiftOverCoordinate * std::min(a.farthest, b.farthest));
}

// The triangles of one key.
class Group {
  public:
    Group(const Scene& scene, std::span<const Keyed> keyed) : scene_(scene) {
        normal_ = geometricNormal(scene, static_cast<int>(keyed.front().triangle));
        const glm::dvec3 size = glm::abs(normal_);
        const int axis = size.x > std::max(size.y, size.z) ? 0 : size.y > size.z ? 1 : 2;
        for (const Keyed& entry : keyed) {
            Flat flat{.triangle = entry.triangle,
                      .corners = {},
                      .lower = {},
                      .upper = {},
                      .extent = 0.0,
                      .farthest = 0.0};
            Bounds bounds;
            for (int c = 0; c < 3; ++c) {
                const vec3& p = scene.positions[scene.triangles[entry.triangle][c]];
                flat.corners[static_cast<size_t>(c)] = {p[(axis + 1) % 3], p[(axis + 2) % 3]};
                bounds.add(p);
            }
            const auto& [p, q, r] = flat.corners;
            flat.lower = glm::min(p, glm::min(q, r));
            flat.upper = glm::max(p, glm::max(q, r));
            flat.extent = bounds.size();
            flat.farthest = std::max(maxAbs(bounds.lower), maxAbs(bounds.upper));
            flats_.push_back(flat);
        }
        std::sort(flats_.begin(), flats_.end(), [](const Flat& a, const Flat& b) {
            return a.lower.x != b.lower.x ? a.lower.x < b.lower.x : a.triangle < b.triangle;
        });
    }

    const glm::dvec3& normal() const { return normal_; }

    // Appends what lies over each other, looking at no more than `pairs_left` pairs.
    void findPairs(std::vector<Pair>& pairs, int64_t& pairs_left) const {
        for (size_t i = 0; i < flats_.size(); ++i) {
            for (size_t j = i + 1;
                 j < flats_.size() && flats_[j].lower.x < flats_[i].upper.x && pairs_left > 0;
                 ++j) {
                --pairs_left;
                const double lift = liftBetween(flats_[i], flats_[j]);
                if (coincide(flats_[i], flats_[j], lift)) {
                    const auto [earlier, later] =
                        std::minmax(flats_[i].triangle, flats_[j].triangle);
                    pairs.push_back({later, earlier, lift});
                }
            }
        }
    }

  private:
    bool coincide(const Flat& a, const Flat& b, double lift) const {
        if (a.lower.y >= b.upper.y || b.lower.y >= a.upper.y ||
            looksAlike(scene_.materials[scene_.materials_of[a.triangle]],
                       scene_.materials[scene_.materials_of[b.triangle]])) {
            return false;
        }
        const glm::dvec3 origin(scene_.positions[scene_.triangles[a.triangle].x]);
        const glm::dvec3 normal(geometricNormal(scene_, static_cast<int>(a.triangle)));
        for (int c = 0; c < 3; ++c) {
            const glm::dvec3 p(scene_.positions[scene_.triangles[b.triangle][c]]);
            if (std::abs(glm::dot(normal, p - origin)) > kPlaneOverLift * lift) {
                return false;
            }
        }
        return overlap(a, b);
    }

    const Scene& scene_;
    glm::dvec3 normal_;
    std::vector<Flat> flats_;
};

using Lifts = std::map<uint32_t, vec3>;  // of vertices

// Adds what lifts each later triangle's vertices along the normal: over those lifted ones it
// covers, by no less than these.
void liftLater(const Scene& scene, std::vector<Pair> pairs, const glm::dvec3& normal,
               Lifts& lifts) {
    std::sort(pairs.begin(), pairs.end(),
              [](const Pair& a, const Pair& b) { return a.later < b.later; });
    struct Layer {
        double step = 0.0, height = 0.0;
    };
    std::map<uint32_t, Layer> layers;           // of triangles
    std::map<uint32_t, double> vertex_heights;  // the most of a vertex's triangles
    for (const Pair& pair : pairs) {
        const auto found = layers.find(pair.earlier);
        const Layer below = found == layers.end() ? Layer{} : found->second;
        Layer& own = layers[pair.later];
        own.step = std::max({own.step, pair.lift, below.step});
        own.height = std::max(own.height, below.height + own.step);
        for (int c = 0; c < 3; ++c) {
            double& vertex = vertex_heights[scene.triangles[pair.later][c]];
            vertex = std::max(vertex, own.height);
        }
    }
    for (const auto& [vertex, height] : vertex_heights) {
        lifts[vertex] += vec3(height * normal);
    }
}

// Moves vertices, unless that would leave a triangle without area, as where one is thinner than a
// step is high; false then.
bool moveVertices(const Lifts& lifts, Scene& scene) {
    const std::vector<vec3> before = scene.positions;
    for (const auto& [vertex, lift] : lifts) {
        scene.positions[vertex] += lift;
    }
    for (int i = 0; i < scene.triangleCount(); ++i) {
        const vec3 normal = geometricNormal(scene, i);
        if (!(std::abs(glm::dot(normal, normal) - 1.0f) < 1e-3f)) {
            scene.positions = before;
            return false;
        }
    }
    for (const auto& [vertex, lift] : lifts) {
        scene.bounds.add(scene.positions[vertex]);
    }
    return true;
}

bool hasOneMaterial(const Scene& scene, std::span<const Keyed> keyed) {
    return std::all_of(keyed.begin(), keyed.end(), [&](const Keyed& entry) {
        return scene.materials_of[entry.triangle] == scene.materials_of[keyed.front().triangle];
    });
}

}  // namespace

void separateCoplanar(File& file, Scene& scene) {
    if (scene.triangles.empty() || !(scene.bounds.size() > 0.0f)) {
        return;
    }
    const std::vector<Keyed> keyed = sortByPlane(scene);
    int64_t pairs_left = kMostPairs;
    Lifts lifts;
    std::vector<Pair> firsts;  // of each plane
    for (auto first = keyed.begin(); first != keyed.end();) {
        const auto end = std::find_if(first, keyed.end(),
                                      [&](const Keyed& entry) { return entry.key != first->key; });
        const std::span<const Keyed> plane(first, end);
        first = end;
        if (hasOneMaterial(scene, plane)) {
            continue;
        }
        const Group group(scene, plane);
        std::vector<Pair> pairs;
        group.findPairs(pairs, pairs_left);
        if (pairs.empty()) {
            continue;
        }
        firsts.push_back(pairs.front());
        liftLater(scene, pairs, group.normal(), lifts);
    }
    const bool lifted = !lifts.empty() && moveVertices(lifts, scene);
    for (const Pair& pair : firsts) {
        const auto name = [&](uint32_t triangle) {
            return scene.materials[scene.materials_of[triangle]].name;
        };
        file.notes.add(fmt::format(
            "surfaces of materials '{}' and '{}' lie in one plane{}; move them apart",
            name(pair.earlier), name(pair.later), lifted ? ": the latter is put in front" : ""));
    }
}

}  // namespace sheen::gltf
