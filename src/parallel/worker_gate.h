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

/// Hands the items of a run to workers and tells its caller which workers have an item. No locks, no allocation, and no
/// system call but where somebody sleeps. Invariant: a run's step is called only by workers who said so before they saw
/// the run open.
///
/// Every worker has a word of its own that says whether it has an item in hand. It says so *before* it looks whether
/// the run is open, and the caller looks at the words *after* it has closed the run (Dekker's handshake, both sides
/// sequentially consistent), so either the worker sees the run closed or the caller sees the item. Between two items a
/// worker is idle, and nobody waits for it. An abandoned worker begins no item before it has been idle again, because
/// no later run would wait for it.
class WorkerGate {
 public:
  /// Numbers 1 to workers - 1 are served; `workers` in [1, 256].
  WorkerGate(int workers, std::chrono::nanoseconds spin);

  /// The calling side; one thread at a time.
  void open(WorkerFunction step, bool may_abandon);
  /// No item begins from now on; waits for items in progress.
  void close();
  /// No item begins from now on; waits for items in progress while patience lasts, abandons the others and returns
  /// their number.
  std::size_t close(const Patience& patience);
  /// Waits until no worker has an item, abandoned ones included.
  void settle();

  /// Worker's side: does items of the open run, if there is one that it has not found exhausted. False if there was
  /// nothing to do. `last_run` is the worker's own and 0 at first.
  bool take_part(int worker, std::uint64_t& last_run);
  [[nodiscard]] bool commit(int worker);

 private:
  friend struct WorkerGateAccess;  // of tests, which stop a worker where only the system does
  enum Hand : std::uint32_t { kEmpty, kWorking, kCommitted, kAbandoned };
  struct alignas(64) Worker {
    std::atomic<std::uint32_t> hand{kEmpty};
  };
  /// What a worker that says it has something in hand then sees: an item of the open run, none, or that it was
  /// abandoned meanwhile.
  enum class ViewQuery : std::uint8_t { Open, Nothing, Abandoned };
  static void raise(Worker& worker) { worker.hand.exchange(kWorking, std::memory_order_seq_cst); }
  [[nodiscard]] ViewQuery look(const Worker& worker, std::uint64_t last_run, std::uint64_t& gate) const;
  static bool has_work(std::uint64_t gate, std::uint64_t last_run) {
    return (gate & kOpen) != 0 && gate / kOneRun != last_run;
  }
  void leave(Worker& worker);
  void wait_while(Worker& worker, bool abandoned_too);

  static constexpr std::uint64_t kOpen = 1, kMayGiveUp = 2, kOneRun = 4;
  alignas(64) std::atomic<std::uint64_t> gate_{0};  ///< kOpen, kMayGiveUp, the rest the run's number
  WorkerFunction step_;                             ///< of a run that waits for its items
  WorkerFunction lasting_step_;  ///< of a run that may abandon items: not changed until all workers have settled
  std::atomic<bool> caller_sleeps_{false};
  int workers_;
  std::chrono::nanoseconds spin_;
  std::unique_ptr<Worker[]> hands_;
};

}  // namespace poise::parallel
