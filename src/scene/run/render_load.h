// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "poise/step.h"

namespace poise::simulation {

/// Work of a host that draws or plays, simulated: after each step it keeps the processor busy, and the frame's deadline
/// counts it in.
struct RenderLoad {
  Nanoseconds mean{0};    ///< time on the CPU, >= 0
  Nanoseconds jitter{0};  ///< each frame's differs from the mean by up to this, evenly distributed; at most the mean
  std::uint64_t seed = 1;
  [[nodiscard]] bool any() const { return mean.count() > 0; }
};

/// What the load of one frame is: the same for the same frame and seed.
Nanoseconds load_of(const RenderLoad& load, std::uint64_t frame);

/// How a load went by.
struct LoadTime {
  Nanoseconds wall{0};
  Nanoseconds off_cpu{0};  ///< of it, taken by the machine
};

/// Keeps the calling thread busy until it has been on the CPU for so long. No system call but reading that clock.
LoadTime burn(Nanoseconds cpu_time);

}  // namespace poise::simulation
