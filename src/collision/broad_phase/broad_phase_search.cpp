// SPDX-License-Identifier: MIT
#include <algorithm>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/broad_phase_cells.h"
#include "collision/broad_phase/near_kernel.h"
#include "collision/broad_phase/resting_grid.h"
#include "parallel/shared_counters.h"
#include "poise_assert.h"

namespace poise::collision {
namespace {

constexpr std::size_t kSearchGrain = 256;

// How many balls lie in the ranges; beyond `room`, which it lowers by those that remain, they are cut off.
std::size_t cut_to_room(std::span<NearRange> ranges, std::uint32_t& room) {
  std::size_t cut = 0;
  for (NearRange& range : ranges) {
    const std::uint32_t taken = std::min(range.end - range.begin, room);
    cut += range.end - range.begin - taken;
    range.end = range.begin + taken;
    room -= taken;
  }
  return cut;
}

}  // namespace

// Cells in a row along x: what lies in one block lies side by side.
struct BroadPhase::RowPieces {
  struct Piece {
    BlockKey first;
    std::uint32_t length;
  };
  Piece pieces[2];
  std::size_t count = 0;
  RowPieces(std::int32_t first_x, std::int32_t length) {
    POISE_ASSERT(length <= kBlockRow);  // so there are two at most
    const std::int32_t end = first_x + length;
    for (std::int32_t x = first_x; x < end;) {
      const std::int32_t next = std::min(end, (x | (kBlockRow - 1)) + 1);
      pieces[count++] = {BlockKey::of_x(x), static_cast<std::uint32_t>(next - x)};
      x = next;
    }
  }
};

// Adds the cells of rows first_y to last_y, but for those that are empty: which these are is not foreseen, so no branch
// depends on it.
void BroadPhase::list_rows(const RowPieces& along, std::int32_t first_y, std::int32_t last_y, const BlockKey& layer,
                           RangeList& ranges) const {
  ranges.make_room(2 * static_cast<std::size_t>(last_y - first_y + 1));
  NearRange* next = ranges.list.data() + ranges.count;
  for (std::int32_t y = first_y; y <= last_y; ++y) {
    const BlockKey row = BlockKey::of_y(y) + layer;
    for (std::size_t k = 0; k < along.count; ++k) {
      const BlockKey first = along.pieces[k].first + row;
      const std::uint32_t* const begins = &bucket_begin_[first.bucket(block_mask_)];
      const std::uint32_t begin = begins[0];
      const std::uint32_t past = begins[along.pieces[k].length];
      *next = {begin, past, first.tag};
      next += begin < past ? 1 : 0;
    }
  }
  ranges.count = static_cast<std::size_t>(next - ranges.list.data());
}

// Half of the neighbourhood, so that a pair is found once; of the own cell, in the first row, find_partners looks at
// the entries behind its own. The next cell of that row mostly follows in the same block.
void BroadPhase::list_own_grid(const Cell& own, Scratch& scratch) const {
  RangeList& ranges = scratch.ranges;
  ranges.count = 0;
  const BlockKey layer = BlockKey::of_z(own.z) + BlockKey::of_grid(own.grid);
  list_rows({own.x, 2}, own.y, own.y, layer, ranges);
  const RowPieces around(own.x - 1, 3);
  list_rows(around, own.y + 1, own.y + 1, layer, ranges);
  list_rows(around, own.y - 1, own.y + 1, BlockKey::of_z(own.z + 1) + BlockKey::of_grid(own.grid), ranges);
  scratch.around = own;
  scratch.of_own_grid = ranges.count;
}

// The cells that hold the centre of any ball of a grid that a ball can meet. Rounding must lose none of them. False
// where they are too many to look at: the ball is far larger than those of the grid.
bool BroadPhase::list_grid(const Vec3& center_m, double radius_m, int grid, RangeList& ranges) const {
  constexpr double kRounding = 1e-15;
  const Grid& of = grids_[static_cast<std::size_t>(grid)];
  const double reach = radius_m + 0.5 * of.widest_m;
  if (!(2 * reach * of.cells_per_m <= kBlockRow / 2.0)) return false;
  const Vec3 around = Vec3::Constant((1.0 + kRounding) * reach) + kRounding * center_m.cwiseAbs();
  const Vec3 low = center_m - around;
  const Vec3 high = center_m + around;
  const std::int32_t first_x = cell_of(low.x(), of.cells_per_m);
  const RowPieces along(first_x, cell_of(high.x(), of.cells_per_m) - first_x + 1);
  const std::int32_t first_y = cell_of(low.y(), of.cells_per_m);
  const std::int32_t last_y = cell_of(high.y(), of.cells_per_m);
  const std::int32_t last_z = cell_of(high.z(), of.cells_per_m);
  for (std::int32_t z = cell_of(low.z(), of.cells_per_m); z <= last_z; ++z)
    list_rows(along, first_y, last_y, BlockKey::of_z(z) + BlockKey::of_grid(grid), ranges);
  return true;
}

void BroadPhase::list_coarser_grids(const Entry& self, RangeList& ranges) const {
  for (const int g : used_grids_) {
    if (g > self.cell.grid) list_grid(self.center_m, self.radius_m, g, ranges);
  }
}

std::size_t BroadPhase::find_partners(std::uint32_t entry, std::uint32_t& room, const RestingGrid* resting,
                                      Scratch& scratch) const {
  const Entry& self = entries_[entry];
  if (scratch.of_own_grid == 0 || !(scratch.around == self.cell)) list_own_grid(self.cell, scratch);
  scratch.ranges.count = scratch.of_own_grid;
  scratch.ranges.list.front().begin = entry + 1;
  list_coarser_grids(self, scratch.ranges);
  const std::span<NearRange> ranges = std::span(scratch.ranges.list).first(scratch.ranges.count);
  std::size_t count = 0;
  for (const NearRange& range : ranges) count += range.end - range.begin;
  std::size_t left = 0;
  if (count <= room) {
    room -= static_cast<std::uint32_t>(count);
  } else {
    left = cut_to_room(ranges, room);
    scratch.of_own_grid = 0;
  }
  std::uint32_t* const hits = scratch.hits.data();
  // Where blocks share a place, the tag tells them apart: those of equal tag are not near.
  const NearCount near = list_near(near_.balls(), near_.ball(entry), ranges, hits);
  scratch.partners = near.listed;
  if (!near.sure) {
    const auto no_partner = [&](std::uint32_t e) {
      const Entry& other = entries_[e];
      return !overlap(beyond_m2(self, other)) || !(self.dynamic || other.dynamic) ||
             !meet(self.group, self.collides_with, other.group, other.collides_with);
    };
    scratch.partners = static_cast<std::size_t>(std::remove_if(hits, hits + near.listed, no_partner) - hits);
  }
  scratch.resting.clear();
  if (resting != nullptr && self.dynamic) {
    left += resting->visit_near(
        self.center_m, self.radius_m, room, [&](std::uint32_t slot, const RestingGrid::Entry& other) {
          const double beyond = beyond_m2(self, other);
          if (overlap(beyond) && meet(self.group, self.collides_with, other.group, other.collides_with))
            scratch.resting.push_back({beyond, slot});
        });
  }
  return left;
}

// Adds the partners of a search, if they are too many the nearest of them.
void BroadPhase::keep_nearest(const Entry& self, std::uint32_t max_partners, Scratch& scratch, Collector& found) const {
  std::vector<Partner>& partners = scratch.resting;
  if (scratch.found() > max_partners) {
    for (const std::uint32_t e : std::span(scratch.hits).first(scratch.partners))
      partners.push_back({beyond_m2(self, entries_[e]), entries_[e].slot});
    scratch.partners = 0;
    found.discarded += partners.size() - max_partners;
    const auto end = partners.begin() + max_partners;
    std::nth_element(partners.begin(), end, partners.end(), [](const Partner& x, const Partner& y) {
      return x.beyond_m2 != y.beyond_m2 ? x.beyond_m2 < y.beyond_m2 : x.slot < y.slot;
    });
    partners.erase(end, partners.end());
  }
  found.add_all(self.slot, scratch.partners, [&](std::size_t i) { return near_.slot[scratch.hits[i]]; });
  found.add_all(self.slot, partners.size(), [&](std::size_t i) { return partners[i].slot; });
}

void BroadPhase::search(std::uint32_t entry, std::span<const PlaneBound> planes, const PartnerLimits& limits,
                        const RestingGrid* resting, Scratch& scratch, Collector& found) const {
  const Entry& self = entries_[entry];
  std::uint32_t most = most_tests(limits.of_body);
  std::uint32_t partners = limits.of_body;
  if (limits.crowds != nullptr) most = std::min(most, most_tests_of_crowded());
  std::uint32_t room = most;
  std::size_t left = find_partners(entry, room, resting, scratch);
  if (limits.crowds != nullptr && (left > 0 || scratch.found() > CrowdedBodies::kLeast)) {
    const std::uint32_t outside = limits.crowds->most_partners(self.slot);
    if (left > 0 && scratch.found() <= outside) {
      // What it looked at tells of no crowd.
      found.looked_at += most - room;
      most = room = most_tests(limits.of_body);
      left = find_partners(entry, room, resting, scratch);
    }
    if (scratch.found() > outside) partners = std::min(partners, std::max(limits.of_crowded, outside / 4));
  }
  found.discarded += left;
  found.looked_at += most - room;
  scratch.most_found = std::max(scratch.most_found, scratch.found());
  keep_nearest(self, partners, scratch, found);
  for_planes(self, planes, [&](std::uint32_t plane) { found.add(self.slot, plane); });
}

// As much for each worker as any search of find() may need, so that no later step has to allocate.
void BroadPhase::make_scratch(std::size_t bounds, std::uint32_t max_partners, parallel::Executor& executor) {
  constexpr std::size_t kRangesOfGrid = 32;
  const std::size_t hits = std::min<std::size_t>(bounds, most_tests(max_partners)) + NearBalls::kPast;
  scratch_.resize(static_cast<std::size_t>(executor.concurrency()));
  for (Scratch& scratch : scratch_) {
    scratch.ranges.count = scratch.of_own_grid = scratch.most_found = 0;
    scratch.ranges.make_room(kRangesOfGrid * (used_grids_.size() + 1));
    if (scratch.hits.size() < hits) scratch.hits.resize(hits);
  }
}

std::size_t BroadPhase::collect(std::size_t bounds, std::span<const PlaneBound> planes,
                                std::span<const SweptBound> swept, const PartnerLimits& limits,
                                const RestingGrid* resting, parallel::Executor& executor, Result& result) {
  parallel::Tickets points;
  parallel::Tickets lost;
  parallel::Tickets looked_at;
  make_scratch(bounds, limits.of_body, executor);
  parallel::parallel_for(executor, bounds, kSearchGrain, [&](std::size_t begin, std::size_t end, int worker) {
    Scratch& scratch = scratch_[static_cast<std::size_t>(worker)];
    Collector found(found_, points);
    for (std::size_t entry = begin; entry < end; ++entry)
      search(static_cast<std::uint32_t>(entry), planes, limits, resting, scratch, found);
    found.flush();
    if (found.discarded > 0) lost.take(found.discarded);
    looked_at.take(found.looked_at);
  });
  if (!swept.empty()) {
    find_ranges();
    sort_swept(swept);
    parallel::parallel_for(executor, swept.size(), 1, [&](std::size_t begin, std::size_t end, int) {
      Collector found(found_, points);
      for (std::size_t place = begin; place < end; ++place) search_along(place, planes, swept, found);
      found.flush();
    });
  }
  result.discarded = lost.take(0);
  result.looked_at = looked_at.take(0);
  return points.take(0);
}

}  // namespace poise::collision
