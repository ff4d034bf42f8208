// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "parallel/executor.h"

namespace poise::parallel {

/// Worker loops on threads of our own. Invariant: a run's loop is read only by workers that are counted in `gate_`.
///
/// One word, the gate, holds the number of the run, whether it may still be entered, and how many workers are in it. A
/// worker enters by counting itself in while the gate is open; the caller closes the gate when its own loop is done and
/// waits for the count to fall to 0. So a worker that the machine gave no time is never waited for, and cannot come in
/// after the end. run() neither locks nor allocates.
///
/// A worker without work spins for a bounded time and then sleeps, having left the caller's processor to the caller:
/// some kernels wake a thread on the processor of its waker although others idle, and there it would come too late. One
/// thread at a time may call run(); a call while another one runs is worked off by its own thread alone.
class ThreadPool final : public Executor {
 public:
  /// `threads` in [1, 256], the calling thread included. Fewer are used if the system refuses to start them.
  explicit ThreadPool(int threads);
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool() override;

  [[nodiscard]] int concurrency() const override { return static_cast<int>(threads_.size()) + 1; }
  void run(WorkerFunction loop) override;
  void wake() override;

 private:
  void work(int worker);
  /// Enters the open run unless its number is `last_run`, works, and leaves. False if there was nothing to enter.
  bool take_part(int worker, std::uint32_t& last_run);
  void call_workers();

  alignas(64) std::atomic<std::uint32_t> gate_{0};   ///< bits 0-7 workers inside, bit 8 open, the rest the run's number
  const WorkerFunction* loop_ = nullptr;             ///< written before the gate opens, read by those who entered
  alignas(64) std::atomic<std::uint32_t> calls_{0};  ///< sleepers wait for it to change
  std::atomic<int> caller_processor_{-1};
  std::atomic<bool> stopping_{false};
  std::atomic<bool> busy_{false};
  std::vector<std::jthread> threads_;  ///< last: its threads end before the words that they read
};

}  // namespace poise::parallel
