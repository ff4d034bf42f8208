// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "dynamics/body_store.h"
#include "parallel/sliced_task.h"
#include "poise/step.h"
#include "poise/world.h"

/// Steps that take several frames: what does not fit into one is done in slices, and each frame is on time.
///
/// Such a step is an ordinary one whose deadline is several frames away by a clock that stands still between slices.
/// Until the last slice nothing that a caller sees of the bodies changes; there they move by one step, in slow motion
/// and as accurately as the time of so many frames allows.
namespace poise::simulation {

struct WorldState;

/// The step that is done in slices, and what the last one taught. Not part of the state.
struct SlicedStep {
  explicit SlicedStep(parallel::Executor& workers) : task(workers) {}

  StepInput input;                      ///< that it began with
  const StepInput* frame = nullptr;     ///< that of the frame which runs now; null: it is ended outside of one
  SteadyClock::time_point slice_begun;  ///< of that frame
  Nanoseconds slice{0};                 ///< what such a frame has for it
  FrameReport report;                   ///< of the step, by its own clock
  SteadyClock::time_point begun;        ///< by it
  const StageTimes* stages = nullptr;   ///< those that have ended, while it is unfinished
  StageTimes told;                      ///< of them, and of the one that goes on, in the frames before
  std::optional<Conserved> sums;        ///< of the bodies, which do not change while it is unfinished; if asked for

  // From when bodies begin to move until its end. Between slices the World has what was before, and this the rest.
  bool moving = false;
  dynamics::BodyStates states;
  std::vector<ContactEvent> events;

  // Of the step before
  bool last = false;         ///< it was done in slices; then
  Nanoseconds mandatory{0};  ///< FrameReport::mandatory, and
  double refinement_ns = 0;  ///< what all of its refinement takes, by score

  // Last: ends the step before the rest goes.
  parallel::SlicedTask task;
};

/// Is a step that begins now to be done in slices? It may, and what must be done is forecast not to fit, or bodies
/// waited in the frame before, or the step before would not have fitted; or nothing is known yet.
[[nodiscard]] bool wants_slices(const WorldState& world, const StepInput& input);

/// A frame of a step that is done in slices: begins one, unless one is unfinished, and goes on until the deadline of
/// `input`. FrameReport::unfinished says whether there is more to do.
FrameReport run_slice(WorldState& world, const StepInput& input);

/// A frame of a replay whose step was unfinished: nothing but counted.
FrameReport replay_unfinished(WorldState& world, const StepInput& input);
/// The frame of a replay that ends such a step: all of it.
FrameReport replay_slices(WorldState& world, const StepInput& input);

// For the step itself.

/// Before the first body moves: from here on callers see of bodies and events what was before, until the step has
/// ended.
void hide_end(WorldState& world, SlicedStep& sliced);

/// Ends an unfinished step, however long it takes.
void end_sliced_step(WorldState& world);

}  // namespace poise::simulation
