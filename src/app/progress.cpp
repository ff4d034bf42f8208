// SPDX-License-Identifier: MIT
#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace poise::app {

Progress::Progress(bool wanted) : on_(wanted && ::isatty(STDERR_FILENO) == 1), begin_(SteadyClock::now()) {}

Progress::~Progress() { end(); }

void Progress::say(std::string_view text) {
  if (!on_) return;
  fmt::print(stderr, "\r\x1b[K{}", text);
  std::fflush(stderr);
  shown_ = true;
  begin_ = SteadyClock::now();
}

void Progress::share(std::string_view text, double share) {
  if (!on_) return;
  const SteadyClock::time_point now = SteadyClock::now();
  if (now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  const double spent_s = std::chrono::duration<double>(now - begin_).count();
  fmt::print(stderr, "\r\x1b[K{}: {:.0f} %", text, 100 * share);
  // The first moments say little of the rest.
  if (spent_s > 1 && share > 0.02) fmt::print(stderr, ", {:.0f} s left", spent_s / share * (1 - share));
  std::fflush(stderr);
  shown_ = true;
}

void Progress::frame(std::uint64_t done, std::uint64_t total, std::uint64_t misses, std::size_t bodies) {
  if (!on_) return;
  const SteadyClock::time_point now = SteadyClock::now();
  // Loading is over: only frames tell how long frames take.
  if (done <= 1) begin_ = now;
  if (done <= 1 || now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  const double spent_s = std::chrono::duration<double>(now - begin_).count();
  const double left_s = spent_s / static_cast<double>(done - 1) * static_cast<double>(total - done);
  fmt::print(stderr, "\r\x1b[Kframe {} of {}, {} missed, {} bodies, {:.0f} s left", done, total, misses, bodies,
             left_s);
  std::fflush(stderr);
  shown_ = true;
}

void Progress::end() {
  if (!shown_) return;
  fmt::print(stderr, "\r\x1b[K");
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace poise::app
