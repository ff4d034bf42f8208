// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "poise/scheduler/priority_bands.h"

namespace poise::scheduler {

/// The open jobs of a frame, by priority: one an item, with its forecast work. An item is anything that the host
/// refines step by step. It is identified by a small number; its state belongs to the host.
///
/// Invariant: an item is in the queue once, or held by one thread, or *closed* for this frame. So no job is lost and
/// none is done twice. Writes of a thread before it gives an item back are visible to the thread that takes it next.
class RefineQueue {
 public:
  static constexpr std::uint32_t kNone = PriorityBands::kNone;

  /// Empties the queue for items 0 .. items - 1. `tail_items` is the number of items that the tail processes if nothing
  /// is refined (the contacts of FrameBudget). One thread, while no thread refines. Allocates only to grow.
  void begin_frame(std::uint32_t items, std::int64_t tail_items);

  /// Adds an item with its priority (octave_band, linear_band or band_of) and the units of its next job. Any thread.
  /// Returns false and does nothing if the item does not exist, is in the queue, or is held by a thread.
  bool add(std::uint32_t item, std::uint32_t band, std::uint64_t units) {
    if (item >= items_ || open_item_[item].exchange(true, std::memory_order_acq_rel)) return false;
    open_.fetch_add(1, std::memory_order_relaxed);
    give_back(item, band, units);
    return true;
  }

  /// Number of items that are in the queue or held. Those left when all threads have returned were not refined for lack
  /// of time. Any thread.
  [[nodiscard]] std::uint32_t open() const { return open_.load(std::memory_order_acquire); }
  /// Number of items that the tail has to process now, never negative. Any thread.
  [[nodiscard]] std::uint64_t tail_items() const {
    return static_cast<std::uint64_t>(std::max<std::int64_t>(tail_items_.load(std::memory_order_acquire), 0));
  }

  // For refine_until and similar loops; any thread.

  /// Takes the item of the highest priority, which the caller then holds, or returns kNone.
  std::uint32_t take() { return bands_.take(); }
  /// Units of the next job of an item that the caller holds.
  [[nodiscard]] std::uint64_t units_of(std::uint32_t item) const { return units_[item]; }
  /// A lower bound of the units of the next job of any open item.
  [[nodiscard]] std::uint64_t least_units() const { return least_units_.load(std::memory_order_relaxed); }
  /// Returns an item that the caller holds to the queue.
  void give_back(std::uint32_t item, std::uint32_t band, std::uint64_t units) {
    units_[item] = units;
    std::uint64_t least = least_units_.load(std::memory_order_relaxed);
    while (units < least && !least_units_.compare_exchange_weak(least, units, std::memory_order_relaxed)) {
    }
    bands_.put(item, band);
  }
  /// Closes an item that the caller holds for this frame, unless it is added again.
  void close(std::uint32_t item) {
    open_item_[item].store(false, std::memory_order_release);
    open_.fetch_sub(1, std::memory_order_release);
  }
  /// Changes the number of items that the tail has to process.
  void change_tail(std::int64_t by) {
    if (by != 0) tail_items_.fetch_add(by, std::memory_order_acq_rel);
  }

 private:
  PriorityBands bands_;
  std::vector<std::uint64_t> units_;  // of each item; written by the thread that holds it
  std::unique_ptr<std::atomic<bool>[]> open_item_;
  std::uint32_t items_ = 0;
  std::uint32_t capacity_ = 0;
  alignas(64) std::atomic<std::uint32_t> open_{0};
  alignas(64) std::atomic<std::int64_t> tail_items_{0};
  alignas(64) std::atomic<std::uint64_t> least_units_{~std::uint64_t{0}};
};

}  // namespace poise::scheduler
