// The tree that finds records: the same as looking at all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "cache/record_tree.h"
#include "test_scenes.h"

namespace sheen {
namespace {

struct Sphere {
    vec3 position;
    float radius;
};

// Points all over a box, on a plane of it, and many in one place.
std::vector<Sphere> spheresIn(const Bounds& bounds) {
    Random random(7);
    std::vector<Sphere> spheres;
    const vec3 extent = bounds.upper - bounds.lower;
    for (int i = 0; i < 2000; ++i) {
        vec3 p = bounds.lower + random.point(0.0f, 1.0f) * extent;
        if (i % 3 == 0) {
            p.y = bounds.lower.y;
        }
        if (i % 5 == 0) {
            p = bounds.center();
        }
        const float share = random.uniform(0.0f, 1.0f);
        spheres.push_back({p, 0.2f * share * share * share * bounds.size()});
    }
    return spheres;
}

class Trees : public testing::TestWithParam<Bounds> {};

TEST_P(Trees, FindAllThatReach) {
    const Bounds bounds = GetParam();
    const std::vector<Sphere> spheres = spheresIn(bounds);
    RecordTree tree(bounds);
    Random random(8);
    size_t visited = 0;
    size_t wanted = 0;
    for (size_t count = 0; count < spheres.size(); ++count) {
        if (count % 97 == 0) {
            const vec3 p = bounds.lower + random.point(-0.2f, 1.2f) * (bounds.upper - bounds.lower);
            std::set<size_t> found;
            tree.visit(
                p, [](float distance2, float greatest) { return distance2 <= greatest * greatest; },
                [&](size_t i) {
                    EXPECT_LT(i, count);
                    EXPECT_TRUE(found.insert(i).second) << "twice: " << i;
                });
            visited += found.size();
            for (size_t i = 0; i < count; ++i) {
                if (glm::length(spheres[i].position - p) < 0.9999f * spheres[i].radius) {
                    EXPECT_EQ(found.count(i), 1u) << i;
                    ++wanted;
                }
            }
        }
        tree.insert(spheres[count].position, spheres[count].radius);
    }
    EXPECT_LE(wanted, visited);
    if (bounds.size() > 0.0f) {
        EXPECT_GT(wanted, 0u);
    }
}

INSTANTIATE_TEST_SUITE_P(Bounds, Trees,
                         testing::Values(Bounds{vec3(-1), vec3(1)}, Bounds{vec3(5e3f), vec3(9e3f)},
                                         Bounds{vec3(1e6f), vec3(1e6f + 8.0f)},
                                         Bounds{vec3(0, 1, 0), vec3(4, 1, 1e-4f)},
                                         Bounds{vec3(2), vec3(2)}));

TEST(RecordTree, LooksAtFew) {
    const Bounds bounds{vec3(-1), vec3(1)};
    RecordTree tree(bounds);
    Random random(9);
    for (int i = 0; i < 20000; ++i) {
        tree.insert(random.point(-1.0f, 1.0f), 0.02f);
    }
    int visited = 0;
    tree.visit(
        vec3(0.3f),
        [](float distance2, float greatest) { return distance2 <= greatest * greatest; },
        [&](size_t) { ++visited; });
    EXPECT_LT(visited, 500);
}

TEST(RecordTree, NothingPlacedNothingVisited) {
    for (const Bounds& bounds : {Bounds{}, Bounds{vec3(-1), vec3(1)}}) {
        RecordTree(bounds).visit(
            vec3(0.0f), [](float, float) { return true; }, [](size_t) { FAIL(); });
    }
}

}  // namespace
}  // namespace sheen
