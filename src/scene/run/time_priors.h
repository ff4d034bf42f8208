// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "poise/scheduler/forecast.h"

namespace poise::io {

/// Everything that the time forecasts of a run depend on, except the scene. Runs with equal keys share what they
/// learned.
struct TimePriorsKey {
  std::string machine;  ///< processor and system, as in a report
  int cores = 0;
  int threads = 0;
  std::string executor, contact;
  double alpha = 0;
};

/// The file of a key's priors in a folder: times-HASH.json (XXH3 of the key).
std::filesystem::path time_priors_file(const std::filesystem::path& folder, const TimePriorsKey& key);

/// Empty if the file is missing, damaged, of another key or has an invalid number.
std::optional<scheduler::TimePriors> read_time_priors(const std::filesystem::path& folder, const TimePriorsKey& key);

/// The same from the text of such a file.
std::optional<scheduler::TimePriors> parse_time_priors(std::string_view text, const TimePriorsKey& key);

/// Writes the file completely or not at all; creates a missing folder. Returns false on failure, or if there is nothing
/// to store.
bool write_time_priors(const std::filesystem::path& folder, const TimePriorsKey& key,
                       const scheduler::TimePriors& priors);

}  // namespace poise::io
