// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/broad_phase_cells.h"
#include "geometry/primitives/bounds.h"
#include "geometry/primitives/triangle_distance.h"

namespace poise::collision {

// The straight way of a ball.
struct BroadPhase::Way {
  Vec3 from_m, to_m;
  double radius_m = 0;
  geometry::Bounds box;  // of the centre's way

  explicit Way(const SweptBound& bound)
      : from_m(bound.start.center_m), to_m(from_m + bound.motion_m), radius_m(bound.start.radius_m) {
    box.add(from_m);
    box.add(to_m);
  }
  [[nodiscard]] bool meets(const Vec3& center_m, double other_m) const {
    const double reach = radius_m + other_m;
    if (box.squared_distance(center_m) >= reach * reach) return false;
    return geometry::squared_distance_of_segments_m2(from_m, to_m, center_m, center_m) < reach * reach;
  }
  [[nodiscard]] bool meets(const Way& other) const {
    const double reach = radius_m + other.radius_m;
    if (((box.low - other.box.high).array() > reach).any() || ((other.box.low - box.high).array() > reach).any())
      return false;
    return geometry::squared_distance_of_segments_m2(from_m, to_m, other.from_m, other.to_m) < reach * reach;
  }
};

// Calls visit for the entries of `count` cells in a row along x.
template <class Visit>
void BroadPhase::visit_row(const Cell& first, std::int32_t count, Visit&& visit) const {
  Cell from = first;
  const std::int32_t end = first.x + count;
  while (from.x < end) {
    const std::int32_t next = std::min(end, (from.x | (kBlockRow - 1)) + 1);
    const std::uint64_t begin = bucket(from);
    const std::uint32_t past = bucket_begin_[begin + static_cast<std::uint64_t>(next - from.x)];
    for (std::uint32_t e = bucket_begin_[begin]; e < past; ++e) {
      const Cell& cell = entries_[e].cell;
      // Blocks may share a place: the cell itself decides.
      if (cell.grid != first.grid || cell.y != first.y || cell.z != first.z) continue;
      if (cell.x < from.x || cell.x >= next) continue;
      visit(e);
    }
    from.x = next;
  }
}

// Calls visit for the entries of a grid that may meet the way: layer after layer of cells along its longest axis, in
// each of them the cells around the part of the way that is near. Every entry if that is fewer.
template <class Visit>
void BroadPhase::visit_along(const Way& way, int grid_index, Visit&& visit) const {
  const Grid& grid = grids_[static_cast<std::size_t>(grid_index)];
  const double reach = way.radius_m + 0.5 * grid.widest_m;
  const auto cells = [&](int axis, double low_m, double high_m, std::int64_t& first, std::int64_t& last) {
    first = std::max<std::int64_t>(cell_of(low_m, grid.cells_per_m), grid.least[axis]);
    last = std::min<std::int64_t>(cell_of(high_m, grid.cells_per_m), grid.most[axis]);
  };
  int along = 0;
  const Vec3 motion = way.to_m - way.from_m;
  motion.cwiseAbs().maxCoeff(&along);
  const double cell_m = 1.0 / grid.cells_per_m;
  std::int64_t first_layer = 0;
  std::int64_t last_layer = 0;
  cells(along, way.box.low[along] - reach, way.box.high[along] + reach, first_layer, last_layer);
  // An upper bound of the cells that the layers would visit, against all entries.
  const double across = 2 * reach * grid.cells_per_m + 3;
  const double layers = static_cast<double>(last_layer - first_layer + 1);
  if (layers * across * across > static_cast<double>(entries_.size()) ||
      std::max(way.box.high.cwiseAbs().maxCoeff(), way.box.low.cwiseAbs().maxCoeff()) * grid.cells_per_m >
          0.5 * kFarthestCell) {
    for (std::uint32_t e = 0; e < entries_.size(); ++e) {
      if (entries_[e].cell.grid == grid_index) visit(e);
    }
    return;
  }
  for (std::int64_t layer = first_layer; layer <= last_layer; ++layer) {
    // The part of the way from which a ball with its centre in this layer can be met.
    double begin = 0;
    double end = 1;
    if (motion[along] != 0) {
      const double low = (static_cast<double>(layer) * cell_m - reach - way.from_m[along]) / motion[along];
      const double high = (static_cast<double>(layer + 1) * cell_m + reach - way.from_m[along]) / motion[along];
      begin = std::clamp(std::min(low, high), 0.0, 1.0);
      end = std::clamp(std::max(low, high), 0.0, 1.0);
    }
    geometry::Bounds part;
    part.add(way.from_m + begin * motion);
    part.add(way.from_m + end * motion);
    std::int64_t first[3];
    std::int64_t last[3];
    for (int axis = 0; axis < 3; ++axis)
      cells(axis, part.low[axis] - reach, part.high[axis] + reach, first[axis], last[axis]);
    first[along] = last[along] = layer;
    if (first[0] > last[0]) continue;
    for (std::int64_t z = first[2]; z <= last[2]; ++z) {
      for (std::int64_t y = first[1]; y <= last[1]; ++y) {
        visit_row({static_cast<std::int32_t>(first[0]), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z),
                   grid_index},
                  static_cast<std::int32_t>(last[0] - first[0] + 1), visit);
      }
    }
  }
}

void BroadPhase::sort_swept(std::span<const SweptBound> swept) {
  geometry::Bounds box;
  for (const SweptBound& bound : swept) box.add(bound.start.center_m);
  int axis = 0;
  (box.high - box.low).maxCoeff(&axis);
  stretches_.clear();
  for (std::uint32_t i = 0; i < swept.size(); ++i) {
    const Way way(swept[i]);
    stretches_.push_back({way.box.low[axis] - way.radius_m, way.box.high[axis] + way.radius_m, i});
  }
  std::sort(stretches_.begin(), stretches_.end(), [](const Stretch& x, const Stretch& y) {
    return x.low_m != y.low_m ? x.low_m < y.low_m : x.swept < y.swept;
  });
}

void BroadPhase::search_along(std::size_t place, std::span<const PlaneBound> planes, std::span<const SweptBound> swept,
                              Collector& found) const {
  const std::uint32_t own = stretches_[place].swept;
  const MotionBound& self = swept[own].start;
  const Way way(swept[own]);
  const auto offer = [&](const auto& other) {
    if (!self.dynamic && !other.dynamic) return;
    if (meet(self.group, self.collides_with, other.group, other.collides_with)) found.add(self.slot, other.slot);
  };
  for (const int grid : used_grids_) {
    visit_along(way, grid, [&](std::uint32_t e) {
      if (way.meets(entries_[e].center_m, entries_[e].radius_m)) offer(entries_[e]);
    });
  }
  for (std::size_t k = place + 1; k < stretches_.size() && stretches_[k].low_m < stretches_[place].high_m; ++k) {
    const SweptBound& other = swept[stretches_[k].swept];
    if (way.meets(Way(other))) offer(other.start);
  }
  if (!self.dynamic) return;
  for (const PlaneBound& plane : planes) {
    const double nearest = std::min(plane.normal.dot(way.from_m), plane.normal.dot(way.to_m));
    if (nearest - plane.height_m >= way.radius_m) continue;
    if (meet(self.group, self.collides_with, plane.group, plane.collides_with)) found.add(self.slot, plane.slot);
  }
}

}  // namespace poise::collision
