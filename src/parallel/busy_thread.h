// SPDX-License-Identifier: MIT
#pragma once

#include <thread>
#include <vector>

namespace poise::parallel {

/// A thread that keeps one processor busy for the lifetime of this object; for studies and tests.
class BusyThread {
 public:
  /// On this processor where the system permits it, otherwise anywhere; -1: anywhere.
  explicit BusyThread(int processor);
  ~BusyThread() = default;
  BusyThread(const BusyThread&) = delete;
  BusyThread& operator=(const BusyThread&) = delete;

 private:
  std::jthread thread_;
};

/// The processors that this process may use, ascending; empty where the system does not tell.
std::vector<int> allowed_processors();

/// Keeps the calling thread on one processor while this lives, and then lets it go where it could before.
class OnProcessor {
 public:
  explicit OnProcessor(int processor);
  ~OnProcessor();
  OnProcessor(const OnProcessor&) = delete;
  OnProcessor& operator=(const OnProcessor&) = delete;
  /// Did the system permit it?
  [[nodiscard]] bool settled() const { return settled_; }

 private:
  std::vector<int> before_;
  bool settled_ = false;
};

}  // namespace poise::parallel
