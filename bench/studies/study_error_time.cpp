// SPDX-License-Identifier: MIT
#include "studies/study_error_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "scene/run/percentiles.h"
#include "scene/run/policy_name.h"

namespace poise::app {
namespace {

constexpr const char* kErrorTimeScene = "jacks";
constexpr std::uint64_t kErrorTimeBodies = 300;
constexpr std::uint64_t kErrorTimeMostBodies = 100'000;
constexpr std::uint64_t kErrorTimeThreads = 1;  // the other engines have one

const std::vector<io::StudyColumn> kErrorTimeColumns = {{"group", "steps by", 0},
                                                        {"setting", "setting", 2},
                                                        {"unit", "of", 0},
                                                        {"states", "states", 0},
                                                        {"time_p50_ms", "ms", 3},
                                                        {"time_p25_ms", "p25", 3},
                                                        {"time_p75_ms", "p75", 3},
                                                        {"e_rel", "E_rel", 3},
                                                        {"e_rel_low", "from", 3},
                                                        {"e_rel_high", "to", 3},
                                                        {"e_seen_mps", "E_seen m/s", 4},
                                                        {"e_seen_low_mps", "from", 4},
                                                        {"e_seen_high_mps", "to", 4},
                                                        {"own_e_rel", "of its own limit", 3},
                                                        {"false_contacts_percent", "false contacts %", 1}};

const char* unit_of(const StepMethod& method) {
  switch (method.kind) {
    case SettingKind::Deadline:
      return "ms";
    case SettingKind::Level:
      return "level";
    case SettingKind::Iterations:
      return "iterations";
  }
  return "";
}

bool counts(const io::ComparedStep& step) { return step.converged && step.e_rel && step.e_seen_mps; }

// Which states count for a group: those in which every setting of it was measured against a reference that has
// converged, so that its rows differ in nothing but the setting.
std::vector<std::size_t> states_of(const ErrorTimeRun& run, const std::string& group) {
  std::vector<std::size_t> states;
  for (std::size_t i = 0; i < run.methods.front().steps.size(); ++i) {
    const bool all = std::ranges::all_of(
        run.methods, [&](const MethodRun& method) { return method.method.group != group || counts(method.steps[i]); });
    if (all) states.push_back(i);
  }
  return states;
}

io::StudyCell cell_of(const std::optional<double>& value) { return value ? io::StudyCell(*value) : io::StudyCell(); }

// One row: a method over the states that count for its group.
std::vector<io::StudyCell> row_of(const MethodRun& method, const std::vector<std::size_t>& states, std::uint64_t seed) {
  io::ComparedSteps steps;
  steps.budgets = {0};
  steps.policies = {method.method.group};
  std::vector<double> times_ms;
  double own = 0;
  std::size_t with_own = 0;
  for (const std::size_t state : states) {
    steps.steps.push_back(method.steps[state]);
    times_ms.push_back(method.steps[state].time_ms);
    if (method.own_e_rel.empty() || !method.own_e_rel[state]) continue;
    own += *method.own_e_rel[state];
    ++with_own;
  }
  const io::PolicyComparison figures = io::compare_steps(steps, seed);
  const io::ComparisonRow& row = figures.rows.front();
  const auto time_ms = [&](double share) { return simulation::percentile(times_ms, share); };
  return {method.method.group,
          method.method.setting,
          std::string(unit_of(method.method)),
          static_cast<std::uint64_t>(states.size()),
          time_ms(0.5),
          time_ms(0.25),
          time_ms(0.75),
          row.e_rel.mean,
          cell_of(row.e_rel.low),
          cell_of(row.e_rel.high),
          row.e_seen_mps.mean,
          cell_of(row.e_seen_mps.low),
          cell_of(row.e_seen_mps.high),
          with_own > 0 ? io::StudyCell(own / static_cast<double>(with_own)) : io::StudyCell(),
          row.false_rate ? io::StudyCell(100 * *row.false_rate) : io::StudyCell()};
}

// The curves of one measure against time.
LineChart chart_of(const io::StudyTable& table, const char* id, const std::array<const char*, 3>& measure,
                   const char* title) {
  const auto of = [&](std::size_t column, const std::string& group) {
    return io::study_points(table, "time_p50_ms", measure[column], {{"group", group}});
  };
  LineChart chart{
      id,   title, "Each line is a way to step, each dot a setting of it.", "median time of a step, ms", {}, {},
      true, true};
  chart.x_measured = true;
  for (const std::vector<io::StudyCell>& row : table.rows) {
    const std::string group = std::get<std::string>(row.front());
    if (!chart.lines.empty() && chart.lines.back().label == group) continue;
    std::vector<LinePoint> points = of(0, group);
    const std::vector<LinePoint> low = of(1, group), high = of(2, group);
    // Levels take about the same time, so there is neither a line through them nor a band.
    const bool is_curve = group != kLevelsGroup;
    // A group has the same states in all rows: one state has no interval in any.
    for (std::size_t i = 0; is_curve && i < low.size(); ++i) {
      points[i].low = low[i].y;
      points[i].high = high[i].y;
    }
    std::ranges::sort(points, {}, &LinePoint::x);
    chart.lines.push_back({group, std::move(points), is_curve ? LineMarks::LineAndDots : LineMarks::Dots});
  }
  return chart;
}

ErrorTimeSettings settings_of(const StudyErrorTimeOptions& o, const Scene& scene) {
  ErrorTimeSettings settings;
  settings.bodies = o.bodies.value_or(kErrorTimeBodies);
  settings.seed = scene.seed;
  settings.warm_up = o.common.warmup.value_or(settings.warm_up);
  settings.states = o.states.value_or(settings.states);
  settings.every = o.every.value_or(settings.every);
  settings.history = o.history.value_or(settings.history);
  settings.deadlines_ms = o.deadlines_ms.empty() ? std::vector<double>{0.4, 0.6, 0.8, 1.2, 2} : o.deadlines_ms;
  settings.iterations = o.iterations.empty() ? std::vector<int>{4, 10, 32, 100} : o.iterations;
  for (const std::string& name : o.policies.empty() ? std::vector<std::string>{"perceptual", "random"} : o.policies) {
    scheduler::Policy policy = scene.policy;
    policy.kind = io::policy_named(name)->kind;
    settings.policies.push_back(policy);
  }
  std::ranges::sort(settings.deadlines_ms);
  std::ranges::sort(settings.iterations);
  return settings;
}

}  // namespace

io::StudyTable error_time_table(const ErrorTimeRun& run, std::uint64_t seed) {
  io::StudyTable table = begin_study("error-time", "poise study error-time");
  table.columns = kErrorTimeColumns;
  const std::uint64_t states = run.methods.empty() ? 0 : run.methods.front().steps.size();
  std::uint64_t least = states;
  for (const MethodRun& method : run.methods) {
    const std::vector<std::size_t> counted = states_of(run, method.method.group);
    least = std::min<std::uint64_t>(least, counted.size());
    if (!counted.empty()) table.rows.push_back(row_of(method, counted, seed));
  }
  table.facts = {{"states", states},
                 {"states_that_count_at_least", least},
                 {"engines", run.engines.empty() ? io::StudyCell(run.why_none)
                                                 : io::StudyCell(fmt::format("{}", fmt::join(run.engines, "; ")))}};
  return table;
}

std::vector<LineChart> error_time_charts(const io::StudyTable& table) {
  return {
      chart_of(table, "relative-error", {"e_rel", "e_rel_low", "e_rel_high"},
               "relative error of the change of velocities"),
      chart_of(table, "seen-error", {"e_seen_mps", "e_seen_low_mps", "e_seen_high_mps"}, "error as it is seen, m/s")};
}

void add_study_error_time_options(CLI::App& command, StudyErrorTimeOptions& o) {
  add_whole(command, "--bodies", o.bodies, 1, kErrorTimeMostBodies,
            fmt::format("Bodies (default {})", kErrorTimeBodies));
  add_whole(command, "--states", o.states, 1, kMaxSceneFrames, "States that are stepped from (default 16)");
  add_whole(command, "--every", o.every, 1, kMaxSceneFrames, "Frames from state to state (default 10)");
  add_whole(command, "--warmup", o.common.warmup, 0, kMaxSceneFrames, "Frames before the first state (default 60)");
  add_whole(command, "--history", o.history, 1, kMaxSceneFrames,
            "Frames that each steps by itself from a state; the last one is measured (default 10)");
  command.add_option("--deadlines", o.deadlines_ms, "Deadlines in ms, with commas (default 0.4,0.6,0.8,1.2,2)")
      ->delimiter(',')
      ->check(numbers_within(0.001, 1e6))
      ->type_name("LIST");
  command.add_option("--policies", o.policies, "Policies under deadlines, with commas (default perceptual,random)")
      ->delimiter(',')
      ->check(CLI::IsMember(std::vector<std::string>(io::kPolicyNames.begin(), io::kPolicyNames.end())))
      ->type_name("LIST");
  command
      .add_option("--iterations", o.iterations,
                  "Iterations of the solvers of other engines, with commas (default 4,10,32,100)")
      ->delimiter(',')
      ->check(CLI::Range(1, 100'000))
      ->type_name("LIST");
  add_study_outputs(command, o.common, kErrorTimeScene, kErrorTimeThreads);
  command.footer(
      "Examples:\n"
      "  poise study error-time --markdown error-time.md --picture error-time.png      four minutes\n"
      "  poise study error-time --bodies 100 --states 4 --iterations 10 --json -\n\n"
      "From each state each way to step goes on by itself; its last frame is held against the reference of the state "
      "in "
      "which\n"
      "that frame began. Whatever an engine models otherwise than Poise counts as its error there; *of its own limit* "
      "is "
      "its\n"
      "error against itself with 3,000 iterations. Engines have one thread, so by default Poise has one too. Words and "
      "figures: "
      "docs/priorities.md.");
}

int study_error_time(const StudyErrorTimeOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound)
    return refuse("study error-time", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  StudyTimesOptions common = o.common;
  common.threads = common.threads.value_or(kErrorTimeThreads);
  const Result<StudyScene> scene = StudyScene::make(common, kErrorTimeScene);
  if (!scene) return refuse("study error-time", scene.error());
  Scene awake = scene.value().scene();
  awake.sleeping = false;
  const ErrorTimeSettings settings = settings_of(o, awake);
  SceneRunOptions start = scene.value().start_options();
  start.bodies = settings.bodies;
  start.world.policy = awake.policy;
  start.world.sleeping = false;
  start.world.islands_wait = IslandsWait::Never;
  Progress progress(!o.common.quiet);
  const Result<ErrorTimeRun> run =
      error_time_run(awake, start, settings, [&](double share) { progress.share("states", share); });
  progress.end();
  if (!run) return refuse("study error-time", run.error());
  io::StudyTable table = error_time_table(run.value(), settings.seed);
  if (table.rows.empty()) {
    return refuse("study error-time", kExitBadInput,
                  "no state counts: nothing touches, or no reference converged; take a later --warmup");
  }
  table.facts.insert(table.facts.begin(), {{"scene", scene.value().name()},
                                           {"bodies", settings.bodies},
                                           {"history", settings.history},
                                           {"threads", static_cast<std::uint64_t>(scene.value().threads())}});
  const Status written = write_study(common, table, error_time_charts(table), 2);
  return written ? kExitDone : refuse("study error-time", written.error());
}

}  // namespace poise::app
