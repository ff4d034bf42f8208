// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "app/live/live_record.h"
#include "app/live/live_run.h"
#include "poise/result.h"

namespace poise::app {

/// How the frames of a live run are driven.
struct LiveLoopSettings {
  std::optional<std::uint64_t> frames;  ///< steps to do; empty: until it is stopped
  bool paced = true;                    ///< in real time; else one frame after the other
  std::function<bool()> stops;          ///< asked before each frame, and while waiting
  std::function<void()> told = [] {};   ///< after something was put into the link
};

/// Steps a live run, with what `link` brings done between frames, and puts each frame into it. A frame for which it has
/// no room is left out there, and counted. Returns the number of frames done. Refused: what the World refuses of a
/// step.
Result<std::uint64_t> live_loop(LiveRun& run, LiveLink& link, const LiveLoopSettings& settings);

}  // namespace poise::app
