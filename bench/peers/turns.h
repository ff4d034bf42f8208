// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "peers/engine.h"

namespace poise::bench {

/// What one step took.
struct StepTime {
  double wall_ms = 0;
  double cpu_ms = 0;  ///< of the calling thread; of an engine with more threads, of the whole process over their number
};

/// What some frames of one engine took, by nearest rank.
struct TimeFigures {
  std::size_t frames = 0;  ///< 0: the others say nothing
  struct Quantiles {
    double p25_ms = 0, p50_ms = 0, p75_ms = 0, p99_ms = 0;
  };
  Quantiles wall, cpu;
};

/// Steps all engines through the same frames, a block of `block_frames` of one after a block of another, so that what
/// else the machine does meets all alike; who begins a round changes from round to round. Times by engine and frame.
/// `progress` is told the frames that all have done. block_frames >= 1.
std::vector<std::vector<StepTime>> take_turns(std::span<const Engine> engines, std::uint64_t frames,
                                              std::uint64_t block_frames,
                                              const std::function<void(std::uint64_t)>& progress);

TimeFigures time_figures(std::span<const StepTime> times);

}  // namespace poise::bench
