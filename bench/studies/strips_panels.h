// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "app/picture/chart_theme.h"
#include "app/picture/frame_picture.h"
#include "studies/study_strips.h"

// What the picture of the strips and its drawing in lines share.
namespace poise::app {

inline constexpr std::uint32_t kPanelWidth = 320, kPanelHeight = 190;  // pixels
inline constexpr std::uint32_t kStripGap = 8, kStripTitle = 26, kStripHead = 34;
inline constexpr const ChartColor& kStripArrow = kChartLate;
inline constexpr double kArrowS = 0.45;  // an arrow is the way of so many seconds
inline constexpr std::array kStripMoments = {"start", "collision, nearer", "later", "end: velocities"};

inline constexpr std::uint32_t strips_width_px() {
  return static_cast<std::uint32_t>(kStripMoments.size()) * (kPanelWidth + kStripGap) + kStripGap;
}
/// Of the title of a strip; for the number of strips, the height of all.
inline constexpr std::uint32_t strip_top_px(std::size_t row) {
  return kStripHead + static_cast<std::uint32_t>(row) * (kPanelHeight + kStripTitle + kStripGap);
}
inline constexpr std::uint32_t panel_left_px(std::size_t column) {
  return kStripGap + static_cast<std::uint32_t>(column) * (kPanelWidth + kStripGap);
}

/// The frame of a panel: bodies in the colour of the level, the view closer at the collision.
io::DrawnFrame panel_frame(const Strips& all, const Strip& strip, const io::FramePictures& pictures,
                           std::size_t moment);

/// What stands over a strip, left and right.
std::string strip_title(const Strip& strip);
std::string strip_end(const Strip& strip);

/// Where a point is seen in a panel, in pixels from its top left corner.
std::array<double, 2> in_panel(const io::Eye& eye, const Vec3& point_m);

}  // namespace poise::app
