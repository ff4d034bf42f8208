// SPDX-License-Identifier: MIT
#include "scene/run/render_load.h"

#include <algorithm>

#include "geometry/primitives/random.h"
#include "parallel/cpu_clock.h"

namespace poise::simulation {

Nanoseconds load_of(const RenderLoad& load, std::uint64_t frame) {
  const double off = geometry::Random::of(load.seed, frame).symmetric();
  return load.mean +
         Nanoseconds(static_cast<std::int64_t>(off * static_cast<double>(std::min(load.jitter, load.mean).count())));
}

LoadTime burn(Nanoseconds cpu_time) {
  const SteadyClock::time_point begun = SteadyClock::now();
  const Nanoseconds cpu_before = parallel::thread_cpu_time();
  Nanoseconds cpu{0};
  while (cpu < cpu_time) cpu = parallel::thread_cpu_time() - cpu_before;
  const Nanoseconds wall = SteadyClock::now() - begun;
  return {wall, std::max(Nanoseconds(0), wall - cpu)};
}

}  // namespace poise::simulation
