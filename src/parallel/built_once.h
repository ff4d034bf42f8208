// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>

namespace poise::parallel {

/// A value that is made when it is first asked for, and again when it is asked for after a change. Any number of
/// threads may ask at once: the first one makes it and the others wait. Invariant: the value is written only under the
/// lock, by a thread that found it outdated.
///
/// Versions are numbers that the owner changes with whatever the value is made from; 0 is none. The owner must not
/// change it while anyone asks or still reads.
template <class T>
class BuiltOnce {
 public:
  BuiltOnce() : lock_(std::make_unique<Lock>()) {}

  /// The value for `version` (> 0): as it is, or after build(value), which may use what is left of the one before. A
  /// build that throws leaves it outdated.
  template <class Build>
  const T& get(std::uint64_t version, Build&& build) {
    if (lock_->built.load(std::memory_order_acquire) == version) return value_;
    const std::lock_guard<std::mutex> hold(lock_->mutex);
    if (lock_->built.load(std::memory_order_relaxed) == version) return value_;
    build(value_);
    lock_->built.store(version, std::memory_order_release);
    return value_;
  }

 private:
  struct Lock {
    std::mutex mutex;
    std::atomic<std::uint64_t> built{0};
  };
  std::unique_ptr<Lock> lock_;
  T value_{};
};

}  // namespace poise::parallel
