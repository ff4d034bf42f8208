// SPDX-License-Identifier: MIT
#include "parallel/executor.h"

#include <sched.h>

#include <algorithm>
#include <thread>

#include "parallel/thread_pool.h"
#ifdef POISE_HAVE_TBB
#include "parallel/tbb_executor.h"
#endif

namespace poise::parallel {
namespace {

constexpr int kMaxThreads = 256;

class SerialExecutor final : public Executor {
 public:
  [[nodiscard]] int concurrency() const override { return 1; }
  void run(WorkerFunction loop) override { loop(0); }
};

}  // namespace

int available_threads() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  const int count = sched_getaffinity(0, sizeof(allowed), &allowed) == 0
                        ? CPU_COUNT(&allowed)
                        : static_cast<int>(std::thread::hardware_concurrency());  // more than 1024 processors
  return std::max(count, 1);
}

std::unique_ptr<Executor> make_executor(ExecutorKind kind, int threads) {
  const int count = std::clamp(threads > 0 ? threads : available_threads(), 1, kMaxThreads);
  if (kind == ExecutorKind::Serial || count == 1) return std::make_unique<SerialExecutor>();
#ifdef POISE_HAVE_TBB
  if (kind == ExecutorKind::Tbb) {
    if (auto executor = make_tbb_executor(count)) return executor;
  }
#endif
  return std::make_unique<ThreadPool>(count);
}

}  // namespace poise::parallel
