// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "peers/engine.h"

namespace poise::bench {

/// Duration of one step.
struct StepTime {
  double wall_ms = 0;
  double cpu_ms = 0;  ///< of the calling thread; for an engine with more threads, of the whole process divided by their
                      ///< number
};

/// Durations of some frames of one engine, by nearest rank.
struct TimeFigures {
  std::size_t frames = 0;  ///< 0: the other figures are undefined
  struct Quantiles {
    double p25_ms = 0, p50_ms = 0, p75_ms = 0, p99_ms = 0;
  };
  Quantiles wall, cpu;
};

/// Steps all engines through the same frames, alternating in blocks of `block_frames` (>= 1), so that other load on the
/// machine affects all of them equally. The engine that begins a round changes from round to round. Returns the times
/// by engine and frame. Calls `progress` with the number of frames that all engines have done.
std::vector<std::vector<StepTime>> take_turns(std::span<const Engine> engines, std::uint64_t frames,
                                              std::uint64_t block_frames,
                                              const std::function<void(std::uint64_t)>& progress);

TimeFigures time_figures(std::span<const StepTime> times);

}  // namespace poise::bench
