// Building blocks of the scenes. Every mesh has positions, normals and uvs (in metres along the
// surface where nothing else is said), so that any two can be joined.
#pragma once

#include <array>
#include <vector>

#include "scenes/model.h"

namespace sheen::scenes {

/// A flat quadrilateral (convex, corners counter-clockwise from the front), split in cells.
void addQuad(Mesh& mesh, const std::array<dvec3, 4>& corners, int cells_u = 1, int cells_v = 1);

/// An axis-aligned box, normals outward.
void addBox(Mesh& mesh, const dvec3& lower, const dvec3& upper);

/// The inside of an axis-aligned box as six meshes with normals inward: -x, +x, -y, +y, -z, +z.
std::array<Mesh, 6> roomWalls(const dvec3& lower, const dvec3& upper);

/// A point of a profile; a sharp one has a crease.
struct ProfilePoint {
    double radius;
    double height;
    bool sharp = false;
};

/// A surface of revolution about +y, profile from bottom to top, normals outward. `segments` 4
/// with `square` gives a square pyramid-like solid with flat sides whose half width is the radius.
void addLathe(Mesh& mesh, const std::vector<ProfilePoint>& profile, int segments,
              bool square = false);

/// A sphere from an icosahedron, each triangle split in four `levels` times. `inward` turns it
/// inside out.
void addSphere(Mesh& mesh, const dvec3& center, double radius, int levels, bool inward = false);

/// A straight moulding: a profile in (outward, up), extruded along `from`..`to` (horizontal);
/// outward is to the right of the way from `from` to `to`.
void addMoulding(Mesh& mesh, const std::vector<dvec2>& profile, const dvec3& from, const dvec3& to);

dmat4 placement(const dvec3& position, double turn_about_y = 0.0);

}  // namespace sheen::scenes
