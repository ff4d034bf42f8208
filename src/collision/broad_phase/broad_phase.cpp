// SPDX-License-Identifier: MIT
#include "collision/broad_phase/broad_phase.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <utility>

#include "collision/broad_phase/broad_phase_cells.h"
#include "collision/broad_phase/order_kernel.h"
#include "geometry/primitives/bounds.h"
#include "parallel/ranges.h"

namespace poise::collision {
namespace {

constexpr std::size_t kBoundGrain = 256;
constexpr double kLeastCellM = 1e-6;

}  // namespace

void BroadPhase::NearArrays::resize(std::size_t n) {
  // What is read past the end is set too.
  for (auto* values : {&x, &y, &z, &most_m, &least_m}) {
    parallel::make_room_anew(*values, n + NearBalls::kPast);
    values->resize(n);
    values->resize(n + NearBalls::kPast, 0.0F);
  }
  parallel::make_room_anew(tag, n + NearBalls::kPast);
  tag.resize(n);
  tag.resize(n + NearBalls::kPast, 0U);
  slot.resize(n);
}

void BroadPhase::NearArrays::set(std::size_t at, const Entry& entry) {
  // Two of these meet, whatever their groups.
  const bool plain = entry.dynamic && entry.group != 0 && entry.collides_with == 0xffffffffU;
  const NearBall ball = near_ball(entry.center_m, entry.radius_m, plain);
  x[at] = ball.x;
  y[at] = ball.y;
  z[at] = ball.z;
  most_m[at] = ball.most_m;
  least_m[at] = ball.least_m;
  tag[at] = block_key(entry.cell.x, entry.cell.y, entry.cell.z, entry.cell.grid).tag;
  slot[at] = entry.slot;
}

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

// Calls write(i, position) for n items, those of one of segments_ after those of the one before, in order of i; fills
// segment_begin_.
template <class SegmentOf, class Write>
void BroadPhase::into_segments(parallel::Executor& executor, std::size_t n, SegmentOf&& segment_of, Write&& write) {
  const parallel::Ranges ranges(n, 4 * kBoundGrain);
  segment_counts_.reserve(parallel::Ranges::kMost);
  segment_counts_.resize(ranges.count);
  parallel::for_ranges(executor, ranges, [&](std::size_t range, std::size_t begin, std::size_t end) {
    SegmentCounts& counts = segment_counts_[range];
    std::fill_n(counts.begin(), segments_, 0U);
    for (std::size_t i = begin; i < end; ++i) ++counts[segment_of(i)];
  });
  std::uint32_t sum = 0;
  for (std::size_t segment = 0; segment < segments_; ++segment) {
    segment_begin_[segment] = sum;
    for (SegmentCounts& counts : segment_counts_) counts[segment] = std::exchange(sum, sum + counts[segment]);
  }
  segment_begin_[segments_] = sum;
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
  for (const std::uint32_t i : members) {
    const MotionBound& bound = bounds[i];
    const std::uint32_t at = bucket_begin_[bucket_of_[i]]++;
    entries_[at] = {bound.center_m, bound.radius_m,      cell_of_[i],  bound.slot,
                    bound.group,    bound.collides_with, bound.dynamic};
    near_.set(at, entries_[at]);
  }
  // Each begin has moved on to its bucket's end, which is the next one's begin.
  std::copy_backward(begins, ends - 1, ends);
  *begins = start;
}

void BroadPhase::sort_into_cells(std::span<const MotionBound> bounds, std::uint32_t crowd,
                                 parallel::Executor& executor) {
  const std::size_t n = bounds.size();
  cell_of_.resize(n);
  entries_.resize(n);
  near_.resize(n);
  bucket_of_.resize(n);
  by_segment_.resize(n);
  const std::size_t buckets = std::bit_ceil(std::max<std::size_t>(4 * n, kBlockCells));
  block_mask_ = buckets / kBlockCells - 1;
  bucket_begin_.resize(buckets + 1);
  bucket_begin_[buckets] = static_cast<std::uint32_t>(n);
  find_grids(bounds, executor);
  find_cells(bounds, executor);
  segments_ = segments_for(n);
  segment_shift_ = std::max(std::countr_zero(buckets) - std::countr_zero(segments_), 0);
  into_segments(
      executor, n, [&](std::size_t i) { return bucket_of_[i] >> segment_shift_; },
      [&](std::size_t i, std::uint32_t position) { by_segment_[position] = static_cast<std::uint32_t>(i); });
  parallel::parallel_for(executor, segments_, n < 4 * kBoundGrain ? segments_ : 1,
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
  for (std::uint32_t e = bucket_begin_[bucket]; e < bucket_begin_[bucket + 1]; ++e) near_.set(e, entries_[e]);
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
  const auto from = static_cast<std::uint32_t>(segment_begin_[segment]);
  std::exclusive_scan(begins, ends, begins, from);
  for (const CandidatePair& pair : members) high_[low_begin_[pair.low]++] = pair.high;
  // Each begin has moved on to its list's end.
  if (order_partners({static_cast<std::uint32_t>(first), from, {begins, ends}, high_.data()}, sorted_.data())) return;
  std::uint32_t begin = from;
  for (std::size_t low = first; low < past; begin = low_begin_[low++]) {
    if (low_begin_[low] - begin > kLongestOrdered) order_long(static_cast<std::uint32_t>(low), begin, low_begin_[low]);
  }
}

// The many partners of a plane, which are a good part of all slots: a bit for each, and then the bits in order.
void BroadPhase::order_long(std::uint32_t low, std::uint32_t begin, std::uint32_t end) {
  const auto high = std::span(high_).subspan(begin, end - begin);
  const auto [least, most] = std::minmax_element(high.begin(), high.end());
  const std::size_t first = *least / 64;
  const std::size_t past = *most / 64 + 1;
  CandidatePair* next = sorted_.data() + begin;
  if (past - first > high.size()) {
    std::sort(high.begin(), high.end());
    for (const std::uint32_t slot : high) *next++ = {low, slot};
    return;
  }
  const auto marks = std::span(marks_).subspan(begin, past - first);
  std::fill(marks.begin(), marks.end(), 0);
  for (const std::uint32_t slot : high) marks[slot / 64 - first] |= std::uint64_t{1} << slot % 64;
  for (std::size_t word = first; word < past; ++word) {
    for (std::uint64_t left = marks[word - first]; left != 0; left &= left - 1)
      *next++ = {low, static_cast<std::uint32_t>(64 * word) + static_cast<std::uint32_t>(std::countr_zero(left))};
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
  marks_.resize(found_.size());
  high_.resize(found_.size() + PartnerLists::kPast);
  segments_ = segments_for(count);
  segment_shift_ = std::max(static_cast<int>(std::bit_width(slots)) - std::countr_zero(segments_), 0);
  into_segments(
      executor, count, [&](std::size_t i) { return found_[i].low >> segment_shift_; },
      [&](std::size_t i, std::uint32_t position) { in_segments_[position] = found_[i]; });
  parallel::parallel_for(executor, segments_, count < 4 * kBoundGrain ? segments_ : 1,
                         [&](std::size_t begin, std::size_t end, int) {
                           for (std::size_t segment = begin; segment < end; ++segment) sort_segment(segment, slots);
                         });
}

BroadPhase::Result BroadPhase::find(std::span<const MotionBound> bounds, std::span<const PlaneBound> planes,
                                    const PartnerLimits& limits, parallel::Executor& executor,
                                    std::span<const SweptBound> swept, const RestingGrid* resting) {
  Result result;
  PartnerLimits used = limits;
  moved_.clear();
  pair_count_ = found_pairs_ = most_found_ = 0;
  if (bounds.empty() && swept.empty()) return result;
  sort_into_cells(bounds, limits.crowds != nullptr ? most_tests_of_crowded() : most_tests(0), executor);
  if (found_.empty()) found_.resize(std::max<std::size_t>(1024, 8 * (bounds.size() + swept.size())));
  std::size_t count = collect(bounds.size(), planes, swept, used, resting, executor, result);
  if (count > limits.of_all && !bounds.empty()) {
    used.of_body =
        std::min(used.of_body, static_cast<std::uint32_t>(std::max<std::size_t>(1, limits.of_all / bounds.size())));
    count = collect(bounds.size(), planes, swept, used, resting, executor, result);
  }
  if (count > found_.size()) {
    parallel::reserve_anew(found_, count + count / 2);
    found_.resize(count + count / 2);
    count = collect(bounds.size(), planes, swept, used, resting, executor, result);
  }
  sort_pairs(count, executor);
  pair_count_ = found_pairs_ = count;
  for (const Scratch& scratch : scratch_) most_found_ = std::max(most_found_, scratch.most_found);
  result.pairs = sorted_pairs();
  return result;
}

}  // namespace poise::collision
