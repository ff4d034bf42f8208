// SPDX-License-Identifier: MIT
#include "parallel/counting_executor.h"

#include <algorithm>
#include <ctime>
#include <utility>

#include "poise_assert.h"

namespace poise::parallel {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

CountedAt thread_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return {std::chrono::seconds(time.tv_sec) + nanoseconds(time.tv_nsec), steady_clock::now()};
}

// The share of serial work from `from` to `to` that lies between two borders.
nanoseconds part_between(const CountedAt& from, const CountedAt& to, steady_clock::time_point begin,
                         steady_clock::time_point end) {
  const nanoseconds common = std::min(to.wall, end) - std::max(from.wall, begin);
  const nanoseconds whole = to.wall - from.wall;
  if (common <= nanoseconds{0} || whole <= nanoseconds{0}) return nanoseconds{0};
  const double share = static_cast<double>(common.count()) / static_cast<double>(whole.count());
  return nanoseconds(static_cast<nanoseconds::rep>(share * static_cast<double>((to.work - from.work).count())));
}

}  // namespace

CountingExecutor::CountingExecutor(int cores, Clock clock)
    : clock_(clock ? std::move(clock) : Clock(thread_time)), free_(static_cast<std::size_t>(std::max(cores, 2))) {}

void CountingExecutor::run(WorkerFunction step) {
  if (inside_) {
    while (step(0)) {
    }
    return;
  }
  inside_ = true;
  std::fill(free_.begin(), free_.end(), nanoseconds{0});
  CountedLoop loop;
  loop.begin = loop.end = clock_();
  while (step(0)) {
    const CountedAt now = clock_();
    const nanoseconds chunk = now.work - loop.end.work;
    loop.end = now;
    loop.work += chunk;
    loop.longest = std::max(loop.longest, chunk);
    ++loop.chunks;
    nanoseconds& first_free = *std::min_element(free_.begin(), free_.end());
    first_free += chunk;
  }
  loop.on_cores = *std::max_element(free_.begin(), free_.end());
  loops_.push_back(loop);
  inside_ = false;
}

std::size_t CountingExecutor::run_with(const Patience& /*patience*/, WorkerFunction step) {
  run(step);
  return 0;
}

std::vector<CountedWork> count_stretches(std::span<const CountedLoop> loops, const CountedAt& start,
                                         const CountedAt& end, std::span<const steady_clock::time_point> borders) {
  POISE_ASSERT(borders.size() >= 2);
  std::vector<CountedWork> stretches(borders.size() - 1);
  const auto add_serial = [&](const CountedAt& from, const CountedAt& to) {
    for (std::size_t k = 0; k < stretches.size(); ++k)
      stretches[k].serial += part_between(from, to, borders[k], borders[k + 1]);
  };
  CountedAt before = start;
  for (const CountedLoop& loop : loops) {
    add_serial(before, loop.begin);
    before = loop.end;
    const auto behind = std::upper_bound(borders.begin() + 1, borders.end() - 1, loop.begin.wall);
    CountedWork& stretch = stretches[static_cast<std::size_t>(behind - borders.begin()) - 1];
    stretch.work += loop.work;
    stretch.span += loop.longest;
    stretch.on_cores += loop.on_cores;
    ++stretch.loops;
  }
  add_serial(before, end);
  for (CountedWork& stretch : stretches) {
    stretch.work += stretch.serial;
    stretch.span += stretch.serial;
    stretch.on_cores += stretch.serial;
  }
  return stretches;
}

}  // namespace poise::parallel
