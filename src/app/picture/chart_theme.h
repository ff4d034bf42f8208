// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

/// The colours of all charts and drawings, on a light and on a dark ground: told apart by most people with impaired
/// colour vision (Okabe and Ito 2008). Drawers use the light ones; what they have drawn becomes dark by
/// `dark_text` (a script), `dark_color` (pixels) or `svg_with_dark` (a browser that asks for it). The pages have the
/// same ones (viewer/src/figures/style.css, viewer/src/palette.js).
namespace poise::app {

using ChartColor = std::array<std::uint8_t, 3>;

inline constexpr ChartColor kChartGround{0xff, 0xff, 0xff}, kChartInk{0x1a, 0x20, 0x27}, kChartGrid{0xd9, 0xde, 0xe3};
/// Beyond a deadline.
inline constexpr ChartColor kChartLate{0xd5, 0x5e, 0x00};
/// Lines, in their order.
inline constexpr std::array<ChartColor, 9> kChartLines{{{0x00, 0x72, 0xb2},
                                                        {0xd5, 0x5e, 0x00},
                                                        {0x00, 0x9e, 0x73},
                                                        {0xcc, 0x79, 0xa7},
                                                        {0xb5, 0x79, 0x00},
                                                        {0x2f, 0x8f, 0xc4},
                                                        {0x7d, 0x2e, 0x99},
                                                        {0x1a, 0x20, 0x27},
                                                        {0x77, 0x77, 0x77}}};
/// Areas of the stages of a frame, in their order. They are the same on both grounds.
inline constexpr std::array<ChartColor, 8> kStageColors{{{0x56, 0xb4, 0xe9},
                                                         {0x00, 0x72, 0xb2},
                                                         {0xcc, 0x79, 0xa7},
                                                         {0x00, 0x9e, 0x73},
                                                         {0xf0, 0xe4, 0x42},
                                                         {0xe6, 0x9f, 0x00},
                                                         {0x8c, 0x8c, 0x8c},
                                                         {0xc4, 0xc4, 0xc4}}};

/// The colour of a line by its number.
inline const ChartColor& line_color(std::size_t line) { return kChartLines[line % kChartLines.size()]; }

/// As #rrggbb.
std::string color_text(const ChartColor& color);

/// What of a drawing has other colours on a dark ground.
enum class DarkPart : std::uint8_t {
  Frame,  ///< ground, grid and letters; areas stay as they are
  All,    ///< lines too
};

/// A colour of a chart on a dark ground; one that is in no chart stays as it is.
ChartColor dark_color(const ChartColor& light, DarkPart part);
/// A script with all colours of charts, written as #rrggbb, in their dark form.
std::string dark_text(std::string script);
/// An SVG whose colours are attributes as #rrggbb: a browser that prefers dark colours shows the dark ones, other
/// programs the light ones.
std::string svg_with_dark(std::string svg, DarkPart part);

}  // namespace poise::app
