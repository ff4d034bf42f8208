// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/sphere_tree/cover/cover_kernels.h"
#include "geometry/sphere_tree/cover/solid_cells.h"
#include "poise/types.h"

namespace poise::geometry {

/// The frame in which trees are built: the middle of the box is the origin, its diagonal the unit of length. Single
/// precision is then accurate to 1e-7 of the diagonal. Exact tests use double and the cells' own points.
struct CoverFrame {
  Vec3 middle_m = Vec3::Zero();
  double diagonal_m = 1;

  [[nodiscard]] Vec3f to(const Vec3& point_m) const { return ((point_m - middle_m) / diagonal_m).cast<float>(); }
  [[nodiscard]] Vec3 from(const Vec3f& point) const { return middle_m + diagonal_m * point.cast<double>(); }
};

/// Cells for the search, in single precision, each with a ball about the middle of its box. Immutable once made.
struct CoverCells {
  PointList middles;
  std::vector<float> reach;        ///< from the middle to the farthest point
  std::vector<std::size_t> begin;  ///< first point of each cell, then the number of points
  PointList points;                ///< and kReadBeyond more

  CoverCells() = default;
  CoverCells(const SolidCells& cells, const CoverFrame& frame);

  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(reach.size()); }
  /// Distance from a point to the farthest point of a cell.
  [[nodiscard]] float reach_from(std::uint32_t cell, const Vec3f& place) const;
  [[nodiscard]] bool within(std::uint32_t cell, const Vec3f& center, float radius) const;
};

/// Some cells, gathered for many queries about one ball. One thread at a time.
class CellSet {
  // Invariant: middles_ and ids_ have the same length; reach_, distances_ and far_ have at least kReadBeyond more.
 public:
  void gather(const CoverCells& cells, const std::vector<std::uint32_t>& ids);
  /// Radius of the ball about `center` that contains all cells, plus slightly more than rounding; 0 for no cell. Once
  /// the radius is certain to exceed `limit`, returns a number above the limit.
  [[nodiscard]] float radius_about(const CoverCells& cells, const Vec3f& center, float limit);

 private:
  PointList middles_;
  std::vector<float> reach_;
  std::vector<std::uint32_t> ids_;
  std::vector<float> distances_;
  std::vector<std::uint32_t> far_;  ///< indices
  float largest_reach_ = 0;
};

}  // namespace poise::geometry
