// SPDX-License-Identifier: MIT
#pragma once

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
/// clear(). Only its worker writes; any thread may read published segments. The memory is reserved once and never
/// grows; pages that were never touched cost nothing.
class FrontPool {
 public:
  explicit FrontPool(std::uint32_t max_entries)
      : entries_(new FrontEntry[max_entries]),
        segments_(new FrontSegment[max_entries / kEntriesPerSegment + 1]),
        max_entries_(max_entries),
        max_segments_(max_entries / kEntriesPerSegment + 1) {}

  void clear() { entry_count_ = segment_count_ = 0; }
  /// Free entries, for the next segment; empty when the pool is full.
  [[nodiscard]] std::span<FrontEntry> room() {
    if (segment_count_ == max_segments_) return {};
    return {entries_.get() + entry_count_, max_entries_ - entry_count_};
  }
  /// Makes a segment of the first `count` entries of room() and returns its index.
  std::uint32_t keep(std::uint32_t count) {
    segments_[segment_count_] = {entry_count_, count, {}};
    entry_count_ += count;
    return segment_count_++;
  }
  /// Frees everything allocated after a mark: a level that does not complete is discarded whole.
  struct Mark {
    std::uint32_t entries, segments;
  };
  [[nodiscard]] Mark mark() const { return {entry_count_, segment_count_}; }
  void release(Mark mark) {
    entry_count_ = mark.entries;
    segment_count_ = mark.segments;
  }
  [[nodiscard]] FrontSegment& segment(std::uint32_t index) { return segments_[index]; }
  [[nodiscard]] const FrontSegment& segment(std::uint32_t index) const { return segments_[index]; }
  [[nodiscard]] std::span<const FrontEntry> entries(const FrontSegment& segment) const {
    return {entries_.get() + segment.begin, segment.count};
  }

 private:
  static constexpr std::uint32_t kEntriesPerSegment = 4;  // jobs of a few entries are the rule
  std::unique_ptr<FrontEntry[]> entries_;
  std::unique_ptr<FrontSegment[]> segments_;
  std::uint32_t max_entries_, max_segments_;
  std::uint32_t entry_count_ = 0;
  std::uint32_t segment_count_ = 0;
};

}  // namespace poise::collision
