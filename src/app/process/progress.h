// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "poise/step.h"

namespace poise::app {

/// What is being done, how much of it, and how long the rest will take at this pace, on stderr. On a terminal: one line
/// as wide as the terminal at most, written over again, ten times a second at most. Elsewhere: a line each 10 % or 10 s
/// from the second second on, so that a log stays short. Nothing where it is not wanted.
class Progress {
 public:
  explicit Progress(bool wanted);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// A new step, of which no share is known yet.
  void say(std::string_view text);
  /// `share` is from 0 to 1.
  void share(std::string_view text, double share);
  void frame(std::uint64_t done, std::uint64_t total, std::uint64_t misses, std::size_t bodies);
  /// Clears the line.
  void end();

 private:
  [[nodiscard]] bool due(SteadyClock::time_point now, double share) const;
  void show(SteadyClock::time_point now, double share, std::string_view text);

  bool on_ = false;
  bool terminal_ = false;
  bool shown_ = false;
  int tenth_ = 0;  ///< no terminal: of the share that was told last
  SteadyClock::time_point begin_{};
  SteadyClock::time_point last_{};
};

/// `12 %, 3 min 20 s left: TEXT`; without the time where `spent_s` and the share say little of the rest.
std::string progress_text(std::string_view text, double share, double spent_s);

/// The first columns of a text, the last of them `~` where something is left out.
std::string fitted_to(std::string_view text, std::size_t columns);

}  // namespace poise::app
