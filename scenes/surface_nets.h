// Turns a signed-distance field into triangles with smooth normals.
// Based on: Gibson 1998, "Constrained Elastic Surface Nets" (the dual method, without relaxation:
// vertices are moved onto the surface along the field's gradient instead).
#pragma once

#include <functional>
#include <vector>

#include "scenes/model.h"

namespace sheen::scenes {

/// Negative inside; any smooth field with the right zero set will do.
using Field = std::function<double(const dvec3&)>;

/// Cell borders along each axis, increasing; they may be closer where there is more detail.
struct Grid {
    std::vector<double> x;
    std::vector<double> y;
    std::vector<double> z;
};

/// Borders from `lower` on, where `step(position)` is the wanted cell size there.
std::vector<double> borders(double lower, double upper, const std::function<double(double)>& step);

/// The zero surface, positions and normals (from the gradient). The field must be positive on the
/// border of the grid.
Mesh polygonize(const Field& field, const Grid& grid);

}  // namespace sheen::scenes
