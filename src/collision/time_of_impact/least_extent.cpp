// SPDX-License-Identifier: MIT
#include "collision/time_of_impact/least_extent.h"

#include <algorithm>
#include <limits>

#include "geometry/primitives/bounds.h"
#include "geometry/shape/shape_surface.h"

namespace poise::collision {

double least_extent_m(const Shape& shape) {
  // Chosen: below this a width says that the object is a sheet.
  constexpr double kSheet = 0.05;
  if (shape.kind == ShapeKind::Plane) return std::numeric_limits<double>::infinity();
  const Mat3 to_principal = shape.principal_axes.conjugate().toRotationMatrix();
  geometry::Bounds box;
  if (shape.surface) {
    for (const ShapeSurface::Triangle& t : shape.surface->triangles) {
      for (const std::uint32_t corner : t.vertex) box.add(to_principal * shape.surface->vertices_m[corner]);
    }
  } else {
    for (NodeIndex node = 0; node < shape.tree.node_count(); ++node) {
      if (shape.tree.child_count[node] != 0) continue;
      const Sphere ball = shape.tree.sphere(node);
      const Vec3 center = to_principal * ball.center_m;
      box.add(center - Vec3::Constant(ball.radius_m));
      box.add(center + Vec3::Constant(ball.radius_m));
    }
  }
  return std::max((box.high - box.low).minCoeff(), kSheet * shape.bounding_radius_m);
}

}  // namespace poise::collision
