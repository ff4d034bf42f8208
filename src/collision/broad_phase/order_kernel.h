// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "collision/broad_phase/candidate_pair.h"

namespace poise::collision {

/// Lists, side by side, of the higher slots of pairs with the same lower slot: that of lower slot `low + k` ends at
/// ends[k], the first begins at `begin`.
struct PartnerLists {
  static constexpr std::uint32_t kPast = 16;  ///< elements that may be read behind the last
  std::uint32_t low = 0;
  std::uint32_t begin = 0;
  std::span<const std::uint32_t> ends;
  const std::uint32_t* high = nullptr;
};

/// Lists longer than this are left alone.
inline constexpr std::uint32_t kLongestOrdered = 32;

/// Writes the pairs in order of (low, high) to where their lists lie, of which no two elements are equal; whether none
/// was left. Any thread; any instruction set gives the same pairs.
bool order_partners(const PartnerLists& lists, CandidatePair* pairs);

}  // namespace poise::collision
