// SPDX-License-Identifier: MIT
#pragma once

#include <csignal>
#include <stop_token>
#include <thread>

namespace poise::parallel {

/// Turns Ctrl-C (SIGINT) into a stop token during its lifetime, and then restores the previous handler. A second Ctrl-C
/// ends the process at once. At most one may live at a time; it must be made and destroyed on the same thread. If the
/// system provides no pipe, Ctrl-C keeps its meaning and the token is never stopped.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Stopped shortly after Ctrl-C. Any thread.
  [[nodiscard]] std::stop_token token() const { return stop_.get_token(); }
  [[nodiscard]] bool asked() const { return stop_.stop_requested(); }

 private:
  // A signal handler must not use a stop source, so it writes a byte to a pipe; a thread reads the pipe and requests
  // the stop.
  std::stop_source stop_;
  int ends_[2] = {-1, -1};
  struct sigaction before_ {};
  std::jthread watcher_;
};

/// A token that is already stopped: work ends at its first check of the token. Any thread.
std::stop_token stopped_token();

}  // namespace poise::parallel
