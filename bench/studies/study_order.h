// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

#include "studies/order_figures.h"
#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study order`.
struct StudyOrderOptions {
  StudyTimesOptions common;
  std::vector<std::uint64_t> bodies;  ///< empty: 2,000
  std::vector<double> deadlines_ms;   ///< empty: 3, 4 and 6
  std::optional<std::uint64_t> every;
  std::optional<double> budget_percent;  ///< of the work of full refinement, counted, instead of deadlines
  std::vector<std::string> weights;      ///< `cue=value`
};
void add_study_order_options(CLI::App& command, StudyOrderOptions& options);

/// Measures what the order of refinement takes, and how far it is from that of a sorted queue. Returns the exit code.
int study_order(const StudyOrderOptions& options);

/// A frame that was looked at.
struct OrderFrame {
  FrameReport report;
  OrderFigures figures;
};

/// How a run is looked at.
struct OrderRun {
  std::uint64_t warm_up = 0, frames = 1, every = 1;
  std::optional<Nanoseconds> deadline;  ///< of a frame, from its start
  std::optional<double> share;          ///< without a deadline: of the work of full refinement, counted
};

/// Steps a scene and looks at each `every`-th frame after the warm-up: does it once more with everything refined, and
/// puts the World back to what it did. Sleeping and waiting islands must be off. `told` gets the share that is done.
/// Refused: what the World refuses.
Result<std::vector<OrderFrame>> order_frames(const Scene& scene, SceneRun& run, const OrderRun& how,
                                             const std::function<void(double share)>& told);

}  // namespace poise::app
