// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "poise/scene/scene.h"

namespace poise::io {

/// The state of a body with its number (RunBody::number).
struct NumberedState {
  std::uint64_t body = 0;
  BodyState state;
};

/// Replaces `states` by those of all bodies that are there, in the order of their numbers. Refused: a body that
/// somebody else removed from the World.
Status read_states(const SceneRun& run, std::vector<NumberedState>& states);

}  // namespace poise::io
