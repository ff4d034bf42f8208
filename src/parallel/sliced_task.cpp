// SPDX-License-Identifier: MIT
#include "parallel/sliced_task.h"

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <utility>

#include "parallel/cpu_clock.h"

namespace poise::parallel {
namespace {

using namespace std::chrono_literals;

// How much earlier than asked a slice stops: what items and the parts between loops make it too long by in all but the
// share of slices that may be late. That is followed step by step (stochastic approximation, Robbins and Monro 1951),
// so a time in which the system took the processor says no more than any other. Chosen.
constexpr std::chrono::nanoseconds kLeastLead = 100us, kMore = 100us;
// However often it does, three quarters of a slice are left. Chosen.
constexpr int kMostOfSlice = 4;

// Half a millisecond where one in a hundred may be late, and as much again for each further tenth. Chosen.
std::chrono::nanoseconds first_lead(double late) {
  std::chrono::nanoseconds lead = 500us;
  for (double share = 0.01; share > 1.5 * late; share /= 10) lead += 500us;
  return lead;
}

}  // namespace

void SlicedTask::Loops::run(WorkerFunction step) {
  // A loop within an item, or of another thread: part of that item.
  if (inside_ || std::this_thread::get_id() != task_.thread_->get_id()) {
    workers_.run(step);
    return;
  }
  inside_ = true;
  bool all = false;
  while (!all) {
    workers_.run([&](int worker) {
      const bool owner = worker == 0;
      if (!(owner && task_.new_slice_) && task_.over()) return false;
      const bool more = step(worker);
      if (owner) {
        if (more) task_.new_slice_ = false;
        all = !more;
      }
      return more;
    });
    if (!all) task_.stand_still();
  }
  inside_ = false;
}

void SlicedTask::Loops::stop_point() {
  if (inside_ || std::this_thread::get_id() != task_.thread_->get_id()) return;
  if (!std::exchange(task_.new_slice_, false) && task_.over()) task_.stand_still();
}

SlicedTask::~SlicedTask() {
  if (unfinished_) take_turn(Clock::time_point::max());
  if (!thread_) return;
  {
    const std::lock_guard<std::mutex> hold(mutex_);
    stopping_ = true;
  }
  turn_.notify_all();
}

bool SlicedTask::begin(std::function<void()> function) {
  if (!thread_) {
    try {
      // It waits for its first turn, so thread_ is set when it runs the function.
      thread_.emplace([this] { live(); });
    } catch (const std::system_error&) {
      return false;
    }
  }
  function_ = std::move(function);
  unfinished_ = true;
  stood_still_ = {};
  return true;
}

bool SlicedTask::run_until(Clock::time_point until, double late) {
  const bool whole = until == Clock::time_point::max();
  const Clock::duration lead = lead_.value_or(first_lead(late));
  const Clock::duration most = whole ? Clock::duration{0} : (until - Clock::now()) / kMostOfSlice;
  take_turn(until - std::min(lead, most));
  if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
  if (unfinished_) {
    const std::chrono::nanoseconds less(static_cast<std::int64_t>(late * static_cast<double>(kMore.count())));
    lead_ = Clock::now() > until ? std::max(lead, std::min<Clock::duration>(lead + kMore, most))
                                 : std::max<Clock::duration>(lead - less, kLeastLead);
  }
  return !unfinished_;
}

void SlicedTask::take_turn(Clock::time_point stop) {
  std::unique_lock<std::mutex> hold(mutex_);
  set_stop(stop);
  running_ = true;
  turn_.notify_all();
  turn_.wait(hold, [&] { return !running_; });
}

void SlicedTask::stand_still() {
  const Clock::time_point begin = Clock::now();
  slice_cpu_ = thread_cpu_time() - slice_cpu_;
  {
    std::unique_lock<std::mutex> hold(mutex_);
    running_ = false;
    turn_.notify_all();
    turn_.wait(hold, [&] { return running_; });
  }
  slice_cpu_ = thread_cpu_time();
  new_slice_ = true;
  stood_still_ += Clock::now() - begin;
}

void SlicedTask::live() {
  std::unique_lock<std::mutex> hold(mutex_);
  for (;;) {
    turn_.wait(hold, [&] { return running_ || stopping_; });
    if (stopping_) return;
    hold.unlock();
    slice_cpu_ = thread_cpu_time();
    new_slice_ = true;
    try {
      function_();
    } catch (...) {
      thrown_ = std::current_exception();
    }
    slice_cpu_ = thread_cpu_time() - slice_cpu_;
    hold.lock();
    unfinished_ = false;
    running_ = false;
    turn_.notify_all();
  }
}

}  // namespace poise::parallel
