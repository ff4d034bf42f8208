// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"

namespace poise::capture {

/// Sums over all bodies of a frame that the fixed part of frames does not have: linear momentum, kg m/s.
using FrameSums = std::array<float, 3>;

/// The SUMS chunk of a block (docs/capture.md); empty where no frame has a value.
std::string sums_bytes(std::span<const FrameSums> frames);
/// What such a chunk holds of a block of so many frames. Refused: another number of frames, another size.
Result<std::vector<FrameSums>> read_sums(std::string_view raw, std::size_t frames);

}  // namespace poise::capture
