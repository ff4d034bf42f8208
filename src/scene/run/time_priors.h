// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "poise/scheduler/forecast.h"

namespace poise::io {

/// What the time forecasts of a run depend on, beside the scene. Runs that agree in it share what they learned.
struct TimePriorsKey {
  std::string machine;  ///< processor and system, as a report names them
  int cores = 0;
  int threads = 0;
  std::string executor, contact;
  double alpha = 0;
};

/// Where a key's figures are kept in a folder: times-HASH.json (XXH3 of the key).
std::filesystem::path time_priors_file(const std::filesystem::path& folder, const TimePriorsKey& key);

/// None where the file is missing, damaged, of another key or has a number that makes no sense.
std::optional<scheduler::TimePriors> read_time_priors(const std::filesystem::path& folder, const TimePriorsKey& key);

/// Puts them in place as a whole; makes the folder. False where that cannot be, or there is nothing to keep.
bool write_time_priors(const std::filesystem::path& folder, const TimePriorsKey& key,
                       const scheduler::TimePriors& priors);

}  // namespace poise::io
