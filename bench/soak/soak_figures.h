// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "soak/soak_drive.h"

namespace poise::soak {

/// Figures of kCycle frames. At their end there are no bodies that come and go.
struct CycleFigures {
  std::uint64_t heap_bytes = 0, resident_bytes = 0;
  std::uint64_t frames_that_allocated = 0;
  std::uint64_t late = 0;      ///< frames
  std::uint64_t forecast = 0;  ///< frames with a forecast of their tail
  std::uint64_t covered = 0;   ///< of these, frames whose tail took no longer than its reserve
  double ratio = 1;            ///< median of tail / forecast
};

/// Something that must hold, and whether it did.
struct Check {
  std::string name;
  bool holds = false;
  std::string value, bound;
};

/// Cycles before those that are compared with each other: four, or a third of all where that is more. A list grows when
/// a frame has more contacts than any before it, and of n cycles as many as ln(n / m) in the mean do after the first m:
/// so after a third of them one does, however long a soak is.
std::uint64_t usual_warm_up(std::uint64_t cycles);

/// Collects frames, and says whether what they must keep was kept. Memory: what it begins with holds 4096 cycles.
class SoakFigures {
 public:
  SoakFigures() { cycles_.reserve(4096); }
  /// Each frame in turn. At the end of a cycle memory is measured.
  void add(const SoakFrame& frame);
  [[nodiscard]] const std::vector<CycleFigures>& cycles() const { return cycles_; }
  /// Of the cycles after the first `warm_up` ones; at least three of them are needed for memory, and nine for
  /// forecasts.
  [[nodiscard]] std::vector<Check> checks(std::uint64_t warm_up, const SoakCounts& counts) const;

 private:
  static constexpr int kBinsOfOctave = 32, kOctaves = 8;  ///< of ratios, from 2^-4 to 2^4

  std::vector<CycleFigures> cycles_;
  CycleFigures now_;
  std::array<std::uint32_t, kBinsOfOctave * kOctaves> ratios_{};
  std::uint64_t frames_ = 0, other_states_ = 0, not_finite_ = 0;
  std::uint64_t first_other_ = 0;
};

}  // namespace poise::soak
