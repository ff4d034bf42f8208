// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "geometry/shape/shape_surface.h"
#include "poise/types.h"

namespace poise::collision {

/// In a groove a corner beneath one face may be so many times its depth past the rim.
inline constexpr double kPastRim = 2;
/// Two features may lean out of their cones of normals by so much together (radians), more than rounding.
inline constexpr double kLeanOfBoth = 0.2004;

/// A surface at a pose: p = rotation * (p of the body) + offset. All that follows is in the frame that this leads to.
struct PlacedSurface {
  const ShapeSurface* surface = nullptr;
  Mat3 rotation = Mat3::Identity();
  Vec3 offset_m = Vec3::Zero();
  [[nodiscard]] Vec3 point(const Vec3& body_m) const { return rotation * body_m + offset_m; }
};

/// A triangle of a placed surface.
struct PlacedTriangle {
  /// From corner k to the next.
  struct Side {
    Vec3 along_m;
    Vec3 middle_m;
    Vec3 into_m;  ///< normal x along_m: in the face, square to the side
    double length_m;
    // Of sides that the triangle stands for alone:
    Vec3 into_beyond_m;  ///< the same in the face beyond the side; zero where there is none
    Vec3 outward;        ///< sum of the normals of both faces
  };
  std::array<Vec3, 3> corner_m;
  std::array<Side, 3> side;
  Vec3 normal;
  std::uint32_t index;
  std::array<std::uint32_t, 3> vertex;  ///< of the corners
  std::uint8_t features;                ///< as in ShapeSurface::Triangle

  [[nodiscard]] bool stands_for_vertex(std::size_t k) const { return (features & (ShapeSurface::kVertex0 << k)) != 0; }
  [[nodiscard]] bool stands_for_edge(std::size_t k) const { return (features & (ShapeSurface::kEdge0 << k)) != 0; }
};
void place(const PlacedSurface& placed, std::uint32_t triangle, PlacedTriangle& out);
/// The same, but it stands for these corners and sides, whoever owns them.
void place_with_features(const PlacedSurface& placed, std::uint32_t triangle, std::uint8_t features,
                         PlacedTriangle& out);

/// Does the foot of a point on the plane of a triangle lie in it, its rim included?
bool over_face(const PlacedTriangle& t, const Vec3& point_m);

/// Two features of two surfaces that face each other: a corner and a face, two edges, an edge and a corner, or two
/// corners.
struct FacingFeatures {
  enum class Kind : std::uint8_t { CornerFace, Edges, Other };
  static constexpr std::uint32_t kNoCorner = 0xffffffffU;

  double
      gap_m;    ///< along the normal, of a ball less its radius; for meshes >= 0 unless features beneath were asked for
  Vec3 normal;  ///< unit, from a to b
  Vec3 point_a_m, point_b_m;
  std::uint32_t corner;  ///< that lies over or beneath a face: its vertex; kNoCorner for all else
  Kind kind;
  bool corner_of_b;  ///< whose corner it is
  bool resting;      ///< penetrating, or leaning a little: counts for resting contact and not for impacts
  bool in_groove;    ///< a corner beneath a face and past its rim, where the surface turns up: beneath the next face as
                     ///< well
};

/// Most facing features of two triangles: 6 of corner and face, over it or beneath (of a sheet both), 9 of two sides,
/// 18 of side and corner, 9 of two corners.
using FeatureList = std::array<FacingFeatures, 48>;

/// Signed distances of the corners of two triangles from each other's plane.
struct PlaneSides {
  std::array<double, 3> a_above_b, b_above_a;
};
PlaneSides plane_sides(const PlacedTriangle& a, const PlacedTriangle& b);
/// Does one of the triangles lie wholly on one side of the other's plane, and farther than `reach_m` from it?
bool beyond(const PlaneSides& sides, double reach_m);

/// Where two triangles pass through each other: from -> to, along normal_a x normal_b.
struct CrossingSegment {
  Vec3 from_m, to_m;
};
/// Nothing where they do not. Whether a side of one passes through the other is decided by numbers that do not
/// depend on which of the two triangles at the side is asked, so the segments of two closed surfaces form closed
/// curves.
std::optional<CrossingSegment> crossing(const PlacedTriangle& a, const PlacedTriangle& b, const PlaneSides& sides);

/// The features of two triangles that face each other within `reach_m` and that the triangles stand for; how many. A
/// pair of features counts where nothing beside it is nearer: the direction between the two lies in the cone of normals
/// of each (a corner over a face counts wherever it is over it, so that a face that lies flat has all its corners).
/// With `beneath_m` > 0 those come too that have passed through each other by less than that, and crossed edges whose
/// direction leans out of a cone by up to 0.1: marked as `resting`. A face of a sheet looks to the side where the other
/// body's centre is.
std::size_t facing_features(const PlacedSurface& on_a, const PlacedTriangle& a, const PlacedSurface& on_b,
                            const PlacedTriangle& b, const PlaneSides& sides, double reach_m, FeatureList& out,
                            double beneath_m = 0);

/// The same for a triangle and the centre of a ball of b.
std::size_t features_facing_point(const PlacedSurface& on_a, const PlacedTriangle& a, const Vec3& point_m,
                                  double reach_m, FeatureList& out);

}  // namespace poise::collision
