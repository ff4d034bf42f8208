// SPDX-License-Identifier: MIT
#include "parallel/tbb_executor.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <exception>
#include <optional>

namespace poise::parallel {
namespace {

/// Invariant: one run at a time is inside the arena, so that its caller always has a slot there.
class TbbExecutor final : public Executor {
 public:
  explicit TbbExecutor(int threads) : threads_(threads), arena_(threads, 1) {
    // oneTBB starts as many threads as there are processors; more are only had by asking. Nobody is ever given fewer by
    // us: the limit is the whole process's, and oneTBB takes the smallest that is asked for.
    if (threads > tbb::info::default_concurrency()) {
      limit_.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    }
    arena_.initialize();
  }

  [[nodiscard]] int concurrency() const override { return threads_; }

  void run(WorkerFunction loop) override {
    if (busy_.exchange(true, std::memory_order_acquire)) {
      loop(0);
      return;
    }
    try {
      arena_.execute([&] { run_in_arena(loop); });
    } catch (const std::exception&) {
      // oneTBB found no memory for a task. All calls that began have ended; the rest is worked off here.
      loop(0);
    }
    busy_.store(false, std::memory_order_release);
  }

  void wake() override {
    try {
      arena_.enqueue([] {});
    } catch (const std::exception&) {
      // Nobody gets up early, and the run will call again.
    }
  }

 private:
  void run_in_arena(const WorkerFunction& loop) const {
    const int caller = tbb::this_task_arena::current_thread_index();
    tbb::parallel_for(
        tbb::blocked_range<int>(0, threads_, 1),
        [&](const tbb::blocked_range<int>& workers) {
          // The first call of the calling thread is number 0 (the leftmost range is never handed on). Those that nobody
          // else took come back to it when its loop has ended: the work is done, and they are dropped.
          const int worker = workers.begin();
          if (worker == 0 || tbb::this_task_arena::current_thread_index() != caller) loop(worker);
        },
        tbb::simple_partitioner{});
  }

  int threads_;
  std::optional<tbb::global_control> limit_;
  tbb::task_arena arena_;
  std::atomic<bool> busy_{false};
};

}  // namespace

std::unique_ptr<Executor> make_tbb_executor(int threads) {
  try {
    return std::make_unique<TbbExecutor>(threads);
  } catch (const std::exception&) {
    return nullptr;
  }
}

}  // namespace poise::parallel
