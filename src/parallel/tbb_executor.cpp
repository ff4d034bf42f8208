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

/// State shared by the executor and the oneTBB tasks that it enqueued. A task may begin after the executor is
/// destroyed.
struct ArenaTasks {
  struct alignas(64) Slot {
    std::uint64_t last_run = 0;
  };

  ArenaTasks(int threads, std::chrono::nanoseconds spin_time)
      : gate(threads, spin_time), spin(spin_time), slots(static_cast<std::size_t>(threads)) {}

  // One thread of the arena takes items at the gate until it has found none for some time.
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
    // A run that opened before this task was marked as ended relies on it.
    if (!over()) gate.take_part(worker, last_run);
  }

  WorkerGate gate;
  std::chrono::nanoseconds spin;
  std::vector<Slot> slots;                ///< one a slot of the arena, used by the thread in that slot
  alignas(64) std::atomic<int> asked{0};  ///< tasks enqueued and not yet ended
  std::atomic<bool> stopping{false};
};

class TbbExecutor final : public Executor {
 public:
  TbbExecutor(int threads, std::chrono::nanoseconds spin)
      : threads_(threads), tasks_(std::make_shared<ArenaTasks>(threads, spin)), arena_(threads, 1) {
    // oneTBB starts as many threads as there are processors; more must be requested. This never reduces the number for
    // other users: the limit is that of the whole process, and oneTBB takes the smallest one requested.
    if (threads > tbb::info::default_concurrency()) {
      limit_.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    }
    arena_.initialize();
  }
  TbbExecutor(const TbbExecutor&) = delete;
  TbbExecutor& operator=(const TbbExecutor&) = delete;
  ~TbbExecutor() override {
    tasks_->stopping.store(true, std::memory_order_release);
    tasks_->gate.settle();
    // Tasks that have not begun keep the shared state alive and end as soon as they begin. The wait is bounded in case
    // no thread ever takes them.
    constexpr std::chrono::seconds kPatience{2};
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (tasks_->asked.load(std::memory_order_seq_cst) > 0 && std::chrono::steady_clock::now() < until)
      std::this_thread::yield();
  }

  [[nodiscard]] int concurrency() const override { return threads_; }

  void run(WorkerFunction step) override {
    const bool alone = busy_.exchange(true, std::memory_order_acquire);
    if (!alone) {
      tasks_->gate.open(step, false);
      wake();
    }
    while (step(0)) {
    }
    if (alone) return;
    tasks_->gate.close();
    busy_.store(false, std::memory_order_release);
  }

  std::size_t run_with(const Patience& patience, WorkerFunction step) override {
    const bool alone = busy_.exchange(true, std::memory_order_acquire);
    if (!alone) {
      tasks_->gate.open(step, true);
      wake();
    }
    while (step(0)) {
    }
    if (alone) return 0;
    const std::size_t abandoned = tasks_->gate.close(patience);
    busy_.store(false, std::memory_order_release);
    return abandoned;
  }

  [[nodiscard]] bool commit(int worker) override { return tasks_->gate.commit(worker); }
  void settle() override { tasks_->gate.settle(); }
  [[nodiscard]] Waits waits() const override { return tasks_->gate.waits(); }

  void wake() override {
    try {
      while (tasks_->asked.load(std::memory_order_seq_cst) < threads_ - 1) {
        tasks_->asked.fetch_add(1, std::memory_order_seq_cst);
        arena_.enqueue([visits = tasks_] { visits->visit(); });
      }
    } catch (const std::exception&) {
      // oneTBB has no memory for a task: there is one worker fewer, and the caller does its work.
      tasks_->asked.fetch_sub(1, std::memory_order_seq_cst);
    }
  }

 private:
  int threads_;
  std::shared_ptr<ArenaTasks> tasks_;
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
