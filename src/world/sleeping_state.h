// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "parallel/large_pages.h"
#include "world/contact_cache.h"

namespace poise::simulation {

/// What sleeping needs (frame/sleeping.h). Empty in a World without it. Part of the state but for what is scratch.
struct SleepingState {
  bool on = false;              ///< WorldSettings::sleeping
  std::vector<double> still_s;  ///< one a slot: for how long an awake body has been still
  std::vector<std::uint32_t>
      island;  ///< one a slot: of a body asleep, the lowest slot of those that fell asleep with it
  std::vector<std::uint8_t> wake_requested;  ///< one a slot: the island of this name is to wake
  bool any_wake_requested = false;
  std::vector<std::uint32_t>
      changed_statics;            ///< static bodies that the caller moved, changed or removed since the last step
  CachedPairList sleeping_pairs;  ///< cached pairs of which a body sleeps, sorted by slots
  std::size_t woken = 0;          ///< since the last report

  CachedPairList next_awake, next_sleeping_pairs;  // scratch
  std::vector<std::uint32_t> parent;               // scratch: the union-find forest
  std::vector<std::uint8_t> restless;              // scratch: islands of which a body moves
  CachedPairList of_cache, of_sleeping;            // scratch: of one of the lists, those that go to the same list
  std::vector<std::uint32_t> slots;                // scratch: of bodies that fall asleep or wake
  std::vector<std::size_t> counts;                 // scratch
};

}  // namespace poise::simulation
