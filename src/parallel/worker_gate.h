// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>

#include "parallel/executor.h"

namespace poise::parallel {

/// Calls done() until it is true or `most` has passed; says whether it became true.
template <class Done>
bool spin_until(std::chrono::nanoseconds most, Done&& done) {
  if (done()) return true;
  const auto end = std::chrono::steady_clock::now() + most;
  do {
    for (int i = 0; i < 16; ++i) {
      if (done()) return true;
#if defined(__x86_64__) || defined(__i386__)
      __builtin_ia32_pause();
#elif defined(__aarch64__)
      asm volatile("yield");
#endif
    }
  } while (std::chrono::steady_clock::now() < end);
  return false;
}

/// Where workers find the work of a run, and its caller finds out who has some in hand. No locks, no allocation, and no system call but where
/// somebody sleeps. Invariant: a run's step is called only by workers who said so before they saw the run open.
///
/// Every worker has a word of its own that says whether it has an item in hand. It says so *before* it looks whether the run is open, and
/// the caller looks at the words *after* it has closed the run (Dekker's handshake, both sides sequentially consistent), so
/// either the worker sees the run closed or the caller sees the item. Between two items a worker is nowhere, and nobody waits for it.
class WorkerGate {
 public:
  /// Numbers 1 to workers - 1 are served; `workers` in [1, 256].
  WorkerGate(int workers, std::chrono::nanoseconds spin);

  /// The calling side; one thread at a time.
  void open(WorkerFunction step, bool may_give_up);
  /// No item begins from now on; waits for those in hand.
  void close();
  /// No item begins from now on; waits for those in hand while patience lasts, gives up the others and returns how many.
  std::size_t close(const Patience& patience);
  /// Until no worker has an item in hand, not even one that was given up.
  void settle();

  /// Worker's side: does items of the open run, if there is one that it has not found exhausted. False if there was nothing to do.
  /// `last_run` is the worker's own and 0 at first.
  bool take_part(int worker, std::uint64_t& last_run);
  [[nodiscard]] bool commit(int worker);

 private:
  enum Hand : std::uint32_t { kEmpty, kWorking, kCommitted, kGivenUp };
  struct alignas(64) Worker {
    std::atomic<std::uint32_t> hand{kEmpty};
  };
  void leave(Worker& worker);
  void wait_while(Worker& worker, bool given_up_too);

  static constexpr std::uint64_t kOpen = 1, kMayGiveUp = 2, kOneRun = 4;
  alignas(64) std::atomic<std::uint64_t> gate_{0};  ///< kOpen, kMayGiveUp, the rest the run's number
  WorkerFunction step_;                             ///< of a run that waits for its items
  WorkerFunction lasting_step_;                     ///< of one that may give up: untouched until all have settled
  std::atomic<bool> caller_sleeps_{false};
  int workers_;
  std::chrono::nanoseconds spin_;
  std::unique_ptr<Worker[]> hands_;
};

}  // namespace poise::parallel
