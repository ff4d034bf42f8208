// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "poise/step.h"

namespace poise::simulation {

/// Simulated work of a host (rendering, game logic): after each step it keeps the processor busy. The frame's deadline
/// includes it.
struct RenderLoad {
  Nanoseconds mean{0};    ///< time on the CPU, >= 0
  Nanoseconds jitter{0};  ///< each frame's load differs from the mean by up to this, uniformly distributed; at most the
                          ///< mean
  std::uint64_t seed = 1;
  [[nodiscard]] bool any() const { return mean.count() > 0; }
};

/// The load of one frame: the same for the same frame and seed.
Nanoseconds load_of(const RenderLoad& load, std::uint64_t frame);

/// Duration of a load.
struct LoadTime {
  Nanoseconds wall{0};
  Nanoseconds off_cpu{0};  ///< part of it in which the system did not run the thread
};

/// Keeps the calling thread busy until it has used this CPU time. The only system call reads that clock.
LoadTime burn(Nanoseconds cpu_time);

}  // namespace poise::simulation
