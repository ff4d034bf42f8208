// SPDX-License-Identifier: MIT
#pragma once

#include "poise/mesh.h"

// Closed meshes of the solids that robot and scene files name, about the origin with their axis along z,
// counter-clockwise from outside. Lengths in metres, > 0 and finite (the caller checks). Vertices lie on the true
// surface, so a round solid has a little less volume than the true one: of 32 edges around, 1.3 % for a ball and 0.6 %
// for a cylinder.
namespace poise::geometry {

/// `half_m`: half the edges along x, y and z. 12 triangles.
TriangleMesh box_solid(const Vec3& half_m);

/// An ellipsoid; a ball has three equal radii.
TriangleMesh ellipsoid_solid(const Vec3& radii_m);

/// A cylinder from z = -half_m to half_m.
TriangleMesh cylinder_solid(double radius_m, double half_m);

/// The points within radius_m of the segment from z = -half_m to half_m.
TriangleMesh capsule_solid(double radius_m, double half_m);

}  // namespace poise::geometry
