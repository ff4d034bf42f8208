// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "app/picture/picture.h"

namespace poise::io {

/// Height of a line of text in pixels at scale 1, without the room below for g, p and y.
inline constexpr std::uint32_t kTextHeight = 7;

/// Width of the text in pixels: six a character at scale 1, the last gap left out.
std::uint32_t text_width_px(std::string_view text, std::uint32_t scale);

/// Writes text over an image in letters of 5 x 7 dots, each `scale` pixels wide, from the upper left corner (x, y). It
/// knows letters (capitals become small ones), digits, space and . , : % < > = + - /; anything else is left blank. What
/// does not fit in the image is cut off.
void draw_text(Image& image, std::string_view text, std::int64_t x_px, std::int64_t y_px, std::uint32_t scale,
               const std::array<std::uint8_t, 3>& color);

}  // namespace poise::io
