// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "parallel/executor.h"

namespace poise::parallel {

/// A function that is run in slices of time, on a thread of its own that stands still between them.
///
/// The function gives its loops to executor(). Where a slice is over it stops between two items of a loop or at a stop
/// point, with all that it has on its stack, and goes on there in the next slice. What lies between these is not
/// interrupted, so a slice is told to end earlier than asked, by as much as lets no more than a share of them end
/// later. Each slice does one item, or what lies before a stop point, at least. While the function stands still, no
/// worker holds an item of it.
///
/// Invariant: of the caller's thread and the function's, one waits for the other. So either may read what the other
/// wrote.
class SlicedTask {
 public:
  using Clock = std::chrono::steady_clock;

  /// `workers` does the items; it must outlive this, and may be used by the caller between slices.
  explicit SlicedTask(Executor& workers) : loops_(*this, workers) {}
  /// Runs the function to its end first.
  ~SlicedTask();
  SlicedTask(const SlicedTask&) = delete;
  SlicedTask& operator=(const SlicedTask&) = delete;

  // The caller's side; one thread at a time.

  /// Sets what the next slices run; there must be nothing unfinished. False if the system gives no thread for it.
  bool begin(std::function<void()> function);
  /// Begun, and has not returned.
  [[nodiscard]] bool unfinished() const { return unfinished_; }
  /// Runs a slice that ends about `until`, and of a share `late`, in (0, 0.5], of all slices later; returns whether the
  /// function has returned. What it throws comes out here, and ends it; at destruction it is dropped.
  bool run_until(Clock::time_point until, double late = 0.01);
  /// How much earlier than `until` the next slice is told to stop; at most a quarter of it.
  [[nodiscard]] Clock::duration lead() const { return lead_.value_or(Clock::duration{0}); }
  /// CPU time of the function's thread in the last slice.
  [[nodiscard]] std::chrono::nanoseconds slice_cpu() const { return slice_cpu_; }

  // The function's side.

  /// Its clock goes on where it was when the function stood still.
  [[nodiscard]] Executor& executor() { return loops_; }

 private:
  // Stops between items.
  class Loops final : public Executor {
   public:
    Loops(SlicedTask& task, Executor& workers) : task_(task), workers_(workers) {}
    // At least two, so that loops come here and not to a shortcut for one thread.
    [[nodiscard]] int concurrency() const override { return workers_.concurrency() > 1 ? workers_.concurrency() : 2; }
    void run(WorkerFunction step) override;
    // Nothing is abandoned.
    std::size_t run_with(const Patience& /*patience*/, WorkerFunction step) override {
      run(step);
      return 0;
    }
    [[nodiscard]] bool commit(int worker) override { return workers_.commit(worker); }
    void settle() override { workers_.settle(); }
    void wake() override { workers_.wake(); }
    void stop_point() override;
    [[nodiscard]] Waits waits() const override { return workers_.waits(); }
    [[nodiscard]] Clock::time_point time() const override { return Clock::now() - task_.stood_still_; }

   private:
    SlicedTask& task_;
    Executor& workers_;
    bool inside_ = false;  // a loop; of the function's thread
  };

  void live();
  void stand_still();
  /// Lets the function run until it returns, throws or stands still.
  void take_turn(Clock::time_point stop);
  [[nodiscard]] bool over() const { return Clock::now().time_since_epoch().count() >= stop_at_.load(); }
  void set_stop(Clock::time_point at) { stop_at_.store(at.time_since_epoch().count()); }

  Loops loops_;
  std::function<void()> function_;
  std::mutex mutex_;
  std::condition_variable turn_;
  bool running_ = false;   // the function's turn
  bool stopping_ = false;  // the thread is to end
  bool unfinished_ = false;
  std::exception_ptr thrown_;                // by the function; read when it has ended
  bool new_slice_ = false;                   // nothing was done in it yet; of the function's thread
  std::atomic<Clock::rep> stop_at_{};        // workers ask it between items
  std::optional<Clock::duration> lead_;      // how much earlier a slice is told to stop
  std::chrono::nanoseconds stood_still_{0};  // since it began
  std::chrono::nanoseconds slice_cpu_{0};
  std::optional<std::jthread> thread_;
};

}  // namespace poise::parallel
