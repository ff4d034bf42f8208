// SPDX-License-Identifier: MIT
#pragma once

#include <ctime>

#include "poise/step.h"

namespace poise::simulation {

/// Time that the calling thread has been on a CPU. About 400 ns a call: a few times a frame, never per job.
inline Nanoseconds thread_cpu_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + Nanoseconds(time.tv_nsec);
}

}  // namespace poise::simulation
