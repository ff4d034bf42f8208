// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "scene/run/requirement.h"
#include "scene/run/run_document.h"
#include "sweep/trial.h"
#include "sweep/trial_store.h"

namespace poise::sweep {

/// What is known of one trial.
struct TrialResult {
  Trial trial;
  Outcome outcome;
  std::vector<std::optional<double>> figures;  ///< parallel to Results::figures, as far as it has them
  std::string state_hash, processor, commit;   ///< of the run; empty unless it is done
  std::optional<bool> holds;  ///< whether all requirements hold; empty: there are none, or it is not done
};

/// All trials of a sweep with their figures.
struct Results {
  std::vector<std::string> figures;  ///< names as in `poise.run` (docs/run-report.md), and miss_rate
  std::vector<TrialResult> trials;   ///< in the order of the expansion

  /// Empty: the trial does not define this figure.
  [[nodiscard]] std::optional<double> figure(const TrialResult& trial, std::string_view name) const;
};

/// How many trials are in each state.
struct StateCounts {
  std::size_t pending = 0, done = 0, failed = 0, timed_out = 0;
};
StateCounts count_states(const Results& results);

/// The requirements of a specification together.
io::Requirement requirement_of(const SweepSpec& spec);

/// Figures that one run may have; longer names than this are none. Chosen: several times what a run has, and together
/// with the settings what an SQLite table has room for.
inline constexpr std::size_t kMostFigures = 1'800, kLongestFigureName = 200;

/// Reads the result of a run (`poise.run`): its figures are returned, its texts go into `result`. Refused: another
/// text, more figures than kMostFigures; messages begin with `name`.
Result<std::vector<io::NamedFigure>> parse_run_result(std::string_view text, const std::string& name,
                                                      TrialResult& result);

/// Reads what is stored of every trial. Figures are all numbers of the run's JSON but those of lists of objects.
/// Refused: a result that cannot be read.
Result<Results> join(const SweepSpec& spec, const std::vector<Trial>& trials, const TrialStore& store);

/// One row for each trial: key, scene, settings, state, figures; a setting has the name that it has in the
/// specification. Figures that are not part of a group have `run.` before their names, so that no two columns have the
/// same (`bodies` is the setting, `run.bodies` what the run had). Text as RFC 4180 has it.
std::string results_csv(const SweepSpec& spec, const Results& results);

/// The same as the bytes of an SQLite 3 database: table `trials` with the columns of the CSV, and table `sweep` (name,
/// value) with the name, the specification's file and its requirements. Refused as OutputFailed: no memory.
Result<std::string> results_sqlite(const SweepSpec& spec, const Results& results);

}  // namespace poise::sweep
