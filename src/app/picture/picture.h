// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "poise/result.h"

namespace poise::io {

/// An image of width x height pixels, rows from the top, red, green and blue a byte each.
struct Image {
  std::uint32_t width_px = 0, height_px = 0;
  std::vector<std::uint8_t> rgb;
};

/// The bytes of a PNG file. Refused: an empty image.
Result<std::string> png_bytes(const Image& image);

}  // namespace poise::io
