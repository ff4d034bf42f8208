// SPDX-License-Identifier: MIT
#include "peers/turns.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

namespace poise::bench {
namespace {

double cpu_clock_ms(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

StepTime timed_step(const Engine& engine) {
  const clockid_t clock = engine.threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_PROCESS_CPUTIME_ID;
  const double cpu_before_ms = cpu_clock_ms(clock);
  const auto before = std::chrono::steady_clock::now();
  engine.step();
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - before;
  return {wall.count(), (cpu_clock_ms(clock) - cpu_before_ms) / engine.threads};
}

TimeFigures::Quantiles quantiles(std::vector<double> values_ms) {
  std::ranges::sort(values_ms);
  const auto at = [&](double quantile) {
    const auto rank = static_cast<std::size_t>(std::ceil(quantile * static_cast<double>(values_ms.size())));
    return values_ms[std::max<std::size_t>(rank, 1) - 1];
  };
  return {at(0.25), at(0.50), at(0.75), at(0.99)};
}

}  // namespace

std::vector<std::vector<StepTime>> take_turns(std::span<const Engine> engines, std::uint64_t frames,
                                              std::uint64_t block_frames,
                                              const std::function<void(std::uint64_t)>& progress) {
  std::vector<std::vector<StepTime>> times(engines.size());
  for (std::vector<StepTime>& of_one : times) of_one.reserve(frames);
  std::size_t round = 0;
  for (std::uint64_t done = 0; done < frames; ++round) {
    const std::uint64_t block = std::min(block_frames, frames - done);
    for (std::size_t turn = 0; turn < engines.size(); ++turn) {
      const std::size_t i = (round + turn) % engines.size();
      for (std::uint64_t frame = 0; frame < block; ++frame) times[i].push_back(timed_step(engines[i]));
    }
    done += block;
    progress(done);
  }
  return times;
}

TimeFigures time_figures(std::span<const StepTime> times) {
  TimeFigures figures;
  figures.frames = times.size();
  if (times.empty()) return figures;
  std::vector<double> wall_ms;
  std::vector<double> cpu_ms;
  for (const StepTime& time : times) {
    wall_ms.push_back(time.wall_ms);
    cpu_ms.push_back(time.cpu_ms);
  }
  figures.wall = quantiles(std::move(wall_ms));
  figures.cpu = quantiles(std::move(cpu_ms));
  return figures;
}

}  // namespace poise::bench
