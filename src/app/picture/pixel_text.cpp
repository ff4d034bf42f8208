// SPDX-License-Identifier: MIT
#include "app/picture/pixel_text.h"

namespace poise::io {
namespace {

constexpr std::uint32_t kAdvance = 6;
constexpr std::uint32_t kRows = 9;  // two of them below the line

struct Glyph {
  char letter = ' ';
  std::array<std::uint8_t, kRows> rows{};  // five dots a row, the leftmost is bit 4
};

constexpr Glyph kGlyphs[] = {
    {'0', {14, 17, 19, 21, 25, 17, 14}},
    {'1', {4, 12, 4, 4, 4, 4, 14}},
    {'2', {14, 17, 1, 2, 4, 8, 31}},
    {'3', {31, 2, 4, 2, 1, 17, 14}},
    {'4', {2, 6, 10, 18, 31, 2, 2}},
    {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},
    {'7', {31, 1, 2, 4, 8, 8, 8}},
    {'8', {14, 17, 17, 14, 17, 17, 14}},
    {'9', {14, 17, 17, 15, 1, 2, 12}},
    {'a', {0, 0, 14, 1, 15, 17, 15}},
    {'b', {16, 16, 22, 25, 17, 17, 30}},
    {'c', {0, 0, 14, 16, 16, 17, 14}},
    {'d', {1, 1, 13, 19, 17, 17, 15}},
    {'e', {0, 0, 14, 17, 31, 16, 14}},
    {'f', {6, 9, 8, 28, 8, 8, 8}},
    {'g', {0, 0, 15, 17, 17, 19, 13, 1, 14}},
    {'h', {16, 16, 22, 25, 17, 17, 17}},
    {'i', {4, 0, 12, 4, 4, 4, 14}},
    {'j', {2, 0, 6, 2, 2, 2, 2, 18, 12}},
    {'k', {16, 16, 18, 20, 24, 20, 18}},
    {'l', {12, 4, 4, 4, 4, 4, 14}},
    {'m', {0, 0, 26, 21, 21, 21, 21}},
    {'n', {0, 0, 22, 25, 17, 17, 17}},
    {'o', {0, 0, 14, 17, 17, 17, 14}},
    {'p', {0, 0, 22, 25, 17, 17, 30, 16, 16}},
    {'q', {0, 0, 13, 19, 17, 17, 15, 1, 1}},
    {'r', {0, 0, 22, 25, 16, 16, 16}},
    {'s', {0, 0, 15, 16, 14, 1, 30}},
    {'t', {8, 8, 28, 8, 8, 9, 6}},
    {'u', {0, 0, 17, 17, 17, 19, 13}},
    {'v', {0, 0, 17, 17, 17, 10, 4}},
    {'w', {0, 0, 17, 17, 21, 21, 10}},
    {'x', {0, 0, 17, 10, 4, 10, 17}},
    {'y', {0, 0, 17, 17, 17, 19, 13, 1, 14}},
    {'z', {0, 0, 31, 2, 4, 8, 31}},
    {'.', {0, 0, 0, 0, 0, 12, 12}},
    {',', {0, 0, 0, 0, 0, 12, 4, 8}},
    {':', {0, 0, 12, 12, 0, 12, 12}},
    {'%', {24, 25, 2, 4, 8, 19, 3}},
    {'<', {2, 4, 8, 16, 8, 4, 2}},
    {'>', {8, 4, 2, 1, 2, 4, 8}},
    {'=', {0, 0, 31, 0, 31, 0, 0}},
    {'+', {0, 4, 4, 31, 4, 4, 0}},
    {'-', {0, 0, 0, 31, 0, 0, 0}},
    {'/', {1, 1, 2, 4, 8, 16, 16}},
};

const Glyph* glyph_of(char letter) {
  const char small = letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
  for (const Glyph& glyph : kGlyphs) {
    if (glyph.letter == small) return &glyph;
  }
  return nullptr;
}

}  // namespace

std::uint32_t text_width_px(std::string_view text, std::uint32_t scale) {
  return text.empty() ? 0 : (static_cast<std::uint32_t>(text.size()) * kAdvance - 1) * scale;
}

void draw_text(Image& image, std::string_view text, std::int64_t x_px, std::int64_t y_px, std::uint32_t scale,
               const std::array<std::uint8_t, 3>& color) {
  for (const char letter : text) {
    const Glyph* glyph = glyph_of(letter);
    for (std::uint32_t dot = 0; glyph != nullptr && dot < kRows * 5 * scale * scale; ++dot) {
      const std::uint32_t across = dot % (5 * scale);
      const std::uint32_t down = dot / (5 * scale);
      if (((static_cast<unsigned>(glyph->rows[down / scale]) >> (4 - across / scale)) & 1U) == 0) continue;
      const std::int64_t x = x_px + across;
      const std::int64_t y = y_px + down;
      if (x < 0 || y < 0 || x >= image.width_px || y >= image.height_px) continue;
      const std::size_t at = 3 * (static_cast<std::size_t>(y) * image.width_px + static_cast<std::size_t>(x));
      for (std::size_t k = 0; k < 3; ++k) image.rgb[at + k] = color[k];
    }
    x_px += std::int64_t{kAdvance} * scale;
  }
}

}  // namespace poise::io
