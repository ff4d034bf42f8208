// SPDX-License-Identifier: MIT
#include "app/options/frame_range.h"

#include <fmt/format.h>

#include <charconv>
#include <cstddef>
#include <system_error>

#include "poise/scene/scene.h"

namespace poise::app {

Result<FrameRange> parse_frame_range(const std::string& text, const std::string& forms) {
  FrameRange range;
  const auto wrong = [&] {
    return bad_input(fmt::format("--frames = {}, must be {}A..B, A.. or ..B with whole A <= B, at most {}", text, forms,
                                 kMaxSceneFrames));
  };
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos || text.size() == 2) return wrong();
  const auto number = [&](std::size_t begin, std::size_t end, std::uint64_t& value) {
    if (begin == end) return true;
    const auto [stop, failure] = std::from_chars(text.data() + begin, text.data() + end, value);
    return failure == std::errc{} && stop == text.data() + end && value <= kMaxSceneFrames;
  };
  if (!number(0, dots, range.from) || !number(dots + 2, text.size(), range.to) || range.from > range.to) return wrong();
  return range;
}

}  // namespace poise::app
