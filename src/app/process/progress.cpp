// SPDX-License-Identifier: MIT
#include "app/process/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "app/process/standard_streams.h"

namespace poise::app {
namespace {

constexpr std::size_t kUsualColumns = 80;

/// Asked anew for each line, so that a terminal may change its width.
std::size_t columns_of_terminal() {
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsualColumns;
  return size.ws_col;
}

std::string duration_text(double seconds) {
  const auto whole = static_cast<std::uint64_t>(std::clamp(seconds + 0.5, 0.0, 1e9));
  if (whole < 120) return fmt::format("{} s", whole);
  if (whole < 7200) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

double seconds(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

std::string progress_text(std::string_view text, double share, double spent_s) {
  std::string line = fmt::format("{:.0f} %", 100 * share);
  // The first moments say little of the rest.
  if (spent_s > 1 && share > 0.02) line += fmt::format(", {} left", duration_text(spent_s / share * (1 - share)));
  return fmt::format("{}: {}", line, text);
}

std::string fitted_to(std::string_view text, std::size_t columns) {
  if (text.size() <= columns) return std::string(text);
  if (columns == 0) return {};
  return std::string(text.substr(0, columns - 1)) + "~";
}

Progress::Progress(bool wanted)
    : on_(wanted), terminal_(::isatty(STDERR_FILENO) == 1), begin_(SteadyClock::now()), last_(begin_) {}

Progress::~Progress() { end(); }

bool Progress::due(SteadyClock::time_point now, double share) const {
  if (terminal_) return !shown_ || now - last_ >= std::chrono::milliseconds(100);
  return now - last_ >= std::chrono::seconds(10) ||
         (now - last_ >= std::chrono::seconds(1) && static_cast<int>(10 * share) > tenth_);
}

void Progress::show(SteadyClock::time_point now, double share, std::string_view text) {
  last_ = now;
  tenth_ = static_cast<int>(10 * share);
  if (!terminal_) {
    print_error("poise: {}\n", text);
  } else {
    // One column stays free: some terminals begin a new line when the last is written.
    print_error("\r\x1b[K{}", fitted_to(text, columns_of_terminal() - 1));
    shown_ = true;
  }
  std::fflush(stderr);
}

void Progress::say(std::string_view text) {
  if (!on_) return;
  const SteadyClock::time_point now = SteadyClock::now();
  if (terminal_ || now - last_ >= std::chrono::seconds(1)) show(now, 0, text);
  begin_ = now;
  tenth_ = 0;
}

void Progress::share(std::string_view text, double share) {
  if (!on_) return;
  const SteadyClock::time_point now = SteadyClock::now();
  if (due(now, share)) show(now, share, progress_text(text, share, seconds(now - begin_)));
}

void Progress::frame(std::uint64_t done, std::uint64_t total, std::uint64_t misses, std::size_t bodies) {
  if (!on_) return;
  const SteadyClock::time_point now = SteadyClock::now();
  // Loading is over: only frames tell how long frames take.
  if (done <= 1) {
    begin_ = now;
    tenth_ = 0;
    return;
  }
  const double share = static_cast<double>(done) / static_cast<double>(std::max<std::uint64_t>(total, 1));
  if (!due(now, share)) return;
  show(now, share,
       progress_text(fmt::format("frame {} of {}, {} missed, {} bodies", done, total, misses, bodies), share,
                     seconds(now - begin_)));
}

void Progress::end() {
  if (!shown_) return;
  print_error("\r\x1b[K");
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace poise::app
