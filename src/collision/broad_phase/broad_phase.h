// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/broad_phase/candidate_pair.h"
#include "collision/broad_phase/grid_blocks.h"
#include "collision/broad_phase/near_kernel.h"
#include "parallel/executor.h"
#include "parallel/unset_vector.h"
#include "poise/types.h"

namespace poise::collision {

/// A ball that contains a body throughout the step.
struct MotionBound {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;  ///< bounding radius and all motion of the step, >= 0
  std::uint32_t slot = 0;
  std::uint32_t group = 1;
  std::uint32_t collides_with = 0xffffffffU;
  bool dynamic = true;
};

/// A body that moves far in the step: its ball at the start and the straight path of its centre.
struct SweptBound {
  MotionBound start;
  Vec3 motion_m = Vec3::Zero();
};

/// A static half-space normal . x <= height, world frame.
struct PlaneBound {
  Vec3 normal = Vec3::UnitZ();
  double height_m = 0;
  std::uint32_t slot = 0;
  std::uint32_t group = 1;
  std::uint32_t collides_with = 0xffffffffU;
};

class RestingGrid;

/// Tells a body in a crowd, with more partners than solid bodies have that do not lie within each other.
class CrowdedBodies {
 public:
  virtual ~CrowdedBodies() = default;
  static constexpr std::uint32_t kLeast = 32;
  /// The most partners that the search of a body may find without being in a crowd; at least kLeast. Any thread.
  [[nodiscard]] virtual std::uint32_t most_partners(std::uint32_t slot) const = 0;
};

/// How many candidate pairs there may be.
struct PartnerLimits {
  std::uint32_t of_body = 256;  ///< partners that the search of one body finds
  /// Pairs of all bodies. Those with planes and of swept bodies count, but none of them is left out.
  std::size_t of_all = std::numeric_limits<std::size_t>::max();
  /// Where it is set, a body in a crowd keeps of_crowded partners, but at least a quarter of the most that it could
  /// have outside of one.
  const CrowdedBodies* crowds = nullptr;
  std::uint32_t of_crowded = 0;
};

/// Finds all pairs of overlapping motion bounds: a grid for each power of two of size, all in one hash table that holds
/// blocks of neighbouring cells side by side. Invariant: buffers only grow, so that a scene that was seen once needs no
/// allocation.
class BroadPhase {
 public:
  struct Result {
    std::span<const CandidatePair> pairs;  ///< sorted by (low, high), each once; valid until the next call
    std::size_t discarded = 0;             ///< candidate partners discarded beyond the limits
    std::size_t looked_at = 0;             ///< bounds that the searches looked at: what the grid cost
  };
  /// At least one of a pair is dynamic, and each is in a group that the other collides with. Each bound has at most
  /// limits.of_body partners found by its own search, the nearest of those that it looked at; where all together have
  /// more than limits.of_all, it has at most its equal share of them. The same result on any number of threads. Linear
  /// in bounds and pairs, also where many lie in one place: there a search looks at no more than
  /// most_tests(limits.of_body) others, or fewer once these tell a crowd, and counts the rest as discarded. `swept`
  /// bodies are not in the grid: each searches the cells along its path, or all entries if these are fewer, and keeps
  /// every partner on it; swept bodies whose paths are near along the axis on which they are spread most are compared
  /// with each other. Without swept bodies this costs nothing. Bounds in `resting` are found by those that move and
  /// search for nothing themselves; swept bodies do not look there.
  Result find(std::span<const MotionBound> bounds, std::span<const PlaneBound> planes, const PartnerLimits& limits,
              parallel::Executor& executor, std::span<const SweptBound> swept = {},
              const RestingGrid* resting = nullptr);
  /// What find() found, and the pairs of bounds that are elsewhere since: those of a few are looked for one by one.
  /// Pairs that no longer overlap stay. `moved` are their numbers in `bounds`, ascending; all others, the planes and
  /// what rests are as they were. Empty where more than most_moved(bounds) are elsewhere since find(), where they have
  /// added more than a sixteenth of its pairs, or where pairs are likely to have to be discarded: find() must be called
  /// then. There must be no swept bodies. The same result on any number of threads.
  std::optional<Result> find_moved(std::span<const MotionBound> bounds, std::span<const std::uint32_t> moved,
                                   std::span<const PlaneBound> planes, const PartnerLimits& limits,
                                   parallel::Executor& executor, const RestingGrid* resting = nullptr);
  /// Each is compared with all others, and pairs that it no longer has stay. Chosen.
  static std::size_t most_moved(std::size_t bounds) { return std::min<std::size_t>(1024, bounds / 16); }
  /// Bounds that the search of one looks at, at most. Far more than cells hold where bounds do not overlap.
  static std::uint32_t most_tests(std::uint32_t max_partners) { return std::max(4096U, 16 * max_partners); }
  /// That the search of one looks at, at most, before it is told whether it is in a crowd. Chosen: a body that is in
  /// one has most of those in the cells around it as partners.
  static constexpr std::uint32_t most_tests_of_crowded() { return 8 * CrowdedBodies::kLeast; }

 private:
  struct Cell {
    std::int32_t x = 0, y = 0, z = 0;
    std::int32_t grid = 0;
    friend bool operator==(const Cell&, const Cell&) = default;
  };
  // What a search asks of a bound, in one cache line.
  struct alignas(64) Entry {
    Vec3 center_m = Vec3::Zero();
    double radius_m = 0;
    Cell cell;
    std::uint32_t slot = 0;
    std::uint32_t group = 0, collides_with = 0;
    bool dynamic = false;
  };
  // What a search asks of all entries that it looks at, an array each.
  struct NearArrays {
    parallel::UnsetVector<float> x, y, z, most_m, least_m;
    parallel::UnsetVector<std::uint32_t> tag, slot;
    void resize(std::size_t n);
    void set(std::size_t at, const Entry& entry);
    [[nodiscard]] NearBall ball(std::size_t at) const { return {x[at], y[at], z[at], most_m[at], least_m[at]}; }
    [[nodiscard]] NearBalls balls() const {
      return {x.data(), y.data(), z.data(), most_m.data(), least_m.data(), tag.data()};
    }
  };
  struct Grid {
    double widest_m = 0;
    double cells_per_m = 1;
    std::int64_t least[3] = {0, 0, 0}, most[3] = {0, 0, 0};  ///< cells in use; set if bodies are swept
    bool used = false;
  };
  struct Partner {
    double beyond_m2 = 0;  // squared distance of the centres less that at which the balls would touch
    std::uint32_t slot = 0;
  };
  struct RangeList {
    std::vector<NearRange> list;
    std::size_t count = 0;  // how many of these are set
    void make_room(std::size_t more) {
      if (list.size() < count + more) list.resize(2 * (count + more));
    }
  };
  // Of one worker; workers write into no cache line of another.
  struct alignas(64) Scratch {
    RangeList ranges;                 // what a search looks at: first its own cell and the next
    std::size_t of_own_grid = 0;      // how many of them are in its own grid; 0: none are listed
    Cell around;                      // the cell around which these lie
    std::vector<std::uint32_t> hits;  // entries; the first `partners` are its partners
    std::size_t partners = 0;
    std::vector<Partner> resting;  // those among the bounds at rest; of find_moved() all
    std::size_t most_found = 0;    // by a search
    [[nodiscard]] std::size_t found() const { return partners + resting.size(); }
  };
  struct Collector;
  struct Way;
  // What a swept body covers along the axis on which swept bodies are spread most.
  struct Stretch {
    double low_m = 0, high_m = 0;
    std::uint32_t swept = 0;
  };

  void find_grids(std::span<const MotionBound> bounds, parallel::Executor& executor);
  void find_cells(std::span<const MotionBound> bounds, parallel::Executor& executor);
  // Where more lie in one place than `crowd`, they are in order of place.
  void sort_into_cells(std::span<const MotionBound> bounds, std::uint32_t crowd, parallel::Executor& executor);
  void fill_buckets(std::span<const MotionBound> bounds, std::size_t segment);
  void sort_crowd(std::size_t bucket);
  void find_ranges();
  void sort_swept(std::span<const SweptBound> swept);
  void search(std::uint32_t entry, std::span<const PlaneBound> planes, const PartnerLimits& limits,
              const RestingGrid* resting, Scratch& scratch, Collector& found) const;
  // Partners of an entry among those that `room` allows to look at; how many it did not look at.
  std::size_t find_partners(std::uint32_t entry, std::uint32_t& room, const RestingGrid* resting,
                            Scratch& scratch) const;
  void keep_nearest(const Entry& self, std::uint32_t max_partners, Scratch& scratch, Collector& found) const;
  void list_own_grid(const Cell& own, Scratch& scratch) const;
  void list_coarser_grids(const Entry& self, RangeList& ranges) const;
  bool list_grid(const Vec3& center_m, double radius_m, int grid, RangeList& ranges) const;
  bool find_partners_anywhere(const MotionBound& self, std::span<const MotionBound> bounds,
                              std::span<const std::uint32_t> moved_now, std::uint32_t room, const RestingGrid* resting,
                              Scratch& scratch) const;
  bool gain(std::span<const CandidatePair> added, std::span<const PlaneBound> planes, std::size_t most,
            parallel::Executor& executor);
  void insert_pairs(std::span<const CandidatePair> added, parallel::Executor& executor);
  [[nodiscard]] std::span<const CandidatePair> sorted_pairs() const {
    return std::span<const CandidatePair>(sorted_).first(pair_count_);
  }
  struct RowPieces;
  void list_rows(const RowPieces& along, std::int32_t first_y, std::int32_t last_y, const BlockKey& layer,
                 RangeList& ranges) const;
  void search_along(std::size_t place, std::span<const PlaneBound> planes, std::span<const SweptBound> swept,
                    Collector& found) const;
  template <class Visit>
  void visit_along(const Way& way, int grid, Visit&& visit) const;
  template <class Visit>
  void visit_row(const Cell& first, std::int32_t count, Visit&& visit) const;
  [[nodiscard]] std::uint64_t bucket(const Cell& cell) const;
  void make_scratch(std::size_t bounds, std::uint32_t max_partners, parallel::Executor& executor);
  std::size_t collect(std::size_t bounds, std::span<const PlaneBound> planes, std::span<const SweptBound> swept,
                      const PartnerLimits& limits, const RestingGrid* resting, parallel::Executor& executor,
                      Result& result);
  void sort_pairs(std::size_t count, parallel::Executor& executor);
  void sort_segment(std::size_t segment, std::uint32_t slots);
  void order_long(std::uint32_t low, std::uint32_t begin, std::uint32_t end);
  template <class SegmentOf, class Write>
  void into_segments(parallel::Executor& executor, std::size_t n, SegmentOf&& segment_of, Write&& write);

  // Both counting sorts have two passes: into segments of keys, whose counts a range of items has at hand, and then
  // each segment by itself.
  static constexpr std::size_t kFewestSegments = 64, kMostSegments = 512, kOfSegment = 4096;
  using SegmentCounts = std::array<std::uint32_t, kMostSegments>;
  // A power of two, for so many items.
  static std::size_t segments_for(std::size_t n) {
    return std::clamp(std::bit_ceil(n / kOfSegment), kFewestSegments, kMostSegments);
  }
  static constexpr int kGrids = 64;
  std::vector<Grid> grids_ = std::vector<Grid>(kGrids);
  std::vector<int> used_grids_;
  parallel::UnsetVector<Cell> cell_of_;
  parallel::UnsetVector<Entry> entries_;
  NearArrays near_;
  parallel::UnsetVector<std::uint32_t> bucket_of_;
  parallel::UnsetVector<std::uint32_t> bucket_begin_;
  std::vector<std::array<double, kGrids>> widest_of_range_;  // scratch: per range of bounds and grid; negative: unused
  std::vector<SegmentCounts> segment_counts_;                // scratch: one a range of items
  std::array<std::size_t, kMostSegments + 1> segment_begin_{};
  std::size_t segments_ = 0;                         // used ones
  int segment_shift_ = 0;                            // a key's segment is the key without so many bits
  parallel::UnsetVector<std::uint32_t> by_segment_;  // scratch: bounds, segment by segment of their buckets
  std::uint64_t block_mask_ = 0;
  std::vector<Scratch> scratch_;    // one a worker
  std::vector<Stretch> stretches_;  // of the swept bodies, by low_m
  parallel::UnsetVector<CandidatePair> found_;
  parallel::UnsetVector<CandidatePair> in_segments_;  // scratch: found pairs, segment by segment of their lower slots
  parallel::UnsetVector<std::uint32_t> high_;         // scratch: higher slots, by lower slots
  parallel::UnsetVector<std::uint64_t> marks_;  // scratch: a bit a slot, for each list as many words as it is long
  parallel::UnsetVector<CandidatePair> sorted_;
  parallel::UnsetVector<std::uint32_t> low_begin_;
  std::vector<std::uint32_t> slots_of_range_;    // scratch
  std::size_t pair_count_ = 0;                   // of sorted_
  std::size_t found_pairs_ = 0;                  // by the last find()
  std::size_t most_found_ = 0;                   // by a search since then
  std::vector<std::uint32_t> moved_;             // since then: numbers of bounds, ascending
  std::vector<std::uint32_t> moved_before_;      // scratch: those that have not moved again now
  parallel::UnsetVector<std::uint32_t> gained_;  // by slot: partners added since then
};

}  // namespace poise::collision
