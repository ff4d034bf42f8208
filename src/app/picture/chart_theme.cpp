// SPDX-License-Identifier: MIT
#include "app/picture/chart_theme.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace poise::app {
namespace {

struct Pair {
  ChartColor light, dark;
};

// The frame first. As the pages have them.
constexpr std::size_t kFrameColors = 3;
constexpr std::array<Pair, 11> kPairs{{{kChartGround, {0x14, 0x19, 0x1f}},
                                       {kChartGrid, {0x36, 0x40, 0x4a}},
                                       {kChartInk, {0xe8, 0xec, 0xf0}},
                                       {kChartLines[0], {0x5a, 0xa9, 0xe0}},
                                       {kChartLines[1], {0xff, 0x8a, 0x3c}},
                                       {kChartLines[2], {0x3d, 0xdb, 0xa6}},
                                       {kChartLines[3], {0xe7, 0x9b, 0xc6}},
                                       {kChartLines[4], {0xe6, 0x9f, 0x00}},
                                       {kChartLines[5], {0x9a, 0xd4, 0xf5}},
                                       {kChartLines[6], {0xb9, 0x8a, 0xe0}},
                                       {kChartLines[8], {0xa0, 0xa0, 0xa0}}}};

std::span<const Pair> pairs_of(DarkPart part) {
  return std::span(kPairs).first(part == DarkPart::All ? kPairs.size() : kFrameColors);
}

}  // namespace

std::string color_text(const ChartColor& color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
}

ChartColor dark_color(const ChartColor& light, DarkPart part) {
  const std::span<const Pair> pairs = pairs_of(part);
  const auto found = std::ranges::find(pairs, light, &Pair::light);
  return found == pairs.end() ? light : found->dark;
}

std::string dark_text(std::string script) {
  constexpr std::size_t kLength = 7;
  for (std::size_t at = script.find('#'); at != std::string::npos; at = script.find('#', at + 1)) {
    for (const Pair& pair : kPairs) {
      if (script.compare(at, kLength, color_text(pair.light)) != 0) continue;
      script.replace(at, kLength, color_text(pair.dark));
      break;
    }
  }
  return script;
}

std::string svg_with_dark(std::string svg, DarkPart part) {
  std::string rules = "<style>@media (prefers-color-scheme: dark) {";
  for (const Pair& pair : pairs_of(part)) {
    const std::string light = color_text(pair.light), dark = color_text(pair.dark);
    for (const char* attribute : {"fill", "stroke", "color"})
      rules += fmt::format(" [{0}=\"{1}\"] {{ {0}: {2} }}", attribute, light, dark);
  }
  const std::size_t begin = svg.find("<svg");
  const std::size_t end = begin == std::string::npos ? begin : svg.find('>', begin);
  if (end == std::string::npos) return svg;
  return svg.insert(end + 1, "\n" + rules + " }</style>");
}

}  // namespace poise::app
