// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "poise/types.h"

namespace poise::collision {

/// Two nodes that overlap, one of each body of a pair.
struct FrontEntry {
  NodeIndex a = 0;
  NodeIndex b = 0;
};

/// Memory for entries on the stack. Not set to zero beforehand: that would take longer than a level of a pair.
template <std::size_t kEntries>
class EntryBuffer {
 public:
  // An aggregate that needs no destructor: it begins to live with the bytes (C++20, implicit-lifetime types).
  [[nodiscard]] std::span<FrontEntry> entries() { return {reinterpret_cast<FrontEntry*>(bytes_.data()), kEntries}; }

 private:
  alignas(FrontEntry) std::array<std::byte, kEntries * sizeof(FrontEntry)> bytes_;
};

/// Of a reference to a segment; the others name the worker.
inline constexpr std::uint32_t kSegmentIndexBits = 24;
/// Reference to a segment of a FrontPool.
struct SegmentRef {
  static constexpr std::uint32_t kNone = 0xffffffffU;
  std::uint32_t bits = kNone;
  [[nodiscard]] bool none() const { return bits == kNone; }
};

/// A run of entries of one front. A front is a chain of segments, each made by one bounded job.
struct FrontSegment {
  std::uint32_t begin = 0;
  std::uint32_t count = 0;
  SegmentRef next;
};

/// Arena for the fronts that one worker makes in one frame. Invariant: entries and segments keep their address until
/// clear(). Only its worker writes; any thread may read published segments. The address space is reserved once
/// and never grows; pages that no front has reached cost no memory. Pools of workers that lie side by side share no
/// cache line: each is written for every level of a pair.
class alignas(64) FrontPool {
 public:
  explicit FrontPool(std::uint32_t max_entries)
      : entry_bytes_(new std::byte[sizeof(FrontEntry) * max_entries]),
        segment_bytes_(new std::byte[sizeof(FrontSegment) * segments_for(max_entries)]),
        max_entries_(max_entries),
        max_segments_(segments_for(max_entries)) {}
  /// How many segments a pool for so many entries has. One index less than there are is used: that of no segment.
  [[nodiscard]] static std::uint32_t segments_for(std::uint32_t max_entries) {
    return std::min(max_entries / kEntriesPerSegment + 1, (1U << kSegmentIndexBits) - 1U);
  }

  void clear() { entry_count_ = segment_count_ = 0; }
  /// Free entries, for the next segment; empty when the pool is full.
  [[nodiscard]] std::span<FrontEntry> room() {
    if (segment_count_ == max_segments_) return {};
    return {entries() + entry_count_, max_entries_ - entry_count_};
  }
  /// Less than a quarter is free: fronts that wait for their next level leave it to those that come to an end.
  [[nodiscard]] bool scarce() const {
    return entry_count_ > max_entries_ / 4 * 3 || segment_count_ > max_segments_ / 4 * 3;
  }
  /// Makes a segment of the first `count` entries of room() and returns its index.
  std::uint32_t keep(std::uint32_t count) {
    segments()[segment_count_] = {entry_count_, count, {}};
    entry_count_ += count;
    return segment_count_++;
  }
  /// Frees everything allocated after a mark, which is how much there was: a level that does not complete is discarded
  /// whole.
  struct Mark {
    std::uint32_t entries, segments;
  };
  [[nodiscard]] Mark mark() const { return {entry_count_, segment_count_}; }
  void release(Mark mark) {
    entry_count_ = mark.entries;
    segment_count_ = mark.segments;
  }
  [[nodiscard]] FrontSegment& segment(std::uint32_t index) { return segments()[index]; }
  [[nodiscard]] const FrontSegment& segment(std::uint32_t index) const { return segments()[index]; }
  [[nodiscard]] std::span<const FrontEntry> entries(const FrontSegment& segment) const {
    return {entries() + segment.begin, segment.count};
  }

 private:
  static constexpr std::uint32_t kEntriesPerSegment = 4;  // jobs of a few entries are the rule
  // Both are aggregates that need no destructor: they begin to live with the bytes (C++20, implicit-lifetime types).
  [[nodiscard]] FrontEntry* entries() const { return reinterpret_cast<FrontEntry*>(entry_bytes_.get()); }
  [[nodiscard]] FrontSegment* segments() const { return reinterpret_cast<FrontSegment*>(segment_bytes_.get()); }
  std::unique_ptr<std::byte[]> entry_bytes_;
  std::unique_ptr<std::byte[]> segment_bytes_;
  std::uint32_t max_entries_, max_segments_;
  std::uint32_t entry_count_ = 0;
  std::uint32_t segment_count_ = 0;
};

}  // namespace poise::collision
