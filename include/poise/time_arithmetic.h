// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

/// Saturating sums and differences of times, where those of std::chrono overflow. Any thread.
namespace poise {

using SteadyClock = std::chrono::steady_clock;
using Nanoseconds = std::chrono::nanoseconds;

/// One year: the farthest deadline from now, before or after, and the longest work of the host that a step uses. Sums
/// of a few such times fit into 64 bits, so code behind the World's interface need not check for overflow.
inline constexpr Nanoseconds kFarthestTime = std::chrono::hours(24 * 365);

/// a + b; the smallest or largest duration if that is out of range.
[[nodiscard]] constexpr Nanoseconds saturating_add(Nanoseconds a, Nanoseconds b) {
  if (b.count() > 0 && a > Nanoseconds::max() - b) return Nanoseconds::max();
  if (b.count() < 0 && a < Nanoseconds::min() - b) return Nanoseconds::min();
  return a + b;
}

/// time + by; the clock's first or last time if that is out of range.
[[nodiscard]] constexpr SteadyClock::time_point saturating_add(SteadyClock::time_point time, Nanoseconds by) {
  return SteadyClock::time_point(saturating_add(time.time_since_epoch(), by));
}

/// later - earlier; the smallest or largest duration if that is out of range.
[[nodiscard]] constexpr Nanoseconds saturating_subtract(SteadyClock::time_point later,
                                                        SteadyClock::time_point earlier) {
  const Nanoseconds a = later.time_since_epoch();
  const Nanoseconds b = earlier.time_since_epoch();
  if (b.count() < 0 && a > Nanoseconds::max() + b) return Nanoseconds::max();
  if (b.count() > 0 && a < Nanoseconds::min() + b) return Nanoseconds::min();
  return a - b;
}

/// The time nearest to `time` that is at most kFarthestTime from `now`.
[[nodiscard]] constexpr SteadyClock::time_point within_reach(SteadyClock::time_point time,
                                                             SteadyClock::time_point now) {
  return std::clamp(time, saturating_add(now, -kFarthestTime), saturating_add(now, kFarthestTime));
}

}  // namespace poise
