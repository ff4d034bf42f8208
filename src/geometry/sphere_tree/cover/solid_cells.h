// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "parallel/executor.h"
#include "poise/mesh.h"

namespace poise::geometry {

/// A solid cut into small pieces by a regular grid. Each cell is a set of points whose convex hull contains the solid
/// within one grid cell: the corners of the triangles clipped to the cell, and the corners of the cell that are inside.
/// (An extreme point of "solid within cell" lies on the surface, hence on a clipped triangle, or is a corner of the
/// cell.) So a ball that contains the points of a cell contains that part of the solid, and balls that contain all
/// cells contain the whole solid.
struct SolidCells {
  std::vector<Vec3> points_m;
  std::vector<std::size_t> begin;  ///< first point of each cell, then the number of points
  std::vector<Vec3> middle_m;      ///< mean of each cell's points

  [[nodiscard]] std::size_t size() const { return middle_m.size(); }
  [[nodiscard]] std::span<const Vec3> points_of(std::size_t cell) const {
    return std::span(points_m).subspan(begin[cell], begin[cell + 1] - begin[cell]);
  }
};

/// Cuts a mesh into about `target` cells (fewer for a thin shape whose box would need too many cells). A block of cells
/// that are completely inside is one cell. For an open mesh a cell with a corner inside includes all of its corners.
/// The result does not depend on the executor.
SolidCells cut_into_cells(const TriangleMesh& mesh, const TriangleBvh& bvh, std::size_t target,
                          parallel::Executor& executor);

}  // namespace poise::geometry
