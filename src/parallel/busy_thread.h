// SPDX-License-Identifier: MIT
#pragma once

#include <thread>
#include <vector>

namespace poise::parallel {

/// A thread that keeps one processor busy for the lifetime of this object; for studies and tests.
class BusyThread {
 public:
  /// Runs on this processor if the system permits it, otherwise on any; -1: on any.
  explicit BusyThread(int processor);
  ~BusyThread() = default;
  BusyThread(const BusyThread&) = delete;
  BusyThread& operator=(const BusyThread&) = delete;

 private:
  std::jthread thread_;
};

/// The processors that this process may use, ascending; empty if the system does not report them.
std::vector<int> allowed_processors();

/// Binds the calling thread to one processor for the lifetime of this object, and then restores its affinity.
class OnProcessor {
 public:
  explicit OnProcessor(int processor);
  ~OnProcessor();
  OnProcessor(const OnProcessor&) = delete;
  OnProcessor& operator=(const OnProcessor&) = delete;
  /// Whether the system permitted it.
  [[nodiscard]] bool settled() const { return settled_; }

 private:
  std::vector<int> before_;
  bool settled_ = false;
};

}  // namespace poise::parallel
