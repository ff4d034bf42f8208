// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

/// Sums and differences of times that stop at the ends of their range, where chrono's own overflow. Any thread.
namespace poise {

using SteadyClock = std::chrono::steady_clock;
using Nanoseconds = std::chrono::nanoseconds;

/// A step takes a deadline as at most so far from now, either way, and work of the host as at most so long: a year.
/// Sums of a few such times stay within 64 bits, so no code behind the World's interface has to check.
inline constexpr Nanoseconds kFarthestTime = std::chrono::hours(24 * 365);

/// a + b; the largest or smallest duration where that is out of range.
[[nodiscard]] constexpr Nanoseconds saturating_add(Nanoseconds a, Nanoseconds b) {
  if (b.count() > 0 && a > Nanoseconds::max() - b) return Nanoseconds::max();
  if (b.count() < 0 && a < Nanoseconds::min() - b) return Nanoseconds::min();
  return a + b;
}

/// A time of the clock moved by a duration; the clock's last or first time where that is out of range.
[[nodiscard]] constexpr SteadyClock::time_point saturating_add(SteadyClock::time_point time, Nanoseconds by) {
  return SteadyClock::time_point(saturating_add(time.time_since_epoch(), by));
}

/// later - earlier; the largest or smallest duration where that is out of range.
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
