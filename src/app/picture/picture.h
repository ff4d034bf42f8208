// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "poise/result.h"
#include "poise/scene/scene.h"

namespace poise::io {

/// An image of width x height pixels, rows from the top, red, green and blue a byte each.
struct Image {
  std::uint32_t width_px = 0, height_px = 0;
  std::vector<std::uint8_t> rgb;
};

/// Draws the bodies of a run as the spheres of their trees, seen by the scene's camera (or by one that sees them all),
/// each in the colour of the deepest level at which one of its contacts was answered in the last step: see level_color.
/// Trees are drawn at their deepest level of at most 128 spheres. Horizontal planes are drawn as a chequered ground.
Image draw_run(const SceneRun& run, std::uint32_t width_px, std::uint32_t height_px);

/// Colour of a level, from dark violet (0) over green to yellow (4 and deeper); bodies that touch nothing are grey.
std::array<double, 3> level_color(int level);

/// The bytes of a PNG file.
Result<std::string> png_bytes(const Image& image);

}  // namespace poise::io
