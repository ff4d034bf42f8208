// SPDX-License-Identifier: MIT
#include "app/compare/compare_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "app/files/output_files.h"
#include "app/files/scene_input.h"
#include "app/options/option_values.h"
#include "app/options/suggestions.h"
#include "app/report/figures_page.h"
#include "assets/json/json_document.h"
#include "scene/policy_file.h"
#include "scene/run/policy_name.h"

namespace poise::app {
namespace {

constexpr std::uint64_t kDefaultFrames = 30;
constexpr std::uint64_t kDefaultEvery = 8;
constexpr std::uint64_t kDefaultWarmUp = 30;
constexpr double kMostBudget = 1e15;
constexpr std::size_t kMostBudgets = 64;

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t end = text.find(',', begin);
    parts.push_back(text.substr(begin, end == std::string::npos ? end : end - begin));
    if (end == std::string::npos) return parts;
    begin = end + 1;
  }
}

Status read_policies(const std::string& text, const scheduler::Policy& policy, std::vector<Competitor>& competitors) {
  for (const std::string& name : split(text)) {
    const Result<Competitor> competitor = competitor_named(name, policy);
    if (!competitor) return bad_input("--policies: " + competitor.error().message);
    for (const Competitor& other : competitors) {
      if (other.name == name) return bad_input(fmt::format("--policies: {} is given twice", name));
    }
    competitors.push_back(competitor.value());
  }
  return Done{};
}

// A budget in a unit: a number, or a share as 25%. Empty: neither, or out of range.
std::optional<double> read_budget(const std::string& text, bool& percent) {
  percent = !text.empty() && text.back() == '%';
  const std::string number = percent ? text.substr(0, text.size() - 1) : text;
  double budget = 0;
  const auto [stop, failure] = std::from_chars(number.data(), number.data() + number.size(), budget);
  if (failure != std::errc{} || stop != number.data() + number.size()) return {};
  return budget >= 0 && budget <= (percent ? 100 : kMostBudget) ? std::optional(budget) : std::nullopt;
}

constexpr const char* kWorkRule = "a number of work units from 0, or a share of full refinement as 25%";

Status read_from(const std::string& text, bool wall, CompareSettings& settings) {
  if (text.empty()) return Done{};
  settings.from = read_budget(text, settings.from_percent);
  if (wall && settings.from == 0.0) return bad_input("--from = 0, must be above 0 with --clock wall");
  if (settings.from && !(wall && settings.from_percent)) return Done{};
  return bad_input(fmt::format("--from = {}, must be {}", text, wall ? "a number of ms above 0" : kWorkRule));
}

Status read_budgets(const std::string& text, bool wall, CompareSettings& settings) {
  bool first = true;
  for (const std::string& part : split(text)) {
    bool percent = false;
    const std::optional<double> budget = read_budget(part, percent);
    if (!budget || (wall && (percent || *budget == 0))) {
      return bad_input(
          fmt::format("--budgets: {}, must be {}", io::in_quotes(part), wall ? "a number of ms above 0" : kWorkRule));
    }
    const BudgetUnit unit = wall ? BudgetUnit::Ms : percent ? BudgetUnit::Percent : BudgetUnit::Work;
    if (!first && unit != settings.unit)
      return bad_input("--budgets: work units and shares of full refinement cannot be mixed");
    first = false;
    settings.unit = unit;
    settings.budgets.push_back(*budget);
  }
  if (settings.budgets.size() > kMostBudgets)
    return bad_input(fmt::format("--budgets: {} of them, must be at most {}", settings.budgets.size(), kMostBudgets));
  std::sort(settings.budgets.begin(), settings.budgets.end());
  const auto twice = std::adjacent_find(settings.budgets.begin(), settings.budgets.end());
  if (twice != settings.budgets.end()) return bad_input(fmt::format("--budgets: {:g} is given twice", *twice));
  return Done{};
}

// Calls check(all files that a comparison writes).
template <class Check>
Status with_outputs(const CompareOptions& options, Check&& check) {
  const std::string page = figures_page_of(options.report);
  return check({{"--json", options.json}, {"--csv", options.csv}, {"--svg", options.svg}, {"--report", page}});
}

}  // namespace

Result<Competitor> competitor_named(const std::string& name, const scheduler::Policy& policy) {
  const io::NamedPolicy* const named = io::policy_named(name);
  const bool oracle = name == io::kOraclePolicy;
  const bool file = io::names_policy_file(name);
  if (named == nullptr && !oracle && !file) {
    return bad_input(fmt::format("{}, must be of {}, oracle, or a policy file", io::in_quotes(name),
                                 fmt::join(io::kPolicyNames, ", ")));
  }
  Competitor competitor{name, policy, file, oracle};
  if (named != nullptr) competitor.policy.kind = named->kind;
  return competitor;
}

Status read_policy_file(Competitor& competitor, std::vector<std::string>& errors) {
  const Result<io::PolicyFile> file = io::read_policy_file(competitor.name, competitor.policy, &errors);
  if (!file) return file.error();
  if (file.value().name == io::kOraclePolicy) {
    const Error taken =
        bad_input(fmt::format("{}: name = \"oracle\", must be another: the oracle has this one", competitor.name));
    errors.push_back(taken.message);
    return taken;
  }
  competitor.name = file.value().name;
  competitor.policy = file.value().policy;
  competitor.file = false;
  return Done{};
}

Status read_policy_files(CompareSettings& settings, std::vector<std::string>& errors) {
  if (settings.from_policy.file) {
    const Status read = read_policy_file(settings.from_policy, errors);
    if (!read) return read;
  }
  for (Competitor& competitor : settings.competitors) {
    if (!competitor.file) continue;
    const std::string file = competitor.name;
    Competitor filled = competitor;
    const Status read = read_policy_file(filled, errors);
    if (!read) return read;
    for (const Competitor& other : settings.competitors) {
      if (other.name != filled.name) continue;
      errors.push_back(fmt::format("{}: name = {}, is that of another policy", file, io::in_quotes(filled.name)));
      return bad_input(errors.back());
    }
    competitor = filled;
  }
  return Done{};
}

void add_compare_options(CLI::App& command, CompareOptions& options) {
  constexpr std::uint64_t kMany = std::numeric_limits<std::uint64_t>::max();
  add_scene(command, options.scene);
  command
      .add_option("--policies", options.policies,
                  fmt::format("Which policies, with commas: {}, oracle, or policy files (default {})",
                              fmt::join(io::kPolicyNames, ", "), options.policies))
      ->type_name("P,P,...");
  command
      .add_option("--budgets", options.budgets,
                  fmt::format("Budgets of a frame, with commas: work units or shares of full refinement (default {}), "
                              "with --clock wall ms (default {})",
                              kPercents, kMilliseconds))
      ->type_name("B,B,...");
  command.add_option("--clock", options.clock, "work: budgets count work; wall: they are time (default work)")
      ->check(one_of({"work", "wall"}))
      ->type_name("CLOCK");
  command
      .add_option("--from", options.from,
                  "Budget of the run that makes the states, in work units or as a share of full refinement, with "
                  "--clock wall in ms (default: everything is refined)")
      ->type_name("B");
  command
      .add_option("--from-policy", options.from_policy,
                  "Policy or policy file of the run that makes the states (default: that of the scene)")
      ->type_name("P");
  command.add_flag("--polygons", options.polygons, "The last level of meshes is their polygons");
  add_whole(command, "--frames", options.frames, 1, kMaxSceneFrames,
            fmt::format("How many states are compared (default {})", kDefaultFrames));
  add_whole(command, "--every", options.every, 1, kMaxSceneFrames,
            fmt::format("Frames from state to state (default {})", kDefaultEvery));
  add_whole(command, "--warmup", options.warmup, 0, kMaxSceneFrames,
            fmt::format("Frames before the first state (default {})", kDefaultWarmUp));
  add_whole(command, "--history", options.history, 1, 10000,
            "Frames that each policy steps by itself from a state; the last one is measured (default 1)");
  add_whole(command, "--bodies", options.bodies, 1, kMaxSceneBodies, "How many bodies the generators make together");
  add_whole(command, "--seed", options.seed, 0, kMany,
            "Seed of the scene, and of the intervals (default: the scene's)");
  add_whole(command, "--threads", options.threads, 0, 256, "Threads, 0 = as many as the machine has (default 0)");
  add_path(command, "--json", options.json, "Write the result as JSON (poise.compare/1), - for the standard output");
  add_path(command, "--csv", options.csv, "Write one row a policy and budget as CSV");
  add_path(command, "--svg", options.svg, "Draw E_seen against the budget");
  add_path(command, "--report", options.report,
           "Write a page into this folder that shows the comparison, and its curves as SVG and PNG (docs/viewing.md)");
  command.add_flag("--serve", options.serve,
                   "Read policies from the standard input, one a line, and answer each with a line of JSON "
                   "(poise.compare-steps/1); states and references are made once");
  add_tree_cache_options(command, options.tree_cache);
  command.add_flag("--quiet", options.quiet, "No progress and no table");
}

Result<CompareSettings> compare_settings(const CompareOptions& options, const scheduler::Policy& policy) {
  CompareSettings settings;
  const bool wall = options.clock == "wall";
  Status read = read_policies(options.policies, policy, settings.competitors);
  if (!read) return read.error();
  const std::string by_default = wall ? kMilliseconds : kPercents;
  read = read_budgets(options.budgets.empty() ? by_default : options.budgets, wall, settings);
  if (!read) return read.error();
  read = read_from(options.from, wall, settings);
  if (!read) return read.error();
  settings.from_policy.policy = policy;
  if (!options.from_policy.empty()) {
    const Result<Competitor> named = competitor_named(options.from_policy, policy);
    if (!named) return bad_input("--from-policy: " + named.error().message);
    if (named.value().oracle) return bad_input("--from-policy: the oracle knows single frames: it can make no run");
    settings.from_policy = named.value();
  }
  settings.warm_up = options.warmup.value_or(kDefaultWarmUp);
  settings.every = options.every.value_or(kDefaultEvery);
  settings.states = options.frames.value_or(kDefaultFrames);
  settings.history = options.history.value_or(1);
  const bool oracle = std::any_of(settings.competitors.begin(), settings.competitors.end(),
                                  [](const Competitor& competitor) { return competitor.oracle; });
  if (oracle && settings.history > 1)
    return bad_input("--policies oracle knows one frame: it cannot be asked with --history above 1");
  if (options.serve && !(options.json.empty() && options.csv.empty() && options.svg.empty() && options.report.empty()))
    return bad_input("--serve writes to the standard output alone: it excludes --json, --csv, --svg and --report");
  if (options.serve && options.scene == "-") return bad_input("--serve reads policies where SCENE = - reads a scene");
  if (options.csv == "-" || options.svg == "-") return bad_input("only --json can go to the standard output");
  if (options.report == "-") return bad_input("--report must be a folder");
  const Status files = with_outputs(options, [&](std::initializer_list<NamedFile> outputs) {
    Status apart = check_outputs(outputs, {{"SCENE", options.scene}, {"--from-policy", options.from_policy}});
    for (const Competitor& competitor : settings.competitors) {
      if (apart && competitor.file) apart = check_outputs(outputs, {{"--policies", competitor.name}});
    }
    return apart;
  });
  if (!files) return files.error();
  return settings;
}

Status check_compare_files(const CompareOptions& options, const Scene& scene) {
  return with_outputs(options,
                      [&](std::initializer_list<NamedFile> outputs) { return check_scene_files(outputs, scene); });
}

}  // namespace poise::app
