// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "poise/scheduler/priority_bands.h"

namespace poise::scheduler {

/// The jobs of a frame that could still be done: one an item, by priority, with the work that it is forecast to take.
/// An item is whatever the host refines step by step; it is named by a small number, and its state is the host's.
///
/// Invariant: an item is in the queue once, or in the hands of one thread, or *closed* for this frame; so no job is
/// lost and none is done twice. What a thread wrote before it gave an item back is seen by the thread that takes it
/// next.
class RefineQueue {
 public:
  static constexpr std::uint32_t kNone = PriorityBands::kNone;

  /// Empties the queue for items 0 .. items - 1. `tail_items` of them, or of whatever else, are what the tail has to
  /// deal with if nothing is refined (FrameBudget's contacts). One thread, nobody refining. Allocates only to grow.
  void begin_frame(std::uint32_t items, std::int64_t tail_items);

  /// Puts an item in, with its priority (octave_band, linear_band or band_of) and the units of its next job. Any
  /// thread. False, and nothing done: there is no such item, or it is in the queue or in hand already.
  bool add(std::uint32_t item, std::uint32_t band, std::uint64_t units) {
    if (item >= items_ || open_item_[item].exchange(true, std::memory_order_acq_rel)) return false;
    open_.fetch_add(1, std::memory_order_relaxed);
    give_back(item, band, units);
    return true;
  }

  /// Items that are in the queue or in hand. What is left when all threads have returned was not refined for want of
  /// time. Any thread.
  [[nodiscard]] std::uint32_t open() const { return open_.load(std::memory_order_acquire); }
  /// What the tail has to deal with now, never negative. Any thread.
  [[nodiscard]] std::uint64_t tail_items() const {
    return static_cast<std::uint64_t>(std::max<std::int64_t>(tail_items_.load(std::memory_order_acquire), 0));
  }

  // For refine_until and loops like it; any thread.

  /// The item of the highest priority, now in the caller's hands, or kNone.
  std::uint32_t take() { return bands_.take(); }
  /// Units of the next job of an item in the caller's hands.
  [[nodiscard]] std::uint64_t units_of(std::uint32_t item) const { return units_[item]; }
  /// Not more units than the next job of any open item.
  [[nodiscard]] std::uint64_t least_units() const { return least_units_.load(std::memory_order_relaxed); }
  /// Puts an item that is in the caller's hands into the queue again.
  void give_back(std::uint32_t item, std::uint32_t band, std::uint64_t units) {
    units_[item] = units;
    std::uint64_t least = least_units_.load(std::memory_order_relaxed);
    while (units < least && !least_units_.compare_exchange_weak(least, units, std::memory_order_relaxed)) {
    }
    bands_.put(item, band);
  }
  /// Nothing more of an item in the caller's hands in this frame, unless it is added again.
  void close(std::uint32_t item) {
    open_item_[item].store(false, std::memory_order_release);
    open_.fetch_sub(1, std::memory_order_release);
  }
  void change_tail(std::int64_t by) {
    if (by != 0) tail_items_.fetch_add(by, std::memory_order_acq_rel);
  }

 private:
  PriorityBands bands_;
  std::vector<std::uint64_t> units_;  // of an item: written by whoever holds it
  std::unique_ptr<std::atomic<bool>[]> open_item_;
  std::uint32_t items_ = 0;
  std::uint32_t capacity_ = 0;
  alignas(64) std::atomic<std::uint32_t> open_{0};
  alignas(64) std::atomic<std::int64_t> tail_items_{0};
  alignas(64) std::atomic<std::uint64_t> least_units_{~std::uint64_t{0}};
};

}  // namespace poise::scheduler
