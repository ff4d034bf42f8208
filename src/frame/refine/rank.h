// SPDX-License-Identifier: MIT
#pragma once

#include "frame/refine/refine.h"

namespace poise::simulation {

/// Ranking under a deadline: puts the pairs whose turn may come in this frame where their turn is. It takes a part of
/// the time until the cut at most. Where that will not do for all pairs, half of it is for the chunks of pairs that
/// were seen best when they were ranked last, and half for the others in turn. False where there is no time for any.
bool rank_pairs(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                SteadyClock::time_point start, SteadyClock::time_point cut, CompletedLevels& levels,
                FrameReport& report, parallel::Executor& executor);

/// The band of what a viewer sees of a pair, whatever else it is ranked by; never 0, that of a pair that was never
/// looked at.
std::uint8_t seen_band(const scheduler::Policy& policy, const scheduler::PairCues& cues);

/// Which chunks of a table are ranked where `most` pairs of it are: in ascending order. Deterministic for the table,
/// the frame and `most`.
void choose_chunks(const PairTable& table, std::uint64_t frame, std::size_t most, std::vector<std::uint32_t>& chosen);

}  // namespace poise::simulation
