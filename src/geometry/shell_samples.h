// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/cover_atoms.h"
#include "geometry/triangle_bvh.h"
#include "parallel/executor.h"

namespace poise::geometry {

/// Places outside an object, evenly spread through everything within `thickness` of it, with their distances: what a union of
/// balls covers of them is what stands out. In the frame of the cover. Immutable once made.
struct ShellSamples {
  PointList points;                 ///< cell after cell of the grid
  std::vector<float> distance;      ///< to the object
  float thickness = 0;
  float volume = 0;                 ///< that each one stands for

  Vec3f low = Vec3f::Zero();
  float cell = 1;
  std::array<int, 3> cells{};
  std::vector<std::uint32_t> cell_begin;  ///< first sample of each cell, then the number of samples

  [[nodiscard]] std::size_t size() const { return distance.size(); }
  /// Calls take(first, last) for runs of samples that hold all within `radius` of `center`.
  template <class Take>
  void runs_near(const Vec3f& center, float radius, Take&& take) const {
    std::array<int, 3> from{};
    std::array<int, 3> to{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const auto place = [&](float x) { return static_cast<int>(std::floor((x - low[axis]) / cell)); };
      from[a] = std::max(0, place(center[axis] - radius));
      to[a] = std::min(cells[a] - 1, place(center[axis] + radius));
      if (from[a] > to[a]) return;
    }
    for (int z = from[2]; z <= to[2]; ++z) {
      for (int y = from[1]; y <= to[1]; ++y) {
        const auto row = (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells[1]) + static_cast<std::size_t>(y)) *
                         static_cast<std::size_t>(cells[0]);
        const std::uint32_t first = cell_begin[row + static_cast<std::size_t>(from[0])];
        const std::uint32_t last = cell_begin[row + static_cast<std::size_t>(to[0]) + 1];
        if (first < last) take(first, last);
      }
    }
  }
};

/// About `target` samples (between half and twice as many) within `thickness` (> 0) of the object. The result does not
/// depend on the executor.
ShellSamples sample_shell(const TriangleMesh& mesh, const TriangleBvh& bvh, const CoverFrame& frame, float thickness, std::size_t target,
                          std::uint64_t seed, parallel::Executor& executor);

}  // namespace poise::geometry
