// SPDX-License-Identifier: MIT
#include "parallel/busy_thread.h"

#include <sched.h>

#include <span>
#include <stop_token>

namespace poise::parallel {
namespace {

bool stay_on(std::span<const int> processors) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int processor : processors) {
    if (processor >= 0 && processor < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(processor), &set);
  }
  return CPU_COUNT(&set) > 0 && sched_setaffinity(0, sizeof(set), &set) == 0;
}

}  // namespace

BusyThread::BusyThread(int processor)
    : thread_([processor](const std::stop_token& stop) {
        if (processor >= 0) stay_on(std::span(&processor, 1));
        while (!stop.stop_requested()) {
        }
      }) {}

std::vector<int> allowed_processors() {
  std::vector<int> processors;
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return processors;
  for (int i = 0; i < CPU_SETSIZE; ++i) {
    if (CPU_ISSET(static_cast<std::size_t>(i), &allowed)) processors.push_back(i);
  }
  return processors;
}

OnProcessor::OnProcessor(int processor) : before_(allowed_processors()), settled_(stay_on(std::span(&processor, 1))) {}

OnProcessor::~OnProcessor() {
  if (settled_) stay_on(before_);
}

}  // namespace poise::parallel
