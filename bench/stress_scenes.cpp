#include "stress_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "test_scenes.h"

namespace sheen {
namespace {

// Numbers that are the same whatever the standard library: only the engine's bits are specified.
class Dice {
  public:
    explicit Dice(uint32_t seed) : engine_(seed) {}
    float uniform(float low, float high) {
        return low + (high - low) * static_cast<float>(engine_() >> 8) * 0x1p-24f;
    }
    float logUniform(float low, float high) {
        return std::exp(uniform(std::log(low), std::log(high)));
    }
    bool chance(float p) { return uniform(0.0f, 1.0f) < p; }
    int below(int n) { return static_cast<int>(engine_() % static_cast<uint32_t>(n)); }
    vec3 inBox(const vec3& lower, const vec3& upper) {
        const float x = uniform(lower.x, upper.x);
        const float y = uniform(lower.y, upper.y);
        return {x, y, uniform(lower.z, upper.z)};
    }
    vec3 direction() {
        const float z = uniform(-1.0f, 1.0f);
        const float phi = uniform(0.0f, 2.0f * kPi);
        const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
        return {r * std::cos(phi), r * std::sin(phi), z};
    }
    mat3 rotation() {
        const vec3 x = direction();
        const vec3 y = glm::normalize(glm::cross(x, direction()));
        return {x, y, glm::cross(x, y)};
    }

  private:
    std::mt19937 engine_;
};

enum class Setting { kRoom, kRoofless, kGround };

class Maker {
  public:
    explicit Maker(uint32_t seed) : dice_(seed) {}
    StressScene make();

  private:
    void addSetting();
    void addObject();
    void addPartition(bool solid);
    void addSteps(const vec3& foot);
    void addShell(const vec3& centre, float size);
    void addLight();
    void addCamera();
    MaterialParams randomMaterial();
    uint32_t anyMaterial() { return static_cast<uint32_t>(dice_.below(materials_)); }
    vec3 onFloor() {
        const vec3 p = dice_.inBox(-0.9f * half_, 0.9f * half_);
        return {p.x, -half_.y, p.z};
    }
    vec3 color() { return dice_.inBox(vec3(0.05f), vec3(0.9f)); }
    // Puts what was added since a vertex and a triangle at m p + t; a mirroring m keeps fronts.
    void transform(size_t vertex, size_t triangle, const mat3& m, const vec3& t);

    Dice dice_;
    StressScene made_;
    Setting setting_ = Setting::kRoom;
    vec3 half_{1.0f};  // of the room; the floor is at -half_.y
    int materials_ = 0;
    std::vector<vec3> centres_;  // of objects, to look at or into
};

MaterialParams Maker::randomMaterial() {
    const float kind = dice_.uniform(0.0f, 1.0f);
    if (kind < 0.5f) {
        return diffuseParams(color());
    }
    // Both ends of the range are as likely as a place in between.
    const float r = dice_.uniform(-0.15f, 1.15f);
    const float roughness = std::min(std::max(r, 0.0f), 1.0f);
    const float metallic = kind < 0.72f ? 0.0f : (kind < 0.95f ? 1.0f : 0.5f);
    return glossyParams(color(), metallic, roughness);
}

void Maker::transform(size_t vertex, size_t triangle, const mat3& m, const vec3& t) {
    Scene& scene = made_.scene;
    const mat3 of_normals = glm::transpose(glm::inverse(m));
    for (size_t v = vertex; v < scene.positions.size(); ++v) {
        scene.positions[v] = m * scene.positions[v] + t;
        scene.normals[v] = glm::normalize(of_normals * scene.normals[v]);
    }
    if (glm::determinant(m) < 0.0f) {
        for (size_t k = triangle; k < scene.triangles.size(); ++k) {
            std::swap(scene.triangles[k].y, scene.triangles[k].z);
        }
    }
}

void Maker::addSetting() {
    const float kind = dice_.uniform(0.0f, 1.0f);
    setting_ = kind < 0.6f ? Setting::kRoom : kind < 0.75f ? Setting::kRoofless : Setting::kGround;
    half_ = dice_.inBox(vec3(0.6f), vec3(1.6f));
    Scene& scene = made_.scene;
    if (setting_ == Setting::kGround) {
        half_ *= vec3(1.5f, 1.0f, 1.5f);
        addQuad(scene, vec3(-half_.x, -half_.y, half_.z), vec3(2.0f * half_.x, 0, 0),
                vec3(0, 0, -2.0f * half_.z), anyMaterial());
        made_.what += "ground";
        return;
    }
    std::array<uint32_t, 6> walls;
    for (uint32_t& wall : walls) {
        wall = anyMaterial();
    }
    addBox(scene, -half_, half_, walls, true);
    if (setting_ == Setting::kRoofless) {
        // The +y face was added fourth, as two triangles.
        scene.triangles.erase(scene.triangles.begin() + 6, scene.triangles.begin() + 8);
        scene.materials_of.erase(scene.materials_of.begin() + 6, scene.materials_of.begin() + 8);
    }
    made_.what += setting_ == Setting::kRoom ? "room" : "roofless";
}

// A wall across the room, all the way or part of it; without thickness or nearly so.
void Maker::addPartition(bool solid) {
    Scene& scene = made_.scene;
    const uint32_t m = anyMaterial();
    const float x = dice_.uniform(-0.7f, 0.7f) * half_.x;
    const float top = dice_.chance(0.5f) ? half_.y : dice_.uniform(-0.6f, 0.6f) * half_.y;
    const float end = dice_.chance(0.4f) ? half_.z : dice_.uniform(-0.5f, 0.8f) * half_.z;
    // Standing on the floor, sunk into it, or just above it.
    const float gap = dice_.chance(0.6f)   ? 0.0f
                      : dice_.chance(0.5f) ? -0.05f
                                           : dice_.logUniform(1e-4f, 1e-2f);
    const vec3 lower(x, -half_.y + gap, -half_.z);
    const float thickness = dice_.logUniform(1e-5f, 5e-2f);
    if (solid) {
        addBox(scene, lower, vec3(x + thickness, top, end), m, false);
        made_.what += fmt::format(" wall:{:.0e}", thickness);
    } else {
        addQuad(scene, lower, vec3(0, top - lower.y, 0), vec3(0, 0, end - lower.z), m);
        made_.what += " sheet";
    }
    if (dice_.chance(0.3f)) {
        // Turned about the vertical: its ends pierce the room's walls or stand free.
        const float angle = dice_.uniform(0.0f, 2.0f * kPi);
        const mat3 turn(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0,
                        std::cos(angle));
        const size_t vertices = solid ? 24 : 4;
        const size_t triangles = solid ? 12 : 2;
        transform(scene.positions.size() - vertices, scene.triangles.size() - triangles, turn,
                  vec3(0.0f));
    }
    centres_.push_back(vec3(x, 0.5f * (lower.y + top), 0.5f * (lower.z + end)));
}

void Maker::addSteps(const vec3& foot) {
    const float height = dice_.logUniform(1e-3f, 0.1f);
    const float depth = dice_.uniform(0.02f, 0.15f);
    const float width = dice_.uniform(0.2f, 0.8f);
    const uint32_t m = anyMaterial();
    const int count = 2 + dice_.below(4);
    for (int k = 0; k < count; ++k) {
        // Faces of neighbouring steps coincide.
        const float z = foot.z + static_cast<float>(k) * depth;
        addBox(made_.scene, vec3(foot.x, foot.y, z),
               vec3(foot.x + width, foot.y + static_cast<float>(k + 1) * height, z + depth), m,
               false);
    }
    made_.what += fmt::format(" steps:{:.0e}", height);
    centres_.push_back(foot + vec3(0.5f * width, height, depth));
}

// A box without one face, of no thickness: light and camera may be inside.
void Maker::addShell(const vec3& centre, float size) {
    Scene& scene = made_.scene;
    const size_t triangle = scene.triangles.size();
    addBox(scene, centre - size, centre + size, anyMaterial(), dice_.chance(0.5f));
    const auto face = static_cast<std::ptrdiff_t>(triangle) + 2 * dice_.below(6);
    scene.triangles.erase(scene.triangles.begin() + face, scene.triangles.begin() + face + 2);
    scene.materials_of.erase(scene.materials_of.begin() + face,
                             scene.materials_of.begin() + face + 2);
    made_.what += " shell";
    centres_.push_back(centre);
}

// Long, since it lists all kinds of objects: the order of its throws is the scenes'.
void Maker::addObject() {
    Scene& scene = made_.scene;
    const size_t vertex = scene.positions.size();
    const size_t triangle = scene.triangles.size();
    const vec3 size = vec3(dice_.logUniform(0.02f, 0.5f)) * dice_.inBox(vec3(0.4f), vec3(1.0f));
    const vec3 floor = onFloor();
    switch (dice_.below(11)) {
        case 0:  // on the floor, exactly or nearly
        case 1: {
            const float gap = dice_.chance(0.5f) ? 0.0f : dice_.logUniform(1e-5f, 1e-2f);
            const vec3 lower = floor + vec3(0, gap, 0);
            addBox(scene, lower, lower + 2.0f * size, anyMaterial(), false);
            made_.what += fmt::format(" box:{:.0e}", gap);
            centres_.push_back(lower + size);
            break;
        }
        case 2: {  // in a corner: three faces coincide with the room's
            addBox(scene, -half_, -half_ + 2.0f * size, anyMaterial(), false);
            made_.what += " corner-box";
            centres_.push_back(-half_ + size);
            break;
        }
        case 3: {  // anyhow, through the floor or another object
            const vec3 centre =
                centres_.empty() || dice_.chance(0.5f)
                    ? floor
                    : centres_[static_cast<size_t>(dice_.below(static_cast<int>(centres_.size())))];
            addBox(scene, -size, size, anyMaterial(), false);
            transform(vertex, triangle, dice_.rotation(), centre);
            made_.what += " sunk-box";
            centres_.push_back(centre);
            break;
        }
        case 4: {  // mirrored and sheared
            addSphere(scene, vec3(0.0f), 1.0f, 6 + dice_.below(8), anyMaterial());
            mat3 m = dice_.rotation() * mat3(size.x, 0, 0, dice_.uniform(-1.0f, 1.0f) * size.y,
                                             size.y, 0, 0, 0, dice_.uniform(0.1f, 1.0f) * size.z);
            if (dice_.chance(0.5f)) {
                m[0] = -m[0];
            }
            const vec3 centre = dice_.inBox(-0.8f * half_, 0.5f * half_);
            transform(vertex, triangle, m, centre);
            made_.what += " ellipsoid";
            centres_.push_back(centre);
            break;
        }
        case 5: {  // on or in the floor
            const float radius = size.x;
            const vec3 centre = floor + vec3(0, dice_.chance(0.5f) ? radius : 0.0f, 0);
            addSphere(scene, centre, radius, 6 + dice_.below(10), anyMaterial());
            made_.what += " sphere";
            centres_.push_back(centre);
            break;
        }
        case 6:
            addPartition(false);
            break;
        case 7:
            addPartition(true);
            break;
        case 8:
            addSteps(floor);
            break;
        case 9:
            addShell(dice_.inBox(-0.7f * half_, 0.7f * half_), size.x);
            break;
        default: {  // crumbs and slivers
            const uint32_t m = anyMaterial();
            for (int k = 0; k < 5; ++k) {
                const vec3 at =
                    floor + vec3(0.1f * dice_.direction().x, 0, 0.1f * dice_.uniform(-1, 1));
                const vec3 s(dice_.logUniform(1e-3f, 0.03f), dice_.logUniform(1e-3f, 0.03f),
                             dice_.logUniform(1e-3f, 0.3f));
                addBox(scene, at, at + s, m, false);
            }
            made_.what += " crumbs";
            centres_.push_back(floor);
            break;
        }
    }
}

void Maker::addLight() {
    Scene& scene = made_.scene;
    const float size = std::min({half_.x, half_.y, half_.z});
    vec3 p = dice_.inBox(-0.9f * half_, 0.9f * half_);
    if (dice_.chance(0.25f)) {  // close to a wall, the floor or the ceiling
        const int axis = setting_ == Setting::kGround ? 1 : dice_.below(3);
        const float side = axis == 1 && setting_ != Setting::kRoom ? -1.0f
                           : dice_.chance(0.5f)                    ? 1.0f
                                                                   : -1.0f;
        p[axis] = side * (half_[axis] - size * dice_.logUniform(1e-3f, 0.1f));
        made_.what += " near-";
    } else {
        made_.what += " ";
    }
    const vec3 tint = dice_.inBox(vec3(0.5f), vec3(1.0f)) * dice_.logUniform(0.3f, 3.0f);
    const float kind = dice_.uniform(0.0f, 1.0f);
    PunctualLight light = pointLight(p, tint * size * size);
    if (kind < 0.3f && setting_ != Setting::kRoom) {
        vec3 direction = dice_.direction();
        direction.y = -std::abs(direction.y) - 0.05f;
        light = directionalLight(direction, tint);
        made_.what += "sun";
    } else if (kind < 0.6f) {
        const float outer = dice_.uniform(0.1f, 1.5f);
        light = spotLight(p, dice_.direction(), 3.0f * tint * size * size,
                          outer * dice_.uniform(0.0f, 1.0f), outer);
        made_.what += "spot";
    } else {
        light.inverse_range = dice_.chance(0.1f) ? 1.0f / dice_.uniform(0.5f, 3.0f) : 0.0f;
        made_.what += "point";
    }
    scene.lights.push_back(light);
    scene.light_names.push_back(fmt::format("light {}", scene.lights.size()));
}

void Maker::addCamera() {
    const auto someCentre = [&] {
        return centres_[static_cast<size_t>(dice_.below(static_cast<int>(centres_.size())))];
    };
    vec3 eye = dice_.inBox(-0.95f * half_, 0.95f * half_);
    vec3 target = dice_.chance(0.7f) ? someCentre() : onFloor();
    const float kind = dice_.uniform(0.0f, 1.0f);
    if (kind < 0.15f) {
        eye.y = -half_.y + dice_.logUniform(1e-3f, 0.05f);  // along the floor
        target.y = eye.y - dice_.uniform(0.0f, 0.1f);
        made_.what += " grazing";
    } else if (kind < 0.22f) {
        // Off the planes that many centres lie in: what is seen from within a plane is anyone's.
        eye = someCentre() + 0.01f * dice_.direction();
        target = eye + dice_.direction();
        made_.what += " inside";
    } else if (kind < 0.35f) {
        eye = someCentre() + 0.1f * dice_.direction();
        made_.what += " close";
    } else if (setting_ == Setting::kGround) {
        eye.y = dice_.uniform(-0.5f, 1.5f) * half_.y;
    }
    if (glm::length(eye - target) < 1e-3f) {
        target = eye + dice_.direction();
    }
    Camera camera = lookAt(eye, target);
    camera.y_fov = dice_.uniform(0.3f, 1.9f);
    made_.scene.cameras.push_back(camera);
}

StressScene Maker::make() {
    Scene& scene = made_.scene;
    materials_ = 3 + dice_.below(5);
    for (int k = 0; k < materials_; ++k) {
        addMaterial(scene, randomMaterial());
    }
    addSetting();
    const int objects = 3 + dice_.below(7);
    for (int k = 0; k < objects; ++k) {
        addObject();
    }
    if (dice_.chance(0.15f)) {  // one of the objects' materials glows
        const vec3 at = dice_.inBox(-0.8f * half_, 0.8f * half_);
        const float edge = dice_.logUniform(0.01f, 0.3f);
        const float nits = dice_.logUniform(0.5f, 20.0f);
        addBox(scene, at, at + edge, addMaterial(scene, diffuseParams(color(), vec3(nits))), false);
        made_.what += fmt::format(" lamp:{:.2f}", edge);
    }
    const int lights = 1 + dice_.below(3);
    for (int k = 0; k < lights; ++k) {
        addLight();
    }
    addCamera();
    // Far from the origin positions are coarser.
    const vec3 away = dice_.chance(0.15f) ? 5.0f * dice_.direction() : vec3(0.0f);
    scene.bounds = {};
    for (vec3& p : scene.positions) {
        p += away;
        scene.bounds.add(p);
    }
    for (PunctualLight& light : scene.lights) {
        light.position += away;
    }
    scene.cameras[0].world_from_camera[3] += vec4(away, 0.0f);
    const float scale = dice_.logUniform(1e-3f, 1e4f);
    scene = scaled(std::move(scene), scale);
    made_.what += fmt::format("{} x{:.0e}", away == vec3(0.0f) ? "" : " away", scale);
    return std::move(made_);
}

}  // namespace

StressScene stressScene(uint32_t seed) { return Maker(seed).make(); }

}  // namespace sheen
