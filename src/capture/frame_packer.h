// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "capture/capture.h"
#include "capture/capture_writer.h"

namespace poise::capture {

/// Makes of frames as they were seen what FrameEncoder codes. Invariant: has the number of each row of the table of
/// bodies, ascending.
class FramePacker {
 public:
  FramePacker(double position_step_m, std::uint32_t orientation_steps)
      : position_step_m_(position_step_m), orientation_steps_(orientation_steps) {}

  /// The table gets the new bodies of the frame first. Valid until the next call.
  const PackedFrame& pack(const SeenFrame& frame);
  /// The pairs of the frame that was packed last. Valid until the next call.
  const std::vector<PackedPair>& pack_pairs(const SeenFrame& frame);
  /// Of the table of bodies.
  [[nodiscard]] std::size_t rows() const { return numbers_.size(); }
  /// The table has no rows: the next frame lists all its bodies as new ones.
  void clear() { numbers_.clear(); }

 private:
  [[nodiscard]] std::optional<std::uint32_t> row_of(std::uint64_t number) const;

  double position_step_m_;
  std::uint32_t orientation_steps_;
  std::vector<std::uint64_t> numbers_;
  PackedFrame packed_;
  std::vector<PackedPair> packed_pairs_;
};

}  // namespace poise::capture
