// SPDX-License-Identifier: MIT
#include "parallel/interrupt.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>

namespace poise::parallel {
namespace {

constexpr char kAsked = 'a';
constexpr char kOver = 'o';

/// The pipe that the signal handler writes to, and the signal that it got. A handler has no argument, so these are
/// global.
volatile std::sig_atomic_t handler_pipe = -1;
std::atomic<int> received = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not wait");

void send(int pipe, char what) {
  ssize_t sent = -1;
  do {
    sent = ::write(pipe, &what, 1);
  } while (sent < 0 && errno == EINTR);
}

void on_interrupt(int signal) {
  const int kept = errno;
  received.store(signal);
  // The next signal, whichever it is, ends the process.
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  ::sigaction(SIGINT, &usual, nullptr);
  ::sigaction(SIGTERM, &usual, nullptr);
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
  received.store(0);
  watcher_ = std::jthread(watch, ends_[0], stop_);
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  // Both at once, so that neither handler runs inside the other.
  sigaddset(&action.sa_mask, SIGINT);
  sigaddset(&action.sa_mask, SIGTERM);
  ::sigaction(SIGINT, &action, &before_int_);
  ::sigaction(SIGTERM, &action, &before_term_);
}

Interrupt::~Interrupt() {
  if (ends_[0] < 0) return;
  ::sigaction(SIGINT, &before_int_, nullptr);
  ::sigaction(SIGTERM, &before_term_, nullptr);
  send(ends_[1], kOver);
  watcher_.join();
  handler_pipe = -1;
  ::close(ends_[0]);
  ::close(ends_[1]);
}

bool Interrupt::asked() const { return received.load() != 0 || stop_.stop_requested(); }

int stop_signal() {
  const int signal = received.load();
  return signal == 0 ? SIGINT : signal;
}

const char* stop_name() { return stop_signal() == SIGTERM ? "SIGTERM" : "Ctrl-C"; }

std::stop_token stopped_token() {
  std::stop_source stop;
  stop.request_stop();
  return stop.get_token();
}

}  // namespace poise::parallel
