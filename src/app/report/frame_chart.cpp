// SPDX-License-Identifier: MIT
#include "app/report/frame_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "app/report/frame_columns.h"
#include "frame/stage_list.h"
#include "scene/run/milliseconds.h"

namespace poise::app {
namespace {

struct Cause {
  MissCause cause;
  ChartColor color;
};
constexpr std::array<Cause, 5> kCauses{{{MissCause::Infeasible, kChartLate},
                                        {MissCause::Machine, {0x7a, 0x7a, 0x7a}},
                                        {MissCause::Overrun, {0xcc, 0x79, 0xa7}},
                                        {MissCause::Forecast, {0x00, 0x72, 0xb2}},
                                        {MissCause::Release, {0xe6, 0x9f, 0x00}}}};

ChartColor color_of(MissCause cause) {
  for (const Cause& known : kCauses) {
    if (known.cause == cause) return known.color;
  }
  return kChartInk;
}

/// Why a frame counts as late; no figure includes the warm-up.
MissCause counted_cause(const simulation::RunFrame& frame) {
  return frame.warm_up ? MissCause::None : frame.report.cause;
}

double total_ms(const simulation::RunFrame& frame) { return ms(frame.report.times.total); }

/// One frame that took very long must not press the others flat.
double top_of(std::optional<double> deadline_ms, std::span<const simulation::RunFrame> frames) {
  std::vector<double> times;
  for (const simulation::RunFrame& frame : frames) times.push_back(total_ms(frame));
  const double slowest = times.empty() ? 1 : *std::max_element(times.begin(), times.end());
  const double p99 = times.empty() ? 1 : simulation::percentile(times, 0.99);
  const double shown = deadline_ms && *deadline_ms < 8 * slowest ? *deadline_ms : 0;
  return std::max({1.12 * shown, std::min(1.05 * slowest, 1.6 * p99), 1e-3});
}

void stack_stages(const simulation::RunFrame& frame, double left, double width, double most_ms, BoxChart& chart) {
  const auto y = [&](double time_ms) { return plot::y(chart, std::min(1.0, time_ms / most_ms)); };
  double sum_ms = 0;
  for (std::size_t stage = 0; stage < simulation::kStages.size(); ++stage) {
    const double from = y(sum_ms);
    sum_ms += ms(frame.report.times.*simulation::kStages[stage].time);
    if (from > y(sum_ms)) chart.boxes.push_back({left, y(sum_ms), width, from - y(sum_ms), kStageColors[stage]});
  }
}

void mark_late_frames(std::span<const simulation::RunFrame> frames, BoxChart& chart) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const MissCause cause = counted_cause(frames[i]);
    if (cause == MissCause::None) continue;
    const double middle = plot::x(chart, share_of_frame(static_cast<double>(i) + 0.5, frames.size()));
    chart.boxes.push_back({middle - 4, plot::kTop - 14, 8, 8, color_of(cause)});
  }
}

void legend(std::span<const simulation::RunFrame> frames, BoxChart& chart) {
  double at = plot::kLeft;
  for (std::size_t stage = 0; stage < simulation::kStages.size(); ++stage)
    at = plot::legend_entry(chart, at, 0, kStageColors[stage], simulation::kStages[stage].name);
  at = plot::kLeft;
  for (const Cause& known : kCauses) {
    const auto late = std::count_if(frames.begin(), frames.end(),
                                    [&](const auto& frame) { return counted_cause(frame) == known.cause; });
    if (late == 0) continue;
    at = plot::legend_entry(chart, at, 1, known.color,
                            fmt::format("late, {}: {}", simulation::cause_name(known.cause), late));
  }
}

}  // namespace

BoxChart frame_chart(const std::string& scene, std::optional<double> deadline_ms,
                     std::span<const simulation::RunFrame> frames) {
  const double most_ms = top_of(deadline_ms, frames);
  BoxChart chart =
      plot::begin(fmt::format("{}: {} frames{}", scene, frames.size(),
                              deadline_ms ? fmt::format(", deadline {:g} ms", *deadline_ms) : std::string()),
                  "ms", "frame");
  for (double tick = 0; tick <= most_ms; tick += plot::tick_step(most_ms))
    plot::tick_up(chart, tick / most_ms, fmt::format("{:g}", tick));
  frame_ticks(chart, frames);
  draw_columns(chart, frames, total_ms, [&](const simulation::RunFrame& frame, double left, double width) {
    stack_stages(frame, left, width, most_ms, chart);
  });
  if (deadline_ms && *deadline_ms <= most_ms) plot::dashes(chart, *deadline_ms / most_ms, kChartLate);
  mark_late_frames(frames, chart);
  legend(frames, chart);
  return chart;
}

}  // namespace poise::app
