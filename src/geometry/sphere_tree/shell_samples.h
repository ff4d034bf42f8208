// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/sphere_tree/cover/cover_cells.h"
#include "parallel/executor.h"

namespace poise::geometry {

/// Points outside an object, uniformly spread through the space within `thickness` of it, with their distances. The
/// samples that a union of balls covers measure how far it stands out. In the frame of the cover. Immutable once made.
struct ShellSamples {
  PointList points;             ///< cell after cell of the grid, and kReadBeyond more
  std::vector<float> distance;  ///< to the object
  float thickness = 0;
  float volume = 0;  ///< represented by each sample

  Vec3f low = Vec3f::Zero();
  float cell = 1;
  std::array<int, 3> cells{};
  std::vector<std::uint32_t> cell_begin;  ///< first sample of each cell, then the number of samples

  [[nodiscard]] std::size_t size() const { return distance.size(); }
  /// Calls take(first, last) for ranges of samples that include all within `radius` of `center`.
  template <class Take>
  void runs_near(const Vec3f& center, float radius, Take&& take) const {
    const auto place = [&](int axis, float x) { return static_cast<int>(std::floor((x - low[axis]) / cell)); };
    // Distance of a row of cells from the centre along an axis; 0 for the row that contains it.
    const auto away = [&](int axis, int row) {
      const float begin = low[axis] + cell * static_cast<float>(row) - center[axis];
      return std::max({0.0F, begin, -begin - cell});
    };
    const float square = radius * radius * 1.0001F;
    const int last_z = std::min(cells[2] - 1, place(2, center.z() + radius));
    for (int z = std::max(0, place(2, center.z() - radius)); z <= last_z; ++z) {
      const float left_z = square - away(2, z) * away(2, z);
      if (left_z < 0) continue;
      const float reach_y = std::sqrt(left_z);
      const int last_y = std::min(cells[1] - 1, place(1, center.y() + reach_y));
      for (int y = std::max(0, place(1, center.y() - reach_y)); y <= last_y; ++y) {
        const float left_y = left_z - away(1, y) * away(1, y);
        if (left_y < 0) continue;
        const float reach_x = std::sqrt(left_y);
        const int from = std::max(0, place(0, center.x() - reach_x));
        const int to = std::min(cells[0] - 1, place(0, center.x() + reach_x));
        if (from > to) continue;
        const auto row =
            (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells[1]) + static_cast<std::size_t>(y)) *
            static_cast<std::size_t>(cells[0]);
        const std::uint32_t first = cell_begin[row + static_cast<std::size_t>(from)];
        const std::uint32_t last = cell_begin[row + static_cast<std::size_t>(to) + 1];
        if (first < last) take(first, last);
      }
    }
  }
};

/// About `target` samples (between half and twice as many) within `thickness` (> 0) of the object. The result does not
/// depend on the executor.
ShellSamples sample_shell(const TriangleMesh& mesh, const TriangleBvh& bvh, const CoverFrame& frame, float thickness,
                          std::size_t target, std::uint64_t seed, parallel::Executor& executor);

}  // namespace poise::geometry
