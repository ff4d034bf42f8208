// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include "parallel/shared_counters.h"
#include "parallel/worker_function.h"
#include "poise/executor.h"
#include "poise/result.h"
#include "poise/types.h"

namespace poise::parallel {

/// How long a run waits for items that other workers have begun: until the later of a point in time and a duration
/// after the wait begins.
struct Patience {
  std::chrono::steady_clock::time_point until{};
  std::chrono::nanoseconds at_least{0};
};

/// Time that the calling thread slept because other workers were not done, over all runs. A wait that is over before
/// the thread sleeps is CPU time, and is not here.
struct Waits {
  std::chrono::nanoseconds slept{0};
  /// Of it, the time in which the system did not run the awaited worker either.
  std::chrono::nanoseconds held_up{0};

  /// A wait of `wall`, in which the awaited worker was on a processor for `worker_cpu`.
  void add(std::chrono::nanoseconds wall, std::chrono::nanoseconds worker_cpu) {
    slept += wall;
    held_up += std::clamp(wall - worker_cpu, std::chrono::nanoseconds(0), wall);
  }
  friend Waits operator-(const Waits& a, const Waits& b) { return {a.slept - b.slept, a.held_up - b.held_up}; }
};

/// Runs work on several threads.
///
/// Work is a function that does one item (a chunk, a job) a call and takes its item from shared tickets. So it may be
/// called on any number of workers, and a worker that comes too late finds no item. A run waits for items, never for
/// workers: a worker that the system suspends between two items, or before its first, delays nothing.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Maximum number of workers, the calling thread (worker 0) included.
  [[nodiscard]] virtual int concurrency() const = 0;
  /// Calls step(worker) on the calling thread until it returns false, and the same on other workers that join in time,
  /// each with its own number in [0, concurrency()). Returns when the calling thread has found no more work and every
  /// call that began has ended. A call must not throw. One thread at a time may call run; the work of a nested or
  /// concurrent call is done by its calling thread alone, as worker 0.
  virtual void run(WorkerFunction step) = 0;
  /// The same, but when patience ends it abandons the items that other workers have not finished. A step must call
  /// commit() before it changes anything that others read, and change nothing if that returns false; so abandoned items
  /// have no effect. `step`, and everything that it reads before its commit, must stay unchanged until settle() has
  /// returned. Returns the number of abandoned items.
  virtual std::size_t run_with(const Patience& patience, WorkerFunction step) = 0;
  /// Called inside a step: returns whether the step may change data that others read. After true, the run waits for the
  /// item. Always true in run().
  [[nodiscard]] virtual bool commit(int worker) = 0;
  /// Waits until abandoned workers have left their items. Costs almost nothing if there are none.
  virtual void settle() = 0;
  /// Wakes sleeping workers before a run. Returns at once.
  virtual void wake() {}
  /// Where the thread that calls run may be made to stand still between two runs, as it may between items of a run: for
  /// long loops that are done one item after another.
  virtual void stop_point() {}
  /// For the thread that calls run, between two runs.
  [[nodiscard]] virtual Waits waits() const { return {}; }
  /// The clock of the work: stands still while the executor does. The caller and workers in a step.
  [[nodiscard]] virtual std::chrono::steady_clock::time_point time() const { return std::chrono::steady_clock::now(); }
};

/// Spinning longer than this wastes a processor; 0 is allowed too.
inline constexpr std::chrono::nanoseconds kMaxSpin{10'000'000};
/// Longer than the serial parts between two loops of a frame, and about the cost of waking a sleeping thread (26 us at
/// the median, 63 us at p99). Chosen. Without a bound, spinning on a loaded machine made frames 1000 times longer.
inline constexpr std::chrono::nanoseconds kDefaultSpin{50'000};

struct ExecutorSettings {
  ExecutorKind kind = ExecutorKind::Tbb;
  int threads = 0;  ///< the calling thread included; 0 or less: available_threads(); at most 256
  std::chrono::nanoseconds spin{
      kDefaultSpin};  ///< a worker without work polls for this time and then sleeps; in [0, kMaxSpin]
  /// Worker w >= 1 runs only on processors[w mod size]; the affinity of the calling thread is not changed. Empty: no
  /// affinity.
  std::vector<int> processors;
  int realtime_priority = 0;           ///< of the workers under SCHED_FIFO, 1 to 99; 0: default
  std::shared_ptr<HostExecutor> host;  ///< with ExecutorKind::Host only
};

/// Refused: a spin out of range; a processor that this process may not use; a priority out of range or that the system
/// does not grant; processors or a priority for threads that are not owned here (oneTBB's and a host's);
/// ExecutorKind::Host without a host, a host with another kind, or a host whose concurrency is not in [1, 256]. The
/// message gives field, value and rule. Any thread; changes nothing.
Status check_executor(const ExecutorSettings& settings);

/// If the system refuses to start threads, fewer are used. Tbb means Threads if the build has no oneTBB, and one thread
/// means Serial. At most host->concurrency() threads of a host are used. Several executors may exist and run at once.
/// Refused as by check_executor.
Result<std::unique_ptr<Executor>> make_executor(const ExecutorSettings& settings);
/// The same with default settings otherwise.
std::unique_ptr<Executor> make_executor(ExecutorKind kind, int threads);

/// Number of processors that this process may use (its affinity mask), at least 1. Any thread.
int available_threads();

/// Binds the calling thread to a processor (`processor` >= 0) and gives it a priority under SCHED_FIFO
/// (`realtime_priority` > 0). Refused as by check_executor.
Status place_this_thread(int processor, int realtime_priority);

/// Calls body(begin, end, worker) over [0, n) in chunks of `grain` (the last may be shorter; a grain of 0 counts as 1).
/// Chunk borders depend on n and grain alone, so per-chunk results combined in order do not depend on threads. Loops of
/// equal length and grain give a worker the same chunks, unless a worker is late. The body must not throw. It may be
/// called for several chunks at once; calls with equal `worker` never overlap.
template <class Body>
void parallel_for(Executor& executor, std::size_t n, std::size_t grain, Body&& body) {
  if (n == 0) return;
  if (grain == 0) grain = 1;
  if (n <= grain || executor.concurrency() == 1) {
    for (std::size_t begin = 0; begin < n; begin += grain) body(begin, begin + grain < n ? begin + grain : n, 0);
    return;
  }
  Shares chunks((n + grain - 1) / grain, executor.concurrency());
  executor.run([&](int worker) -> bool {
    const std::size_t chunk = chunks.take(worker);
    if (chunk == Shares::kNone) return false;
    const std::size_t begin = chunk * grain;
    body(begin, begin + grain < n ? begin + grain : n, worker);
    return true;
  });
}

/// Calls body(begin, end) over [0, n) in chunks of `grain` >= 1, one after another on the calling thread, with a stop
/// point after each.
template <class Body>
void serial_for(Executor& executor, std::size_t n, std::size_t grain, Body&& body) {
  for (std::size_t begin = 0; begin < n; begin += grain) {
    body(begin, begin + grain < n ? begin + grain : n);
    executor.stop_point();
  }
}

}  // namespace poise::parallel
