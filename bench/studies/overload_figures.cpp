// SPDX-License-Identifier: MIT
#include "studies/overload_figures.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace poise::simulation {
namespace {

// Number of frames whose mean level says that levels are back: one frame in which few bodies touch says little. Chosen.
constexpr std::size_t kBackFrames = 10;

double mean_of(std::span<const RunFrame> frames, double FrameReport::*member) {
  double sum = 0;
  for (const RunFrame& frame : frames) sum += frame.report.*member;
  return frames.empty() ? 0 : sum / static_cast<double>(frames.size());
}

// Over the contacts of spheres; those of polygons count as `polygons`, if that is given.
std::optional<double> mean_level(std::span<const RunFrame> frames, std::optional<std::size_t> polygons = {}) {
  double levels = 0;
  double contacts = 0;
  const auto add = [&](std::size_t level, std::uint64_t count) {
    levels += static_cast<double>(level * count);
    contacts += static_cast<double>(count);
  };
  for (const RunFrame& frame : frames) {
    const auto& histogram = frame.report.level_histogram;
    for (std::size_t level = 0; level < kPolygonBin; ++level) add(level, histogram[level]);
    if (polygons) add(*polygons, histogram[kPolygonBin]);
  }
  return contacts > 0 ? std::optional(levels / contacts) : std::nullopt;
}

// The deepest level of spheres of any contact; 0 without one.
std::size_t deepest_level(std::span<const RunFrame> frames) {
  std::size_t deepest = 0;
  for (const RunFrame& frame : frames) {
    for (std::size_t level = deepest + 1; level < kPolygonBin; ++level) {
      if (frame.report.level_histogram[level] > 0) deepest = level;
    }
  }
  return deepest;
}

double late_share(const OverloadRow& row) {
  const double late = static_cast<double>(row.infeasible + row.machine + row.own);
  return row.frames > 0 ? late / static_cast<double>(row.frames) : 0;
}

using Figure = std::pair<const char*, std::optional<double> (*)(const OverloadRow&)>;
constexpr Figure kFigures[] = {
    {"level_mean", [](const OverloadRow& row) { return row.level_mean; }},
    {"left_share", [](const OverloadRow& row) { return std::optional(row.left_share); }},
    {"late_share", [](const OverloadRow& row) { return std::optional(late_share(row)); }},
    {"p50_ms", [](const OverloadRow& row) { return std::optional(row.p50_ms); }},
    {"p99_ms", [](const OverloadRow& row) { return std::optional(row.p99_ms); }},
    {"potential_relative", [](const OverloadRow& row) { return row.potential_relative; }},
    {"kinetic_j", [](const OverloadRow& row) { return std::optional(row.kinetic_j); }},
    {"e_seen_mps", [](const OverloadRow& row) { return row.e_seen_mps; }},
};

}  // namespace

std::vector<OverloadStep> overload_steps(double least, double most) {
  std::vector<OverloadStep> steps;
  for (int k = 0;; ++k) {
    const double demand = least * std::exp2(0.5 * k);
    if (demand > most * (1 - 1e-9)) break;
    steps.push_back({true, demand});
  }
  steps.push_back({true, most});
  for (std::size_t k = steps.size(); k-- > 0;) steps.push_back({false, steps[k].demand});
  return steps;
}

OverloadRow overload_row(const OverloadStep& step, std::span<const RunFrame> frames,
                         std::span<const RunFrame> unlimited) {
  OverloadRow row;
  row.up = step.up;
  row.demand = step.demand;
  row.frames = frames.size();
  for (const RunFrame& frame : frames) {
    const MissCause cause = frame.report.cause;
    if (cause == MissCause::Infeasible) ++row.infeasible;
    if (cause == MissCause::Machine) ++row.machine;
    if (cause == MissCause::Overrun || cause == MissCause::Forecast) ++row.own;
  }
  const std::span<const RunFrame> half = frames.subspan(frames.size() / 2);
  const std::span<const RunFrame> whole = unlimited.subspan(unlimited.size() / 2);
  if (half.empty()) return row;
  row.bodies = half.back().report.bodies;
  row.level_mean = mean_level(half);
  double left = 0;
  double pairs = 0;
  for (const RunFrame& frame : half) {
    left += static_cast<double>(frame.report.pairs_left);
    pairs += static_cast<double>(frame.report.coarse_pairs);
    row.held_mean += static_cast<double>(frame.report.degraded.bodies_held) / static_cast<double>(half.size());
  }
  row.left_share = pairs > 0 ? left / pairs : 0;
  const RunFigures figures = run_figures(half, {false});
  row.p50_ms = figures.frame_ms.p50;
  row.p99_ms = figures.frame_ms.p99;
  row.kinetic_j = mean_of(half, &FrameReport::kinetic_j);
  const double without_j = mean_of(whole, &FrameReport::potential_j);
  if (without_j != 0) row.potential_relative = mean_of(half, &FrameReport::potential_j) / without_j;
  if (figures.reference.e_seen_mps) row.e_seen_mps = figures.reference.e_seen_mps->mean;
  return row;
}

std::vector<OverloadLoop> overload_loops(std::span<const OverloadRow> rows) {
  std::vector<OverloadLoop> loops;
  for (const auto& [name, figure] : kFigures) {
    OverloadLoop loop;
    loop.name = name;
    for (const OverloadRow& up : rows) {
      const auto back = std::ranges::find_if(
          rows, [&](const OverloadRow& row) { return up.up && !row.up && row.demand == up.demand; });
      if (back == rows.end()) continue;
      const std::optional<double> before = figure(up);
      const std::optional<double> after = figure(*back);
      if (!before || !after) continue;
      if (loop.difference && std::abs(*after - *before) <= std::abs(*loop.difference)) continue;
      loop.difference = *after - *before;
      loop.demand = up.demand;
    }
    loops.push_back(loop);
  }
  return loops;
}

Recovery recovery(std::span<const RunFrame> frames, std::span<const RunFrame> unlimited) {
  Recovery found;
  const std::size_t polygons = std::max(deepest_level(frames), deepest_level(unlimited)) + 1;
  const std::size_t both = std::min(frames.size(), unlimited.size());
  for (std::size_t first = 0; first + kBackFrames <= both && !found.frames; ++first) {
    const std::optional<double> full = mean_level(unlimited.subspan(first, kBackFrames), polygons);
    if (!full) continue;
    found.defined = true;
    const std::optional<double> level = mean_level(frames.subspan(first, kBackFrames), polygons);
    if (level && *level >= *full - kLevelBack) found.frames = first;
  }
  return found;
}

}  // namespace poise::simulation
