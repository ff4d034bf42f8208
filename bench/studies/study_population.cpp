// SPDX-License-Identifier: MIT
#include "studies/study_population.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "studies/child_command.h"

namespace poise::app {
namespace {

constexpr const char* kPopulationScene = "jacks";
constexpr double kPopulationDeadline_ms = 16;
constexpr std::uint64_t kPopulationFrames = 600;
// A reference of more bodies takes seconds a frame. Chosen.
constexpr std::uint64_t kReferenceBodies = 2000;
// Deadlines by which the median frame may be late before larger populations are left out: they would take hours.
constexpr double kTooManyLate = 12;

bool wall_clock(const StudyPopulationOptions& o) { return o.clock != "work"; }

Status check(const StudyPopulationOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound) return sound;
  if (wall_clock(o) && o.budget_work) return bad_input("--budget-work needs --clock work");
  if (!wall_clock(o) && !o.budget_work) return bad_input("--clock work needs --budget-work");
  if (!wall_clock(o) && o.common.deadline_ms) return bad_input("--deadline has no meaning with --clock work");
  if (!wall_clock(o) && o.hold == "on")
    return bad_input("--hold on has no meaning with --clock work: islands wait under a deadline alone");
  if (o.reference_most_bodies && !o.reference_every)
    return bad_input("--reference-most-bodies needs --reference-every");
  return Done{};
}

std::vector<std::uint64_t> populations(const StudyPopulationOptions& o) {
  std::vector<std::uint64_t> bodies =
      o.bodies.empty() ? std::vector<std::uint64_t>{1000, 2000, 5000, 10'000, 20'000, 50'000, 100'000} : o.bodies;
  std::ranges::sort(bodies);
  return bodies;
}

std::vector<bool> holds(const StudyPopulationOptions& o) {
  if (!wall_clock(o) || o.hold == "off") return {false};
  return o.hold == "on" ? std::vector<bool>{true} : std::vector<bool>{true, false};
}

StudyTimesOptions with_deadline(const StudyPopulationOptions& o) {
  StudyTimesOptions common = o.common;
  if (!common.deadline_ms) common.deadline_ms = kPopulationDeadline_ms;
  return common;
}

std::optional<std::uint64_t> reference_of(const StudyPopulationOptions& o, std::uint64_t bodies) {
  return bodies <= o.reference_most_bodies.value_or(kReferenceBodies) ? o.reference_every : std::nullopt;
}

// One row measured in this process.
Result<std::vector<io::StudyCell>> row_here(const StudyPopulationOptions& o, const StudyScene& scene,
                                            Progress& progress) {
  StudyRun run;
  run.bodies = populations(o).front();
  run.frames = o.common.frames.value_or(kPopulationFrames);
  run.deadline = wall_clock(o);
  run.budget_work = o.budget_work;
  run.islands_wait = holds(o).front();
  run.sleeping = o.sleeping;
  run.reference_every = reference_of(o, run.bodies);
  StudyRunCost cost;
  const auto frames = scene.run(
      run, fmt::format("{} bodies{}", run.bodies, run.islands_wait ? ", islands may wait" : ""), progress, &cost);
  if (!frames) return frames.error();
  return population_row(run, cost, frames.value());
}

// The same in a child process.
Result<std::vector<io::StudyCell>> row_of_child(const StudyPopulationOptions& o, std::uint64_t bodies, bool hold,
                                                const parallel::Interrupt& interrupt) {
  std::vector<std::string> words = {
      "study",    "population",          "--here", "--json", "-", "--hold", hold ? "on" : "off",
      "--bodies", std::to_string(bodies)};
  const StudyTimesOptions& common = o.common;
  if (!common.scene.empty()) words.insert(words.end(), {"--scene", common.scene});
  if (common.deadline_ms) words.insert(words.end(), {"--deadline", fmt::format("{}", *common.deadline_ms)});
  if (!o.clock.empty()) words.insert(words.end(), {"--clock", o.clock});
  if (common.tree_cache.folder) words.insert(words.end(), {"--tree-cache", *common.tree_cache.folder});
  if (common.tree_cache.off) words.emplace_back("--no-tree-cache");
  if (common.quiet) words.emplace_back("--quiet");
  if (o.sleeping) words.emplace_back("--sleeping");
  const std::pair<const char*, const std::optional<std::uint64_t>*> numbers[] = {
      {"--frames", &common.frames},
      {"--threads", &common.threads},
      {"--budget-work", &o.budget_work},
      {"--reference-every", &o.reference_every},
      {"--reference-most-bodies", &o.reference_most_bodies}};
  for (const auto& [name, value] : numbers) {
    if (*value) words.insert(words.end(), {name, std::to_string(**value)});
  }
  const Result<ChildResult> child = run_child(words, interrupt);
  if (!child) return child.error();
  if (interrupt.asked()) return stopped_error();
  if (child.value().exit_code != kExitDone)
    return bad_input(fmt::format("the process with {} bodies ended with {}", bodies, child.value().exit_code));
  return io::first_row_of(child.value().out, population_columns());
}

double number_in(const std::vector<io::StudyCell>& row, const std::string& name) {
  const std::vector<io::StudyColumn> columns = population_columns();
  const auto at = std::ranges::find(columns, name, &io::StudyColumn::name) - columns.begin();
  const auto* value = std::get_if<double>(&row[static_cast<std::size_t>(at)]);
  return value != nullptr ? *value : 0;
}

Result<io::StudyTable> measured(const StudyPopulationOptions& o, const StudyScene& scene) {
  io::StudyTable table = begin_study("population", "poise study population");
  table.columns = population_columns();
  table.facts = {{"scene", scene.name()},
                 {"frames", o.common.frames.value_or(kPopulationFrames)},
                 {"deadline_ms", wall_clock(o) ? io::StudyCell(scene.deadline_ms()) : io::StudyCell()},
                 {"budget_work", o.budget_work ? io::StudyCell(*o.budget_work) : io::StudyCell()},
                 {"threads", static_cast<std::uint64_t>(scene.threads())}};
  if (o.here) {
    Progress progress(!o.common.quiet);
    Result<std::vector<io::StudyCell>> row = row_here(o, scene, progress);
    progress.end();
    if (!row) return row.error();
    table.rows.push_back(std::move(row).value());
    return table;
  }
  const parallel::Interrupt interrupt;
  std::optional<std::uint64_t> last;
  const std::vector<std::uint64_t> all = populations(o);
  for (const std::uint64_t bodies : all) {
    bool late = wall_clock(o);
    for (const bool hold : holds(o)) {
      Result<std::vector<io::StudyCell>> row = row_of_child(o, bodies, hold, interrupt);
      if (!row) return row.error();
      late = late && too_late(number_in(row.value(), "p50_ms"), scene.deadline_ms());
      table.rows.push_back(std::move(row).value());
    }
    if (!late || bodies == all.back()) continue;
    last = bodies;
    break;
  }
  // Null where every population was run.
  table.facts.emplace_back("stopped_after_bodies", last ? io::StudyCell(*last) : io::StudyCell());
  if (last)
    print_error(
        "poise study population: with {} bodies the median frame is more than {:g} deadlines late; larger "
        "populations were left out\n",
        *last, kTooManyLate);
  return table;
}

std::vector<LineChart> population_charts(const io::StudyTable& table, double deadline_ms) {
  LineChart times{"frame-time", "99 of 100 frames take at most, ms", "",   "bodies",
                  {},           {{"deadline", deadline_ms, {}}},     true, true};
  LineChart levels{"levels", "mean level in the last third", "", "bodies", {}, {}, true};
  for (const bool hold : {true, false}) {
    const std::vector<io::StudyFilter> only = {{"islands_wait", hold ? "yes" : "no"}};
    const char* name = hold ? "islands may wait" : "every body in every frame";
    times.lines.push_back({name, io::study_points(table, "bodies", "p99_ms", only)});
    levels.lines.push_back({name, io::study_points(table, "bodies", "level_last", only)});
  }
  return {std::move(times), std::move(levels)};
}

}  // namespace

void add_study_population_options(CLI::App& command, StudyPopulationOptions& o) {
  command
      .add_option("--bodies", o.bodies,
                  "Populations, with commas between them (default 1000,2000,5000,10000,20000,50000,100000)")
      ->delimiter(',')
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1'000'000}))
      ->type_name("LIST");
  add_whole(command, "--frames", o.common.frames, 3, kMaxSceneFrames,
            fmt::format("Frames of each run (default {})", kPopulationFrames));
  add_number(command, "--deadline", o.common.deadline_ms, 0, true, 1e6,
             fmt::format("Deadline of a frame in ms (default {:g})", kPopulationDeadline_ms));
  command.add_option("--hold", o.hold, "Whether islands may wait: on, off or both (default both)")
      ->check(CLI::IsMember({"on", "off", "both"}))
      ->type_name("H");
  command.add_flag("--sleeping", o.sleeping, "Let bodies at rest fall asleep (default: the scene's)");
  add_study_clock(command, o.clock);
  add_whole(command, "--budget-work", o.budget_work, 0, std::uint64_t{1} << 40U,
            "With --clock work: refinement a frame in node-pair expansions");
  add_whole(command, "--reference-every", o.reference_every, 1, kMaxSceneFrames,
            "Measure the error of each N-th frame against its reference (of more than one frame in 100 the frames "
            "after, whose caches are cold, are seen in p99)");
  add_whole(command, "--reference-most-bodies", o.reference_most_bodies, 1, 1'000'000,
            fmt::format("Largest population with references, which also take memory (default {})", kReferenceBodies));
  command.add_flag("--here", o.here, "Measure one population in this process")->group("");
  add_study_outputs(command, o.common, kPopulationScene);
  command.footer(
      "Examples:\n"
      "  poise study population --markdown population.md --picture population.png      an hour; nothing else should "
      "run\n"
      "  poise study population --bodies 1000,2000,5000 --reference-every 120 --json -\n"
      "  poise study population --bodies 1000000 --frames 60 --hold on\n\n"
      "Each population runs from its start in a process of its own, once with islands that may wait and "
      "once without. Memory\n"
      "is what the scene adds to the process. Larger populations are left out once the median frame is more than 12 "
      "deadlines late.");
}

bool too_late(double p50_ms, double deadline_ms) { return p50_ms - deadline_ms > kTooManyLate * deadline_ms; }

int study_population(const StudyPopulationOptions& o) {
  const Status sound = check(o);
  if (!sound)
    return refuse("study population", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  const Result<StudyScene> scene = StudyScene::make(with_deadline(o), kPopulationScene);
  if (!scene) return refuse("study population", scene.error());
  const Result<io::StudyTable> table = measured(o, scene.value());
  if (!table) return refuse("study population", table.error());
  const Status written =
      write_study(o.common, table.value(), population_charts(table.value(), scene.value().deadline_ms()), 2);
  return written ? kExitDone : refuse("study population", written.error());
}

}  // namespace poise::app
