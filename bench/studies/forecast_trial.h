// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "poise/step.h"
#include "scene/run/run_report.h"

namespace poise::simulation {

/// The tail of one frame of a run: its counts before and after, and its duration.
struct RecordedTail {
  scheduler::TailWork forecast_for;  ///< FrameReport::tail_work
  std::uint64_t contacts = 0;        ///< number that was solved in the end
  Nanoseconds actual{0};             ///< > 0; of what it had to do
};

/// The tails of the measured frames of a run in which there was something to do. `undisturbed`: without those of frames
/// from which the system took more than 3 % of the tail's time.
std::vector<RecordedTail> recorded_tails(std::span<const RunFrame> frames, bool undisturbed);

/// Quality of one method of computing a reserve.
struct ForecastScore {
  std::string method;
  double exceeded = 0;             ///< share of frames that took longer than their reserve; alpha was requested
  double reserve_over_actual = 0;  ///< sum of the reserves / sum of the actual times
  /// Mean pinball loss of the reserve as the 1 - alpha quantile of the time (Koenker and Bassett 1978), as a share of
  /// the mean time: alpha (reserve - actual) if the reserve was long enough, else (1 - alpha) (actual - reserve).
  /// Smaller is better; a perfect forecast has 0.
  double pinball = 0;
  std::uint64_t beyond_clip = 0;  ///< only for our tracker: ratios outside the range of its bound
};

/// Replays recorded tails frame by frame. Each method knows only the frames before: our tracker, the point forecast
/// alone, the mean of all previous frames, mean + 3 standard deviations, and the 1 - alpha quantile of the last 200
/// frames. The first `skip` frames are for learning and are not measured. A pure function; alpha in [1e-5, 0.5].
std::vector<ForecastScore> try_forecasts(std::span<const RecordedTail> tails, double alpha, std::size_t skip);

}  // namespace poise::simulation
