// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>

namespace poise::parallel {

/// Hands out the numbers 0, 1, 2, ... to any number of workers, each number once. A worker stops when its number is
/// beyond the end of the work. Gives no memory ordering: Executor::run orders the writes of workers.
class Tickets {
 public:
  /// Takes `count` consecutive numbers and returns the first. Any thread.
  std::size_t take(std::size_t count = 1) { return next_.fetch_add(count, std::memory_order_relaxed); }
  /// The number that is likely to be taken next: other workers may take it meanwhile. Any thread.
  [[nodiscard]] std::size_t next() const { return next_.load(std::memory_order_relaxed); }
  /// Restarts at 0. Only while no worker takes numbers.
  void reset() { next_.store(0, std::memory_order_relaxed); }

 private:
  alignas(64) std::atomic<std::size_t> next_{0};
};

/// Hands out the numbers 0 to count - 1 to any number of workers, each number once. Each worker first takes the numbers
/// of its own share, in ascending order, and then numbers left in the shares of others. The shares depend on the count
/// and the number of workers alone, so a worker's data of one loop is in its cache in the next. Gives no memory
/// ordering, like Tickets.
class Shares {
 public:
  static constexpr std::size_t kNone = ~std::size_t{0};
  /// `workers` >= 1; if there are more than kMost, some begin with the same share.
  Shares(std::size_t count, int workers) : shares_(std::min<std::size_t>(static_cast<std::size_t>(workers), kMost)) {
    for (std::size_t k = 0; k < shares_; ++k) {
      share_[k].next.store(count * k / shares_, std::memory_order_relaxed);
      share_[k].end = count * (k + 1) / shares_;
    }
  }
  /// Takes a number, or returns kNone when all are taken. Any thread.
  std::size_t take(int worker) {
    for (std::size_t k = 0; k < shares_; ++k) {
      Share& share = share_[(static_cast<std::size_t>(worker) + k) % shares_];
      if (share.next.load(std::memory_order_relaxed) >= share.end) continue;
      const std::size_t number = share.next.fetch_add(1, std::memory_order_relaxed);
      if (number < share.end) return number;
    }
    return kNone;
  }

 private:
  static constexpr std::size_t kMost = 16;
  struct alignas(64) Share {
    std::atomic<std::size_t> next{0};
    std::size_t end = 0;
  };
  std::size_t shares_;
  std::array<Share, kMost> share_;
};

/// A number that the workers of a run share: a sum, a flag, the time of the cut. Any thread may call anything. A get()
/// that sees a value also sees everything that its writer wrote before.
template <class T>
class Shared {
 public:
  explicit Shared(T value = T{}) : value_(value) {}
  [[nodiscard]] T get() const { return value_.load(std::memory_order_acquire); }
  void set(T value) { value_.store(value, std::memory_order_release); }
  /// Adds and returns the previous value. Only for integers: with floating point, a result would depend on the order of
  /// additions.
  T add(T value) requires std::is_integral_v<T> { return value_.fetch_add(value, std::memory_order_acq_rel); }

 private:
  alignas(64) std::atomic<T> value_;
};

}  // namespace poise::parallel
