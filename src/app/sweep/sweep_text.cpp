// SPDX-License-Identifier: MIT
#include "app/sweep/sweep_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace poise::app {
namespace {

constexpr std::size_t kShownTrials = 20;
constexpr std::size_t kShownGroups = 10;

std::string values_text(const sweep::Axis& axis) {
  std::string text;
  for (const sweep::Setting& value : axis.values) text += (text.empty() ? "" : ", ") + value.text;
  return text;
}

std::string time_text(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

/// Trials that run at the same time, by the needs of all.
double at_once(const std::vector<sweep::Trial>& pending, const RunnerSettings& runner) {
  double cores = 0;
  for (const sweep::Trial& trial : pending)
    cores += static_cast<double>(std::min<std::uint64_t>(trial.cores, runner.processors.size()));
  cores /= static_cast<double>(std::max<std::size_t>(1, pending.size()));
  const double fit = static_cast<double>(runner.processors.size()) / std::max(1.0, cores);
  return std::clamp(fit, 1.0, static_cast<double>(runner.workers));
}

std::string point_text(const sweep::FrontierPoint& point) {
  if (!point.largest) return point.open ? "?" : "none";
  return fmt::format("{}{:g}", point.open ? ">= " : "", *point.largest);
}

/// Where the requirements hold, and the first combinations in which they do not.
std::string requirements_text(const sweep::SweepSpec& spec, const std::vector<sweep::Group>& groups) {
  const std::string holds = holds_text(groups);
  if (holds.empty()) return {};
  std::string text = fmt::format("{}: {}", fmt::join(spec.requirements, " and "), holds);
  std::size_t missed = 0;
  for (const sweep::Group& group : groups) {
    if (group.holds.value_or(true)) continue;
    if (missed < kShownGroups)
      text += fmt::format("{}\n  {}", missed == 0 ? ", and not in" : "", sweep::group_label(spec, group, {}));
    ++missed;
  }
  if (missed > kShownGroups) text += fmt::format("\n  and {} more", missed - kShownGroups);
  return text + "\n";
}

}  // namespace

std::string holds_text(const std::vector<sweep::Group>& groups) {
  const auto known = std::ranges::count_if(groups, [](const sweep::Group& group) { return group.holds.has_value(); });
  const auto held = std::ranges::count(groups, std::optional(true), &sweep::Group::holds);
  if (known == 0) return {};
  return fmt::format("the requirements hold in {} of {} combination{}", held, known, known == 1 ? "" : "s");
}

std::string plan_text(const SweepPlan& plan, const sweep::TrialStore& store, const std::vector<sweep::Trial>& pending,
                      const SweepOptions& options, const RunnerSettings& runner) {
  std::string text = fmt::format("{}: {} trials\n", plan.spec.name, plan.trials.size());
  text += fmt::format("  scenes          {}\n", fmt::join(plan.spec.scenes, ", "));
  for (const sweep::Setting& setting : plan.spec.settings)
    text += fmt::format("  {:<15} {}\n", setting.name, setting.text);
  for (const sweep::Axis& axis : plan.spec.axes) text += fmt::format("  {:<15} {}\n", axis.name, values_text(axis));
  text += fmt::format("  {:<15} {}\n", "repeats", plan.spec.repeats);
  text += fmt::format("  {:<15} {}\n", "results in", store.folder().string());
  text += fmt::format("{} have a result, {} are to be run\n", plan.trials.size() - pending.size(), pending.size());
  const TimeEstimate estimate = estimate_time(plan, store, pending);
  if (options.engine == "local") {
    const double parallel = at_once(pending, runner);
    text += estimate.known
                ? fmt::format("about {} with {:.3g} at a time, {}\n", time_text(estimate.seconds / parallel), parallel,
                              estimate.basis)
                : fmt::format("how long they take is known when one has run; at most {} by their time limits\n",
                              time_text(static_cast<double>(pending.size()) * plan.spec.time_limit_s / parallel));
  } else if (estimate.known) {
    text += fmt::format("about {} of node time, {}\n", time_text(estimate.seconds), estimate.basis);
  }
  for (std::size_t i = 0; i < std::min(kShownTrials, pending.size()); ++i)
    text += fmt::format("  {}  {} ({} core{}, {})\n", pending[i].key.substr(0, 8), pending[i].label, pending[i].cores,
                        pending[i].cores == 1 ? "" : "s", pending[i].timed ? "timed" : "counts work");
  if (pending.size() > kShownTrials) text += fmt::format("  and {} more\n", pending.size() - kShownTrials);
  return text;
}

std::string frontier_table(const sweep::SweepSpec& spec, const std::vector<sweep::FrontierLine>& frontier) {
  if (frontier.empty() || !spec.frontier) return {};
  std::string text = fmt::format("| largest {} by {} |", spec.frontier->largest, spec.frontier->against);
  std::string rule = "|---|";
  for (const sweep::FrontierPoint& point : frontier.front().points) {
    text += fmt::format(" {:g} |", point.at);
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (const sweep::FrontierLine& line : frontier) {
    text += fmt::format("| {} |", line.label);
    for (const sweep::FrontierPoint& point : line.points) text += fmt::format(" {} |", point_text(point));
    text += "\n";
  }
  return text;
}

std::string result_text(const sweep::SweepSpec& spec, const sweep::StateCounts& counts,
                        const std::vector<sweep::Group>& groups) {
  std::string text = fmt::format("{}: {} done", spec.name, counts.done);
  if (counts.failed > 0) text += fmt::format(", {} failed", counts.failed);
  if (counts.timed_out > 0) text += fmt::format(", {} past their time limit", counts.timed_out);
  if (counts.pending > 0) text += fmt::format(", {} pending", counts.pending);
  text += "\n";
  const std::string table = frontier_table(spec, sweep::frontier_of(spec, groups));
  if (table.empty()) return text + requirements_text(spec, groups);
  return text + fmt::format("{} where {}\n{}", spec.frontier->largest, fmt::join(spec.requirements, " and "), table);
}

}  // namespace poise::app
