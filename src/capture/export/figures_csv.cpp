// SPDX-License-Identifier: MIT
#include "capture/export/figures_csv.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>

namespace poise::capture {
namespace {

constexpr std::array<const char*, 6> kCauses{"none", "infeasible", "machine", "overrun", "forecast", "release"};
constexpr std::array<const char*, kActivities> kActivityNames{"static", "kinematic", "moving",
                                                              "asleep", "held",      "paused"};

}  // namespace

std::string figures_header() {
  std::string text =
      "frame,time_s,left_out,warm_up,cause,predict_ms,broad_phase_ms,coarse_ms,refine_ms,manifolds_ms,solve_ms,"
      "integrate_ms,publish_ms,total_ms,host_ms,budget_ms,reserve_ms,lateness_ms,dynamic_bodies,candidate_pairs,"
      "coarse_pairs,contact_pairs,pairs_left,jobs_done,jobs_discarded,asleep,held,paused";
  for (int level = 0; level < kPolygonBin; ++level) text += fmt::format(",contacts_level_{}", level);
  text += ",contacts_polygons,work,kinetic_j,potential_j,momentum_x_kgmps,momentum_y_kgmps,momentum_z_kgmps,bodies";
  for (const char* name : kActivityNames) text += fmt::format(",bodies_{}", name);
  return text + "\n";
}

std::string figures_row(const PackedFrame& frame) {
  const FrameFacts& f = frame.facts;
  std::string text = fmt::format("{},{},{},{},{}", f.frame, f.time_s, f.left_out, f.warm_up ? 1 : 0,
                                 kCauses[static_cast<std::size_t>(f.cause)]);
  const auto out = std::back_inserter(text);
  const auto cell = [&](auto value) {
    text += ',';
    if (f.measured) fmt::format_to(out, "{}", value);
  };
  const auto time = [&](std::uint32_t hundred_ns) { cell(static_cast<double>(hundred_ns) / 1e4); };
  for (const std::uint32_t value : f.times) time(value);
  for (const std::uint32_t value : {f.budget, f.reserve, f.lateness}) time(value);
  for (const std::uint32_t count : f.counts) cell(count);
  for (const std::uint32_t count : f.levels) cell(count);
  cell(f.work);
  for (const double energy : {f.kinetic_j, f.potential_j}) {
    text += ',';
    if (std::isfinite(energy)) fmt::format_to(out, "{}", energy);
  }
  for (const float momentum : f.momentum_ns) {
    text += ',';
    if (std::isfinite(momentum)) fmt::format_to(out, "{}", momentum);
  }
  fmt::format_to(out, ",{}", frame.rows.size());
  std::array<std::size_t, kActivities> bodies{};
  for (const std::uint8_t activity : frame.activity) ++bodies[activity];
  for (const std::size_t count : bodies) fmt::format_to(out, ",{}", count);
  return text + "\n";
}

}  // namespace poise::capture
