// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/manifold/manifold_point.h"
#include "parallel/executor.h"
#include "parallel/shared_counters.h"
#include "parallel/unset_vector.h"
#include "poise/types.h"
#include "solver/contacts/contact_point.h"

/// The contact cache: what pairs of bodies take from one frame to the next. Part of the state.
namespace poise::simulation {

/// Contact points of one pair: that of the impact, and those of its manifold, which have forces.
inline constexpr std::size_t kForcesOfPair = collision::kMaxManifoldPoints;
inline constexpr std::size_t kPointsOfPair = kForcesOfPair + 1;
inline constexpr std::uint32_t kNoSlot = 0xffffffffU;

/// Contact points and their forces, those of a pair one after another in a slot. The force of a point has its index.
/// A pair keeps its slot for as long as it has points and these have room there. Invariant: a slot is free,
/// released, or one pair's.
struct PointCache {
  /// Points that slots have room for: that of the impact and those of a manifold.
  static constexpr std::array<std::uint8_t, 6> kPointsOfSize = {2, 3, 4, 5, 7, 9};
  static constexpr std::size_t kSizes = kPointsOfSize.size();
  static_assert(kPointsOfSize.back() == kPointsOfPair);

  parallel::UnsetVector<solver::ContactPoint> points;
  parallel::UnsetVector<solver::ContactForce> forces;
  std::vector<std::uint32_t> released;                  ///< slots of any size, not yet among the free ones
  std::array<std::vector<std::uint32_t>, kSizes> free;  ///< one a size

  /// The size of slots for so many points, at most kPointsOfPair.
  [[nodiscard]] static std::size_t size_for(std::size_t point_count) {
    std::size_t size = 0;
    while (kPointsOfSize[size] < point_count) ++size;
    return size;
  }
  [[nodiscard]] static std::size_t room_of(std::uint32_t slot) { return kPointsOfSize[size_of(slot)]; }
  /// The slot whose points begin there, of the first 2^29 (48 GB).
  [[nodiscard]] static std::uint32_t slot_at(std::size_t begin, std::size_t size) {
    return static_cast<std::uint32_t>(begin << kSizeBits | size);
  }
  [[nodiscard]] static std::size_t begin(std::uint32_t slot) { return slot >> kSizeBits; }
  [[nodiscard]] static std::size_t size_of(std::uint32_t slot) { return slot & ((1U << kSizeBits) - 1U); }
  /// Of so many points of a pair those of its manifold: all but the first, or that one if it is the only one.
  [[nodiscard]] static std::size_t before_manifold(std::size_t point_count) { return point_count > 1 ? 1 : 0; }
  [[nodiscard]] static std::size_t manifold_count(std::size_t point_count) {
    return point_count - before_manifold(point_count);
  }
  [[nodiscard]] static std::size_t manifold_begin(std::uint32_t slot, std::size_t point_count) {
    return begin(slot) + before_manifold(point_count);
  }
  [[nodiscard]] std::span<solver::ContactPoint> points_of(std::uint32_t slot, std::size_t count) {
    return std::span(points).subspan(begin(slot), count);
  }
  /// The forces of the manifold of a pair with so many points.
  [[nodiscard]] std::span<solver::ContactForce> forces_of(std::uint32_t slot, std::size_t point_count) {
    return std::span(forces).subspan(manifold_begin(slot, point_count), manifold_count(point_count));
  }

 private:
  static constexpr std::uint32_t kSizeBits = std::bit_width(kSizes - 1);
};

/// Hands out slots of a point cache to the workers of a frame. Which one a pair gets depends on threads and is not part
/// of any result. Invariant: buffers only grow.
class SlotAllocator {
 public:
  /// Does begin() for so many pairs move what is in the cache elsewhere?
  [[nodiscard]] static bool grows(const PointCache& cache, std::size_t pairs, std::size_t workers) {
    return most_points(cache, pairs, workers) > cache.points.capacity();
  }
  /// Memory for what `pairs` pairs may need at most, or where that has to grow `most_pairs`, at least as many; pages
  /// that are never used stay untouched. Released slots are free from here on.
  void begin(PointCache& cache, std::size_t pairs, std::size_t most_pairs, parallel::Executor& executor);
  /// A slot for so many points. Each worker as itself.
  [[nodiscard]] std::uint32_t take(const PointCache& cache, std::size_t point_count, int worker);
  /// The slot is no longer used, but what is in it stays as it is until the next begin(). Each worker as itself.
  void give_back(std::uint32_t slot, int worker) { rooms_[static_cast<std::size_t>(worker)].left.push_back(slot); }
  /// When all have been handed out.
  void end(PointCache& cache);

 private:
  static constexpr std::size_t kBlock = 16;  // slots that a worker takes at once; chosen
  // What a worker has taken and not given to pairs yet, the last first, and what it has got back.
  struct alignas(64) Room {
    std::array<std::uint32_t, PointCache::kSizes> count{};
    std::array<std::array<std::uint32_t, kBlock>, PointCache::kSizes> slots;
    std::vector<std::uint32_t> left;
  };
  void refill(const PointCache& cache, std::size_t size, Room& room);
  // With what workers may have left over.
  static std::size_t points_before_pairs(const PointCache& cache, std::size_t workers);
  static std::size_t most_points(const PointCache& cache, std::size_t pairs, std::size_t workers) {
    return points_before_pairs(cache, workers) + kPointsOfPair * pairs;
  }

  std::vector<Room> rooms_;  // one a worker
  std::array<parallel::Tickets, PointCache::kSizes> taken_;
  parallel::Tickets added_;        // points beyond those that the cache had at begin()
  std::size_t points_before_ = 0;  // those that it had
  std::vector<std::size_t> counts_;
};

/// A pair of the contact cache.
///
/// What a frame found out about a pair holds until its bodies have moved too far against each other: that it is
/// separated, or the points where it may touch. Invariant: the first of its points is that of the impact; the others
/// (or the first, if it is the only one) are the manifold.
struct alignas(64) CachedPair {
  std::uint32_t low = 0, high = 0;  ///< body slots
  std::uint32_t frames_waited = 0;  ///< since a level was completed, or nothing was left to complete
  std::uint32_t slot = kNoSlot;     ///< of its points in the PointCache; which one is not part of the state
  std::uint8_t point_count = 0;
  std::uint8_t frames_touched = 0;  ///< in a row, that learn, before the last one in which it touched
  Level level = 0;                  ///< that found it out
  bool touching = false;
  bool apart = false;     ///< nothing was nearer than reach_m
  bool solved = false;    ///< in the last step the solver had a manifold of it
  std::uint8_t seen = 0;  ///< band of how well it was seen when it was ranked last; 0: never. Not part of the state
  /// Band of its score when it was ranked last, had it not waited; 0: never. Not part of the state.
  std::uint8_t band = 0;
  double reach_m = 0;  ///< all that was nearer than this is in the points; 0: only the forces are cached
  double moved_m = 0;  ///< upper bound of the change of any separation since
  double nearest_m = 0,
         impact_gap_m = 0;  ///< least separation of its points, and that of the first, when they were last computed
  double looked_m = 0;      ///< moved_m at that time
  /// By how much a separation may have changed since it was last computed: normals turn with the bodies, so by a little
  /// more than the surfaces have moved.
  [[nodiscard]] double changed_m() const { return 2.0 * (moved_m - looked_m); }
};

static_assert(sizeof(CachedPair) == 64, "one cache line");

/// Of a pair of which nothing is cached.
inline constexpr CachedPair kNothingCached{};

using CachedPairList = parallel::UnsetVector<CachedPair>;

/// Invariant: both lists are sorted by (low, high). Between steps `pairs` are those of the last step.
struct ContactCache {
  CachedPairList pairs;
  CachedPairList previous_pairs;  ///< those that the last step began with, until the next one begins
  PointCache points;
};

}  // namespace poise::simulation
