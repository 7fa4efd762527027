#include "scenes/surface_nets.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace sheen::scenes {
namespace {

constexpr uint32_t kNone = ~0u;
constexpr double kGradientStep = 1e-3;
constexpr int kProjectionSteps = 4;
// Vertices stay this share of their cell inside it: no two meet, no triangle loses its area.
constexpr double kCellMargin = 0.05;

dvec3 gradientOf(const Field& field, const dvec3& p) {
    const double h = kGradientStep;
    return dvec3(field(p + dvec3(h, 0, 0)) - field(p - dvec3(h, 0, 0)),
                 field(p + dvec3(0, h, 0)) - field(p - dvec3(0, h, 0)),
                 field(p + dvec3(0, 0, h)) - field(p - dvec3(0, 0, h))) /
           (2.0 * h);
}

class Polygonizer {
  public:
    Polygonizer(const Field& field, const Grid& grid)
        : field_(field), grid_(grid), size_(grid.x.size(), grid.y.size(), grid.z.size()) {}

    Mesh run() {
        sampleField();
        placeVertices();
        for (int axis = 0; axis < 3; ++axis) {
            connect(axis);
        }
        return std::move(mesh_);
    }

  private:
    using Index = glm::vec<3, size_t>;

    size_t flat(const Index& i) const { return (i.z * size_.y + i.y) * size_.x + i.x; }
    dvec3 point(const Index& i) const { return {grid_.x[i.x], grid_.y[i.y], grid_.z[i.z]}; }

    template <class Visit>
    static void forEach(const Index& lower, const Index& upper, const Visit& visit) {
        for (size_t z = lower.z; z < upper.z; ++z) {
            for (size_t y = lower.y; y < upper.y; ++y) {
                for (size_t x = lower.x; x < upper.x; ++x) {
                    visit(Index(x, y, z));
                }
            }
        }
    }

    void sampleField() {
        values_.resize(size_.x * size_.y * size_.z);
        forEach(Index(0), size_, [&](const Index& i) {
            values_[flat(i)] = field_(point(i));
            const bool border = i.x == 0 || i.y == 0 || i.z == 0 || i.x + 1 == size_.x ||
                                i.y + 1 == size_.y || i.z + 1 == size_.z;
            SHEEN_CHECK(!border || values_[flat(i)] > 0.0);
        });
    }

    // One vertex in every cell the surface crosses: the mean of the crossings, then moved onto the
    // surface, but not out of its cell.
    void placeVertices() {
        vertex_of_.assign(values_.size(), kNone);
        forEach(Index(0), size_ - Index(1), [&](const Index& cell) {
            dvec3 sum(0.0);
            int crossings = 0;
            for (int axis = 0; axis < 3; ++axis) {
                for (int side = 0; side < 4; ++side) {
                    Index a = cell;
                    a[(axis + 1) % 3] += static_cast<size_t>(side & 1);
                    a[(axis + 2) % 3] += static_cast<size_t>(side >> 1);
                    Index b = a;
                    b[axis] += 1;
                    const double va = values_[flat(a)];
                    const double vb = values_[flat(b)];
                    if ((va < 0.0) != (vb < 0.0)) {
                        sum += glm::mix(point(a), point(b), va / (va - vb));
                        ++crossings;
                    }
                }
            }
            if (crossings == 0) {
                return;
            }
            dvec3 p = sum / static_cast<double>(crossings);
            const dvec3 margin = kCellMargin * (point(cell + Index(1)) - point(cell));
            const dvec3 lower = point(cell) + margin;
            const dvec3 upper = point(cell + Index(1)) - margin;
            for (int step = 0; step < kProjectionSteps; ++step) {
                const dvec3 gradient = gradientOf(field_, p);
                p -= field_(p) / std::max(glm::dot(gradient, gradient), 0.05) * gradient;
                p = glm::clamp(p, lower, upper);
            }
            vertex_of_[flat(cell)] = static_cast<uint32_t>(mesh_.positions.size());
            mesh_.positions.push_back(p);
            mesh_.normals.push_back(glm::normalize(gradientOf(field_, p)));
        });
    }

    // A quadrilateral around every grid edge along `axis` that the surface crosses.
    void connect(int axis) {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        Index lower(0);
        lower[u] = 1;
        lower[v] = 1;
        forEach(lower, size_ - Index(1), [&](const Index& a) {
            Index b = a;
            b[axis] += 1;
            const bool inside_a = values_[flat(a)] < 0.0;
            if (inside_a == (values_[flat(b)] < 0.0)) {
                return;
            }
            std::array<uint32_t, 4> corner;
            for (size_t k = 0; k < 4; ++k) {
                Index cell = a;
                cell[u] -= k == 0 || k == 3 ? 1 : 0;
                cell[v] -= k < 2 ? 1 : 0;
                corner[k] = vertex_of_[flat(cell)];
            }
            if (!inside_a) {
                std::swap(corner[1], corner[3]);
            }
            addQuadrilateral(corner);
        });
    }

    // Split along the diagonal whose two normals agree better: folds then keep their ridges.
    void addQuadrilateral(const std::array<uint32_t, 4>& c) {
        const std::vector<dvec3>& n = mesh_.normals;
        const size_t turn = glm::dot(n[c[0]], n[c[2]]) >= glm::dot(n[c[1]], n[c[3]]) ? 0 : 1;
        const auto at = [&](size_t k) { return c[(k + turn) % 4]; };
        mesh_.indices.insert(mesh_.indices.end(), {at(0), at(1), at(2), at(0), at(2), at(3)});
    }

    const Field& field_;
    const Grid& grid_;
    Index size_;
    std::vector<double> values_;
    std::vector<uint32_t> vertex_of_;
    Mesh mesh_;
};

}  // namespace

std::vector<double> borders(double lower, double upper, const std::function<double(double)>& step) {
    std::vector<double> result;
    for (double position = lower; position < upper; position += step(position)) {
        result.push_back(position);
    }
    result.push_back(upper);
    return result;
}

Mesh polygonize(const Field& field, const Grid& grid) { return Polygonizer(field, grid).run(); }

}  // namespace sheen::scenes
