// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <vector>

#include "collision/shapes.h"
#include "collision/triangles/polygon_contact.h"
#include "geometry/meshes.h"
#include "geometry/shared_tree.h"

namespace poise::collision {

inline ShapePtr mesh_shape(const TriangleMesh& mesh, Level depth = 2) {
  return make_mesh_shape_with_tree(mesh, test::shared_tree(mesh, depth)).value();
}

/// The polygon result of one pair.
struct PolygonAnswer {
  SinglePair level;
  PolygonSums sums;
  std::uint32_t units = 0, quanta = 0;
  double longest = 0;  ///< work of the longest piece, in units
  PairContact contact;
};

/// Refines a pair to its leaves and through its polygons, `units` at a time. If a tree separates the pair, only `apart`
/// is set.
inline PolygonAnswer solve_by_polygons(const PairFrame& frame, std::span<FrontPool> pools,
                                       std::uint32_t units = 1U << 30U, bool rests = true) {
  PolygonAnswer answer;
  SinglePair& pair = answer.level;
  pools[0].clear();
  pair.deepest = deepest_level(*frame.a, *frame.b, kMaxTreeDepth);
  allow_polygons(*frame.a, *frame.b, kMaxTreeDepth, pair);
  while (pair.refinable() && !pair.next_is_polygons()) {
    LevelProgress progress = begin_level(pair, pools[0]);
    while (run_quantum(frame, pools, 0, units, progress) == Quantum::More) {
    }
    publish_level(frame, Mat3::Identity(), progress, pair, pair);
  }
  if (pair.apart) return answer;
  answer.units = polygon_units(*frame.a, *frame.b, pools, pair.front);
  PolygonProgress progress;
  begin_polygons(frame, Mat3::Identity(), pair, pair, progress, rests);
  Quantum quantum = Quantum::More;
  while (quantum == Quantum::More) {
    quantum = run_polygons(frame, pools, units, progress);
    ++answer.quanta;
    answer.longest = std::max(answer.longest, progress.work);
  }
  publish_polygons(progress, pair, pair);
  answer.sums = progress.sums;
  answer.contact = pair.contact;
  return answer;
}

/// The same with a separate pool, a at rest at the origin, b rotated and moved; the contact is in a's frame.
inline PolygonAnswer solve_by_polygons(const Shape& a, const Shape& b, const Mat3& turn, const Vec3& offset_m,
                                       double margin_m, std::uint32_t units = 1U << 30U) {
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 18U);
  return solve_by_polygons(make_pair_frame(a, Pose{}, b, Pose{offset_m, turn}, margin_m, 0), pools, units);
}

inline Mat3 turned(double angle_rad, const Vec3& axis) {
  return Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
}
/// Rotates the corner (-,-,-) of a box straight down.
inline Mat3 on_its_corner() {
  return Quat::FromTwoVectors(Vec3(-1, -1, -1).normalized(), -Vec3::UnitZ()).toRotationMatrix();
}

}  // namespace poise::collision
