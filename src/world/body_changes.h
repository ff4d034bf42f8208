// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "poise/world.h"

namespace poise::simulation {

/// What the caller has changed of bodies since the last step, as far as cached pairs no longer hold.
struct BodyChanges {
  std::vector<BodyId> removed;
  std::vector<std::uint32_t> displaced;  ///< slots of bodies that the caller moved

  std::vector<std::size_t> counts;  // scratch
};

/// Begins and ends of contacts in the last step, and ends that wait for the events of the next one.
struct ContactEvents {
  std::vector<ContactEvent> events;
  std::vector<ContactEvent> of_removed;  ///< ends of contacts of removed bodies
};

}  // namespace poise::simulation
