// Where a ray starts that leaves a surface: never behind another one that touches it there.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rays/surface_point.h"
#include "rays/tracer.h"
#include "test_scenes.h"

namespace sheen {
namespace {

// A room in another one, whose size decides nothing. The inner one has its corners at
// coordinates of up to about 10.
struct Room {
    Scene scene;
    mat3 turn;
    static constexpr float kHalf = 6.0f;
    static constexpr uint32_t kInside = 0;  // material

    Room(const mat3& turn, float outer_half) : turn(turn) {
        const uint32_t inside = addMaterial(scene, diffuseParams(vec3(0.5f)));
        const uint32_t outside = addMaterial(scene, diffuseParams(vec3(0.5f)));
        EXPECT_EQ(inside, kInside);
        addBox(scene, vec3(-kHalf), vec3(kHalf), inside, true);
        addBox(scene, vec3(-outer_half), vec3(outer_half), outside, true);
        scene.bounds = {};
        for (vec3& p : scene.positions) {
            p = turn * p;
            scene.bounds.add(p);
        }
    }
    // The first triangle of the wall at -kHalf on an axis: addBox() makes walls in pairs.
    static uint32_t wallTriangle(int axis) { return static_cast<uint32_t>(4 * axis); }
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
    const Tracer tracer(room.scene);
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
            const vec3 normal = room.turn * n_g;
            const float offset = surfaceOffset(room.scene, Room::wallTriangle(wall), p, normal,
                                               glm::length(room.turn * viewer - p));
            const vec3 start = offSurface(p, normal, toward_viewer, offset);
            EXPECT_LT(glm::length(start - p), 1e-4f * Room::kHalf);
            std::vector<vec3> directions;
            for (int i = 0; i < 24; ++i) {
                // The wall's hemisphere, half of it against the other walls.
                directions.push_back(room.turn * random.direction(n_g));
            }
            std::vector<Hit> hits(directions.size());
            tracer.meet({.origin = start, .directions = directions}, hits.data());
            for (const Hit& hit : hits) {
                ASSERT_TRUE(hit.found());
                EXPECT_EQ(room.scene.materials_of[hit.triangle], Room::kInside)
                    << "nudge " << which << " wall " << wall;
            }
        }
    }
}

TEST(RayOrigin, InACornerItStartsInsideTheRoom) {
    Random random(6);
    for (const float outer_half : {8.66f, 1e5f}) {
        expectInside(Room(mat3(1.0f), outer_half), 1, random);
        for (int trial = 0; trial < 15; ++trial) {
            const Room room(trial == 0 ? mat3(1.0f) : random.rotation(), outer_half);
            expectInside(room, 2, random);
            expectInside(room, 3, random);
        }
    }
}

TEST(RayOrigin, SeenByNoOneItLeavesAlongTheNormal) {
    const vec3 start = offSurface(vec3(1, 0, 2), vec3(0, 1, 0), vec3(0.0f), 1e-5f);
    EXPECT_EQ(start, vec3(1, 1e-5f, 2));
}

// A point as surfacePoint() has it, of triangles of any size and tilt: rays that leave it meet
// nothing of a plane, which two triangles share.
TEST(RayOrigin, OffItsOwnPlaneWhateverItsSize) {
    Random random(7);
    for (const float size : {1e-3f, 1.0f, 1e3f, 1e6f}) {
        for (int trial = 0; trial < 200; ++trial) {
            Scene scene;
            const mat3 turn = random.rotation();
            const uint32_t material = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(1.0f)));
            const vec3 place = random.point(-10.0f, 10.0f);
            addQuad(scene, place - size * (turn[0] + turn[1]), 2.0f * size * turn[0],
                    2.0f * size * turn[1], material);
            const Tracer tracer(scene);
            const float u = random.uniform(0.0f, 0.5f), v = random.uniform(0.0f, 0.5f);
            const vec3 wo = random.direction(turn[2]);
            const SurfacePoint p =
                surfacePoint(scene, 0, u, v, wo, random.uniform(0.0f, 2.0f) * size);
            for (const vec3& viewer : {wo, vec3(0.0f)}) {
                const float offset = surfaceOffset(scene, 0, p.position, p.n_g, p.distance);
                const vec3 start = offSurface(p.position, p.n_g, viewer, offset);
                for (int k = 0; k < 20; ++k) {
                    EXPECT_FALSE(tracer.seeAlone(start, random.direction(p.n_g)).ground.hit.found())
                        << "size " << size << ", trial " << trial;
                }
            }
        }
    }
}

TEST(RayOrigin, AFloorAlongTheAxesCostsNothingHoweverLargeItIs) {
    Scene scene;
    const uint32_t material = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addQuad(scene, vec3(-1e5f, 0, 1e5f), vec3(2e5f, 0, 0), vec3(0, 0, -2e5f), material);
    const float offset = surfaceOffset(scene, 0, vec3(1, 0, 2), vec3(0, 1, 0), 3.0f);
    EXPECT_GT(offset, 0.0f);
    EXPECT_LT(offset, 1e-4f);
}

TEST(DistanceToTriangle, ToItsFaceEdgesAndCorners) {
    Scene scene;
    addQuad(scene, vec3(0), vec3(2, 0, 0), vec3(0, 2, 0), addMaterial(scene, {}));
    ASSERT_EQ(scene.positions[scene.triangles[0].y], vec3(2, 0, 0));  // (0 0) (2 0) (2 2)
    EXPECT_FLOAT_EQ(distanceToTriangle(scene, 0, vec3(1.5f, 0.5f, -3)), 3.0f);
    EXPECT_FLOAT_EQ(distanceToTriangle(scene, 0, vec3(1, -2, 0)), 2.0f);
    EXPECT_FLOAT_EQ(distanceToTriangle(scene, 0, vec3(0, 2, 0)), std::sqrt(2.0f));
    EXPECT_FLOAT_EQ(distanceToTriangle(scene, 0, vec3(5, 6, 0)), 5.0f);
    EXPECT_FLOAT_EQ(distanceToTriangle(scene, 0, vec3(-3, 0, 4)), 5.0f);
}

}  // namespace
}  // namespace sheen
