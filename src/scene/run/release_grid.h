// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

#include "poise/step.h"

namespace poise::simulation {

/// Release times of a paced run: number k is at begin + k dt, with k exact, so rounding does not drift. A late frame
/// does not move the grid: the next frame has the rest of its period, so lateness does not accumulate beyond that. The
/// caller passes the time; there is no clock here.
class ReleaseGrid {
 public:
  /// `dt_s` > 0; a frame's deadline is relative to its release.
  ReleaseGrid(SteadyClock::time_point begin, double dt_s, Nanoseconds deadline)
      : begin_(begin), dt_s_(dt_s), deadline_(deadline) {}

  [[nodiscard]] SteadyClock::time_point release() const { return at(number_); }
  [[nodiscard]] SteadyClock::time_point deadline() const { return release() + deadline_; }
  /// Moves the grid by the duration of work outside of frames, e.g. a reference.
  void postpone(Nanoseconds time) { begin_ += time; }
  /// Advances to the next release that can still be met at `now`; returns how many were skipped.
  std::uint64_t advance(SteadyClock::time_point now) {
    const std::uint64_t next = number_ + 1;
    // With a step of 1e-12 s a million pass within a microsecond: they are not gone through one by one. The one that is
    // looked for is from `first` to `last`.
    std::uint64_t first = next;
    std::uint64_t last = next;
    for (std::uint64_t step = 1; last < kMostReleases && !can_be_met(last, now); step *= 2) {
      first = last + 1;
      last += step;
    }
    while (first < last) {
      const std::uint64_t middle = first + (last - first) / 2;
      if (can_be_met(middle, now)) {
        last = middle;
      } else {
        first = middle + 1;
      }
    }
    number_ = last;
    return last - next;
  }

 private:
  // Beyond it releases are not counted: steps of 1e-18 s and less.
  static constexpr std::uint64_t kMostReleases = std::uint64_t{1} << 60U;

  [[nodiscard]] bool can_be_met(std::uint64_t number, SteadyClock::time_point now) const {
    return now < std::min(at(number + 1), at(number) + deadline_);
  }
  [[nodiscard]] SteadyClock::time_point at(std::uint64_t number) const {
    return begin_ + Nanoseconds(static_cast<std::int64_t>(static_cast<double>(number) * dt_s_ * 1e9));
  }
  SteadyClock::time_point begin_;
  double dt_s_;
  Nanoseconds deadline_;
  std::uint64_t number_ = 0;
};

}  // namespace poise::simulation
