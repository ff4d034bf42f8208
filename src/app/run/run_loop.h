// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "parallel/interrupt.h"
#include "poise/scene/scene.h"
#include "scene/run/numbered_states.h"
#include "scene/run/render_load.h"
#include "scene/run/run_report.h"

namespace poise::app {

/// How the frames of a run are driven.
struct LoopSettings {
  std::uint64_t warm_up = 0;
  std::uint64_t frames = 1;  ///< measured ones, after warm_up
  double dt_s = 1.0 / 60;
  bool wall_clock = true;
  Nanoseconds deadline{0};  ///< wall clock: of a frame, from its start or release
  bool paced = false;       ///< wall clock: releases on a grid of dt_s
  Nanoseconds host_work{0};
  bool learn_host_work = false;              ///< reserve what the render load lets expect, instead of host_work
  simulation::RenderLoad render_load;        ///< wall clock: after each step
  std::optional<std::uint64_t> budget_work;  ///< work clock
  Level max_level = kMaxTreeDepth;
  bool polygons = false;
  bool backtracking = false;
  Trace* trace = nullptr;  ///< where the steps leave what the threads did when
  /// >= 1: a reference of each measured frame whose number from 1 it divides (simulation::ReferenceTurns). Such a frame
  /// is not done in slices.
  std::optional<std::uint64_t> reference_every;
  std::uint64_t states_every = 1;  ///< states are told of frames whose number this divides
};

struct LoopResult {
  std::vector<simulation::RunFrame> frames;  ///< warm-up included
  Conserved start, end;
  double energy_max_j = 0;
  std::vector<std::array<std::uint64_t, 2>> traced_pairs;  ///< of each piece of the trace, the numbers of its bodies
  bool stopped = false;                                    ///< by a signal
};

/// Told the states after frames (and of the start, as frame 0). As with a record, the time that this takes belongs to
/// no frame.
using StatesSink = std::function<Status(std::uint64_t frame, std::span<const io::NumberedState> states)>;
/// Told what each frame did while World::decisions has what it decided. The time that this takes belongs to no frame:
/// releases are put off by it.
using RecordSink = std::function<Status(const FrameReport&)>;
/// Told what each frame did, for a capture, while the World stands as the frame left it. As with a record, the time
/// that this takes belongs to no frame.
using CaptureSink = std::function<Status(const simulation::RunFrame&)>;
/// Told after each frame.
using FrameSink = std::function<void(const simulation::RunFrame&)>;

/// Refuses more frames than `most_bytes` has room for: their figures are kept until the end, which gives exact
/// percentiles. Without a limit none are.
Status check_memory_of_frames(const LoopSettings& settings, const std::optional<std::uint64_t>& most_bytes);

/// Runs a scene to its end, or until a signal, after which it ends its frame. `states`, `record` and `capture` may be
/// empty. Refused: what the World or a sink refuses.
Result<LoopResult> run_loop(SceneRun& run, const LoopSettings& settings, const parallel::Interrupt& interrupt,
                            const StatesSink& states, const FrameSink& frame, const RecordSink& record = {},
                            const CaptureSink& capture = {});

}  // namespace poise::app
