// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace poise::collision {

/// Two bodies that may touch in the step; low < high are their slots.
struct CandidatePair {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  friend bool operator==(const CandidatePair&, const CandidatePair&) = default;
};

}  // namespace poise::collision
