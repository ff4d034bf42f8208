// SPDX-License-Identifier: MIT
#pragma once

#include <sched.h>
#include <sys/resource.h>

#include <csignal>
#include <functional>
#include <thread>
#include <utility>

namespace poise::parallel {

/// Runs a function on a thread of its own, which gives way to all others as that of BackgroundQueue does and is not
/// told of signals. The function must end by itself when it is asked to, and must not throw.
class BackgroundThread {
 public:
  explicit BackgroundThread(std::function<void()> work) : thread_([work = std::move(work)] { run(work); }) {}
  /// Waits for the function.
  ~BackgroundThread() = default;
  BackgroundThread(const BackgroundThread&) = delete;
  BackgroundThread& operator=(const BackgroundThread&) = delete;

 private:
  static void run(const std::function<void()>& work) {
    constexpr int kLowPriority = 10;
    const sched_param usual{};
    ::sched_setscheduler(0, SCHED_OTHER, &usual);
    ::setpriority(PRIO_PROCESS, 0, kLowPriority);
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, nullptr);
    work();
  }

  std::jthread thread_;
};

}  // namespace poise::parallel
