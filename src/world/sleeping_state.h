// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/unset_vector.h"
#include "poise/decisions.h"
#include "world/contact_cache.h"

namespace poise::simulation {

/// A body that waits is stepped at least in every eighth step. Chosen: time enough to refine a heap of thousands as a
/// whole.
inline constexpr std::uint8_t kMostFramesHeld = 7;

/// And one that is out of view, if there is a viewer, in every 32nd: twice a second, where a step takes one frame.
inline constexpr std::uint8_t kMostStepsUnseen = 31;

/// Bodies that fell asleep in the same step, or wait until the same one, and their cached pairs. Invariant: the pairs
/// are sorted by slots; a body is in at most one set.
struct SleepingSet {
  static constexpr std::uint64_t kNever = ~std::uint64_t{0};
  std::uint64_t wakes = kNever;      ///< the step before which they wake by themselves
  std::vector<std::uint32_t> slots;  ///< empty: the set is free
  CachedPairList pairs;              ///< of which a body is in the set
  /// Bodies that wait, and their pairs, by how many steps the body may leave out.
  std::array<std::uint64_t, kMostStepsUnseen + 1> load{};
  /// Of those that wait out of view: a ball around an island, its largest body, one of its slots, and the step after
  /// which it was paused. It may wake when it comes into view.
  struct Unseen {
    Vec3 center_m;
    double radius_m, body_radius_m;
    std::uint32_t slot;
    std::uint64_t since;
  };
  std::vector<Unseen> unseen;
};

/// What sleeping needs (frame/sleeping.h), and islands that wait for several steps (frame/budget/pause.h). Empty in a
/// World without both. Part of the state but for what is scratch.
struct SleepingState {
  bool on = false;              ///< WorldSettings::sleeping
  std::vector<double> still_s;  ///< one a slot: for how long an awake body has been still
  std::vector<std::uint32_t>
      island;  ///< one a slot: of a body asleep, the lowest slot of those that fell asleep with it
  std::vector<std::uint8_t> wake_requested;  ///< one a slot: the island of this name is to wake
  bool any_wake_requested = false;
  std::vector<std::uint32_t>
      changed_statics;  ///< static bodies that the caller moved, changed or removed since the last step
  std::vector<SleepingSet> sets;
  std::vector<std::uint32_t> set_of;  ///< one a slot: of a body asleep, its set
  std::size_t woken = 0;              ///< since the last report

  CachedPairList merged, taken;               // scratch: pairs on their way from list to list
  std::vector<std::span<CachedPair>> places;  // scratch
  std::vector<std::uint32_t> parent;          // scratch: the union-find forest
  std::vector<std::uint8_t> restless;         // scratch: islands of which a body moves
  std::vector<std::uint32_t> slots;           // scratch: of bodies that fall asleep, or roots of islands that may wait
  std::vector<PausedIsland> islands_paused, islands_sorting;  // scratch
  std::vector<std::size_t> counts;                            // scratch
};

}  // namespace poise::simulation
