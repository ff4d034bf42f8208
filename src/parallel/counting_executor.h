// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "parallel/executor.h"

namespace poise::parallel {

/// A point in time on the two clocks of a CountingExecutor.
struct CountedAt {
  std::chrono::nanoseconds work{0};            ///< by the clock that work is counted with
  std::chrono::steady_clock::time_point wall;  ///< to find the stretch that something belongs to
};

/// One parallel loop as a CountingExecutor saw it.
struct CountedLoop {
  CountedAt begin, end;
  std::chrono::nanoseconds work{0};      ///< of all chunks
  std::chrono::nanoseconds longest{0};   ///< chunk: the loop's time on any number of cores
  std::chrono::nanoseconds on_cores{0};  ///< its time on as many cores as the executor stands for
  std::size_t chunks = 0;
};

/// Counts how parallel a program is: does the work of every loop on the calling thread, chunk by chunk in order, and
/// takes the time of each. What lies between two loops is serial. For one thread; nested loops count as work of their
/// chunk.
///
/// The time of a loop on `cores` cores is that of list scheduling: the next chunk goes to the core that is free first
/// (Graham 1966). Neither it nor the longest chunk counts what it costs to start a loop and to wait for its end.
class CountingExecutor final : public Executor {
 public:
  using Clock = std::function<CountedAt()>;
  /// `cores` >= 2: what the loops see as concurrency(); only worker 0 is called. By default work is counted in CPU time
  /// of the calling thread, which stands still while the system gives the processor to another; tests invent a clock.
  explicit CountingExecutor(int cores, Clock clock = {});

  [[nodiscard]] int concurrency() const override { return static_cast<int>(free_.size()); }
  void run(WorkerFunction step) override;
  std::size_t run_with(const Patience& patience, WorkerFunction step) override;
  [[nodiscard]] bool commit(int /*worker*/) override { return true; }
  void settle() override {}

  /// The loops since the last clear(), in order.
  [[nodiscard]] std::span<const CountedLoop> loops() const { return loops_; }
  void clear() { loops_.clear(); }
  [[nodiscard]] CountedAt now() const { return clock_(); }

 private:
  Clock clock_;
  std::vector<std::chrono::nanoseconds> free_;  // when each core has done its chunks of this loop
  std::vector<CountedLoop> loops_;
  bool inside_ = false;
};

/// Work and critical path of a stretch of a program.
struct CountedWork {
  std::chrono::nanoseconds work{0};      ///< in all
  std::chrono::nanoseconds serial{0};    ///< of it outside parallel loops
  std::chrono::nanoseconds span{0};      ///< serial, and the longest chunk of each loop
  std::chrono::nanoseconds on_cores{0};  ///< serial, and the time of each loop on the executor's cores
  std::size_t loops = 0;
};

/// Sums up the stretches between `borders` (ascending wall times, at least two; the first not before `start`, the last
/// not after `end`). A loop belongs to the stretch in which it began. Serial work in which a border lies is divided as
/// the wall time is.
std::vector<CountedWork> count_stretches(std::span<const CountedLoop> loops, const CountedAt& start,
                                         const CountedAt& end,
                                         std::span<const std::chrono::steady_clock::time_point> borders);

}  // namespace poise::parallel
