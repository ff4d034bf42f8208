// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>

namespace poise::solver {

/// Whether the iterations of a system take less time on all threads or on the calling one alone. Each colour of an
/// iteration is a loop of its own, and from one colour to the next bodies go from the cache of one processor to that of
/// another. How long that takes differs from machine to machine, and so does the size of a system from which on threads
/// pay (docs/deadlines.md, "Small scenes on many threads"). So it is measured: now and then a few iterations
/// are made one way and as many the other way. What they compute is the same.
class IterationThreads {
 public:
  /// Steps with a choice from one measurement to the next. Chosen: a measurement costs three iterations that go the
  /// slower way, of some thousand in so many steps.
  static constexpr std::uint32_t kSteps = 32;
  /// Iterations of each way; the first is not timed, since it finds the bodies in the caches of the other way.
  static constexpr std::uint32_t kTrials = 3;
  /// Alone is quicker only if it saves as much: the other threads fall asleep meanwhile and have to be woken. Chosen.
  static constexpr int kTenthsOfAll = 9;

  /// Before the iterations of a step. `choice`: there are several threads, and so many iterations that measuring is a
  /// small part of them; otherwise none is alone.
  void begin(bool choice) {
    choice_ = choice;
    if (!choice || trial_ < 2 * kTrials) return;
    if (++steps_ >= kSteps) {
      steps_ = 0;
      trial_ = 0;
    }
  }
  /// Is the next iteration to be made on the calling thread alone?
  [[nodiscard]] bool alone() const {
    if (!choice_) return false;
    return measures() ? trial_ < kTrials : alone_;
  }
  /// Is it one of a measurement? Then its time is noted, once it is made.
  [[nodiscard]] bool measures() const { return choice_ && trial_ < 2 * kTrials; }
  void note(std::chrono::nanoseconds took) {
    constexpr auto kNever = std::chrono::nanoseconds::max();
    std::chrono::nanoseconds& least = least_[trial_ / kTrials];
    least = trial_ % kTrials == 0 ? kNever : std::min(least, took);
    if (++trial_ == 2 * kTrials) alone_ = 10 * least_[0] < kTenthsOfAll * least_[1];
  }

 private:
  bool choice_ = false, alone_ = false;
  std::uint32_t steps_ = 0;
  std::uint32_t trial_ = 0;                          // of a measurement; 2 kTrials: none goes on
  std::array<std::chrono::nanoseconds, 2> least_{};  // alone, and by all threads
};

}  // namespace poise::solver
