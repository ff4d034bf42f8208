// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "poise/types.h"

/// What refinement has brought so far, for each pair of shapes and each level: learned from frames with a budget, in
/// the order of their pairs. Part of the state.
namespace poise::simulation {

/// What a frame has shown of one pair. Every bit counts for the state: there is no padding.
struct GainObservation {
  enum class Life : std::uint32_t {
    Unknown,  ///< nothing was cached
    Valid,    ///< what was cached is valid still
    Expired,  ///< it was valid in the frame before and is not now
  };
  std::uint32_t shape_low = 0, shape_high = 0;  ///< indices of the shapes, ascending
  std::uint32_t level = 0;                      ///< completed; 0: the pair was not refined
  std::uint32_t apart = 0;                      ///< 1: the level found it separated
  std::uint32_t anew = 0;                       ///< 1: it was refined from level 0, and change_m is known
  float change_m = 0;                           ///< of the separation that counts, from level 0 to the completed level
  Life life = Life::Unknown;                    ///< of what an earlier frame has found
  std::uint32_t life_level = 0;                 ///< the level that found it
  float hazard = 0;                             ///< the probability that it would expire, by the motion of the bodies
};
static_assert(sizeof(GainObservation) == 9 * sizeof(std::uint32_t));

/// What one level of a pair of shapes has brought.
struct LevelGain {
  float refined = 0;   ///< pairs that completed the level
  float ended = 0;     ///< of these, that it found separated
  float anew = 0;      ///< pairs that were refined from level 0 to this level and no deeper
  float change_m = 0;  ///< sum over these of the change of their separation
  float hazard = 0;    ///< sum of the probabilities that what it had found would expire in a frame
  float expired = 0;   ///< how often it did
};

struct ShapePairGains {
  std::uint32_t shape_low = 0, shape_high = 0;
  std::array<LevelGain, kPolygonBin + 1> level{};
};
static_assert(sizeof(ShapePairGains) == 2 * sizeof(std::uint32_t) + (kPolygonBin + 1) * sizeof(LevelGain));

/// A bounded table. Invariant: the first entry is that of all pairs of shapes that came when the table was full.
class LearnedGains {
 public:
  /// Pairs of shapes with an entry of their own. Chosen: 200 kB.
  static constexpr std::size_t kMostShapePairs = 1023;

  /// What is known of two shapes; null: nothing. Any thread, between calls of those that change it.
  [[nodiscard]] const ShapePairGains* find(std::uint32_t shape_low, std::uint32_t shape_high) const;

  /// Where a frame's observations are written, in the order of its pairs. They count from the next frame with a budget
  /// on: threads that were left behind may still read what is learned.
  std::vector<GainObservation>& observed() { return observed_; }
  [[nodiscard]] std::span<const GainObservation> observed() const { return observed_; }
  /// Learns what was observed, and forgets the observations.
  void learn();

  void clear();
  [[nodiscard]] bool empty() const { return entries_.empty() && observed_.empty(); }
  [[nodiscard]] std::span<const ShapePairGains> entries() const { return entries_; }

 private:
  static constexpr std::size_t kBuckets = 4096;
  [[nodiscard]] std::size_t bucket_of(std::uint32_t shape_low, std::uint32_t shape_high) const;
  ShapePairGains& entry_of(std::uint32_t shape_low, std::uint32_t shape_high);

  std::vector<ShapePairGains> entries_;
  std::vector<std::uint16_t> buckets_;  ///< index of an entry, 0: free
  std::vector<GainObservation> observed_;
};

}  // namespace poise::simulation
