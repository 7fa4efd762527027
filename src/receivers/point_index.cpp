#include "receivers/point_index.h"

#include <nanoflann.hpp>
#include <utility>

namespace sheen {
namespace {

// What nanoflann asks of points.
struct Cloud {
    std::vector<vec3> points;
    std::vector<uint32_t> numbers;

    size_t kdtree_get_point_count() const { return points.size(); }
    float kdtree_get_pt(size_t i, size_t axis) const {
        return points[i][static_cast<glm::length_t>(axis)];
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};

// Keeps all that is near enough.
struct Within {
    const std::vector<uint32_t>& numbers;
    float radius2;
    std::vector<uint32_t> found = {};

    bool full() const { return true; }
    size_t size() const { return found.size(); }
    float worstDist() const { return radius2; }
    bool addPoint(float distance2, size_t i) {
        if (distance2 < radius2) {
            found.push_back(numbers[i]);
        }
        return true;
    }
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>,
                                                   Cloud, 3, size_t>;

}  // namespace

struct PointIndex::Tree {
    Cloud cloud;
    KdTree tree;

    explicit Tree(Cloud points) : cloud(std::move(points)), tree(3, cloud) {}
};

PointIndex::PointIndex(const std::vector<vec3>& points, std::vector<uint32_t> numbers) {
    Cloud cloud;
    for (const uint32_t number : numbers) {
        cloud.points.push_back(points[number]);
    }
    cloud.numbers = std::move(numbers);
    tree_ = std::make_unique<Tree>(std::move(cloud));
}

PointIndex::~PointIndex() = default;

std::vector<uint32_t> PointIndex::within(const vec3& p, float radius) const {
    Within result{.numbers = tree_->cloud.numbers, .radius2 = radius * radius};
    if (!tree_->cloud.points.empty()) {
        tree_->tree.findNeighbors(result, &p.x, {});
    }
    return result.found;
}

}  // namespace sheen
