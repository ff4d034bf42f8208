// SPDX-License-Identifier: MIT
#include "parallel/thread_pool.h"

#include <sched.h>

#include <chrono>
#include <system_error>

namespace poise::parallel {
namespace {

constexpr std::uint32_t kInsideMask = 0xffU;
constexpr std::uint32_t kOpen = 0x100U;
constexpr std::uint32_t kOneRun = 0x200U;

// Chosen: longer than the serial stretches between two loops of a frame, and about what it costs to wake a sleeper (26
// us at the median, 63 us at p99). Without a bound, spinning on a loaded machine made frames 1000 times longer.
constexpr std::chrono::microseconds kSpin{50};

void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Calls done() until it is true or kSpin has passed; says whether it became true.
template <class Done>
bool spin_until(Done&& done) {
  if (done()) return true;
  const auto end = std::chrono::steady_clock::now() + kSpin;
  do {
    for (int i = 0; i < 16; ++i) {
      if (done()) return true;
      relax();
    }
  } while (std::chrono::steady_clock::now() < end);
  return false;
}

/// Lets this thread run on all of `allowed` but `processor`. Where that leaves nothing the kernel refuses, and all
/// stays.
void stay_away_from(const cpu_set_t& allowed, int processor) {
  cpu_set_t others = allowed;
  if (processor >= 0 && processor < CPU_SETSIZE) CPU_CLR(static_cast<std::size_t>(processor), &others);
  sched_setaffinity(0, sizeof(others), &others);
}

}  // namespace

ThreadPool::ThreadPool(int threads) {
  threads_.reserve(static_cast<std::size_t>(threads - 1));
  try {
    for (int worker = 1; worker < threads; ++worker) {
      threads_.emplace_back([this, worker] { work(worker); });
    }
  } catch (const std::system_error&) {
    // The system gives no more threads; those that started do the work.
  }
}

ThreadPool::~ThreadPool() {
  stopping_.store(true, std::memory_order_release);
  call_workers();
  threads_.clear();
}

void ThreadPool::call_workers() {
  caller_processor_.store(sched_getcpu(), std::memory_order_relaxed);
  calls_.fetch_add(1, std::memory_order_seq_cst);
  calls_.notify_all();
}

void ThreadPool::wake() {
  if (!threads_.empty()) call_workers();
}

void ThreadPool::run(WorkerFunction loop) {
  if (threads_.empty() || busy_.exchange(true, std::memory_order_acquire)) {
    loop(0);
    return;
  }
  loop_ = &loop;
  const std::uint32_t next_run = (gate_.load(std::memory_order_relaxed) & ~(kOpen | kInsideMask)) + kOneRun;
  gate_.store(next_run | kOpen, std::memory_order_release);
  call_workers();

  loop(0);

  std::uint32_t gate = gate_.fetch_and(~kOpen, std::memory_order_acq_rel) & ~kOpen;
  const auto all_left = [&] {
    gate = gate_.load(std::memory_order_acquire);
    return (gate & kInsideMask) == 0;
  };
  if (!spin_until(all_left)) {
    while (!all_left()) gate_.wait(gate, std::memory_order_acquire);
  }
  busy_.store(false, std::memory_order_release);
}

bool ThreadPool::take_part(int worker, std::uint32_t& last_run) {
  std::uint32_t gate = gate_.load(std::memory_order_relaxed);
  for (;;) {
    const std::uint32_t this_run = gate & ~(kOpen | kInsideMask);
    if ((gate & kOpen) == 0 || this_run == last_run) return false;
    if (gate_.compare_exchange_weak(gate, gate + 1, std::memory_order_acq_rel, std::memory_order_relaxed)) {
      last_run = this_run;
      break;
    }
  }
  (*loop_)(worker);
  // The caller may sleep only on a closed gate, so only then does the last one out have someone to tell.
  const std::uint32_t before = gate_.fetch_sub(1, std::memory_order_seq_cst);
  if ((before & kOpen) == 0 && (before & kInsideMask) == 1) gate_.notify_one();
  return true;
}

void ThreadPool::work(int worker) {
  cpu_set_t allowed;
  const bool knows_processors = sched_getaffinity(0, sizeof(allowed), &allowed) == 0;
  int avoided_processor = -1;
  std::uint32_t last_run = 0;  // no run has number 0 until the count wraps, and then a worker stays out of that one
  for (;;) {
    // Read before the gate is looked at: a run that opens after the look has changed it, and wait() returns at once.
    const std::uint32_t calls = calls_.load(std::memory_order_acquire);
    bool worked = false;
    const bool up = spin_until([&] {
      worked = take_part(worker, last_run);
      return worked || stopping_.load(std::memory_order_acquire);
    });
    if (up && !worked) return;
    if (worked) continue;
    // The caller may have moved. To follow it costs the caller nothing here, and a frame at most comes in between.
    const int processor = caller_processor_.load(std::memory_order_relaxed);
    if (knows_processors && processor != avoided_processor) {
      avoided_processor = processor;
      stay_away_from(allowed, processor);
    }
    calls_.wait(calls, std::memory_order_acquire);
  }
}

}  // namespace poise::parallel
