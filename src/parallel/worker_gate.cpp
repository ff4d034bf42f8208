// SPDX-License-Identifier: MIT
#include "parallel/worker_gate.h"

#include <pthread.h>

#include <algorithm>
#include <thread>

namespace poise::parallel {
namespace {

// The CPU clock of the calling thread, which other threads may read too.
clockid_t clock_of_this_thread(clockid_t none) {
  clockid_t clock{};
  return ::pthread_getcpuclockid(::pthread_self(), &clock) == 0 ? clock : none;
}

}  // namespace

WorkerGate::WorkerGate(int workers, std::chrono::nanoseconds spin)
    : workers_(workers), spin_(spin), hands_(new Worker[static_cast<std::size_t>(workers)]) {}

void WorkerGate::open(WorkerFunction step, bool may_abandon) {
  if (may_abandon) {
    settle();
    lasting_step_ = step;
  } else {
    step_ = step;
  }
  const std::uint64_t run = (gate_.load(std::memory_order_relaxed) & ~(kOneRun - 1)) + kOneRun;
  gate_.store(run | kOpen | (may_abandon ? kMayAbandon : 0), std::memory_order_seq_cst);
}

void WorkerGate::wait_while(Worker& worker, bool abandoned_too) {
  std::uint32_t hand = kEmpty;
  const auto done = [&] {
    hand = worker.hand.load(std::memory_order_seq_cst);
    return hand == kEmpty || (hand == kAbandoned && !abandoned_too);
  };
  if (spin_until(spin_, done)) return;
  const auto begun = std::chrono::steady_clock::now();
  const std::chrono::nanoseconds cpu_before = cpu_time_of(worker);
  caller_sleeps_.store(true, std::memory_order_seq_cst);
  while (!done()) worker.hand.wait(hand, std::memory_order_seq_cst);
  caller_sleeps_.store(false, std::memory_order_relaxed);
  waits_.add(std::chrono::steady_clock::now() - begun, cpu_time_of(worker) - cpu_before);
}

// 0 if it cannot be told: then what is waited for counts as held up.
std::chrono::nanoseconds WorkerGate::cpu_time_of(const Worker& worker) {
  const clockid_t clock = worker.cpu_clock.load(std::memory_order_relaxed);
  timespec time{};
  if (clock == kNoClock || ::clock_gettime(clock, &time) != 0) return std::chrono::nanoseconds(0);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

void WorkerGate::close() {
  gate_.fetch_and(~kOpen, std::memory_order_seq_cst);
  for (int w = 1; w < workers_; ++w) wait_while(hands_[static_cast<std::size_t>(w)], false);
}

std::size_t WorkerGate::close(const Patience& patience) {
  gate_.fetch_and(~kOpen, std::memory_order_seq_cst);
  const auto now = std::chrono::steady_clock::now();
  const auto end = std::max(patience.until, now + patience.at_least);
  std::size_t abandoned = 0;
  for (int w = 1; w < workers_; ++w) {
    Worker& worker = hands_[static_cast<std::size_t>(w)];
    // Once seen, for good: the worker may set its word again, to look at the run, but finds it closed.
    bool left = false;
    const auto has_left = [&] {
      left = left || worker.hand.load(std::memory_order_seq_cst) == kEmpty;
      return left;
    };
    const auto most =
        std::max(std::chrono::nanoseconds(0), std::chrono::nanoseconds(end - std::chrono::steady_clock::now()));
    if (spin_until(std::min(most, spin_), has_left)) continue;
    // Yields the processor to threads that need it, possibly to the awaited worker itself.
    while (!has_left() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    if (left) continue;
    std::uint32_t hand = kWorking;
    if (worker.hand.compare_exchange_strong(hand, kAbandoned, std::memory_order_acq_rel)) {
      ++abandoned;
    } else {
      wait_while(worker, false);
    }
  }
  return abandoned;
}

void WorkerGate::settle() {
  for (int w = 1; w < workers_; ++w) wait_while(hands_[static_cast<std::size_t>(w)], true);
}

bool WorkerGate::commit(int worker) {
  if (worker == 0) return true;
  std::uint32_t hand = kWorking;
  std::atomic<std::uint32_t>& word = hands_[static_cast<std::size_t>(worker)].hand;
  return word.compare_exchange_strong(hand, kCommitted, std::memory_order_acq_rel) || hand == kCommitted;
}

void WorkerGate::leave(Worker& worker) {
  worker.hand.exchange(kEmpty, std::memory_order_seq_cst);
  if (caller_sleeps_.load(std::memory_order_seq_cst)) worker.hand.notify_one();
}

WorkerGate::GateState WorkerGate::look(const Worker& worker, std::uint64_t last_run, std::uint64_t& gate) const {
  gate = gate_.load(std::memory_order_seq_cst);
  // A worker that was suspended here may have been abandoned in the previous run, and now sees the next run, which does
  // not wait for it.
  if (worker.hand.load(std::memory_order_seq_cst) == kAbandoned) return GateState::Abandoned;
  return has_work(gate, last_run) ? GateState::Open : GateState::Nothing;
}

bool WorkerGate::take_part(int number, std::uint64_t& last_run) {
  if (!has_work(gate_.load(std::memory_order_relaxed), last_run)) return false;
  thread_local const clockid_t own_clock = clock_of_this_thread(kNoClock);
  Worker& worker = hands_[static_cast<std::size_t>(number)];
  if (worker.cpu_clock.load(std::memory_order_relaxed) != own_clock)
    worker.cpu_clock.store(own_clock, std::memory_order_relaxed);
  bool worked = false;
  for (bool more = true; more;) {
    raise(worker);
    std::uint64_t gate = 0;
    const GateState state = look(worker, last_run, gate);
    if (state == GateState::Open) {
      worked = true;
      more = ((gate & kMayAbandon) != 0 ? lasting_step_ : step_)(number);
      if (!more) last_run = gate / kOneRun;
    }
    leave(worker);
    if (state == GateState::Nothing) break;
  }
  return worked;
}

}  // namespace poise::parallel
