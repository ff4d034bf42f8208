// SPDX-License-Identifier: MIT
#pragma once

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "poise/result.h"

namespace poise::parallel {

/// Hands values to a function that runs on one thread of its own, in order. The thread gives way to all others: it is
/// not real-time whatever its maker is, and has a low priority. What the function refuses ends its work: it gets no
/// value after that. Invariant: at most `capacity` values wait.
///
/// One thread hands values in; it makes and destroys this.
template <class T>
class BackgroundQueue {
 public:
  /// `capacity` >= 1. `work` must not throw.
  BackgroundQueue(std::size_t capacity, std::function<Status(T&)> work)
      : capacity_(std::max<std::size_t>(capacity, 1)), work_(std::move(work)), thread_([this] { run(); }) {}
  /// As close().
  ~BackgroundQueue() { close(); }
  BackgroundQueue(const BackgroundQueue&) = delete;
  BackgroundQueue& operator=(const BackgroundQueue&) = delete;

  /// Whether a value can be pushed without waiting. If so, this stays true until the next push.
  [[nodiscard]] bool has_room() const {
    const std::lock_guard lock(mutex_);
    return waiting_.size() < capacity_;
  }
  /// What the function refused, if it did so by now.
  [[nodiscard]] Status failure() const {
    const std::lock_guard lock(mutex_);
    return failure_;
  }
  /// A value whose memory can be used again, as the function left it; T{} where there is none.
  [[nodiscard]] T fresh() {
    const std::lock_guard lock(mutex_);
    if (used_.empty()) return T{};
    T value = std::move(used_.back());
    used_.pop_back();
    return value;
  }
  /// Waits until there is room. After close() the value is ignored.
  void push(T value) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return waiting_.size() < capacity_ || closed_; });
      if (closed_) return;
      waiting_.push_back(std::move(value));
    }
    changed_.notify_all();
  }
  /// Waits until the function has had all values, and ends the thread. Any number of times.
  void close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run() {
    constexpr int kLowPriority = 10;
    const sched_param usual{};
    ::sched_setscheduler(0, SCHED_OTHER, &usual);
    // Of this thread alone, on Linux. Where it is refused the thread is as all others.
    ::setpriority(PRIO_PROCESS, 0, kLowPriority);
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return !waiting_.empty() || closed_; });
      if (waiting_.empty()) return;
      T value = std::move(waiting_.front());
      waiting_.pop_front();
      const bool working = static_cast<bool>(failure_);
      lock.unlock();
      changed_.notify_all();
      Status done = working ? work_(value) : Status(Done{});
      lock.lock();
      if (!done) failure_ = std::move(done);
      if (used_.size() < capacity_) used_.push_back(std::move(value));
    }
  }

  const std::size_t capacity_;
  const std::function<Status(T&)> work_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<T> waiting_;
  std::vector<T> used_;
  Status failure_ = Done{};
  bool closed_ = false;
  std::thread thread_;  // the last member: it uses the others from its start
};

}  // namespace poise::parallel
