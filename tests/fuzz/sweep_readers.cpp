// SPDX-License-Identifier: MIT
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "fuzz/checks.h"
#include "fuzz/containers.h"
#include "sweep/frontier.h"
#include "sweep/results.h"
#include "sweep/sweep_spec.h"
#include "sweep/trial_batch.h"
#include "sweep/trial_store.h"

namespace poise::fuzz {

bool read_sweep_spec(std::string_view bytes) {
  std::vector<std::string> errors;
  const Result<sweep::SweepSpec> spec = sweep::parse_spec(bytes, "sweep", ".", errors);
  for (const std::string& error : errors) checked(bad_input(error));
  require(spec.ok() == errors.empty(), "a specification is refused with what is wrong");
  if (!spec) return checked(spec.error());
  std::size_t settings = spec.value().settings.size() + spec.value().axes.size();
  double trials = static_cast<double>(spec.value().scenes.size()) * static_cast<double>(spec.value().repeats);
  for (const sweep::Axis& axis : spec.value().axes) trials *= static_cast<double>(axis.values.size());
  require(settings <= sweep::kMostSettings + 1, "settings are limited");
  require(trials >= 1 && trials <= static_cast<double>(sweep::kMostTrials), "trials are limited");
  sweep::requirement_of(spec.value());
  return true;
}

/// What a job array is given is read as it is written, and each trial belongs to one task.
bool read_trials(std::string_view bytes) {
  const Result<sweep::TrialBatch> batch = sweep::parse_batch(bytes, "batch");
  if (!batch) return checked(batch.error());
  std::size_t of_tasks = 0;
  for (std::uint64_t task = 0; task <= batch.value().tasks(); ++task) of_tasks += batch.value().of_task(task).size();
  require(of_tasks == batch.value().trials.size(), "each trial belongs to one task");
  const Result<sweep::TrialBatch> again = sweep::parse_batch(sweep::batch_json(batch.value()), "batch");
  require(again.ok() && again.value().trials.size() == batch.value().trials.size(), "a batch is read as it is written");
  return true;
}

bool read_outcome(std::string_view bytes) {
  const sweep::Outcome outcome = sweep::parse_outcome(bytes);
  require(std::isfinite(outcome.seconds) && std::isfinite(outcome.time_limit_s), "a time is finite");
  return outcome.state != sweep::TrialState::Pending;
}

bool read_run_result(std::string_view bytes) {
  sweep::TrialResult result;
  const Result<std::vector<io::NamedFigure>> figures = sweep::parse_run_result(bytes, "result", result);
  if (!figures) return checked(figures.error());
  // One more: the miss rate under its short name.
  require(figures.value().size() <= sweep::kMostFigures + 1, "figures are limited");
  for (const io::NamedFigure& figure : figures.value())
    require(!figure.value || std::isfinite(*figure.value), "a figure is finite");
  return true;
}

}  // namespace poise::fuzz
