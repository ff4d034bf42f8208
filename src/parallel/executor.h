// SPDX-License-Identifier: MIT
#pragma once

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

/// Runs work on several threads. The one interface with more than one implementation here.
///
/// Work is a function that does one item (a chunk, a job) a call and takes what it does from shared tickets, so it may
/// be called on any number of workers, and a worker that comes too late finds nothing to do. Items are waited for,
/// never workers: one that the system holds up between two items, or before its first, holds up nobody.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Workers at most, the calling thread (worker 0) included.
  [[nodiscard]] virtual int concurrency() const = 0;
  /// Calls step(worker) on the calling thread until it returns false, and likewise on those others that come in time,
  /// each with its own number in [0, concurrency()). Returns when the calling thread has found nothing more to do and
  /// every call that began has ended. A call must not throw. One thread at a time may call run; a call from inside a
  /// step of the same executor, or beside one, is worked off by its own thread alone, as worker 0.
  virtual void run(WorkerFunction step) = 0;
  /// The same, but abandons the items that other workers have not finished when patience ends. A step must call
  /// commit() before it changes anything that others read, and change nothing if that returns false, so abandoned items
  /// have no effect. `step`, and all that it reads before its commit, must stay as they are until settle() has
  /// returned. Returns how many items were abandoned.
  virtual std::size_t run_with(const Patience& patience, WorkerFunction step) = 0;
  /// Inside a step: may it change what others read? After true the item is waited for until its end. Always true in
  /// run().
  [[nodiscard]] virtual bool commit(int worker) = 0;
  /// Waits until abandoned workers have noticed it. Costs almost nothing if there are none.
  virtual void settle() = 0;
  /// Wakes sleeping workers before a run. Returns at once.
  virtual void wake() {}
};

/// Spinning longer than this wastes a processor; no spinning is allowed too.
inline constexpr std::chrono::nanoseconds kMaxSpin{10'000'000};
/// Longer than the serial stretches between two loops of a frame, and about what it costs to wake a sleeper (26 us at
/// the median, 63 us at p99). Chosen. Without a bound, spinning on a loaded machine made frames 1000 times longer.
inline constexpr std::chrono::nanoseconds kDefaultSpin{50'000};

struct ExecutorSettings {
  ExecutorKind kind = ExecutorKind::Tbb;
  int threads = 0;  ///< the calling thread included; 0 or less: available_threads(); at most 256
  std::chrono::nanoseconds spin{
      kDefaultSpin};  ///< a worker without work looks for it for this long and then sleeps; in [0, kMaxSpin]
  /// Worker w (from 1; the calling thread's place is its owner's matter) runs on processors[w mod size] alone; empty:
  /// where the system puts it.
  std::vector<int> processors;
  int realtime_priority = 0;           ///< of the workers under SCHED_FIFO, 1 to 99; 0: as all threads
  std::shared_ptr<HostExecutor> host;  ///< with ExecutorKind::Host, and only then
};

/// Refused: a spin out of range; a processor that this process may not use; a priority out of range or that the system
/// does not grant; processors or a priority for threads that are not ours, oneTBB's and a host's; ExecutorKind::Host
/// without a host, a host with another kind, or one whose concurrency is out of [1, 256]. The message names field,
/// value and rule. Any thread; nothing is changed by asking.
Status check_executor(const ExecutorSettings& settings);

/// If the system refuses to start threads, fewer are used. Tbb means Threads where oneTBB was left out of the build,
/// and one thread means Serial. Of a host's threads at most host->concurrency() are used. Several executors may exist
/// and run at once. Refused: as by check_executor.
Result<std::unique_ptr<Executor>> make_executor(const ExecutorSettings& settings);
/// The same with all else as it comes.
std::unique_ptr<Executor> make_executor(ExecutorKind kind, int threads);

/// Number of threads this process may use (its affinity mask), at least 1.
int available_threads();

/// Gives the calling thread a processor of its own (`processor` >= 0) and a priority under SCHED_FIFO
/// (`realtime_priority` > 0). Refused as by check_executor.
Status place_this_thread(int processor, int realtime_priority);

/// Calls body(begin, end, worker) over [0, n) in chunks of `grain` (the last may be shorter). Chunk borders depend on
/// n and grain alone, so that per-chunk results put together in order do not depend on threads. A grain of 0 counts
/// as 1. Loops of equal length and grain give a worker the same chunks, as far as nobody is late. The body must not
/// throw; it may be called for several chunks at once, and calls with equal `worker` never overlap.
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

}  // namespace poise::parallel
