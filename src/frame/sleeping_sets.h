// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "frame/sleeping.h"

/// The sets of bodies that sleep, or wait for several steps: who is in which, and their cached pairs. For what lets
/// bodies sleep or wait.
namespace poise::simulation {

/// Does anything sleep or wait, or may it fall asleep?
inline bool in_use(const SleepAccess& access) { return access.sleeping.on || access.bodies.asleep_count() > 0; }

/// Memory for what sleeps and waits, before any of it does: a late frame must find it without asking for it.
void reserve_sets(const SleepAccess& access, parallel::Executor& executor);
/// Columns for all slots.
void reserve_slots(const SleepAccess& access);

/// The set of what wakes before a step, which may be new; with SleepingSet::kNever always a new one.
std::uint32_t set_that_wakes(SleepingState& sleep, std::uint64_t wakes);
/// Before the body sleeps: puts it into a set. `island`: the lowest slot of those that wake together.
void add_to_set(SleepingState& sleep, std::uint32_t set, std::uint32_t slot, std::uint32_t island);
/// After bodies have fallen asleep: their cached pairs go from those of the last step to their sets.
void take_pairs_of_sleepers(const SleepAccess& access, parallel::Executor& executor);

/// The body's own part of waking.
void wake_body(const SleepAccess& access, std::uint32_t slot);
/// Wakes the islands that are to wake; their cached pairs come back.
void wake_requested_islands(const SleepAccess& access, parallel::Executor& executor);

}  // namespace poise::simulation
