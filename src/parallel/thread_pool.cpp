// SPDX-License-Identifier: MIT
#include "parallel/thread_pool.h"

#include <sched.h>

#include <system_error>

#include "parallel/thread_affinity.h"

namespace poise::parallel {
namespace {

/// Lets this thread run on all processors of `allowed` except `processor`. If none remains, the kernel refuses and
/// nothing changes.
void stay_away_from(const cpu_set_t& allowed, int processor) {
  cpu_set_t others = allowed;
  if (processor >= 0 && processor < CPU_SETSIZE) CPU_CLR(static_cast<std::size_t>(processor), &others);
  sched_setaffinity(0, sizeof(others), &others);
}

}  // namespace

ThreadPool::ThreadPool(const ExecutorSettings& settings)
    : gate_(settings.threads, settings.spin), spin_(settings.spin), follow_caller_(settings.processors.empty()) {
  threads_.reserve(static_cast<std::size_t>(settings.threads - 1));
  try {
    for (int worker = 1; worker < settings.threads; ++worker) {
      threads_.emplace_back([this, worker] { work(worker); });
      const std::vector<int>& on = settings.processors;
      const int processor = on.empty() ? -1 : on[static_cast<std::size_t>(worker) % on.size()];
      const Status placed = place_thread(threads_.back().native_handle(), processor, settings.realtime_priority);
      if (!placed) placed_ = placed;
    }
  } catch (const std::system_error&) {
    // The system starts no more threads; those that started do the work.
  }
}

ThreadPool::~ThreadPool() {
  stopping_.store(true, std::memory_order_release);
  call_workers();
  threads_.clear();
}

void ThreadPool::call_workers() {
  if (follow_caller_) caller_processor_.store(sched_getcpu(), std::memory_order_relaxed);
  calls_.fetch_add(1, std::memory_order_seq_cst);
  // A thread that is counted as a sleeper after this load finds calls_ changed and does not sleep.
  if (sleepers_.load(std::memory_order_seq_cst) > 0) calls_.notify_all();
}

void ThreadPool::wake() {
  if (!threads_.empty()) call_workers();
}

void ThreadPool::run(WorkerFunction step) {
  if (threads_.empty() || busy_.exchange(true, std::memory_order_acquire)) {
    while (step(0)) {
    }
    return;
  }
  gate_.open(step, false);
  call_workers();
  while (step(0)) {
  }
  gate_.close();
  busy_.store(false, std::memory_order_release);
}

std::size_t ThreadPool::run_with(const Patience& patience, WorkerFunction step) {
  if (threads_.empty() || busy_.exchange(true, std::memory_order_acquire)) {
    while (step(0)) {
    }
    return 0;
  }
  gate_.open(step, true);
  call_workers();
  while (step(0)) {
  }
  const std::size_t abandoned = gate_.close(patience);
  busy_.store(false, std::memory_order_release);
  return abandoned;
}

void ThreadPool::work(int worker) {
  cpu_set_t allowed;
  const bool knows_processors = follow_caller_ && sched_getaffinity(0, sizeof(allowed), &allowed) == 0;
  int avoided_processor = -1;
  std::uint64_t last_run = 0;
  for (;;) {
    // Read before the gate is checked: a run that opens after the check has changed it, and wait() returns at once.
    const std::uint32_t calls = calls_.load(std::memory_order_seq_cst);
    bool worked = false;
    const bool up = spin_until(spin_, [&] {
      worked = gate_.take_part(worker, last_run);
      return worked || stopping_.load(std::memory_order_acquire);
    });
    if (up && !worked) return;
    if (worked) continue;
    // The caller may have moved to another processor. Following it here costs the caller nothing and is late by at most
    // a frame.
    const int processor = caller_processor_.load(std::memory_order_relaxed);
    if (knows_processors && processor != avoided_processor) {
      avoided_processor = processor;
      stay_away_from(allowed, processor);
    }
    sleepers_.fetch_add(1, std::memory_order_seq_cst);
    calls_.wait(calls, std::memory_order_seq_cst);
    sleepers_.fetch_sub(1, std::memory_order_relaxed);
  }
}

}  // namespace poise::parallel
