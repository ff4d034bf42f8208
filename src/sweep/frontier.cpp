// SPDX-License-Identifier: MIT
#include "sweep/frontier.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace poise::sweep {
namespace {

const std::string kSeed = "seed";

std::string group_key(const SweepSpec& spec, const Trial& trial) {
  std::string key = trial.scene;
  for (const Axis& axis : spec.axes) {
    if (axis.name != kSeed) key += "\n" + std::string(trial.value_of(axis.name));
  }
  return key;
}

void add_figures(const TrialResult& result, Group& group) {
  for (std::size_t i = 0; i < result.figures.size(); ++i) {
    const std::optional<double>& value = result.figures[i];
    if (!value) continue;
    group.mean[i] = group.mean[i].value_or(0) + *value;
    group.least[i] = std::min(group.least[i].value_or(*value), *value);
    group.most[i] = std::max(group.most[i].value_or(*value), *value);
  }
}

/// A figure that a trial of the group does not define has no mean.
void finish(const Results& results, const std::vector<std::size_t>& defined, const io::Requirement& requirement,
            Group& group) {
  std::vector<io::NamedFigure> figures;
  for (std::size_t i = 0; i < group.mean.size(); ++i) {
    if (defined[i] < group.done || group.done == 0) {
      group.mean[i] = group.least[i] = group.most[i] = std::nullopt;
    } else {
      group.mean[i] = *group.mean[i] / static_cast<double>(group.done);
    }
    figures.push_back({results.figures[i], group.mean[i]});
  }
  if (requirement.empty() || group.pending > 0) return;
  group.holds = group.ended == 0 && io::failed_comparisons(requirement, figures).empty();
}

double number_of(const Group& group, const std::string& name) {
  const auto found = std::ranges::find(group.settings, name, &Setting::name);
  return found == group.settings.end() ? 0 : found->number.value_or(0);
}

/// From groups that differ in the axis `largest` alone, by its ascending values.
FrontierPoint point_of(double at, const std::vector<const Group*>& groups, const std::string& largest) {
  FrontierPoint point{at, {}, true};
  for (const Group* group : groups) {
    if (group->holds != true) {
      point.open = !group->holds.has_value();
      break;
    }
    point.largest = number_of(*group, largest);
  }
  return point;
}

}  // namespace

std::string value_of(const Group& group, const std::string& name) {
  const auto found = std::ranges::find(group.settings, name, &Setting::name);
  return found == group.settings.end() ? std::string() : found->text;
}

std::vector<Group> groups_of(const SweepSpec& spec, const Results& results) {
  const io::Requirement requirement = requirement_of(spec);
  std::vector<Group> groups;
  std::vector<std::vector<std::size_t>> defined;
  std::map<std::string, std::size_t> index;
  const bool seeds = std::ranges::find(spec.axes, kSeed, &Axis::name) != spec.axes.end();
  for (const TrialResult& result : results.trials) {
    const auto [at, is_new] = index.try_emplace(group_key(spec, result.trial), groups.size());
    if (is_new) {
      Group group;
      group.scene = result.trial.scene;
      group.settings = result.trial.settings;
      if (seeds) std::erase_if(group.settings, [](const Setting& setting) { return setting.name == kSeed; });
      group.mean.resize(results.figures.size());
      group.least.resize(results.figures.size());
      group.most.resize(results.figures.size());
      groups.push_back(std::move(group));
      defined.emplace_back(results.figures.size(), 0);
    }
    Group& group = groups[at->second];
    group.pending += result.outcome.state == TrialState::Pending ? 1 : 0;
    group.done += result.outcome.state == TrialState::Done ? 1 : 0;
    group.ended += result.outcome.state == TrialState::Failed || result.outcome.state == TrialState::TimedOut ? 1 : 0;
    add_figures(result, group);
    for (std::size_t i = 0; i < result.figures.size(); ++i) defined[at->second][i] += result.figures[i] ? 1U : 0U;
  }
  for (std::size_t i = 0; i < groups.size(); ++i) finish(results, defined[i], requirement, groups[i]);
  return groups;
}

std::string group_label(const SweepSpec& spec, const Group& group, const std::vector<std::string>& without) {
  std::string label = spec.scenes.size() > 1 ? group.scene : std::string();
  for (const Axis& axis : spec.axes) {
    if (axis.name == kSeed || axis.values.size() < 2 || std::ranges::find(without, axis.name) != without.end())
      continue;
    label += fmt::format("{}{}={}", label.empty() ? "" : ", ", axis.name, value_of(group, axis.name));
  }
  return label.empty() ? group.scene : label;
}

std::vector<FrontierLine> frontier_of(const SweepSpec& spec, const std::vector<Group>& groups) {
  std::vector<FrontierLine> lines;
  if (!spec.frontier) return lines;
  const std::string& largest = spec.frontier->largest;
  const std::string& against = spec.frontier->against;
  // By label in the order of the groups, then by both axes ascending.
  std::vector<std::pair<std::string, std::map<double, std::vector<const Group*>>>> sorted;
  for (const Group& group : groups) {
    const std::string label = group_label(spec, group, {largest, against});
    auto line = std::ranges::find(sorted, label, [](const auto& entry) { return entry.first; });
    if (line == sorted.end()) line = sorted.insert(sorted.end(), {label, {}});
    line->second[number_of(group, against)].push_back(&group);
  }
  for (auto& [label, points] : sorted) {
    FrontierLine line{label, {}};
    for (auto& [at, column] : points) {
      std::ranges::stable_sort(column, {}, [&](const Group* group) { return number_of(*group, largest); });
      line.points.push_back(point_of(at, column, largest));
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace poise::sweep
