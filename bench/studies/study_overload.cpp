// SPDX-License-Identifier: MIT
#include "studies/study_overload.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "scene/run/milliseconds.h"

namespace poise::app {
namespace {

constexpr const char* kOverloadScene = "jacks";
constexpr std::uint64_t kOverloadBodies = 2000;
constexpr std::uint64_t kOverloadSettle = 600;
constexpr std::uint64_t kOverloadHold = 60;
// What is poured in takes longer to come to rest.
constexpr std::uint64_t kPopulationHold = 180;
constexpr double kLeastDemand = 0.5;
constexpr double kMostDemand = 4;
// On the work clock a heap at rest has almost nothing to refine, and so no demand. Chosen.
constexpr double kWorkShake_mps = 0.5;

bool wall_clock(const StudyOverloadOptions& o) { return o.clock != "work"; }

Status check(const StudyOverloadOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound) return sound;
  const std::uint64_t hold = o.hold.value_or(o.drive == "population" ? kPopulationHold : kOverloadHold);
  if (o.reference_every && *o.reference_every > hold / 2)
    return bad_input(fmt::format(
        "--reference-every {}: must be at most half of --hold {}, so that one is due in the second half of each step",
        *o.reference_every, hold));
  return Done{};
}

OverloadSettings settings_of(const StudyOverloadOptions& o, bool population) {
  OverloadSettings settings;
  settings.population = population;
  settings.wall_clock = wall_clock(o);
  settings.bodies = o.bodies.value_or(kOverloadBodies);
  settings.settle = o.settle.value_or(kOverloadSettle);
  settings.hold = o.hold.value_or(population ? kPopulationHold : kOverloadHold);
  settings.shake.speed_mps = o.shake_mps.value_or(settings.wall_clock ? 0 : kWorkShake_mps);
  settings.reference_every = o.reference_every;
  settings.steps = simulation::overload_steps(kLeastDemand, o.most.value_or(kMostDemand));
  return settings;
}

// One line up and one back for a figure of a drive.
LineChart overload_chart(const io::StudyTable& table, const std::string& drive, const std::string& column,
                         const std::string& label) {
  LineChart chart{fmt::format("{}-{}", drive,
                              column == "level_mean"   ? "level"
                              : column == "e_seen_mps" ? "error"
                                                       : "potential"),
                  fmt::format("{} driven: {}", drive, label),
                  "Demand goes up, then comes back.",
                  "demand",
                  {},
                  {},
                  true};
  chart.y_from_data = column == "potential_relative";
  for (const char* way : {"up", "back"}) {
    std::vector<LinePoint> points = io::study_points(table, "demand", column, {{"drive", drive}, {"way", way}});
    std::ranges::sort(points, {}, &LinePoint::x);
    chart.lines.push_back({way == std::string_view("up") ? "demand goes up" : "and back", std::move(points)});
  }
  return chart;
}

std::vector<LineChart> overload_charts(const io::StudyTable& table, const std::vector<std::string>& drives,
                                       bool references) {
  std::vector<LineChart> charts;
  for (const std::string& drive : drives) {
    charts.push_back(overload_chart(table, drive, "level_mean", "mean level"));
    charts.push_back(references
                         ? overload_chart(table, drive, "e_seen_mps", "E seen, m/s")
                         : overload_chart(table, drive, "potential_relative", "potential energy / without a limit"));
  }
  return charts;
}

// Drives as asked, one after the other. Ctrl-C is caught here alone: gnuplot catches it for itself.
Result<io::StudyTable> measured(const StudyOverloadOptions& o, const StudyScene& scene,
                                const std::vector<std::string>& drives) {
  const OverloadSettings common = settings_of(o, false);
  io::StudyTable table =
      begin_study("overload", common.wall_clock ? "poise study overload" : "poise study overload --clock work");
  table.facts = {{"scene", scene.name()},
                 {"clock", std::string(common.wall_clock ? "wall" : "work")},
                 {"bodies", common.bodies},
                 {"settle_frames", common.settle},
                 {"shake_mps", common.shake.speed_mps},
                 {"threads", static_cast<std::uint64_t>(scene.threads())}};
  Progress progress(!o.common.quiet);
  const parallel::Interrupt interrupt;
  for (const std::string& drive : drives) {
    const std::string doing = fmt::format("{} driven", drive);
    progress.say(doing);
    const OverloadSettings settings = settings_of(o, drive == "population");
    const Result<OverloadDrive> driven = drive_overload(
        scene.scene(), scene.start_options(), settings, [&](double share) { progress.share(doing, share); },
        &interrupt);
    if (!driven) {
      progress.end();
      return driven.error();
    }
    add_overload_part(overload_part(settings, driven.value()), table);
  }
  progress.end();
  return table;
}

}  // namespace

void add_study_overload_options(CLI::App& command, StudyOverloadOptions& o) {
  command.add_option("--drive", o.drive, "What changes the demand: deadline, population or both (default both)")
      ->check(CLI::IsMember({"deadline", "population", "both"}))
      ->type_name("D");
  add_study_clock(command, o.clock);
  add_whole(command, "--bodies", o.bodies, 1, kMaxSceneBodies / 100,
            fmt::format("Bodies at demand 1 (default {})", kOverloadBodies));
  add_number(command, "--most", o.most, 0.5, true, 100, fmt::format("Largest demand (default {:g})", kMostDemand));
  add_whole(command, "--settle", o.settle, 1, kMaxSceneFrames,
            fmt::format("Frames without a limit before (default {})", kOverloadSettle));
  add_whole(command, "--hold", o.hold, 10, 100'000,
            fmt::format("Frames at each demand (default {}; {} where the population is driven)", kOverloadHold,
                        kPopulationHold));
  add_number(command, "--shake", o.shake_mps, 0, false, 1000,
             fmt::format("Change the velocity of each body by this many m/s once in 16 frames (default 0; {:g} with "
                         "--clock work)",
                         kWorkShake_mps));
  add_whole(command, "--reference-every", o.reference_every, 1, 50'000,
            "Measure the error of each N-th driven frame against its reference");
  add_study_outputs(command, o.common, kOverloadScene);
  command.footer(
      "Examples:\n"
      "  poise study overload --markdown overload.md --picture overload.png      a few minutes; nothing else should "
      "run\n"
      "  poise study overload --drive deadline --most 8 --reference-every 20 --json -\n"
      "  poise study overload --clock work --bodies 500 --threads 1\n\n"
      "A scene settles without a limit. Then its demand is driven by half octaves from 0.5 to 4 and back: by the "
      "deadline, which is\n"
      "the median time of a settled frame / demand, or by the population, which is poured in and taken out while the "
      "deadline stays. A row\n"
      "is a demand held; its figures are of the second half of its frames, its late frames of all. The last table is "
      "the loop: what\n"
      "differs most between the ways up and back, and how many frames after demand fell to 1 the levels were back.");
}

OverloadPart overload_part(const OverloadSettings& settings, const OverloadDrive& drive) {
  OverloadPart part;
  part.drive = settings.population ? "population" : "deadline";
  part.wall_clock = settings.wall_clock;
  part.unit = drive.unit;
  const std::span<const simulation::RunFrame> frames = drive.frames;
  const std::span<const simulation::RunFrame> unlimited = drive.unlimited;
  std::size_t fits = frames.size();
  for (std::size_t k = 0; k < settings.steps.size(); ++k) {
    const simulation::OverloadStep& step = settings.steps[k];
    const std::size_t first = k * settings.hold;
    part.rows.push_back(
        simulation::overload_row(step, frames.subspan(first, settings.hold), unlimited.subspan(first, settings.hold)));
    if (!step.up && step.demand <= 1 + 1e-9) fits = std::min(fits, first);
  }
  part.loops = simulation::overload_loops(part.rows);
  part.recovery = simulation::recovery(frames.subspan(fits), unlimited.subspan(fits));
  return part;
}

void add_overload_part(const OverloadPart& part, io::StudyTable& table) {
  const auto cell = [](const std::optional<double>& value) { return value ? io::StudyCell(*value) : io::StudyCell(); };
  const auto late = [&](std::uint64_t count) { return part.wall_clock ? io::StudyCell(count) : io::StudyCell(); };
  table.columns = {{"drive", "driven", 0},
                   {"way", "way", 0},
                   {"demand", "demand", 2},
                   {"deadline_ms", "deadline ms", 2},
                   {"budget_work", "budget, expansions", 0},
                   {"bodies", "bodies", 0},
                   {"level_mean", "level", 2},
                   {"left_share", "pairs left coarse (share)", 3},
                   {"infeasible", "late: infeasible", 0},
                   {"machine", "machine", 0},
                   {"own", "forecast + overrun", 0},
                   {"frames", "of frames", 0},
                   {"p50_ms", "p50 ms", 2},
                   {"p99_ms", "p99 ms", 2},
                   {"held_mean", "bodies that waited", 0},
                   {"potential_relative", "height / without a limit", 4},
                   {"kinetic_j", "kinetic J", 2},
                   {"e_seen_mps", "E seen m/s", 4}};
  for (const simulation::OverloadRow& row : part.rows) {
    const FrameLimit limit = limit_of(part.unit, part.drive == "population" ? 1 : row.demand, part.wall_clock);
    table.rows.push_back({part.drive, std::string(row.up ? "up" : "back"), row.demand,
                          limit.deadline ? io::StudyCell(ms(*limit.deadline)) : io::StudyCell(),
                          limit.work_units ? io::StudyCell(*limit.work_units) : io::StudyCell(), row.bodies,
                          cell(row.level_mean), row.left_share, late(row.infeasible), late(row.machine), late(row.own),
                          row.frames, row.p50_ms, row.p99_ms, row.held_mean, cell(row.potential_relative),
                          row.kinetic_j, cell(row.e_seen_mps)});
  }
  if (!table.summary) table.summary = io::StudySummary{"loops", {}, {}};
  std::vector<io::StudyColumn>& columns = table.summary->columns;
  columns = {{"drive", "back minus up, largest: driven", 0}, {"unit_ms", "", 3}, {"unit_work", "", 1}};
  std::vector<io::StudyCell> row = {part.drive, part.unit.frame_ms, part.unit.work_units};
  for (const simulation::OverloadLoop& loop : part.loops) {
    columns.push_back({loop.name, loop.name, 3});
    columns.push_back({loop.name + "_at_demand", "", 2});
    row.push_back(cell(loop.difference));
    row.push_back(loop.difference ? io::StudyCell(loop.demand) : io::StudyCell());
  }
  columns.push_back({"recovery_frames", "frames until levels were back", 0});
  row.push_back(part.recovery.frames    ? io::StudyCell(*part.recovery.frames)
                : part.recovery.defined ? io::StudyCell(std::string("never"))
                                        : io::StudyCell());
  table.summary->rows.push_back(row);
}

int study_overload(const StudyOverloadOptions& o) {
  const Status sound = check(o);
  if (!sound)
    return refuse("study overload", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  const Result<StudyScene> scene = StudyScene::make(o.common, kOverloadScene);
  if (!scene) return refuse("study overload", scene.error());
  const std::vector<std::string> drives =
      o.drive == "both" ? std::vector<std::string>{"deadline", "population"} : std::vector<std::string>{o.drive};
  const Result<io::StudyTable> table = measured(o, scene.value(), drives);
  if (!table) return refuse("study overload", table.error());
  const Status written =
      write_study(o.common, table.value(), overload_charts(table.value(), drives, o.reference_every.has_value()), 2);
  return written ? kExitDone : refuse("study overload", written.error());
}

}  // namespace poise::app
