// SPDX-License-Identifier: MIT
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <vector>

namespace poise::bench {

/// Wall times of single iterations, for percentiles, which a mean hides. One thread.
class Latencies {
 public:
  /// Times one call of work() and passes the time to the state, which must use manual time. Returns the seconds.
  template <class Work>
  double time(benchmark::State& state, Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    state.SetIterationTime(elapsed.count());
    seconds_.push_back(elapsed.count());
    return elapsed.count();
  }

  /// Adds the counters p50_us, p99_us and max_us (nearest rank).
  void report(benchmark::State& state) {
    if (seconds_.empty()) return;
    std::ranges::sort(seconds_);
    state.counters["p50_us"] = at(0.50);
    state.counters["p99_us"] = at(0.99);
    state.counters["max_us"] = at(1.0);
  }

 private:
  [[nodiscard]] double at(double quantile) const {
    const auto rank = static_cast<std::size_t>(std::ceil(quantile * static_cast<double>(seconds_.size())));
    return 1e6 * seconds_[std::max<std::size_t>(rank, 1) - 1];
  }

  std::vector<double> seconds_;
};

}  // namespace poise::bench
