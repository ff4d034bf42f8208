// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <memory>

#include "parallel/executor.h"

namespace poise::parallel {

/// Calls done() until it returns true or `most` has passed; returns whether it became true.
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

/// Hands the items of a run to workers and tracks which workers hold an item. No locks, no allocation, and no system
/// call unless a thread sleeps. Invariant: a run's step is called only by workers that set their own word before they
/// saw the run open.
///
/// Each worker has a word that says whether it holds an item. It sets the word *before* it checks whether the run is
/// open, and the caller reads the words *after* it has closed the run (Dekker's algorithm, both sides sequentially
/// consistent). So either the worker sees the run closed or the caller sees the item. Between two items a worker is
/// idle, and the caller does not wait for it. An abandoned worker begins no item before it has been idle again, because
/// no later run would wait for it.
class WorkerGate {
 public:
  /// Serves the workers 1 to workers - 1; `workers` in [1, 256].
  WorkerGate(int workers, std::chrono::nanoseconds spin);

  /// The caller's side; one thread at a time.
  void open(WorkerFunction step, bool may_abandon);
  /// Prevents further items and waits for items in progress.
  void close();
  /// Prevents further items, waits for items in progress while patience lasts, abandons the others and returns their
  /// number.
  std::size_t close(const Patience& patience);
  /// Waits until no worker holds an item, abandoned workers included.
  void settle();

  /// Waits of the caller that it slept through.
  [[nodiscard]] const Waits& waits() const { return waits_; }

  /// Worker's side: does items of the open run, unless there is none or this worker has found it exhausted. Returns
  /// false if it did nothing. `last_run` belongs to the worker and starts at 0.
  bool take_part(int worker, std::uint64_t& last_run);
  [[nodiscard]] bool commit(int worker);

 private:
  friend struct WorkerGateAccess;  // for tests, which stop a worker at points where otherwise only the system does
  static constexpr clockid_t kNoClock = CLOCK_REALTIME;  ///< never that of a thread
  enum Hand : std::uint32_t { kEmpty, kWorking, kCommitted, kAbandoned };
  struct alignas(64) Worker {
    std::atomic<std::uint32_t> hand{kEmpty};
    std::atomic<clockid_t> cpu_clock{kNoClock};  ///< of the thread that was this worker last
  };
  /// The state that a worker finds after it has set its word: a run is open, none is, or the worker was abandoned
  /// meanwhile.
  enum class GateState : std::uint8_t { Open, Nothing, Abandoned };
  static std::chrono::nanoseconds cpu_time_of(const Worker& worker);
  static void raise(Worker& worker) { worker.hand.exchange(kWorking, std::memory_order_seq_cst); }
  [[nodiscard]] GateState look(const Worker& worker, std::uint64_t last_run, std::uint64_t& gate) const;
  static bool has_work(std::uint64_t gate, std::uint64_t last_run) {
    return (gate & kOpen) != 0 && gate / kOneRun != last_run;
  }
  void leave(Worker& worker);
  void wait_while(Worker& worker, bool abandoned_too);

  static constexpr std::uint64_t kOpen = 1, kMayAbandon = 2, kOneRun = 4;
  alignas(64) std::atomic<std::uint64_t> gate_{0};  ///< kOpen, kMayAbandon, and the run's number in the other bits
  WorkerFunction step_;                             ///< of a run that waits for all of its items
  WorkerFunction lasting_step_;  ///< of a run that may abandon items: not changed until all workers have settled
  std::atomic<bool> caller_sleeps_{false};
  Waits waits_;  ///< the caller's
  int workers_;
  std::chrono::nanoseconds spin_;
  std::unique_ptr<Worker[]> hands_;
};

}  // namespace poise::parallel
