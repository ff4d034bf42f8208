// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>

#include "app/report/box_chart.h"
#include "scene/run/run_report.h"

namespace poise::app {

/// Frame times against the deadline: stages stacked, a mark of the colour of its cause above each late frame but those
/// of the warm-up. Where there are more frames than columns, a column is the slowest frame of its part of the run.
BoxChart frame_chart(const std::string& scene, std::optional<double> deadline_ms,
                     std::span<const simulation::RunFrame> frames);

/// Contact pairs by the level that they reached, stacked, in the colours of pictures. Where there are more frames than
/// columns, a column is the frame with most pairs of its part of the run. None without any such pair.
std::optional<BoxChart> level_chart(const std::string& scene, std::span<const simulation::RunFrame> frames);

/// The time that so many frames in a hundred do not exceed, with a log scale; the slow end is stretched. Without
/// warm-up. None without a frame that took any time.
std::optional<BoxChart> percentile_chart(const std::string& scene, std::optional<double> deadline_ms,
                                         std::span<const simulation::RunFrame> frames);

}  // namespace poise::app
