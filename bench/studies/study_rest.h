// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study rest`.
struct StudyRestOptions {
  StudyTimesOptions common;
  std::vector<std::string> meshes;
  std::optional<std::uint64_t> drops, depth;
};
void add_study_rest_options(CLI::App& command, StudyRestOptions& options);

/// Drops each mesh alone on a plane, several times, refined to each level and by polygons, and measures how fast it
/// still moves when it has had the time to come to rest. Returns the exit code.
int study_rest(const StudyRestOptions& options);

}  // namespace poise::app
