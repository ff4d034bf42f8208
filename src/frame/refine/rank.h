// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "frame/refine/pair_cues.h"
#include "frame/refine/refine.h"
#include "poise/scheduler/bands.h"

namespace poise::simulation {

/// Of the time until the cut, what ranking may take at most. Measured: docs/priorities.md.
inline constexpr double kRankingShare = 0.5;

/// Ranking under a deadline: puts the pairs whose turn may come in this frame where their turn is. It takes a part of
/// the time until the cut at most (kRankingShare), by its forecast and by the clock. Where that will not do for all
/// pairs, half of it is for the chunks of pairs that were seen best when they were ranked last, and half for the others
/// in turn; pairs that are not ranked have their turn where they had it when they were ranked last, if there is time to
/// put them there and no host has a cue, and are ranked by the job that takes them. False where there is no time for
/// any.
bool rank_pairs(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                SteadyClock::time_point start, SteadyClock::time_point cut, CompletedLevels& levels,
                FrameReport& report, parallel::Executor& executor);

/// What ranking a pair finds beside its cues and bands.
struct RankedPair {
  bool refused = false;    ///< the host's cue was no number or out of range
  bool left_out = false;   ///< the policy leaves it out
  std::uint32_t band = 0;  ///< where it has its turn
};
/// Ranks one pair: fills its cues, and what `pair` says of ranking. Any thread.
RankedPair ranked_pair(const RefineInput& input, const PairCueSource& source, const scheduler::FrameFacts& facts,
                       std::uint32_t item, PairProgress& pair, const collision::PairContact& found,
                       scheduler::PairCues& cues);

/// PairProgress::turn of a pair that waits in this band; one beyond the last counts as the last.
inline std::uint8_t turn_at(std::uint32_t band) {
  return static_cast<std::uint8_t>(std::clamp<std::uint32_t>(band, 1, scheduler::kBands - 1));
}

/// The band of what a viewer sees of a pair, whatever else it is ranked by; never 0, that of a pair that was never
/// looked at.
std::uint8_t seen_band(const scheduler::Policy& policy, const scheduler::PairCues& cues);

/// Which chunks of a table are ranked where `most` pairs of it are: in ascending order. Deterministic for the table,
/// the frame and `most`.
void choose_chunks(const PairTable& table, std::uint64_t frame, std::size_t most, std::vector<std::uint32_t>& chosen);

}  // namespace poise::simulation
