// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "parallel/executor.h"
#include "parallel/unset_vector.h"

namespace poise::parallel {

/// A set of keys, each with the value of whoever claimed it first, filled by any number of threads at once without
/// locks. Which value that is depends on the threads; which keys there are does not. Gives no memory ordering.
class ClaimedKeys {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffU;

  /// Empty, with room for so many keys. Allocates nothing that reserve() has seen.
  void begin(std::size_t keys, Executor& executor) {
    places_.resize(places_for(keys));
    parallel_for(executor, places_.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) places_[i] = {};
    });
  }
  void reserve(std::size_t keys) { places_.reserve(places_for(keys)); }

  /// Claims a key, which is not 0, for a value; the value that has it now. Any thread.
  std::uint32_t claim(std::uint64_t key, std::uint32_t value) {
    for (std::size_t at = home_of(key);; at = next(at)) {
      std::uint64_t found = 0;
      const std::atomic_ref<std::uint64_t> own(places_[at].key);
      if (!own.compare_exchange_strong(found, key, std::memory_order_relaxed) && found != key) continue;
      std::uint32_t first = kNone;
      const std::atomic_ref<std::uint32_t> holder(places_[at].value);
      return holder.compare_exchange_strong(first, value, std::memory_order_relaxed) ? value : first;
    }
  }
  /// The value of a key, or kNone. Any thread, once all were claimed; so is the rest.
  [[nodiscard]] std::uint32_t value_of(std::uint64_t key) const {
    for (std::size_t at = home_of(key); places_[at].key != 0; at = next(at)) {
      if (places_[at].key == key) return places_[at].value;
    }
    return kNone;
  }
  /// Places for keys, used or not.
  [[nodiscard]] std::size_t size() const { return places_.size(); }
  /// 0 where there is none.
  [[nodiscard]] std::uint64_t key_at(std::size_t place) const { return places_[place].key; }
  [[nodiscard]] std::uint32_t value_at(std::size_t place) const { return places_[place].value; }

 private:
  static constexpr std::size_t kGrain = 4096;
  struct Place {
    std::uint64_t key = 0;
    std::uint32_t value = kNone;
  };
  static std::size_t places_for(std::size_t keys) { return std::bit_ceil(2 * keys + 64); }
  [[nodiscard]] std::size_t home_of(std::uint64_t key) const {
    return (key * 0x9e3779b97f4a7c15U >> 32U) & (places_.size() - 1);
  }
  [[nodiscard]] std::size_t next(std::size_t at) const { return (at + 1) & (places_.size() - 1); }

  UnsetVector<Place> places_;
};

}  // namespace poise::parallel
