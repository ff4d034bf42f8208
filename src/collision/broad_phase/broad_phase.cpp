// SPDX-License-Identifier: MIT
#include "collision/broad_phase/broad_phase.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "collision/broad_phase/broad_phase_cells.h"
#include "parallel/shared_counters.h"

namespace poise::collision {
namespace {

constexpr std::size_t kBoundGrain = 256;
constexpr double kLeastCellM = 1e-6;

// The grid of a ball: those whose diameters lie within one octave share it. Its cells are as wide as its largest ball,
// so they are wider than any ball of a finer grid.
int grid_of(double radius_m) {
  int exponent = 0;
  std::frexp(std::max(2.0 * radius_m, kLeastCellM), &exponent);
  return std::clamp(exponent + 24, 0, 63);
}

}  // namespace

std::uint64_t BroadPhase::bucket(const Cell& cell) const {
  const Grid& grid = grids_[static_cast<std::size_t>(cell.grid)];
  const auto along = [&](std::int32_t at, int axis) { return static_cast<std::uint64_t>(at - grid.least[axis]); };
  return (grid.base + along(cell.x, 0) + grid.row * along(cell.y, 1) + grid.layer * along(cell.z, 2)) & mask_;
}

void BroadPhase::sort_into_cells(std::span<const MotionBound> bounds, parallel::Executor& executor) {
  const std::size_t n = bounds.size();
  cell_of_.resize(n);
  entries_.resize(n);
  bucket_of_.resize(n);
  std::fill(grids_.begin(), grids_.end(), Grid{});
  for (std::size_t i = 0; i < n; ++i) {
    cell_of_[i].grid = grid_of(bounds[i].radius_m);
    Grid& grid = grids_[static_cast<std::size_t>(cell_of_[i].grid)];
    grid.widest_m = std::max(grid.widest_m, 2.0 * bounds[i].radius_m);
  }
  for (Grid& grid : grids_) grid.cells_per_m = 1.0 / std::max(grid.widest_m, kLeastCellM);
  parallel::parallel_for(executor, n, 4 * kBoundGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const double scale = grids_[static_cast<std::size_t>(cell_of_[i].grid)].cells_per_m;
      const Vec3& center = bounds[i].center_m;
      cell_of_[i].x = cell_of(center.x(), scale);
      cell_of_[i].y = cell_of(center.y(), scale);
      cell_of_[i].z = cell_of(center.z(), scale);
    }
  });
  struct Range {
    std::int64_t least[3], most[3];
  };
  Range ranges[kGrids];
  for (const Cell& cell : cell_of_) {
    Grid& grid = grids_[static_cast<std::size_t>(cell.grid)];
    Range& range = ranges[cell.grid];
    const std::int64_t at[3] = {cell.x, cell.y, cell.z};
    for (int axis = 0; axis < 3; ++axis) {
      range.least[axis] = grid.used ? std::min(range.least[axis], at[axis]) : at[axis];
      range.most[axis] = grid.used ? std::max(range.most[axis], at[axis]) : at[axis];
    }
    grid.used = true;
  }
  used_grids_.clear();
  std::uint64_t base = 0;
  for (int g = 0; g < kGrids; ++g) {
    Grid& grid = grids_[static_cast<std::size_t>(g)];
    if (!grid.used) continue;
    used_grids_.push_back(g);
    std::uint64_t size[3];
    for (int axis = 0; axis < 3; ++axis) {
      grid.least[axis] = ranges[g].least[axis] - 1;  // a free border: searches reach one cell beyond
      grid.most[axis] = ranges[g].most[axis] + 1;
      size[axis] = static_cast<std::uint64_t>(ranges[g].most[axis] - ranges[g].least[axis] + 3);
    }
    grid.row = size[0];
    grid.layer = size[0] * size[1];
    grid.base = base;
    base += grid.layer * size[2];
  }
  const std::size_t buckets = std::bit_ceil(std::max<std::size_t>(4 * n, 64));
  mask_ = buckets - 1;
  bucket_begin_.assign(buckets + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    bucket_of_[i] = static_cast<std::uint32_t>(bucket(cell_of_[i]));
    ++bucket_begin_[bucket_of_[i] + 1];
  }
  for (std::size_t i = 1; i <= buckets; ++i) bucket_begin_[i] += bucket_begin_[i - 1];
  for (std::size_t i = 0; i < n; ++i) {
    entries_[bucket_begin_[bucket_of_[i]]++] = {bounds[i].center_m, bounds[i].radius_m, cell_of_[i],
                                                static_cast<std::uint32_t>(i)};
  }
  // Each begin has moved on to its bucket's end, which is the next one's begin.
  std::copy_backward(bucket_begin_.begin(), bucket_begin_.end() - 1, bucket_begin_.end());
  bucket_begin_[0] = 0;
}

void BroadPhase::search(std::size_t entry, std::span<const MotionBound> bounds, std::span<const PlaneBound> planes,
                        std::uint32_t max_partners, Collector& found) const {
  const Entry& self = entries_[entry];
  const MotionBound& bound = bounds[self.bound];
  std::uint32_t partners = 0;
  const auto keep = [&](std::uint32_t slot) {
    if (partners++ < max_partners) {
      found.add(bound.slot, slot);
    } else {
      ++found.discarded;
    }
  };
  const auto test = [&](std::uint32_t e) {
    const Entry& other = entries_[e];
    const double reach = self.radius_m + other.radius_m;
    if ((other.center_m - self.center_m).squaredNorm() >= reach * reach) return;
    const MotionBound& partner = bounds[other.bound];
    if (!bound.dynamic && !partner.dynamic) return;
    if (!meet(bound.group, bound.collides_with, partner.group, partner.collides_with)) return;
    keep(partner.slot);
  };
  // Own grid: half of the neighbourhood, and of the own cell the entries behind this one, so that a pair is found once.
  const Cell own = self.cell;
  const auto shifted = [](const Cell& cell, int dx, int dy, int dz) {
    return Cell{cell.x + dx, cell.y + dy, cell.z + dz, cell.grid};
  };
  visit_row(own, 2, [&](std::uint32_t e) {
    if (entries_[e].cell.x != own.x || e > entry) test(e);
  });
  visit_row(shifted(own, -1, 1, 0), 3, test);
  for (int dy = -1; dy <= 1; ++dy) visit_row(shifted(own, -1, dy, 1), 3, test);
  // Coarser grids: a ball reaches at most half a cell of its own and half of theirs, so again one cell around.
  for (const int g : used_grids_) {
    if (g <= own.grid) continue;
    const double scale = grids_[static_cast<std::size_t>(g)].cells_per_m;
    const Cell home{cell_of(self.center_m.x(), scale), cell_of(self.center_m.y(), scale),
                    cell_of(self.center_m.z(), scale), g};
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) visit_row(shifted(home, -1, dy, dz), 3, test);
    }
  }
  if (!bound.dynamic) return;
  for (const PlaneBound& plane : planes) {
    if (plane.normal.dot(self.center_m) - plane.height_m >= self.radius_m) continue;
    if (meet(bound.group, bound.collides_with, plane.group, plane.collides_with)) found.add(bound.slot, plane.slot);
  }
}

std::size_t BroadPhase::collect(std::span<const MotionBound> bounds, std::span<const PlaneBound> planes,
                                std::span<const SweptBound> swept, std::uint32_t max_partners,
                                parallel::Executor& executor, std::size_t& discarded) {
  parallel::Tickets points;
  parallel::Tickets lost;
  parallel::parallel_for(executor, bounds.size(), kBoundGrain, [&](std::size_t begin, std::size_t end, int) {
    Collector found{found_, points};
    for (std::size_t entry = begin; entry < end; ++entry) search(entry, bounds, planes, max_partners, found);
    found.flush();
    if (found.discarded > 0) lost.take(found.discarded);
  });
  if (!swept.empty()) {
    parallel::parallel_for(executor, swept.size(), 1, [&](std::size_t begin, std::size_t end, int) {
      Collector found{found_, points};
      for (std::size_t own = begin; own < end; ++own) search_along(own, bounds, planes, swept, found);
      found.flush();
    });
  }
  discarded = lost.take(0);
  return points.take(0);
}

// Counting sort by the lower slot, then each lower slot's few partners by comparison.
void BroadPhase::sort_pairs(std::size_t count, parallel::Executor& executor) {
  std::uint32_t slots = 0;
  for (std::size_t i = 0; i < count; ++i) slots = std::max(slots, found_[i].low + 1);
  low_begin_.assign(std::size_t{slots} + 1, 0);
  for (std::size_t i = 0; i < count; ++i) ++low_begin_[found_[i].low + 1];
  for (std::size_t s = 1; s <= slots; ++s) low_begin_[s] += low_begin_[s - 1];
  sorted_.resize(found_.size());
  for (std::size_t i = 0; i < count; ++i) sorted_[low_begin_[found_[i].low]++] = found_[i];
  std::copy_backward(low_begin_.begin(), low_begin_.end() - 1, low_begin_.end());
  low_begin_[0] = 0;
  parallel::parallel_for(executor, slots, 4 * kBoundGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t s = begin; s < end; ++s) {
      std::sort(sorted_.begin() + low_begin_[s], sorted_.begin() + low_begin_[s + 1],
                [](const CandidatePair& x, const CandidatePair& y) { return x.high < y.high; });
    }
  });
}

BroadPhase::Result BroadPhase::find(std::span<const MotionBound> bounds, std::span<const PlaneBound> planes,
                                    std::uint32_t max_partners, parallel::Executor& executor,
                                    std::span<const SweptBound> swept) {
  Result result;
  if (bounds.empty() && swept.empty()) return result;
  sort_into_cells(bounds, executor);
  if (found_.empty()) found_.resize(std::max<std::size_t>(1024, 8 * (bounds.size() + swept.size())));
  std::size_t count = collect(bounds, planes, swept, max_partners, executor, result.discarded);
  if (count > found_.size()) {
    found_.resize(count + count / 2);
    count = collect(bounds, planes, swept, max_partners, executor, result.discarded);
  }
  sort_pairs(count, executor);
  result.pairs = std::span<const CandidatePair>(sorted_).first(count);
  return result;
}

}  // namespace poise::collision
