// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <random>

#include "collision/polygon_oracle.h"
#include "collision/shapes.h"
#include "geometry/shape/shape_surface.h"
#include "poise/sphere_tree.h"

namespace poise::collision {

/// A mesh about the middle of its bounding box, its oracle, and a shape with a tree of it.
struct OracleShape {
  PolygonOracle oracle;
  Shape shape;
  double diagonal_m = 0;
};

/// Moves the middle of the bounding box to the origin, so that rotations do not move the body.
inline void center_mesh(TriangleMesh& mesh) {
  Vec3 low = mesh.vertices_m.front();
  Vec3 high = low;
  for (const Vec3& v : mesh.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const Vec3 middle = 0.5 * (low + high);
  for (Vec3& v : mesh.vertices_m) v -= middle;
}

/// A shape with triangles but without mass properties, which queries do not use.
inline OracleShape make_oracle_shape(const TriangleMesh& mesh, SphereTree tree) {
  OracleShape made{PolygonOracle(mesh), {}, mesh.diagonal_m()};
  const Sphere root = tree.sphere(0);
  made.shape.bounding_radius_m = root.center_m.norm() + root.radius_m;
  made.shape.tree = std::move(tree);
  made.shape.surface = std::make_shared<const ShapeSurface>(
      geometry::make_surface(mesh, Vec3::Zero(), Solidity::Solid, made.shape.tree));
  return made;
}

struct PosedPair {
  Pose a, b;
};

/// Two bodies with random rotations near their first contact on a random line. b moves along the line until the
/// surfaces are within 0.2 % of the smaller diagonal, and is then moved farther or nearer by up to `band` of it. Both
/// are about 10 m from the origin of the world, so that coordinates are not round.
inline PosedPair pose_near_first_touch(const OracleShape& a, const OracleShape& b, double band,
                                       std::mt19937_64& random) {
  const double size = std::min(a.diagonal_m, b.diagonal_m);
  const double far = a.shape.bounding_radius_m + b.shape.bounding_radius_m;
  for (;;) {
    PosedPair posed{random_pose(random, 10), random_pose(random, 0)};
    const Vec3 direction = random_pose(random, 0).rotation.col(0);
    const Vec3 aside = 0.3 * far * direction.cross(random_pose(random, 0).rotation.col(0));
    double along = far;
    // A body that moves by the distance cannot pass the other one. A grazing contact that takes too many steps is
    // skipped.
    for (int step = 0; step < 60 && along > -far; ++step) {
      posed.b.position_m = posed.a.position_m + aside + along * direction;
      const double distance = a.oracle.distance_m(posed.a, b.oracle, posed.b);
      if (distance < 2e-3 * size) {
        posed.b.position_m += uniform(random, -band, band) * size * direction;
        return posed;
      }
      along -= distance;
    }
  }
}

}  // namespace poise::collision
