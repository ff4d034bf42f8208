// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collision/manifold/manifold_point.h"
#include "parallel/executor.h"
#include "parallel/unset_vector.h"
#include "poise/types.h"
#include "solver/contacts/contact_point.h"

/// The contact cache: what pairs of bodies take from one frame to the next. Part of the state.
namespace poise::simulation {

/// Contact points of one pair: that of the impact, and those of its manifold, which have forces.
inline constexpr std::size_t kForcesOfPair = collision::kMaxManifoldPoints;
inline constexpr std::size_t kPointsOfPair = kForcesOfPair + 1;
inline constexpr std::uint32_t kNoSlot = 0xffffffffU;

/// Contact points and their forces, in slots of kPointsOfPair and kForcesOfPair. A pair keeps its slot for as long as
/// it has points. Invariant: a slot is either free or one pair's.
struct PointCache {
  parallel::UnsetVector<solver::ContactPoint> points;
  parallel::UnsetVector<solver::ContactForce> forces;
  std::vector<std::uint32_t> free;

  /// Memory for at least `slots` slots; pages of those that are never used stay untouched.
  void reserve(std::size_t slots, parallel::Executor& executor);
  /// Makes sure that there are `count` free slots.
  void reserve_slots(std::size_t count, parallel::Executor& executor);
  /// The n-th of the free slots that reserve_slots made sure of; take_slots(count) when all have been handed out. Any
  /// thread.
  [[nodiscard]] std::uint32_t free_slot(std::size_t n) const { return free[free.size() - 1 - n]; }
  void take_slots(std::size_t count) { free.resize(free.size() - count); }
  void release(std::uint32_t slot) {
    if (slot != kNoSlot) free.push_back(slot);
  }

  [[nodiscard]] static std::size_t begin(std::uint32_t slot) { return slot * kPointsOfPair; }
  /// Of so many points of a pair those of its manifold: all but the first, or that one if it is the only one.
  [[nodiscard]] static std::size_t before_manifold(std::size_t point_count) { return point_count > 1 ? 1 : 0; }
  [[nodiscard]] static std::size_t manifold_count(std::size_t point_count) {
    return point_count - before_manifold(point_count);
  }
  [[nodiscard]] static std::size_t forces_begin(std::uint32_t slot) { return slot * kForcesOfPair; }
  [[nodiscard]] std::span<solver::ContactPoint> points_of(std::uint32_t slot, std::size_t count) {
    return std::span(points).subspan(begin(slot), count);
  }
  /// The forces of the manifold of a pair with so many points.
  [[nodiscard]] std::span<solver::ContactForce> forces_of(std::uint32_t slot, std::size_t point_count) {
    return std::span(forces).subspan(forces_begin(slot), manifold_count(point_count));
  }
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
