// SPDX-License-Identifier: MIT
#include "sweep/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "assets/files/text_file.h"
#include "assets/json/json_document.h"

namespace poise::sweep {
namespace {

using io::JsonValue;
using Kind = JsonValue::Kind;

constexpr std::uint64_t kMostResultBytes = 1U << 28U;

std::string part_of(const std::string& path, std::string_view name) {
  return path.empty() ? std::string(name) : fmt::format("{}.{}", path, name);
}

void flatten(const JsonValue& value, const std::string& path, std::vector<io::NamedFigure>& out) {
  if (path.size() > kLongestFigureName || out.size() > kMostFigures) return;
  if (value.is_number()) {
    out.push_back({path, value.number()});
  } else if (value.kind() == Kind::Null) {
    out.push_back({path, std::nullopt});
  } else if (value.is_object()) {
    const JsonValue::Keys keys = value.keys();
    for (std::size_t i = 0; i < keys.size() && out.size() <= kMostFigures; ++i)
      if (keys[i].size() <= kLongestFigureName) flatten(value.items()[i], part_of(path, keys[i]), out);
  } else if (value.is_array()) {
    for (std::size_t i = 0; i < value.items().size() && out.size() <= kMostFigures; ++i)
      flatten(value.items()[i], part_of(path, std::to_string(i)), out);
  }
}

std::string text_at(const JsonValue& root, std::string_view first, std::string_view second = {}) {
  const JsonValue* found = root.find(first);
  if (found != nullptr && !second.empty()) found = found->find(second);
  return found != nullptr && found->is_string() ? std::string(found->text()) : std::string();
}

/// The figures of a stored run, and its texts.
Result<std::vector<io::NamedFigure>> read_result(const std::filesystem::path& file, TrialResult& result) {
  const Result<std::string> text = geometry::read_text_file(file, kMostResultBytes);
  if (!text) return text.error();
  return parse_run_result(text.value(), file.string(), result);
}

}  // namespace

Result<std::vector<io::NamedFigure>> parse_run_result(std::string_view text, const std::string& name,
                                                      TrialResult& result) {
  const Result<JsonValue> root = io::parse_json(text, name);
  if (!root) return root.error();
  if (!text_at(root.value(), "schema").starts_with("poise.run/"))
    return bad_input(name + ": must be the result of a run (poise.run); remove it to run the trial again");
  result.state_hash = text_at(root.value(), "state_hash");
  result.processor = text_at(root.value(), "machine", "processor");
  result.commit = text_at(root.value(), "build", "commit");
  std::vector<io::NamedFigure> figures;
  flatten(root.value(), "", figures);
  if (figures.size() > kMostFigures) return bad_input(fmt::format("{}: has more than {} figures", name, kMostFigures));
  const auto rate = std::ranges::find(figures, "misses.rate", &io::NamedFigure::name);
  if (rate != figures.end()) {
    const std::optional<double> value = rate->value;
    figures.push_back({"miss_rate", value});
  }
  return figures;
}

std::optional<double> Results::figure(const TrialResult& trial, std::string_view name) const {
  const auto found = std::ranges::find(figures, name);
  const auto at = static_cast<std::size_t>(found - figures.begin());
  return at < trial.figures.size() ? trial.figures[at] : std::nullopt;
}

StateCounts count_states(const Results& results) {
  StateCounts counts;
  for (const TrialResult& result : results.trials) {
    switch (result.outcome.state) {
      case TrialState::Pending:
        ++counts.pending;
        break;
      case TrialState::Done:
        ++counts.done;
        break;
      case TrialState::Failed:
        ++counts.failed;
        break;
      case TrialState::TimedOut:
        ++counts.timed_out;
        break;
    }
  }
  return counts;
}

io::Requirement requirement_of(const SweepSpec& spec) {
  io::Requirement all;
  for (const std::string& text : spec.requirements) {
    const Result<io::Requirement> parsed = io::parse_requirement(text);
    if (parsed) all.insert(all.end(), parsed.value().begin(), parsed.value().end());
  }
  return all;
}

Result<Results> join(const SweepSpec& spec, const std::vector<Trial>& trials, const TrialStore& store) {
  const io::Requirement requirement = requirement_of(spec);
  Results results;
  std::map<std::string, std::size_t, std::less<>> columns;
  for (const Trial& trial : trials) {
    TrialResult result;
    result.trial = trial;
    result.outcome = store.outcome_of(trial);
    if (result.outcome.state == TrialState::Done) {
      const Result<std::vector<io::NamedFigure>> figures = read_result(store.result_file(trial.key), result);
      if (!figures) return figures.error();
      for (const io::NamedFigure& figure : figures.value()) {
        const auto [column, is_new] = columns.try_emplace(figure.name, results.figures.size());
        if (is_new) results.figures.push_back(figure.name);
        if (result.figures.size() <= column->second) result.figures.resize(column->second + 1);
        result.figures[column->second] = figure.value;
      }
      if (!requirement.empty()) result.holds = io::failed_comparisons(requirement, figures.value()).empty();
    }
    results.trials.push_back(std::move(result));
  }
  return results;
}

}  // namespace poise::sweep
