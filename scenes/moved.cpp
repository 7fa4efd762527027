#include "scenes/moved.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace sheen::scenes {
namespace {

constexpr double kLeastMove = 0.025, kMostMove = 0.05;  // of the scene's size
constexpr double kLeastTurn = 2.5 * kDegree, kMostTurn = 5.0 * kDegree;
constexpr double kKeptRoom = 0.5;  // of the distance to the nearest surface, as it was
constexpr int kImage = 24;         // rays along a side of a camera's image
constexpr int kAround = 200;       // rays that look for the nearest surface
constexpr int kMostCandidates = 10000;
constexpr double kFar = std::numeric_limits<double>::infinity();

// PCG-XSH-RR, 64 bits of state [O'Neill 2014, "PCG"]. The standard library's distributions differ
// between implementations.
class Random {
  public:
    Random(uint32_t seed, uint32_t stream) : increment_(2 * uint64_t{stream} + 1) {
        next();
        state_ += seed;
        next();
    }
    double uniform(double low, double high) { return low + (high - low) * (next() * 0x1p-32); }
    dvec3 direction() {
        const double z = uniform(-1.0, 1.0);
        const double phi = uniform(0.0, 2.0 * kPi);
        const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
        return {r * std::cos(phi), r * std::sin(phi), z};
    }

  private:
    uint32_t next() {
        const uint64_t old = state_;
        state_ = old * 6364136223846793005u + increment_;
        const auto shifted = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
        const auto rotation = static_cast<uint32_t>(old >> 59);
        return (shifted >> rotation) | (shifted << ((32 - rotation) % 32));
    }

    uint64_t state_ = 0;
    uint64_t increment_;
};

// All triangles of a model, for some thousand rays.
class Surfaces {
  public:
    explicit Surfaces(const Model& model) {
        dvec3 lower(kFar);
        dvec3 upper(-kFar);
        for (const Object& object : model.objects) {
            for (const dmat4& placement : object.placements) {
                Part part;
                dvec3 part_lower(kFar);
                dvec3 part_upper(-kFar);
                std::vector<dvec3> positions;
                for (const dvec3& p : object.mesh.positions) {
                    positions.emplace_back(placement * glm::dvec4(p, 1.0));
                    part_lower = glm::min(part_lower, positions.back());
                    part_upper = glm::max(part_upper, positions.back());
                }
                for (size_t i = 0; i < object.mesh.indices.size(); i += 3) {
                    const uint32_t* v = &object.mesh.indices[i];
                    const dvec3& p = positions[v[0]];
                    part.triangles.push_back({p, positions[v[1]] - p, positions[v[2]] - p});
                }
                part.center = 0.5 * (part_lower + part_upper);
                part.radius = 0.5 * glm::length(part_upper - part_lower);
                lower = glm::min(lower, part_lower);
                upper = glm::max(upper, part_upper);
                parts_.push_back(std::move(part));
            }
        }
        size_ = glm::length(upper - lower);
    }
    double size() const { return size_; }

    // How far a ray goes before it meets a surface; direction is unit.
    double distance(const dvec3& origin, const dvec3& direction) const {
        double nearest = kFar;
        for (const Part& part : parts_) {
            // Does the ray's line pass the part's bounding sphere?
            const dvec3 to_center = part.center - origin;
            if (glm::length(glm::cross(to_center, direction)) > 1.001 * part.radius) {
                continue;
            }
            for (const Triangle& t : part.triangles) {
                nearest = std::min(nearest, distance(t, origin, direction));
            }
        }
        return nearest;
    }

    // About how far the nearest surface is, in any direction.
    double room(const dvec3& p) const {
        double nearest = kFar;
        for (int i = 0; i < kAround; ++i) {
            // A spiral of equal areas.
            const double z = 1.0 - (2.0 * i + 1.0) / kAround;
            const double phi = kPi * (3.0 - std::sqrt(5.0)) * i;
            const double r = std::sqrt(1.0 - z * z);
            nearest = std::min(nearest, distance(p, {r * std::cos(phi), r * std::sin(phi), z}));
        }
        return nearest;
    }

  private:
    struct Triangle {
        dvec3 p, e1, e2;
    };
    struct Part {
        std::vector<Triangle> triangles;
        dvec3 center;
        double radius;
    };

    // Moeller-Trumbore
    static double distance(const Triangle& t, const dvec3& origin, const dvec3& direction) {
        const dvec3 s = glm::cross(direction, t.e2);
        const double det = glm::dot(t.e1, s);
        if (det == 0.0) {
            return kFar;
        }
        const dvec3 to_origin = origin - t.p;
        const double b1 = glm::dot(to_origin, s) / det;
        const dvec3 q = glm::cross(to_origin, t.e1);
        const double b2 = glm::dot(direction, q) / det;
        const double along = glm::dot(t.e2, q) / det;
        return b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 && along > 0.0 ? along : kFar;
    }

    std::vector<Part> parts_;
    double size_ = 0.0;
};

// Where something stands and what it is turned to.
struct Pose {
    dvec3 position;
    dvec3 target;
};

Pose movedPose(const Pose& pose, bool also_placed, double size, Random& random) {
    const dvec3 view = pose.target - pose.position;
    const dvec3 w = glm::normalize(view);
    const dvec3 u =
        glm::normalize(glm::cross(w, std::abs(w.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(1, 0, 0)));
    const dvec3 v = glm::cross(w, u);
    const double turn = random.uniform(kLeastTurn, kMostTurn);
    const double phi = random.uniform(0.0, 2.0 * kPi);
    const dvec3 turned =
        w * std::cos(turn) + (u * std::cos(phi) + v * std::sin(phi)) * std::sin(turn);
    const double way = random.uniform(kLeastMove, kMostMove) * size;
    const dvec3 move = way * random.direction();
    const dvec3 position = also_placed ? pose.position + move : pose.position;
    return {position, position + glm::length(view) * turned};
}

// Whether a pose is in the free space where another one is, and has about its room.
bool staysFree(const Surfaces& surfaces, const Pose& from, const Pose& to, double least_room) {
    const dvec3 way = to.position - from.position;
    const double length = glm::length(way);
    return surfaces.distance(from.position, way / length) > length &&
           surfaces.room(to.position) >= least_room;
}

// What a camera's square image shows: share of surface, and how near the nearest one is.
struct Sight {
    double seen = 0.0;
    double nearest = kFar;
};

Sight sightOf(const Surfaces& surfaces, const Pose& pose, double y_fov) {
    const dvec3 w = glm::normalize(pose.target - pose.position);
    const dvec3 right = glm::normalize(glm::cross(w, dvec3(0, 1, 0)));
    const dvec3 up = glm::cross(right, w);
    const double half = std::tan(0.5 * y_fov);
    Sight sight;
    for (int y = 0; y < kImage; ++y) {
        for (int x = 0; x < kImage; ++x) {
            const double a = (2.0 * x + 1.0) / kImage - 1.0;
            const double b = (2.0 * y + 1.0) / kImage - 1.0;
            const double d =
                surfaces.distance(pose.position, glm::normalize(w + half * (a * right + b * up)));
            sight.seen += d < kFar ? 1.0 / (kImage * kImage) : 0.0;
            sight.nearest = std::min(sight.nearest, d);
        }
    }
    return sight;
}

// The first of the seed's poses that will do.
template <class WillDo>
Pose firstThat(const WillDo& will_do, const Pose& pose, bool also_placed, double size,
               Random random) {
    for (int i = 0; i < kMostCandidates; ++i) {
        const Pose candidate = movedPose(pose, also_placed, size, random);
        if (will_do(candidate)) {
            return candidate;
        }
    }
    throw std::logic_error("a camera or light has no room to move");
}

}  // namespace

Model moved(Model model, uint32_t seed) {
    SHEEN_CHECK(seed >= 1 && !model.cameras.empty());
    const Surfaces surfaces(model);
    CameraSpec& camera = model.cameras.front();
    const Pose eye{camera.position, camera.target};
    const double eye_room = kKeptRoom * surfaces.room(eye.position);
    const double eye_nearest = kKeptRoom * sightOf(surfaces, eye, camera.y_fov).nearest;
    const Pose new_eye = firstThat(
        [&](const Pose& to) {
            if (!staysFree(surfaces, eye, to, eye_room)) {
                return false;
            }
            const Sight sight = sightOf(surfaces, to, camera.y_fov);
            return sight.seen >= kSeenShare && sight.nearest >= eye_nearest;
        },
        eye, true, surfaces.size(), Random(seed, 0));
    camera.position = new_eye.position;
    camera.target = new_eye.target;

    for (size_t i = 0; i < model.lights.size(); ++i) {
        LightSpec& light = model.lights[i];
        const Pose lamp{light.position, light.target};
        const bool is_placed = light.type != "directional";
        const double lamp_room = is_placed ? kKeptRoom * surfaces.room(lamp.position) : 0.0;
        const Pose new_lamp = firstThat(
            [&](const Pose& to) { return !is_placed || staysFree(surfaces, lamp, to, lamp_room); },
            lamp, is_placed, surfaces.size(), Random(seed, static_cast<uint32_t>(i) + 1));
        light.position = new_lamp.position;
        light.target = new_lamp.target;
    }
    return model;
}

}  // namespace sheen::scenes
