// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "poise/shape.h"
#include "poise/types.h"

namespace poise::query {

/// A convex solid that is surely inside a shape, in the body frame: what is behind it is behind the shape.
struct InnerSolid {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;                 ///< > 0: a ball
  Vec3 half_extents_m = Vec3::Zero();  ///< otherwise a box along the axes of the body
};

/// A shape has no more of them. Chosen: each is drawn for each of its bodies.
inline constexpr std::size_t kMostInnerSolids = 8;

/// The largest leaves of a tree that is its own surface; boxes that are grown inside a mesh from a grid of points until
/// its triangles stop them; nothing for planes and for meshes that enclose nothing. Takes about 10 ms for a mesh. Any
/// thread.
std::vector<InnerSolid> inner_solids(const ShapePtr& shape);

}  // namespace poise::query
