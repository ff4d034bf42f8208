// SPDX-License-Identifier: MIT
#include "capture/sums_code.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "capture/bytes.h"

namespace poise::capture {

std::string sums_bytes(std::span<const FrameSums> frames) {
  const bool any = std::ranges::any_of(frames, [](const FrameSums& sums) { return std::isfinite(sums[0]); });
  std::string out;
  if (!any) return out;
  put(static_cast<std::uint32_t>(frames.size()), out);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const FrameSums& sums : frames) put(sums[axis], out);
  }
  return out;
}

Result<std::vector<FrameSums>> read_sums(std::string_view raw, std::size_t frames) {
  ByteReader bytes(raw);
  const auto count = bytes.get<std::uint32_t>();
  if (count != frames) return bad_input(fmt::format("SUMS: frames = {}, its block has {}", count, frames));
  if (bytes.left() != frames * sizeof(FrameSums))
    return bad_input(fmt::format("SUMS: has {} bytes for {} frames", raw.size(), frames));
  std::vector<FrameSums> sums(frames);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (FrameSums& of_frame : sums) of_frame[axis] = bytes.get<float>();
  }
  return sums;
}

}  // namespace poise::capture
