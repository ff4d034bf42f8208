// SPDX-License-Identifier: MIT
#include "parallel/tbb_executor.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <optional>
#include <thread>
#include <vector>

#include "parallel/worker_gate.h"

namespace poise::parallel {
namespace {

/// What the visits of oneTBB's threads share with the executor that asked for them. A visit may begin when the executor
/// is gone.
struct PointIterationCount {
  struct alignas(64) Slot {
    std::uint64_t last_run = 0;
  };

  PointIterationCount(int threads, std::chrono::nanoseconds spin_time)
      : gate(threads, spin_time), spin(spin_time), slots(static_cast<std::size_t>(threads)) {}

  // One thread of the arena works at the gate until it has found nothing for a while.
  void visit() {
    const int worker = tbb::this_task_arena::current_thread_index();
    if (worker < 1 || worker >= static_cast<int>(slots.size())) {
      asked.fetch_sub(1, std::memory_order_seq_cst);
      return;
    }
    std::uint64_t& last_run = slots[static_cast<std::size_t>(worker)].last_run;
    const auto over = [&] { return stopping.load(std::memory_order_acquire); };
    bool worked = true;
    while (worked && !over()) {
      worked = false;
      spin_until(spin, [&] { return (worked = gate.take_part(worker, last_run)) || over(); });
    }
    asked.fetch_sub(1, std::memory_order_seq_cst);
    // A run that opened before this one was known to leave counted on it.
    if (!over()) gate.take_part(worker, last_run);
  }

  WorkerGate gate;
  std::chrono::nanoseconds spin;
  std::vector<Slot> slots;                ///< one a slot of the arena, used by the thread that is in it
  alignas(64) std::atomic<int> asked{0};  ///< visits that were asked for and are not over
  std::atomic<bool> stopping{false};
};

class TbbExecutor final : public Executor {
 public:
  TbbExecutor(int threads, std::chrono::nanoseconds spin)
      : threads_(threads), point_iterations_(std::make_shared<PointIterationCount>(threads, spin)), arena_(threads, 1) {
    // oneTBB starts as many threads as there are processors; more are only had by asking. Nobody is ever given fewer by
    // us: the limit is the whole process's, and oneTBB takes the smallest that is asked for.
    if (threads > tbb::info::default_concurrency()) {
      limit_.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    }
    arena_.initialize();
  }
  TbbExecutor(const TbbExecutor&) = delete;
  TbbExecutor& operator=(const TbbExecutor&) = delete;
  ~TbbExecutor() override {
    point_iterations_->stopping.store(true, std::memory_order_release);
    point_iterations_->gate.settle();
    // Visits that were asked for and have not begun hold what they share, and for good if the program ends first. They
    // end as soon as they begin; a process that gets no thread for them is not waited for longer.
    constexpr std::chrono::seconds kPatience{2};
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (point_iterations_->asked.load(std::memory_order_seq_cst) > 0 && std::chrono::steady_clock::now() < until)
      std::this_thread::yield();
  }

  [[nodiscard]] int concurrency() const override { return threads_; }

  void run(WorkerFunction step) override {
    const bool alone = busy_.exchange(true, std::memory_order_acquire);
    if (!alone) {
      point_iterations_->gate.open(step, false);
      wake();
    }
    while (step(0)) {
    }
    if (alone) return;
    point_iterations_->gate.close();
    busy_.store(false, std::memory_order_release);
  }

  std::size_t run_with(const Patience& patience, WorkerFunction step) override {
    const bool alone = busy_.exchange(true, std::memory_order_acquire);
    if (!alone) {
      point_iterations_->gate.open(step, true);
      wake();
    }
    while (step(0)) {
    }
    if (alone) return 0;
    const std::size_t abandoned = point_iterations_->gate.close(patience);
    busy_.store(false, std::memory_order_release);
    return abandoned;
  }

  [[nodiscard]] bool commit(int worker) override { return point_iterations_->gate.commit(worker); }
  void settle() override { point_iterations_->gate.settle(); }

  void wake() override {
    try {
      while (point_iterations_->asked.load(std::memory_order_seq_cst) < threads_ - 1) {
        point_iterations_->asked.fetch_add(1, std::memory_order_seq_cst);
        arena_.enqueue([visits = point_iterations_] { visits->visit(); });
      }
    } catch (const std::exception&) {
      // oneTBB found no memory for a task: one visit less, and the caller does the work.
      point_iterations_->asked.fetch_sub(1, std::memory_order_seq_cst);
    }
  }

 private:
  int threads_;
  std::shared_ptr<PointIterationCount> point_iterations_;
  std::optional<tbb::global_control> limit_;
  tbb::task_arena arena_;
  std::atomic<bool> busy_{false};
};

}  // namespace

std::unique_ptr<Executor> make_tbb_executor(int threads, std::chrono::nanoseconds spin) {
  try {
    return std::make_unique<TbbExecutor>(threads, spin);
  } catch (const std::exception&) {
    return nullptr;
  }
}

}  // namespace poise::parallel
