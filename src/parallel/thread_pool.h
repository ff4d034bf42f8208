// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "parallel/executor.h"
#include "parallel/worker_gate.h"

namespace poise::parallel {

/// Work on threads of our own, handed out at a WorkerGate. run() neither locks nor allocates, and makes no system call
/// while all workers are up.
///
/// A worker without work spins for a bounded time and then sleeps, having left the caller's processor to the caller:
/// some kernels wake a thread on the processor of its waker although others idle, and there it would come too late. One
/// thread at a time may call run(); a call while another one runs is worked off by its own thread alone.
class ThreadPool final : public Executor {
 public:
  /// `settings.threads` in [1, 256], the calling thread included. Fewer are used if the system refuses to start them.
  explicit ThreadPool(const ExecutorSettings& settings);
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool() override;

  [[nodiscard]] int concurrency() const override { return static_cast<int>(threads_.size()) + 1; }
  void run(WorkerFunction step) override;
  std::size_t run_with(const Patience& patience, WorkerFunction step) override;
  [[nodiscard]] bool commit(int worker) override { return gate_.commit(worker); }
  void settle() override { gate_.settle(); }
  void wake() override;

  /// What placing the threads as the settings ask came to.
  [[nodiscard]] const Status& placed() const { return placed_; }

 private:
  void work(int worker);
  void call_workers();

  WorkerGate gate_;
  std::chrono::nanoseconds spin_;
  bool follow_caller_;  ///< stay away from the caller's processor
  Status placed_ = Done{};
  alignas(64) std::atomic<std::uint32_t> calls_{0};  ///< sleepers wait for it to change
  std::atomic<std::uint32_t> sleepers_{0};           ///< who sleep, or are about to
  std::atomic<int> caller_processor_{-1};
  std::atomic<bool> stopping_{false};
  std::atomic<bool> busy_{false};
  std::vector<std::jthread> threads_;  ///< last: its threads end before the words that they read
};

}  // namespace poise::parallel
