// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/shape/shape_surface.h"

/// What a descent of two surfaces does most, in lanes and in single precision: boxes of nodes against each other, and
/// triangles against each other. Any thread; any instruction set gives the same answers.
namespace poise::collision {

/// The frame of b's surface in that of a's, both about the origins of their BVHs.
struct SurfaceFrame {
  std::array<std::array<float, 3>, 3> rotation, absolute;  ///< [row][column]; absolute: its magnitudes
  std::array<float, 3> offset_m;
};

/// Boxes of four nodes of one surface, as BvhNode holds them: x, y and z, four lanes each. Of `single` only the first
/// counts.
struct FourBoxes {
  const float* low_m;
  const float* high_m;
  bool single = false;
};

inline constexpr std::size_t kBoxPairs = 16;
/// Squares of how far the boxes of two nodes' children are at least apart: along the axes of a, and along those of b.
/// Answer 4 i + j is of box i of a and box j of b; of a single a others than the first four are not set. A bit is set
/// for each that is at most `limit_m2`.
std::uint32_t boxes_within(const SurfaceFrame& frame, const FourBoxes& a, const FourBoxes& b, float limit_m2,
                           std::array<float, kBoxPairs>& squared_m2);

/// Triangles of one surface for compare_triangles: the rows of NearTriangle, one pair after the other.
struct NearRows {
  static constexpr std::size_t kPairs = 16;
  alignas(64) std::array<std::array<std::array<float, 4>, kPairs>, 4> row;
  void set(std::size_t pair, const ShapeSurface::NearTriangle& triangle);
};

struct TriangleTest {
  float apart_m, beneath_m;  ///< as in SurfaceReach
  float rounding_m;          ///< of a coordinate
  bool solid_a, solid_b;
};

/// A bit for each pair of triangles.
struct TriangleAnswers {
  std::uint32_t near;       ///< within the reach, and one of the two owns a feature
  std::uint32_t may_cross;  ///< neither lies on one side of the other's plane, or beyond a side of it
  std::uint32_t may_face;   ///< both may have features that face each other within the reach
};
/// Each answer errs on the safe side: it is left out only where it is certain.
TriangleAnswers compare_triangles(const SurfaceFrame& frame, const TriangleTest& test, const NearRows& a,
                                  const NearRows& b);

}  // namespace poise::collision
