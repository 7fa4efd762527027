// Where a ray starts that leaves a surface: never behind another one that touches it there.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rays/ray_caster.h"
#include "test_scenes.h"

namespace sheen {
namespace {

// A dim room in a bright one, the whole of size 30; the dim one has its corners at coordinates of
// up to about 10.
struct Room {
    Scene scene;
    mat3 turn;
    static constexpr float kHalf = 6.0f;

    explicit Room(const mat3& turn) : turn(turn) {
        const uint32_t dim = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(0, 1, 0)));
        const uint32_t bright = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(1000, 0, 0)));
        addBox(scene, vec3(-kHalf), vec3(kHalf), dim, true);
        addBox(scene, vec3(-8.66f), vec3(8.66f), bright, true);
        scene.bounds = {};
        for (vec3& p : scene.positions) {
            p = turn * p;
            scene.bounds.add(p);
        }
    }
};

// p with each coordinate moved by an ulp down, not at all, or up.
vec3 nudged(vec3 p, int which) {
    for (int axis = 0; axis < 3; ++axis, which /= 3) {
        p[axis] = which % 3 == 1   ? std::nextafter(p[axis], kInfinity)
                  : which % 3 == 2 ? std::nextafter(p[axis], -kInfinity)
                                   : p[axis];
    }
    return p;
}

// Rays from a point in the corner of `walls` walls, as a point of any of them, meet the inside
// alone.
void expectInside(const Room& room, int walls, Random& random) {
    const RayCaster rays(room.scene);
    vec3 corner = random.point(-0.9f, 0.9f) * Room::kHalf;
    for (int i = 0; i < walls; ++i) {
        corner[i] = -Room::kHalf;
    }
    const vec3 viewer = random.point(-0.9f, 0.9f) * Room::kHalf;
    for (int which = 0; which < 27; ++which) {
        const vec3 p = nudged(room.turn * corner, which);
        const vec3 toward_viewer = glm::normalize(room.turn * viewer - p);
        for (int wall = 0; wall < walls; ++wall) {
            vec3 n_g(0.0f);
            n_g[wall] = 1.0f;
            const vec3 start = rays.origin(p, room.turn * n_g, toward_viewer);
            EXPECT_LT(glm::length(start - p), 1e-4f * room.scene.bounds.size());
            std::vector<vec3> directions;
            for (int i = 0; i < 24; ++i) {
                // The wall's hemisphere, half of it against the other walls.
                directions.push_back(room.turn * random.direction(n_g));
            }
            std::vector<vec4> seen(directions.size());
            rays.cast({.origin = start, .directions = directions}, seen.data());
            for (const vec4& v : seen) {
                EXPECT_EQ(vec3(v), vec3(0, 1, 0)) << "nudge " << which << " wall " << wall;
                EXPECT_GT(v.w, 0.0f);
            }
        }
    }
}

TEST(RayOrigin, InACornerItStartsInsideTheRoom) {
    Random random(6);
    expectInside(Room(mat3(1.0f)), 1, random);
    for (int trial = 0; trial < 15; ++trial) {
        const Room room(trial == 0 ? mat3(1.0f) : random.rotation());
        expectInside(room, 2, random);
        expectInside(room, 3, random);
    }
}

TEST(RayOrigin, SeenByNoOneItLeavesAlongTheNormal) {
    const Room room(mat3(1.0f));
    const vec3 start = RayCaster(room.scene).origin(vec3(1, 0, 2), vec3(0, 1, 0), vec3(0.0f));
    EXPECT_EQ(start.x, 1.0f);
    EXPECT_EQ(start.z, 2.0f);
    EXPECT_EQ(start.y, surfaceOffset(room.scene));
    EXPECT_GT(start.y, 0.0f);
}

}  // namespace
}  // namespace sheen
