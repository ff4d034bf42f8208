// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "collision/front/pair_frame.h"
#include "collision/manifold/contact_sums.h"
#include "collision/triangles/triangle_pair.h"
#include "poise/types.h"

namespace poise::collision {

/// A segment of the curve along which two surfaces pass through each other, and the triangles that made it.
struct RetainedSegment {
  Vec3 from_m, to_m;
  std::uint32_t triangle_a, triangle_b;
};

/// The centre of a ball that may lie inside a solid, and the nearest face through which it can leave.
struct SunkBall {
  double gap_m = -std::numeric_limits<double>::infinity();  ///< of the ball, were it to leave there
  Vec3 normal;                                              ///< from a to b
  Vec3 center_m, point_m;                                   ///< of the ball; on the face
  bool of_b = true;                                         ///< the ball is b's
};

/// What the polygons of a pair add up to, in the frame of a. Facing features weigh 2^(-(gap - least gap) / softness),
/// so that faces in contact give a contact at their middle, and a single corner one at the corner; the least gap may
/// fall while they are added. Where surfaces cross, the curve of the crossing gives the gradient of the overlapped
/// volume (docs/method.md).
struct PolygonSums {
  static constexpr std::size_t kRetainedSegments = 128;

  double softness_m = 0;  ///< a gap larger by this weighs half
  double least_gap_m = std::numeric_limits<double>::infinity();
  double weight = 0;
  Vec3 normal = Vec3::Zero();    ///< sum of w n
  Vec3 moment_m = Vec3::Zero();  ///< sum of w p x n
  Vec3 point_m = Vec3::Zero();   ///< sum of w p

  bool crossed = false;
  Vec3 reference_m = Vec3::Zero();  ///< the first point of the curve; what follows is measured from there
  Vec3 area_m2 = Vec3::Zero();      ///< half the sum of x cross dx
  double swept_m2 = 0;              ///< sum of its lengths
  Vec3 lever_m3 = Vec3::Zero();     ///< - 1/2 sum of the integral of |x|^2 dx
  Vec3 open_m = Vec3::Zero();       ///< sum of dx, 0 for closed curves
  double length_m = 0;
  Vec3 middle_m2 = Vec3::Zero();  ///< sum of |dx| times the middle of the segment
  std::uint32_t segments = 0;
  std::array<RetainedSegment, kRetainedSegments> kept;  ///< the first of them

  SunkBall sunk;
};

/// The softness of a pair of shapes.
double polygon_softness_m(const PairFrame& frame);
/// Gaps from here on weigh nothing beside what is there already, or beside a gap of `most_m` that is known to come; at
/// most the margin.
double reach_of_sums_m(const PairFrame& frame, const PolygonSums& sums, double most_m);

void add_feature(const FacingFeatures& feature, PolygonSums& sums);
void add_segment(const CrossingSegment& segment, std::uint32_t triangle_a, std::uint32_t triangle_b, PolygonSums& sums);
void add_sunk_ball(const SunkBall& ball, PolygonSums& sums);

/// The contact of a pair by its polygons. `leaves` is the contact of the leaves, used where polygons give none: for a
/// body that lies wholly inside another, and for a curve that encloses nothing. `on_b` is the placement of b's surface
/// that the sums used.
PairContact make_polygon_contact(const PairFrame& frame, const PlacedSurface& on_a, const PlacedSurface& on_b,
                                 const PolygonSums& sums, const PairContact& leaves, const Mat3& rotation_a);

}  // namespace poise::collision
