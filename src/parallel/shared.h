// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <type_traits>

namespace poise::parallel {

/// Hands out the numbers 0, 1, 2, ... to any number of workers, each number once. Whoever holds a number from the end
/// of the work or beyond stops. Orders nothing else: what workers write is ordered by Executor::run.
class Tickets {
 public:
  /// The first of `count` numbers that are now the caller's. Any thread.
  std::size_t take(std::size_t count = 1) { return next_.fetch_add(count, std::memory_order_relaxed); }
  /// Starts again at 0. Only while no worker takes.
  void reset() { next_.store(0, std::memory_order_relaxed); }

 private:
  alignas(64) std::atomic<std::size_t> next_{0};
};

/// A number that workers of a run share: a sum, a flag, the time of the cut. Any thread may call anything. A get() that
/// sees a value also sees all that its writer wrote before.
template <class T>
class Shared {
 public:
  explicit Shared(T value = T{}) : value_(value) {}
  [[nodiscard]] T get() const { return value_.load(std::memory_order_acquire); }
  void set(T value) { value_.store(value, std::memory_order_release); }
  /// Adds and gives the value before. Only whole numbers: the order of additions must not show in a result.
  T add(T value) requires std::is_integral_v<T> { return value_.fetch_add(value, std::memory_order_acq_rel); }

 private:
  alignas(64) std::atomic<T> value_;
};

}  // namespace poise::parallel
