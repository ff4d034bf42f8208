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
    ++number_;
    std::uint64_t passed = 0;
    while (now >= std::min(at(number_ + 1), deadline())) {
      ++number_;
      ++passed;
    }
    return passed;
  }

 private:
  [[nodiscard]] SteadyClock::time_point at(std::uint64_t number) const {
    return begin_ + Nanoseconds(static_cast<std::int64_t>(static_cast<double>(number) * dt_s_ * 1e9));
  }
  SteadyClock::time_point begin_;
  double dt_s_;
  Nanoseconds deadline_;
  std::uint64_t number_ = 0;
};

}  // namespace poise::simulation
