// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "poise/step.h"

namespace poise::simulation {

/// The tail of one frame of a run: what was counted before it and after it, and how long it took.
struct RecordedTail {
  scheduler::TailWork forecast_for;    ///< FrameReport::tail_work
  std::uint64_t contacts = 0;          ///< that were answered in the end
  std::uint64_t point_iterations = 0;  ///< that were made in the time that was kept
  Nanoseconds actual{0};               ///< > 0; without what was done in time left over
};

/// How one way to make a reserve did.
struct ForecastScore {
  std::string method;
  double exceeded = 0;             ///< share of frames that took longer than their reserve; alpha is what was asked
  double reserve_over_actual = 0;  ///< sum of the reserves / sum of what was needed
  /// Mean pinball loss of the reserve as the 1 - alpha quantile of the time (Koenker and Bassett 1978), as a share of
  /// the mean time: alpha (reserve - actual) where it held, (1 - alpha) (actual - reserve) where not. Less is better; 0
  /// is a seer.
  double pinball = 0;
  std::uint64_t beyond_clip = 0;  ///< ours only: ratios that the bound does not speak of
};

/// Plays recorded tails again, frame by frame, each method knowing only the frames before: the tracker of this program,
/// the same without the visits that the frame before needed, the point forecast alone, the mean of all frames before,
/// mean + 3 standard deviations, and the 1 - alpha quantile of the last 200. The first `skip` frames are learned from
/// and not measured. A pure function; alpha in [1e-5, 0.5].
std::vector<ForecastScore> try_forecasts(std::span<const RecordedTail> tails, double alpha, std::size_t skip);

}  // namespace poise::simulation
