// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

namespace poise::simulation {

/// Which frames of a run have a reference: each K-th. It is one of a whole step, so where the step of an earlier frame
/// is still under way, the turn passes to the next frame that begins a step.
class ReferenceTurns {
 public:
  /// `every`: K >= 1; none: no frame has one.
  explicit ReferenceTurns(std::optional<std::uint64_t> every) : every_(every) {}

  /// Asked once for each frame in order, the first of which is `frame` 1. `begins`: the frame begins a step.
  bool due(std::uint64_t frame, bool begins) {
    if (every_ && frame % *every_ == 0) waits_ = true;
    if (!waits_ || !begins) return false;
    waits_ = false;
    return true;
  }

 private:
  std::optional<std::uint64_t> every_;
  bool waits_ = false;
};

}  // namespace poise::simulation
