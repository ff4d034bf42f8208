// SPDX-License-Identifier: MIT
#include "parallel/thread_affinity.h"

#include <fmt/format.h>
#include <sched.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <thread>

#include "parallel/executor.h"

namespace poise::parallel {
namespace {

constexpr int kLowestPriority = 1, kHighestPriority = 99;  // of SCHED_FIFO under Linux (sched(7))

Status check_processor(int processor) {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  const bool known = processor >= 0 && processor < CPU_SETSIZE && sched_getaffinity(0, sizeof(allowed), &allowed) == 0;
  if (known && CPU_ISSET(static_cast<std::size_t>(processor), &allowed)) return Done{};
  return bad_input(fmt::format("processors = {}, must be processors that this process may use (there are {} of them)",
                               processor, available_threads()));
}

Status refused_priority(int priority, int failure) {
  return bad_input(fmt::format(
      "realtime_priority = {}, must be granted by the system: {} (CAP_SYS_NICE, or a limit `ulimit -r` of at least {})",
      priority, std::strerror(failure), priority));
}

// Tries the priority on a temporary thread, so that nothing else changes.
Status try_priority(int priority) {
  Status tried = Done{};
  try {
    std::jthread probe([&] { tried = place_thread(pthread_self(), -1, priority); });
  } catch (const std::system_error&) {
    return Done{};  // no thread can be started, so there will be no worker
  }
  return tried;
}

Status check_host(const ExecutorSettings& settings) {
  constexpr int kMostThreads = 256;
  if (settings.kind != ExecutorKind::Host) {
    return settings.host ? Status(bad_input("host_executor: must be left out but with the executor host")) : Done{};
  }
  if (!settings.host) return bad_input("host_executor = null, must be given with the executor host");
  const int offered = settings.host->concurrency();
  if (offered >= 1 && offered <= kMostThreads) return Done{};
  return bad_input(fmt::format("host_executor: concurrency() = {}, must be in [1, {}]", offered, kMostThreads));
}

}  // namespace

Status place_thread(pthread_t thread, int processor, int realtime_priority) {
  if (processor >= CPU_SETSIZE) return check_processor(processor);
  if (processor >= 0) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(processor), &one);
    const int failure = pthread_setaffinity_np(thread, sizeof(one), &one);
    if (failure != 0)
      return bad_input(fmt::format("processors = {}, must be processors that this process may use: {}", processor,
                                   std::strerror(failure)));
  }
  if (realtime_priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = realtime_priority;
    const int failure = pthread_setschedparam(thread, SCHED_FIFO, &parameters);
    if (failure != 0) return refused_priority(realtime_priority, failure);
  }
  return Done{};
}

Status place_this_thread(int processor, int realtime_priority) {
  return place_thread(pthread_self(), processor, realtime_priority);
}

Status check_executor(const ExecutorSettings& settings) {
  if (settings.spin.count() < 0 || settings.spin > kMaxSpin) {
    return bad_input(fmt::format("spin = {} ns, must be in [0, {}]", settings.spin.count(), kMaxSpin.count()));
  }
  const int priority = settings.realtime_priority;
  if (priority != 0 && (priority < kLowestPriority || priority > kHighestPriority)) {
    return bad_input(
        fmt::format("realtime_priority = {}, must be 0 or in [{}, {}]", priority, kLowestPriority, kHighestPriority));
  }
  const Status host = check_host(settings);
  if (!host) return host;
  const bool of_host = settings.kind == ExecutorKind::Host;
  if ((of_host || settings.kind == ExecutorKind::Tbb) && (priority != 0 || !settings.processors.empty())) {
    return bad_input(
        fmt::format("{}: must be left out with the executor {}, whose threads belong to the {}; the "
                    "executor threads can",
                    priority != 0 ? "realtime_priority" : "processors", of_host ? "host" : "tbb",
                    of_host ? "host" : "whole process"));
  }
  for (const int processor : settings.processors) {
    const Status allowed = check_processor(processor);
    if (!allowed) return allowed;
  }
  return priority != 0 ? try_priority(priority) : Done{};
}

}  // namespace poise::parallel
