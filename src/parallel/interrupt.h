// SPDX-License-Identifier: MIT
#pragma once

#include <csignal>
#include <stop_token>
#include <thread>

namespace poise::parallel {

/// Turns Ctrl-C (SIGINT) into a stop token while it lives, and puts back what was there before. A second Ctrl-C ends
/// the process at once. One may live at a time; it is made and destroyed on the same thread. Where the system gives it
/// no pipe, Ctrl-C keeps its meaning and the token is never stopped.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Stopped a moment after Ctrl-C. Any thread.
  [[nodiscard]] std::stop_token token() const { return stop_.get_token(); }
  [[nodiscard]] bool asked() const { return stop_.stop_requested(); }

 private:
  // A handler may not ask a stop source itself, so it writes a byte to a pipe, and a thread that reads the pipe asks.
  std::stop_source stop_;
  int ends_[2] = {-1, -1};
  struct sigaction before_ {};
  std::jthread watcher_;
};

/// A token that was stopped before it is asked: work that looks at it ends at its first look. Any thread.
std::stop_token stopped_token();

}  // namespace poise::parallel
