// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace poise::scheduler {

/// A possible refinement.
struct Candidate {
  double score = 0;
  std::uint32_t pair = 0;   ///< index of the pair in canonical order
  std::uint32_t units = 0;  ///< its charge: the size of its front
};

/// The work clock: refinement in rounds of a fixed size, so that the selection depends on scores and budget alone, not
/// on threads. Candidates are admitted by (score, pair) while the budget lasts, in each round until half of what is
/// left of it is charged, so that what a round makes possible has its turn. A candidate that does not fit is left, and
/// smaller ones behind it may still fit. One thread at a time.
class RoundSelector {
 public:
  static constexpr std::uint32_t kDefaultRoundPairs = 512;

  /// Discards all candidates. `budget_units`: most units to charge in this frame. `round_pairs`: most candidates of a
  /// round (Policy::round_pairs; 0 counts as 1).
  void begin_frame(std::uint64_t budget_units, std::size_t expected_candidates,
                   std::uint32_t round_pairs = kDefaultRoundPairs);
  void add(const Candidate& candidate);
  /// The next round, best first; empty if no candidate fits. Valid until the next call.
  std::span<const Candidate> next_round();
  [[nodiscard]] std::uint64_t charged_units() const { return charged_; }

 private:
  std::vector<Candidate> heap_;
  std::vector<Candidate> round_;
  std::uint64_t budget_ = 0;
  std::uint64_t charged_ = 0;
  std::size_t round_pairs_ = kDefaultRoundPairs;
};

}  // namespace poise::scheduler
