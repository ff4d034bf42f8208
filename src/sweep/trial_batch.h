// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "sweep/trial.h"

namespace poise::sweep {

/// Trials that another process runs, perhaps on another machine: task i those from i * per_task on. As a file it is
/// `poise.sweep-batch/1`.
struct TrialBatch {
  std::vector<Trial> trials;
  std::uint64_t per_task = 1;  ///< at least 1; the last task may have fewer
  bool exclusive = false;      ///< the tasks have their machines to themselves

  [[nodiscard]] std::uint64_t tasks() const { return (trials.size() + per_task - 1) / per_task; }
  /// Those of one task; none beyond the last.
  [[nodiscard]] std::vector<Trial> of_task(std::uint64_t task) const;
};

std::string batch_json(const TrialBatch& batch);

/// Reads what batch_json made. Refused with file, field, value and rule.
Result<TrialBatch> read_batch(const std::filesystem::path& file);
/// The same from text; messages begin with `name`.
Result<TrialBatch> parse_batch(std::string_view text, const std::string& name);

/// As many tasks as there may be, each with as many trials as it must have, so that there are at most `most_tasks`.
std::uint64_t trials_per_task(std::size_t trials, std::uint64_t most_tasks);

}  // namespace poise::sweep
