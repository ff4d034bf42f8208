// SPDX-License-Identifier: MIT
#include "parallel/executor.h"

#include <sched.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "parallel/host_adapter.h"
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
  void run(WorkerFunction step) override {
    while (step(0)) {
    }
  }
  std::size_t run_with(const Patience& /*patience*/, WorkerFunction step) override {
    run(step);
    return 0;
  }
  [[nodiscard]] bool commit(int /*worker*/) override { return true; }
  void settle() override {}
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

Result<std::unique_ptr<Executor>> make_executor(const ExecutorSettings& asked) {
  const Status sound = check_executor(asked);
  if (!sound) return sound.error();
  ExecutorSettings settings = asked;
  settings.threads = std::clamp(asked.threads > 0 ? asked.threads : available_threads(), 1, kMaxThreads);
  if (settings.kind == ExecutorKind::Host) {
    const int offered = settings.host->concurrency();
    settings.threads = asked.threads > 0 ? std::min(settings.threads, offered) : offered;
  }
  if (settings.kind == ExecutorKind::Serial || settings.threads == 1)
    return std::unique_ptr<Executor>(std::make_unique<SerialExecutor>());
  if (settings.kind == ExecutorKind::Host)
    return make_host_adapter(std::move(settings.host), settings.threads, settings.spin);
#ifdef POISE_HAVE_TBB
  if (settings.kind == ExecutorKind::Tbb) {
    if (auto executor = make_tbb_executor(settings.threads, settings.spin)) return executor;
  }
#endif
  auto pool = std::make_unique<ThreadPool>(settings);
  if (!pool->placed()) return pool->placed().error();
  return std::unique_ptr<Executor>(std::move(pool));
}

std::unique_ptr<Executor> make_executor(ExecutorKind kind, int threads) {
  ExecutorSettings settings;
  settings.kind = kind;
  settings.threads = threads;
  return make_executor(settings).value();
}

}  // namespace poise::parallel
