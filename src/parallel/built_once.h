// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>

namespace poise::parallel {

/// A value that is built on first request, and rebuilt on the first request after a change. Any number of threads may
/// request it at once: the first one builds it and the others wait. Invariant: the value is written only under the
/// lock, by a thread that found it outdated.
///
/// The owner passes a version that changes whenever the sources of the value change; 0 is no version. The owner must
/// not change the sources while a thread requests or reads the value.
template <class T>
class BuiltOnce {
 public:
  BuiltOnce() : lock_(std::make_unique<Lock>()) {}

  /// Whether the value is up to date for `version`.
  [[nodiscard]] bool built(std::uint64_t version) const {
    return lock_->built.load(std::memory_order_acquire) == version;
  }

  /// The value for `version` (> 0), after build(value) if it is outdated; build may reuse the previous value. If build
  /// throws, the value stays outdated.
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
