// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "poise/step.h"

namespace poise::app {

/// One line on a terminal that is written over again, ten times a second at most. Silent where stderr is no terminal.
class Progress {
 public:
  explicit Progress(bool wanted);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void say(std::string_view text);
  /// What is being done, how much of it, and how long the rest will take at this pace. `share` is from 0 to 1.
  void share(std::string_view text, double share);
  void frame(std::uint64_t done, std::uint64_t total, std::uint64_t misses, std::size_t bodies);
  /// Clears the line.
  void end();

 private:
  bool on_ = false;
  bool shown_ = false;
  SteadyClock::time_point begin_{};
  SteadyClock::time_point last_{};
};

}  // namespace poise::app
