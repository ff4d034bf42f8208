// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "poise/scene/scene.h"
#include "scene/run/render_load.h"
#include "scene/run/time_priors.h"

namespace poise::app {

/// Options of how a frame's time is forecast and used.
struct TimeOptions {
  std::optional<double> alpha;
  std::optional<std::array<double, 2>> render_load_ms;  ///< mean and jitter
  std::optional<std::string> priors_folder;
  bool no_priors = false;
};

/// Adds --alpha, --render-load, --time-priors and --no-time-priors.
void add_time_options(CLI::App& command, TimeOptions& options);

/// Refused: options that contradict each other or the work clock, as one line.
Status check_time_options(const TimeOptions& options, bool work_clock);

/// What the host does in each frame: by the command line, else by the scene.
simulation::RenderLoad render_load_of(const TimeOptions& options, const Scene& scene, std::uint64_t seed);

/// Where what was learned of times is kept between runs; empty: nowhere. By default poise in the user's cache,
/// POISE_TIME_PRIORS names another folder, or "off".
std::filesystem::path time_priors_folder(const TimeOptions& options);

/// Frames under a deadline that a run must have had before what it learned is kept: until then it is mostly what it
/// began with.
inline constexpr std::uint64_t kFramesToKeep = 120;

}  // namespace poise::app
