// SPDX-License-Identifier: MIT
#pragma once

#include <csignal>
#include <stop_token>
#include <thread>

namespace poise::parallel {

/// Turns Ctrl-C (SIGINT) and SIGTERM into a stop token during its lifetime, and then restores the previous handlers. A
/// second signal, either of them, ends the process at once. At most one may live at a time; it must be made and
/// destroyed on the same thread. If the system provides no pipe, the signals keep their meaning and the token is never
/// stopped.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Stopped shortly after the signal. Any thread.
  [[nodiscard]] std::stop_token token() const { return stop_.get_token(); }
  /// True from the signal on, also where it is seen by the call of the system that it ended. Any thread.
  [[nodiscard]] bool asked() const;

 private:
  // A signal handler must not use a stop source, so it writes a byte to a pipe; a thread reads the pipe and requests
  // the stop.
  std::stop_source stop_;
  int ends_[2] = {-1, -1};
  struct sigaction before_int_ {};
  struct sigaction before_term_ {};
  std::jthread watcher_;
};

/// The signal that the last Interrupt was asked by; SIGINT where there was none. Any thread.
int stop_signal();
/// The same in words: `Ctrl-C` or `SIGTERM`.
const char* stop_name();

/// A token that is already stopped: work ends at its first check of the token. Any thread.
std::stop_token stopped_token();

}  // namespace poise::parallel
