// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "poise/mesh.h"

namespace poise::geometry {

/// Names of the shapes that can be made, in the order of the help text.
std::span<const std::string_view> procedural_shapes();

/// A closed mesh about 1 m across, outward oriented, made from dimensions chosen here (docs/sphere-trees.md):
///   jack   three crossed round rods with round ends, 0.12 m thick radius, 1 m long
///   torus  ring radius 0.35 m, tube radius 0.15 m
///   slab   a box of 1.0 x 0.6 x 0.1 m
///   l      an L of 0.8 x 0.8 m, arms 0.25 m wide, 0.25 m deep
///   bowl   half a hollow ball, outer radius 0.5 m, wall 0.08 m
///   cube   edge 0.7 m
///   disc   radius 0.5 m, 0.12 m thick
/// Round parts have 16 (jack, tube of the torus) or 32 edges around, times `fineness`. Coordinates are rounded to 1e-9
/// m, so that the mesh is the same as read back from its file. Refused: any other name, a fineness that is not from 1
/// to kMaxFineness.
inline constexpr int kMaxFineness = 16;
Result<TriangleMesh> make_procedural_shape(std::string_view kind, int fineness = 1);

/// Least edge of boxes and wedges, so that the rounding to 1e-9 m is small relative to it.
inline constexpr double kLeastBlockM = 1e-5;
inline constexpr double kMostBlockM = 1e5;

/// A box of 12 triangles around the origin, rounded as above. Refused: an edge out of the range above.
Result<TriangleMesh> make_box(const Vec3& size_m);

/// A stone of an arch around the y axis: the part of a ring between two radii, `angle_deg` (0.1 to 90) wide about the z
/// axis. It has flat faces, so its corners lie on the two circles, and neighbouring stones share their faces.
struct WedgeSize {
  double inner_m = 0, outer_m = 0;
  double angle_deg = 0;
  double depth_m = 0;  ///< along y
};
/// Refused: lengths and angles out of these ranges, outer_m not above inner_m.
Result<TriangleMesh> make_wedge(const WedgeSize& size);

/// The mesh as OBJ text with nine decimals; the first line contains `comment`.
std::string obj_text(const TriangleMesh& mesh, std::string_view comment);

}  // namespace poise::geometry
