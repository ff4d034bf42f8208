// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "parallel/executor.h"
#include "parallel/worker_gate.h"

namespace poise::parallel {

/// An executor on its own threads, which take items at a WorkerGate. run() neither locks nor allocates, and makes no
/// system call while all workers are awake.
///
/// A worker without work spins for a bounded time and then sleeps; a sleeping worker does not use the caller's
/// processor. Some kernels wake a thread on the processor of its waker although others are idle, and it would start too
/// late there. One thread at a time may call run(); the work of a concurrent call is done by its calling thread alone.
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
  [[nodiscard]] Waits waits() const override { return gate_.waits(); }

  /// The result of setting affinity and priority of the threads.
  [[nodiscard]] const Status& placed() const { return placed_; }

 private:
  void work(int worker);
  void call_workers();

  WorkerGate gate_;
  std::chrono::nanoseconds spin_;
  bool follow_caller_;  ///< stay away from the caller's processor
  Status placed_ = Done{};
  alignas(64) std::atomic<std::uint32_t> calls_{0};  ///< sleeping threads wait for it to change
  std::atomic<std::uint32_t> sleepers_{0};           ///< threads that sleep or are about to
  std::atomic<int> caller_processor_{-1};
  std::atomic<bool> stopping_{false};
  std::atomic<bool> busy_{false};
  std::vector<std::jthread> threads_;  ///< last member: its threads end before the members that they read are destroyed
};

}  // namespace poise::parallel
