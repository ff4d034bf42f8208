// SPDX-License-Identifier: MIT
#include "parallel/host_adapter.h"

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

#include "parallel/worker_gate.h"

namespace poise::parallel {
namespace {

/// State shared by the calls of a host's threads and the adapter; it lives until the last call has ended. Invariant: a
/// worker's number belongs to one call at a time.
struct HostCalls {
  struct alignas(64) Worker {
    std::atomic<bool> taken{false};
    std::uint64_t last_run = 0;  ///< the last run of the call that holds this worker
  };

  HostCalls(int threads, std::chrono::nanoseconds spin_time)
      : gate(threads, spin_time), spin(spin_time), workers(static_cast<std::size_t>(threads)) {}

  /// A free worker's number, or 0 if there are more calls than workers.
  int take_worker() {
    for (std::size_t worker = 1; worker < workers.size(); ++worker) {
      if (!workers[worker].taken.load(std::memory_order_relaxed) &&
          !workers[worker].taken.exchange(true, std::memory_order_acquire)) {
        return static_cast<int>(worker);
      }
    }
    return 0;
  }

  void call() {
    const auto over = [&] { return stopping.load(std::memory_order_acquire); };
    const int number = over() ? 0 : take_worker();
    if (number == 0) {
      pending.fetch_sub(1, std::memory_order_seq_cst);
      return;
    }
    Worker& worker = workers[static_cast<std::size_t>(number)];
    bool worked = true;
    while (worked && !over()) {
      worked = false;
      spin_until(spin, [&] { return (worked = gate.take_part(number, worker.last_run)) || over(); });
    }
    pending.fetch_sub(1, std::memory_order_seq_cst);
    // A run that opened before this call was marked as ended relies on it.
    if (!over()) gate.take_part(number, worker.last_run);
    worker.taken.store(false, std::memory_order_release);
  }

  WorkerGate gate;
  std::chrono::nanoseconds spin;
  std::vector<Worker> workers;              ///< worker 0 is the calling thread's and is never taken
  alignas(64) std::atomic<int> pending{0};  ///< calls that the host will make or that have not ended
  std::atomic<bool> stopping{false};
};

class HostAdapter final : public Executor {
 public:
  HostAdapter(std::shared_ptr<HostExecutor> host, int threads, std::chrono::nanoseconds spin)
      : host_(std::move(host)),
        threads_(threads),
        calls_(std::make_shared<HostCalls>(threads, spin)),
        task_(calls_, [](void* calls) { static_cast<HostCalls*>(calls)->call(); }) {}
  HostAdapter(const HostAdapter&) = delete;
  HostAdapter& operator=(const HostAdapter&) = delete;
  ~HostAdapter() override {
    calls_->stopping.store(true, std::memory_order_release);
    // The gate is closed: after this, no call holds an item, and none begins one.
    calls_->gate.settle();
  }

  [[nodiscard]] int concurrency() const override { return threads_; }

  void run(WorkerFunction step) override {
    const bool alone = busy_.exchange(true, std::memory_order_acquire);
    if (!alone) {
      calls_->gate.open(step, false);
      wake();
    }
    while (step(0)) {
    }
    if (alone) return;
    calls_->gate.close();
    busy_.store(false, std::memory_order_release);
  }

  std::size_t run_with(const Patience& patience, WorkerFunction step) override {
    const bool alone = busy_.exchange(true, std::memory_order_acquire);
    if (!alone) {
      calls_->gate.open(step, true);
      wake();
    }
    while (step(0)) {
    }
    if (alone) return 0;
    const std::size_t abandoned = calls_->gate.close(patience);
    busy_.store(false, std::memory_order_release);
    return abandoned;
  }

  [[nodiscard]] bool commit(int worker) override { return calls_->gate.commit(worker); }
  void settle() override { calls_->gate.settle(); }
  [[nodiscard]] Waits waits() const override { return calls_->gate.waits(); }

  void wake() override {
    const int wanted = threads_ - 1 - calls_->pending.load(std::memory_order_seq_cst);
    if (wanted <= 0) return;
    // Counted before they can begin; the calls that the host refuses are subtracted again.
    calls_->pending.fetch_add(wanted, std::memory_order_seq_cst);
    const int started = std::clamp(host_->start(wanted, task_), 0, wanted);
    if (started < wanted) calls_->pending.fetch_sub(wanted - started, std::memory_order_seq_cst);
  }

 private:
  std::shared_ptr<HostExecutor> host_;
  int threads_;
  std::shared_ptr<HostCalls> calls_;
  HostTask task_;
  std::atomic<bool> busy_{false};
};

}  // namespace

std::unique_ptr<Executor> make_host_adapter(std::shared_ptr<HostExecutor> host, int threads,
                                            std::chrono::nanoseconds spin) {
  return std::make_unique<HostAdapter>(std::move(host), threads, spin);
}

}  // namespace poise::parallel
