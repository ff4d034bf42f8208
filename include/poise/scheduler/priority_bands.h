// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <iterator>
#include <memory>

#include "poise/scheduler/bands.h"

namespace poise::scheduler {

/// Items (small numbers) in bands of priority. Any number of workers take items and put them back, without a lock and
/// without allocation. Within a band the last item put is the first one taken.
///
/// Invariant: an item is in at most one band at a time, so one link an item is enough. Each band is a Treiber stack
/// (Treiber 1986) whose head carries a counter against the ABA problem (IBM System/370).
class PriorityBands {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffU;

  /// So that reset() for up to so many items allocates nothing. What is in the bands is lost if it has to grow. One
  /// thread, while no worker runs.
  void reserve(std::uint32_t items) {
    if (items <= capacity_) return;
    next_ = std::make_unique_for_overwrite<std::uint32_t[]>(items);
    capacity_ = items;
  }

  /// Empties all bands and reserves capacity for items 0 .. items - 1. One thread, while no worker runs. Allocates only
  /// to grow.
  void reset(std::uint32_t items) {
    if (items > capacity_) reserve(items + items / 2);
    for (auto& head : heads_) head.store(kNone, std::memory_order_relaxed);
    for (auto& word : filled_) word.store(0, std::memory_order_relaxed);
  }

  /// Puts an item into a band. `item` must be below the number given to reset() and in no band. A band beyond the last
  /// counts as the last. Any thread; the caller's earlier writes are visible to the thread that takes the item.
  void put(std::uint32_t item, std::uint32_t band) {
    band = std::min(band, kBands - 1);
    std::atomic<std::uint64_t>& head = heads_[band];
    std::uint64_t old = head.load(std::memory_order_relaxed);
    do {
      link(item).store(item_of(old), std::memory_order_relaxed);
    } while (
        !head.compare_exchange_weak(old, with_item(old, item), std::memory_order_release, std::memory_order_relaxed));
    filled_[band / 64].fetch_or(std::uint64_t{1} << (band % 64), std::memory_order_release);
  }

  /// Takes an item from the highest band that is not empty, or returns kNone. Any thread.
  std::uint32_t take() {
    for (std::uint32_t word = kBands / 64; word-- > 0;) {
      for (std::uint64_t bits = filled_[word].load(std::memory_order_acquire); bits != 0;) {
        const auto bit = static_cast<std::uint32_t>(63 - std::countl_zero(bits));
        const std::uint32_t item = take_from(64 * word + bit);
        if (item != kNone) return item;
        bits = clear_if_empty(word, bit);
      }
    }
    return kNone;
  }

  /// The highest band that may have an item, or 0 if there is none: other workers may take it meanwhile. Any thread.
  [[nodiscard]] std::uint32_t highest() const {
    for (std::uint32_t word = kBands / 64; word-- > 0;) {
      const std::uint64_t bits = filled_[word].load(std::memory_order_relaxed);
      if (bits != 0) return 64 * word + static_cast<std::uint32_t>(63 - std::countl_zero(bits));
    }
    return 0;
  }
  /// Whether all bands are empty. One thread, while no worker runs.
  [[nodiscard]] bool empty() const {
    return std::all_of(std::begin(heads_), std::end(heads_),
                       [](const auto& head) { return item_of(head.load(std::memory_order_relaxed)) == kNone; });
  }

 private:
  static_assert(kBands % 64 == 0, "a word of marks has 64 bands");
  // Memory that is set when an item is put, so that room for many costs nothing.
  [[nodiscard]] std::atomic_ref<std::uint32_t> link(std::uint32_t item) { return std::atomic_ref(next_[item]); }
  static std::uint32_t item_of(std::uint64_t head) { return static_cast<std::uint32_t>(head); }
  static std::uint64_t with_item(std::uint64_t head, std::uint32_t item) {
    return (((head >> 32U) + 1U) << 32U) | item;
  }

  std::uint32_t take_from(std::uint32_t band) {
    std::atomic<std::uint64_t>& head = heads_[band];
    std::uint64_t old = head.load(std::memory_order_acquire);
    while (item_of(old) != kNone) {
      const std::uint32_t next = link(item_of(old)).load(std::memory_order_relaxed);
      if (head.compare_exchange_weak(old, with_item(old, next), std::memory_order_acquire, std::memory_order_acquire)) {
        return item_of(old);
      }
    }
    return kNone;
  }

  // Clears the mark of a band that was found empty. Sets it again if an item arrived meanwhile.
  std::uint64_t clear_if_empty(std::uint32_t word, std::uint32_t bit) {
    const std::uint64_t mark = std::uint64_t{1} << bit;
    std::uint64_t bits = filled_[word].fetch_and(~mark, std::memory_order_acq_rel) & ~mark;
    if (item_of(heads_[64 * word + bit].load(std::memory_order_acquire)) != kNone) {
      bits = filled_[word].fetch_or(mark, std::memory_order_acq_rel) | mark;
    }
    return bits;
  }

  std::atomic<std::uint64_t> heads_[kBands];
  std::atomic<std::uint64_t> filled_[kBands / 64];
  std::unique_ptr<std::uint32_t[]> next_;
  std::uint32_t capacity_ = 0;
};

}  // namespace poise::scheduler
