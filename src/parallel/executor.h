// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

#include "parallel/shared.h"
#include "poise/types.h"

namespace poise::parallel {

/// A reference to a callable, without ownership or allocation; valid while the callable lives.
class WorkerFunction {
 public:
  template <class F>
  requires(!std::is_same_v<std::remove_cvref_t<F>, WorkerFunction>)
      // NOLINTNEXTLINE(google-explicit-constructor): made at the call, lives as long as the call
      WorkerFunction(F&& f)
      : object_(const_cast<void*>(static_cast<const void*>(&f))),
        call_([](void* object, int worker) { (*static_cast<std::remove_reference_t<F>*>(object))(worker); }) {}
  void operator()(int worker) const { call_(object_, worker); }

 private:
  void* object_;
  void (*call_)(void*, int);
};

/// Runs a worker loop on several threads. The one interface with more than one implementation here.
///
/// A loop takes its work from shared tickets and returns when none is left, so it may run on any number of
/// workers, and a worker that comes too late finds nothing to do.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Workers at most, the calling thread (worker 0) included.
  [[nodiscard]] virtual int concurrency() const = 0;
  /// Calls loop(worker) on the calling thread and on those others that come in time, each with its own number
  /// in [0, concurrency()). Returns when every call that began has ended: it waits for work that was taken, never
  /// for a worker that has not shown up. The loop must not throw. One thread at a time may call run; a call from inside
  /// a loop of the same executor, or beside one, is worked off by its own thread alone, as worker 0.
  virtual void run(WorkerFunction loop) = 0;
  /// Asks sleeping workers to get up, because a run is about to come. Returns at once.
  virtual void wake() {}
};

/// An executor with `threads` workers, the calling thread included: 0 or less means available_threads(), more than 256
/// means 256. If the system refuses to start threads, fewer are used. Tbb means Threads where oneTBB was left out of
/// the build, and one thread means Serial. Several executors may exist and run at once.
std::unique_ptr<Executor> make_executor(ExecutorKind kind, int threads);

/// Number of threads this process may use (its affinity mask), at least 1.
int available_threads();

/// Calls body(begin, end, worker) over [0, n) in chunks of `grain` (the last may be shorter). Chunk borders depend on
/// n and grain alone, so that per-chunk results put together in order do not depend on threads. A grain of 0 counts
/// as 1. The body must not throw; it may be called for several chunks at once, and calls with equal `worker` never
/// overlap.
template <class Body>
void parallel_for(Executor& executor, std::size_t n, std::size_t grain, Body&& body) {
  if (n == 0) return;
  if (grain == 0) grain = 1;
  if (n <= grain || executor.concurrency() == 1) {
    for (std::size_t begin = 0; begin < n; begin += grain) body(begin, begin + grain < n ? begin + grain : n, 0);
    return;
  }
  Tickets tickets;
  executor.run([&](int worker) {
    for (;;) {
      const std::size_t begin = tickets.take(grain);
      if (begin >= n) return;
      body(begin, begin + grain < n ? begin + grain : n, worker);
    }
  });
}

}  // namespace poise::parallel
