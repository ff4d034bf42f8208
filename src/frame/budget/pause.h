// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "frame/budget/islands.h"
#include "frame/sleeping_sets.h"
#include "world/decision_log.h"
#include "world/forecasts.h"

/// Islands at lower rates: where frames have no time for all bodies, some islands take part in every second step only,
/// or up to every eighth. In between they are not looked at, as if they slept, so that a frame costs what is
/// stepped in it. A hook before *predict*, and one after *publish*.
///
/// A paused island keeps position and velocity, so it is seen in slow motion. It takes part again after the steps that
/// it was to leave out, or at once if a moving body comes near it, the caller touches it, or the time suffices for all.
/// No pair of a paused and a moving body is ever solved, so momentum and energy are as they would be later.
namespace poise::simulation {

/// Before the step: what was paused until now, or all of it if there is time for all or the step has no deadline,
/// is requested to wake. True if all.
/// `steps`: that have ended.
bool begin_paused(const StepInput& step, const WorldSettings& settings, std::uint64_t steps, const Forecasts& forecasts,
                  const SleepAccess& access, parallel::Executor& executor);

struct PauseResources {
  CompletedLevels& levels;  ///< its memory for islands
  SleepAccess access;
  Forecasts& forecasts;
  std::uint64_t steps = 0;     ///< that ended before this one
  DecisionLog* log = nullptr;  ///< of a step that is recorded
};

/// After a step: pauses the islands that the decisions of another run name. False if one of them is no island, or may
/// not wait.
bool pause_as_recorded(const RefineInput& input, std::span<const PausedIsland> recorded,
                       const PauseResources& resources, parallel::Executor& executor);

/// After a step that had no time for all: islands that take turns.
class IslandTurns {
 public:
  /// All must outlive this; reserve_sets was called.
  IslandTurns(const RefineInput& input, const PauseResources& resources, parallel::Executor& executor)
      : input_(input), resources_(resources), executor_(executor) {}

  /// Finds who could wait, if not all that there are fit into a frame of `frame_ns`. False if nobody. `in_slices`: the
  /// step may take longer.
  bool find(double frame_ns, bool in_slices);
  /// Then pauses them. Best seen islands are stepped in every frame, as many as half of a
  /// frame holds if there is a viewer; the others take turns, at the rate that fits.
  void deal();

 private:
  const RefineInput& input_;
  const PauseResources& resources_;
  parallel::Executor& executor_;
  std::optional<Islands> islands_;
  double holds_ = 0;              // a step, as a load
  std::uint64_t other_load_ = 0;  // of what takes part in every frame
};

}  // namespace poise::simulation
