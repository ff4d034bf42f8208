// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"

namespace poise::simulation {

/// All of a World that its next step depends on, but for settings and what it has learned of times.
struct SavedState {
  dynamics::BodyStore bodies;
  std::vector<std::uint32_t> shape_of;
  ContactCache cache;
  BodyChanges body_changes;
  ContactEvents events;
  SleepingState sleeping;
  LearnedGains learned;
  std::uint64_t frame = 0, frames_without_step = 0;
};

/// Copies the state between two steps.
void save(const WorldState& world, SavedState& saved);

/// Puts the World that was saved back to that state, whatever was stepped, added or removed since: the next step has
/// the bits that it would have had then. Shapes and materials must not have been removed. Forecasts keep what they have
/// learned, and settings are as they are.
void restore(const SavedState& saved, WorldState& world);

}  // namespace poise::simulation
