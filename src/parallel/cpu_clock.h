// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <ctime>

namespace poise::parallel {

/// Time that the calling thread has been on a CPU. About 400 ns a call: a few times a frame, never per job.
inline std::chrono::nanoseconds thread_cpu_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace poise::parallel
