// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "poise/types.h"

namespace poise::capture {

/// Where the contact of a pair came from in a frame.
enum class PairSource : std::uint8_t { Coarsest, Cached, Refined, Exact, CachedSeparated, Separated };
inline constexpr std::uint8_t kPairWaits = 8;  ///< its bodies wait: no response in this frame
inline constexpr std::uint8_t kPairLeft = 16;  ///< refinement could have gone on

/// A pair near enough to be looked at, by rows of the table of bodies.
struct PackedPair {
  std::uint32_t a = 0, b = 0;
  std::uint8_t state = 0;    ///< PairSource, with the flags
  std::uint8_t level = 0;    ///< that counted in the response; kPolygonBin for polygons
  std::uint8_t deepest = 0;  ///< likewise, that it can reach
  std::uint8_t seen = 0;     ///< band of what a viewer sees of an error; 0: never ranked
  std::uint8_t error = 0;    ///< band of the error that is expected at the level; 0: none
  std::uint8_t outcome = 0;  ///< PairOutcome + 1
  std::uint8_t turn = 0;     ///< band of the score that its next level waits with, or its last one had; 0: none
  friend bool operator==(const PackedPair&, const PackedPair&) = default;
};

/// Appends the pairs of a frame as a PAIR chunk holds them (docs/capture.md).
void put_pairs(std::uint64_t frame, std::span<const PackedPair> pairs, std::string& out);

}  // namespace poise::capture
