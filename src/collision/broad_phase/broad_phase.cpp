// SPDX-License-Identifier: MIT
#include "collision/broad_phase/broad_phase.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <utility>

#include "collision/broad_phase/broad_phase_cells.h"
#include "collision/broad_phase/resting_grid.h"
#include "geometry/primitives/bounds.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::collision {
namespace {

constexpr std::size_t kBoundGrain = 256;
constexpr double kLeastCellM = 1e-6;
// A search that tells crowds first looks at so many others for each of the least number of partners that tells one.
// Chosen: a body that is in one has most of those in the cells around it as partners.
constexpr std::uint32_t kTestsOfPartner = 8;

}  // namespace

// The grids in use, and the size of their cells.
void BroadPhase::find_grids(std::span<const MotionBound> bounds, parallel::Executor& executor) {
  const parallel::Ranges ranges(bounds.size(), 4 * kBoundGrain);
  widest_of_range_.resize(ranges.count);
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    std::array<double, kGrids>& widest_m = widest_of_range_[range];
    widest_m.fill(-1);
    for (std::size_t i = begin; i < end; ++i) {
      cell_of_[i].grid = grid_of(bounds[i].radius_m);
      double& widest = widest_m[static_cast<std::size_t>(cell_of_[i].grid)];
      widest = std::max(widest, 2.0 * bounds[i].radius_m);
    }
  });
  used_grids_.clear();
  for (int g = 0; g < kGrids; ++g) {
    double widest_m = -1;
    for (const auto& of_range : widest_of_range_) widest_m = std::max(widest_m, of_range[static_cast<std::size_t>(g)]);
    Grid& grid = grids_[static_cast<std::size_t>(g)];
    grid = Grid{};
    grid.used = widest_m >= 0;
    grid.widest_m = std::max(widest_m, 0.0);
    grid.cells_per_m = 1.0 / std::max(grid.widest_m, kLeastCellM);
    if (grid.used) used_grids_.push_back(g);
  }
}

void BroadPhase::find_cells(std::span<const MotionBound> bounds, parallel::Executor& executor) {
  parallel::parallel_for(executor, bounds.size(), 2 * kBoundGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const double scale = grids_[static_cast<std::size_t>(cell_of_[i].grid)].cells_per_m;
      const Vec3& center = bounds[i].center_m;
      cell_of_[i].x = cell_of(center.x(), scale);
      cell_of_[i].y = cell_of(center.y(), scale);
      cell_of_[i].z = cell_of(center.z(), scale);
      bucket_of_[i] = static_cast<std::uint32_t>(bucket(cell_of_[i]));
    }
  });
}

// Calls write(i, position) for n items, those of one segment after those of the one before, in order of i; fills
// segment_begin_.
template <class SegmentOf, class Write>
void BroadPhase::into_segments(parallel::Executor& executor, std::size_t n, SegmentOf&& segment_of, Write&& write) {
  const parallel::Ranges ranges(n, 4 * kBoundGrain);
  segment_counts_.reserve(parallel::Ranges::kMost);
  segment_counts_.resize(ranges.count);
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    SegmentCounts& counts = segment_counts_[range];
    counts.fill(0);
    for (std::size_t i = begin; i < end; ++i) ++counts[segment_of(i)];
  });
  std::uint32_t sum = 0;
  for (std::size_t segment = 0; segment < kSegments; ++segment) {
    segment_begin_[segment] = sum;
    for (SegmentCounts& counts : segment_counts_) counts[segment] = std::exchange(sum, sum + counts[segment]);
  }
  segment_begin_[kSegments] = sum;
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    SegmentCounts& next = segment_counts_[range];
    for (std::size_t i = begin; i < end; ++i) write(i, next[segment_of(i)]++);
  });
}

// The buckets of one segment, and their entries in the order of the bounds.
void BroadPhase::fill_buckets(std::span<const MotionBound> bounds, std::size_t segment) {
  const std::size_t first = segment << segment_shift_;
  const std::size_t past = std::min((segment + 1) << segment_shift_, bucket_begin_.size() - 1);
  if (first >= past) return;
  const auto begins = bucket_begin_.begin() + static_cast<std::ptrdiff_t>(first);
  const auto ends = bucket_begin_.begin() + static_cast<std::ptrdiff_t>(past);
  const auto members =
      std::span(by_segment_).subspan(segment_begin_[segment], segment_begin_[segment + 1] - segment_begin_[segment]);
  std::fill(begins, ends, 0U);
  for (const std::uint32_t i : members) ++bucket_begin_[bucket_of_[i]];
  const auto start = static_cast<std::uint32_t>(segment_begin_[segment]);
  std::exclusive_scan(begins, ends, begins, start);
  for (const std::uint32_t i : members)
    entries_[bucket_begin_[bucket_of_[i]]++] = {bounds[i].center_m, bounds[i].radius_m, cell_of_[i], i};
  // Each begin has moved on to its bucket's end, which is the next one's begin.
  std::copy_backward(begins, ends - 1, ends);
  *begins = start;
}

void BroadPhase::sort_into_cells(std::span<const MotionBound> bounds, std::uint32_t crowd,
                                 parallel::Executor& executor) {
  const std::size_t n = bounds.size();
  cell_of_.resize(n);
  entries_.resize(n);
  bucket_of_.resize(n);
  by_segment_.resize(n);
  const std::size_t buckets = std::bit_ceil(std::max<std::size_t>(4 * n, kBlockCells));
  block_mask_ = buckets / kBlockCells - 1;
  bucket_begin_.resize(buckets + 1);
  bucket_begin_[buckets] = static_cast<std::uint32_t>(n);
  find_grids(bounds, executor);
  find_cells(bounds, executor);
  segment_shift_ = std::countr_zero(buckets) - std::countr_zero(kSegments);
  into_segments(
      executor, n, [&](std::size_t i) { return bucket_of_[i] >> segment_shift_; },
      [&](std::size_t i, std::uint32_t position) { by_segment_[position] = static_cast<std::uint32_t>(i); });
  parallel::parallel_for(executor, kSegments, n < 4 * kBoundGrain ? kSegments : 1,
                         [&](std::size_t begin, std::size_t end, int) {
                           for (std::size_t segment = begin; segment < end; ++segment) fill_buckets(bounds, segment);
                         });
  if (n <= crowd) return;
  parallel::for_ranges(executor, {buckets, 8 * kBoundGrain}, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      if (bucket_begin_[b + 1] - bucket_begin_[b] > crowd) sort_crowd(b);
    }
  });
}

// Where more lie in one place than a search looks at, those that follow each other are near each other: along a Morton
// curve through the bucket's box.
void BroadPhase::sort_crowd(std::size_t bucket) {
  const auto begin = entries_.begin() + bucket_begin_[bucket];
  const auto end = entries_.begin() + bucket_begin_[bucket + 1];
  geometry::Bounds box;
  for (auto entry = begin; entry != end; ++entry) box.add(entry->center_m);
  const Vec3 scale = (box.high - box.low).unaryExpr([](double size_m) { return size_m > 0 ? 1023.0 / size_m : 0.0; });
  const auto place = [&](const Entry& entry) {
    std::uint32_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::uint32_t>((entry.center_m[axis] - box.low[axis]) * scale[axis]);
      for (std::uint32_t bit = 0; bit < 10; ++bit)
        code |= (at >> bit & 1U) << (3 * bit + static_cast<std::uint32_t>(axis));
    }
    return code;
  };
  // Entries are in the order of their bounds.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> places;
  places.reserve(static_cast<std::size_t>(end - begin));
  for (auto entry = begin; entry != end; ++entry)
    places.emplace_back(place(*entry), static_cast<std::uint32_t>(entry - begin));
  std::sort(places.begin(), places.end());
  const std::vector<Entry> unsorted(begin, end);
  std::transform(places.begin(), places.end(), begin, [&](const auto& at) { return unsorted[at.second]; });
}

// The cells that each grid uses.
void BroadPhase::find_ranges() {
  for (const int g : used_grids_) {
    std::fill_n(grids_[static_cast<std::size_t>(g)].least, 3, std::numeric_limits<std::int64_t>::max());
    std::fill_n(grids_[static_cast<std::size_t>(g)].most, 3, std::numeric_limits<std::int64_t>::min());
  }
  for (const Cell& cell : cell_of_) {
    Grid& grid = grids_[static_cast<std::size_t>(cell.grid)];
    const std::int64_t at[3] = {cell.x, cell.y, cell.z};
    for (int axis = 0; axis < 3; ++axis) {
      grid.least[axis] = std::min(grid.least[axis], at[axis]);
      grid.most[axis] = std::max(grid.most[axis], at[axis]);
    }
  }
}

std::size_t BroadPhase::find_partners(std::size_t entry, std::span<const MotionBound> bounds, std::uint32_t& room,
                                      const RestingGrid* resting, std::vector<Partner>& partners) const {
  const Entry& self = entries_[entry];
  const MotionBound& bound = bounds[self.bound];
  partners.clear();
  std::size_t left = 0;
  const auto test = [&](std::uint32_t e) {
    const Entry& other = entries_[e];
    const double reach = self.radius_m + other.radius_m;
    const double beyond_m2 = (other.center_m - self.center_m).squaredNorm() - reach * reach;
    if (beyond_m2 >= 0) return;
    const MotionBound& partner = bounds[other.bound];
    if (!bound.dynamic && !partner.dynamic) return;
    if (!meet(bound.group, bound.collides_with, partner.group, partner.collides_with)) return;
    partners.push_back({beyond_m2, partner.slot});
  };
  // Own grid: half of the neighbourhood, and of the own cell the entries behind this one, so that a pair is found once.
  // The next cell of the row mostly follows in the same block.
  const Cell own = self.cell;
  const auto shifted = [](const Cell& cell, int dx, int dy, int dz) {
    return Cell{cell.x + dx, cell.y + dy, cell.z + dz, cell.grid};
  };
  const auto behind = static_cast<std::uint32_t>(entry + 1);
  const bool next_follows = (own.x & (kBlockRow - 1)) != kBlockRow - 1;
  const std::uint32_t own_end = bucket_begin_[bucket(own) + (next_follows ? 2 : 1)];
  const std::uint32_t looked_at = std::min(own_end - behind, room);
  for (std::uint32_t e = behind; e < behind + looked_at; ++e) {
    const Cell& cell = entries_[e].cell;
    const std::int32_t next = cell.x - own.x;
    if (cell.y == own.y && cell.z == own.z && cell.grid == own.grid && (next == 0 || next == 1)) test(e);
  }
  room -= looked_at;
  left += own_end - behind - looked_at;
  const auto visit = [&](const Cell& first, std::int32_t count) { left += visit_row(first, count, room, test); };
  if (!next_follows) visit(shifted(own, 1, 0, 0), 1);
  visit(shifted(own, -1, 1, 0), 3);
  for (int dy = -1; dy <= 1; ++dy) visit(shifted(own, -1, dy, 1), 3);
  // Coarser grids: the cells that hold the centre of any ball that it can meet. Rounding must lose none of them.
  constexpr double kRounding = 1e-15;
  for (const int g : used_grids_) {
    if (g <= own.grid) continue;
    const Grid& grid = grids_[static_cast<std::size_t>(g)];
    const double reach = self.radius_m + 0.5 * grid.widest_m;
    const Vec3 around = Vec3::Constant((1.0 + kRounding) * reach) + kRounding * self.center_m.cwiseAbs();
    const Vec3 low = self.center_m - around;
    const Vec3 high = self.center_m + around;
    const std::int32_t first_x = cell_of(low.x(), grid.cells_per_m);
    const std::int32_t count = cell_of(high.x(), grid.cells_per_m) - first_x + 1;
    const std::int32_t last_y = cell_of(high.y(), grid.cells_per_m);
    const std::int32_t last_z = cell_of(high.z(), grid.cells_per_m);
    for (std::int32_t z = cell_of(low.z(), grid.cells_per_m); z <= last_z; ++z) {
      for (std::int32_t y = cell_of(low.y(), grid.cells_per_m); y <= last_y; ++y) visit({first_x, y, z, g}, count);
    }
  }
  if (resting != nullptr && bound.dynamic) {
    left += resting->visit_near(
        self.center_m, self.radius_m, room, [&](std::uint32_t slot, const RestingGrid::Entry& other) {
          const double reach = self.radius_m + other.radius_m;
          const double beyond_m2 = (other.center_m - self.center_m).squaredNorm() - reach * reach;
          if (beyond_m2 < 0 && meet(bound.group, bound.collides_with, other.group, other.collides_with))
            partners.push_back({beyond_m2, slot});
        });
  }
  return left;
}

void BroadPhase::search(std::size_t entry, std::span<const MotionBound> bounds, std::span<const PlaneBound> planes,
                        const PartnerLimits& limits, const RestingGrid* resting, Collector& found) const {
  const Entry& self = entries_[entry];
  const MotionBound& bound = bounds[self.bound];
  std::uint32_t most = most_tests(limits.of_body);
  std::uint32_t partners = limits.of_body;
  if (limits.crowds != nullptr) most = std::min(most, kTestsOfPartner * CrowdedBodies::kLeast);
  std::uint32_t room = most;
  std::size_t left = find_partners(entry, bounds, room, resting, found.partners);
  if (limits.crowds != nullptr && (left > 0 || found.partners.size() > CrowdedBodies::kLeast)) {
    const std::uint32_t outside = limits.crowds->most_partners(bound.slot);
    if (left > 0 && found.partners.size() <= outside) {
      // What it looked at tells of no crowd.
      found.looked_at += most - room;
      most = room = most_tests(limits.of_body);
      left = find_partners(entry, bounds, room, resting, found.partners);
    }
    if (found.partners.size() > outside) partners = std::min(partners, std::max(limits.of_crowded, outside / 4));
  }
  found.discarded += left;
  found.looked_at += most - room;
  found.keep_nearest(bound.slot, partners);
  if (!bound.dynamic) return;
  for (const PlaneBound& plane : planes) {
    if (plane.normal.dot(self.center_m) - plane.height_m >= self.radius_m) continue;
    if (meet(bound.group, bound.collides_with, plane.group, plane.collides_with)) found.add(bound.slot, plane.slot);
  }
}

std::size_t BroadPhase::collect(std::span<const MotionBound> bounds, std::span<const PlaneBound> planes,
                                std::span<const SweptBound> swept, const PartnerLimits& limits,
                                const RestingGrid* resting, parallel::Executor& executor, Result& result) {
  parallel::Tickets points;
  parallel::Tickets lost;
  parallel::Tickets looked_at;
  scratch_.resize(static_cast<std::size_t>(executor.concurrency()));
  const auto collector = [&](int worker) {
    return Collector{found_, points, scratch_[static_cast<std::size_t>(worker)].partners};
  };
  parallel::parallel_for(executor, bounds.size(), kBoundGrain, [&](std::size_t begin, std::size_t end, int worker) {
    Collector found = collector(worker);
    for (std::size_t entry = begin; entry < end; ++entry) search(entry, bounds, planes, limits, resting, found);
    found.flush();
    if (found.discarded > 0) lost.take(found.discarded);
    looked_at.take(found.looked_at);
  });
  if (!swept.empty()) {
    find_ranges();
    sort_swept(swept);
    parallel::parallel_for(executor, swept.size(), 1, [&](std::size_t begin, std::size_t end, int worker) {
      Collector found = collector(worker);
      for (std::size_t place = begin; place < end; ++place) search_along(place, bounds, planes, swept, found);
      found.flush();
    });
  }
  result.discarded = lost.take(0);
  result.looked_at = looked_at.take(0);
  return points.take(0);
}

// The pairs of one segment by the lower slot, and each lower slot's few partners by comparison.
void BroadPhase::sort_segment(std::size_t segment, std::uint32_t slots) {
  const std::size_t first = std::min<std::size_t>(segment << segment_shift_, slots);
  const std::size_t past = std::min<std::size_t>((segment + 1) << segment_shift_, slots);
  if (first == past) return;
  const auto begins = low_begin_.begin() + static_cast<std::ptrdiff_t>(first);
  const auto ends = low_begin_.begin() + static_cast<std::ptrdiff_t>(past);
  const std::size_t count = segment_begin_[segment + 1] - segment_begin_[segment];
  const auto members = std::span(in_segments_).subspan(segment_begin_[segment], count);
  std::fill(begins, ends, 0U);
  for (const CandidatePair& pair : members) ++low_begin_[pair.low];
  auto from = static_cast<std::uint32_t>(segment_begin_[segment]);
  std::exclusive_scan(begins, ends, begins, from);
  for (const CandidatePair& pair : members) sorted_[low_begin_[pair.low]++] = pair;
  for (auto end = begins; end != ends; from = *end++) {
    std::sort(sorted_.begin() + from, sorted_.begin() + *end,
              [](const CandidatePair& x, const CandidatePair& y) { return x.high < y.high; });
  }
}

void BroadPhase::sort_pairs(std::size_t count, parallel::Executor& executor) {
  const parallel::Ranges ranges(count, 4 * kBoundGrain);
  slots_of_range_.reserve(parallel::Ranges::kMost);
  slots_of_range_.assign(ranges.count, 0);
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    std::uint32_t slots = 0;
    for (std::size_t i = begin; i < end; ++i) slots = std::max(slots, found_[i].low + 1);
    slots_of_range_[range] = slots;
  });
  const std::uint32_t slots = *std::max_element(slots_of_range_.begin(), slots_of_range_.end());
  low_begin_.resize(slots);
  sorted_.resize(found_.size());
  in_segments_.resize(found_.size());
  segment_shift_ = std::max(static_cast<int>(std::bit_width(slots)) - std::countr_zero(kSegments), 0);
  into_segments(
      executor, count, [&](std::size_t i) { return found_[i].low >> segment_shift_; },
      [&](std::size_t i, std::uint32_t position) { in_segments_[position] = found_[i]; });
  parallel::parallel_for(executor, kSegments, count < 4 * kBoundGrain ? kSegments : 1,
                         [&](std::size_t begin, std::size_t end, int) {
                           for (std::size_t segment = begin; segment < end; ++segment) sort_segment(segment, slots);
                         });
}

BroadPhase::Result BroadPhase::find(std::span<const MotionBound> bounds, std::span<const PlaneBound> planes,
                                    const PartnerLimits& limits, parallel::Executor& executor,
                                    std::span<const SweptBound> swept, const RestingGrid* resting) {
  Result result;
  PartnerLimits used = limits;
  if (bounds.empty() && swept.empty()) return result;
  sort_into_cells(bounds, limits.crowds != nullptr ? kTestsOfPartner * CrowdedBodies::kLeast : most_tests(0), executor);
  if (found_.empty()) found_.resize(std::max<std::size_t>(1024, 8 * (bounds.size() + swept.size())));
  std::size_t count = collect(bounds, planes, swept, used, resting, executor, result);
  if (count > limits.of_all && !bounds.empty()) {
    used.of_body =
        std::min(used.of_body, static_cast<std::uint32_t>(std::max<std::size_t>(1, limits.of_all / bounds.size())));
    count = collect(bounds, planes, swept, used, resting, executor, result);
  }
  if (count > found_.size()) {
    found_.resize(count + count / 2);
    count = collect(bounds, planes, swept, used, resting, executor, result);
  }
  sort_pairs(count, executor);
  result.pairs = std::span<const CandidatePair>(sorted_).first(count);
  return result;
}

}  // namespace poise::collision
