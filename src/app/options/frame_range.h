// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "poise/result.h"

namespace poise::app {

/// Frames by their numbers, both ends included.
struct FrameRange {
  std::uint64_t from = 0, to = std::numeric_limits<std::uint64_t>::max();
};

/// `A..B`, or one of the two alone. `forms` begins the rule of a refusal, before these three.
Result<FrameRange> parse_frame_range(const std::string& text, const std::string& forms = {});

}  // namespace poise::app
