// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>

#include "capture/capture_reader.h"

/// What is made of captures for other programs. Each function reads the frames that it is asked for, once, and gives
/// bytes or text. Refused: what CaptureReader refuses.
namespace poise::capture {

/// Which frames of a capture: from the first with at least number `from`, and then each that comes `every` or more
/// after the one before, to number `to`.
struct FrameChoice {
  std::uint64_t from = 0, to = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t every = 1;  ///< >= 1
};

/// Tells the chosen frames. Refused: also where there is none.
Status read_chosen(CaptureReader& reader, const FrameChoice& choice, const CaptureReader::FrameSink& sink);

/// A name of a body for people: its own, or its shape and number.
std::string body_name(const CaptureReader& reader, std::uint32_t row);

}  // namespace poise::capture
