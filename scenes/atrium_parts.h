// The building elements of the atrium, each made once and placed often. Heights are from the foot
// of the element, y up; where an element has a front, it faces +z.
#pragma once

#include <vector>

#include "scenes/model.h"
#include "scenes/png.h"

namespace sheen::scenes {

/// A column with base, tapered shaft, capital and square abacus.
Mesh column(double height, double radius, int segments);

/// A square pier with foot and head mouldings.
Mesh pier(double height, double half_width);

/// What stands on two columns: a wall `bay` wide and `height` high, centred on x = 0, with a
/// semicircular opening of `radius` at its foot, mouldings around the arch and a keystone.
struct ArchSpec {
    double bay = 2.0;
    double height = 1.6;
    double radius = 0.78;
    double half_depth = 0.19;
    int segments = 16;
};
Mesh archedWall(const ArchSpec& spec);

/// A balustrade of `length`, centred on x = 0, with `count` turned balusters.
Mesh balustrade(double length, int count);

/// A groin vault over a square of half width `half`, springing at y = 0; seen from below.
Mesh groinVault(double half, int cells);

/// A moulded door frame with a panelled, closed door in a recess, foot at y = 0, centred on x = 0;
/// it fills an opening 2 * half_width wide and `height` high in a wall at z = 0.
Mesh doorway(double half_width, double height, double recess);

/// A large vase.
Mesh vase();

/// A wall from x = -half to half at z = 0, `height` high, with an opening as doorway() fills it.
Mesh wallWithDoor(double half, double height, double door_half_width, double door_height);

/// Courses of cut stone, and square paving; one repeat is 2 m wide.
Picture stoneCourses();
Picture paving();

}  // namespace sheen::scenes
