// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <utility>

namespace poise::parallel {

/// Disjoint sets of the numbers [0, n), united by any number of threads at once without locks (Anderson and Woll 1991).
/// Invariant: a parent is never above its child, so the root of a set is its lowest member, in whatever order sets were
/// united. Gives no memory ordering, like Tickets.
class DisjointSets {
 public:
  /// `parent[i]` is i, or what it was made by earlier calls; it must outlive this.
  explicit DisjointSets(std::span<std::uint32_t> parent) : parent_(parent) {}

  /// Of the set that i is in now. Any thread.
  [[nodiscard]] std::uint32_t root(std::uint32_t i) const {
    for (;;) {
      const std::uint32_t above = at(i).load(std::memory_order_relaxed);
      if (above == i) return i;
      const std::uint32_t next = at(above).load(std::memory_order_relaxed);
      // Halves the path; whatever another thread has stored meanwhile is above i too.
      if (next != above) at(i).store(next, std::memory_order_relaxed);
      i = next;
    }
  }
  /// Any thread.
  void unite(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = root(a);
      b = root(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      std::uint32_t expected = a;
      if (at(a).compare_exchange_strong(expected, b, std::memory_order_relaxed)) return;
    }
  }

 private:
  [[nodiscard]] std::atomic_ref<std::uint32_t> at(std::uint32_t i) const {
    return std::atomic_ref<std::uint32_t>(parent_[i]);
  }
  std::span<std::uint32_t> parent_;
};

/// Sets a flag that other threads may set at the same time.
inline void raise(std::uint8_t& flag) { std::atomic_ref<std::uint8_t>(flag).store(1, std::memory_order_relaxed); }

/// Adds to a number to which other threads may add at the same time.
template <class T>
void add_shared(T& to, T value) {
  if (value != T{}) std::atomic_ref<T>(to).fetch_add(value, std::memory_order_relaxed);
}

/// Makes a number that other threads may raise at the same time at least `value`.
template <class T>
void raise_shared(T& to, T value) {
  const std::atomic_ref<T> shared(to);
  T before = shared.load(std::memory_order_relaxed);
  while (before < value && !shared.compare_exchange_weak(before, value, std::memory_order_relaxed)) {
  }
}

}  // namespace poise::parallel
