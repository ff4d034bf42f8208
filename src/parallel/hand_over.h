// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

namespace poise::parallel {

/// Hands values from one thread to another, in order. Neither ever waits for the other: there is no lock. Values are
/// swapped, so that their memory is used again. Invariant: at most `capacity` values wait.
template <class T>
class HandOver {
 public:
  /// `capacity` >= 1.
  explicit HandOver(std::size_t capacity) : slots_(std::max<std::size_t>(capacity, 1) + 1) {}
  HandOver(const HandOver&) = delete;
  HandOver& operator=(const HandOver&) = delete;

  /// The thread that gives: whether there is room. If so, this stays true until it gives.
  [[nodiscard]] bool has_room() const {
    const std::size_t next = (end_.load(std::memory_order_relaxed) + 1) % slots_.size();
    return next != begin_.load(std::memory_order_acquire);
  }
  /// The thread that gives: hands `value` over and leaves in it one that was taken before, or T{}. False, and `value`
  /// stays, where there is no room.
  [[nodiscard]] bool give(T& value) {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    const std::size_t next = (end + 1) % slots_.size();
    if (next == begin_.load(std::memory_order_acquire)) return false;
    std::swap(slots_[end], value);
    end_.store(next, std::memory_order_release);
    return true;
  }
  /// The thread that takes: the oldest value; what `value` was is left for the giver. False where none waits.
  [[nodiscard]] bool take(T& value) {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    std::swap(slots_[begin], value);
    begin_.store((begin + 1) % slots_.size(), std::memory_order_release);
    return true;
  }

 private:
  std::vector<T> slots_;  // one is always empty, so that full and empty differ
  std::atomic<std::size_t> begin_ = 0, end_ = 0;
};

}  // namespace poise::parallel
