// SPDX-License-Identifier: MIT
#include "parallel/interrupt.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace poise::parallel {
namespace {

constexpr char kAsked = 'a';
constexpr char kOver = 'o';

/// The pipe that the signal handler writes to. A handler has no argument, so this is a global.
volatile std::sig_atomic_t handler_pipe = -1;

void send(int pipe, char what) {
  ssize_t sent = -1;
  do {
    sent = ::write(pipe, &what, 1);
  } while (sent < 0 && errno == EINTR);
}

void on_interrupt(int /*signal*/) {
  const int kept = errno;
  send(handler_pipe, kAsked);
  errno = kept;
}

// NOLINTNEXTLINE(performance-unnecessary-value-param): the standard has no const request_stop().
void watch(int pipe, std::stop_source stop) {
  for (;;) {
    char what = kOver;
    const ssize_t got = ::read(pipe, &what, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got != 1 || what == kOver) return;
    stop.request_stop();
  }
}

}  // namespace

Interrupt::Interrupt() {
  if (::pipe2(ends_, O_CLOEXEC) != 0) return;
  handler_pipe = ends_[1];
  watcher_ = std::jthread(watch, ends_[0], stop_);
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  ::sigaction(SIGINT, &action, &before_);
}

Interrupt::~Interrupt() {
  if (ends_[0] < 0) return;
  ::sigaction(SIGINT, &before_, nullptr);
  send(ends_[1], kOver);
  watcher_.join();
  handler_pipe = -1;
  ::close(ends_[0]);
  ::close(ends_[1]);
}

std::stop_token stopped_token() {
  std::stop_source stop;
  stop.request_stop();
  return stop.get_token();
}

}  // namespace poise::parallel
