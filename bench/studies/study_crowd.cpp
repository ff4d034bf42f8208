// SPDX-License-Identifier: MIT
#include "studies/study_crowd.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "studies/crowd_run.h"

namespace poise::app {
namespace {

constexpr const char* kCrowdScene = "pile";
constexpr std::uint64_t kCrowdBodies = 250;
constexpr std::uint64_t kCrowdFrames = 120;
constexpr std::uint64_t kCrowdEvery = 6;
constexpr std::uint64_t kCrowdSeeds = 3;
constexpr std::uint64_t kCrowdMostBodies = 20'000;

// Chosen: from what hardly shows to what the leaves of the scene's meshes are wrong by (docs/levels.md).
constexpr std::array<simulation::ContactNoise, 9> kNoises = {{{1e-4, 0, 0},
                                                              {1e-3, 0, 0},
                                                              {3e-3, 0, 0},
                                                              {0, 3e-3, 0},
                                                              {0, 1e-2, 0},
                                                              {0, 3e-2, 0},
                                                              {0, 0, 3e-3},
                                                              {0, 0, 1e-2},
                                                              {0, 0, 5e-2}}};

io::StudyCell cell_of(double value) { return std::isfinite(value) ? io::StudyCell(value) : io::StudyCell(); }

const std::vector<io::StudyColumn> kLevelColumns = {{"level", "to level", 0},
                                                    {"frames", "frames", 0},
                                                    {"not_converged", "not converged", 0},
                                                    {"e_rel_p50", "E_rel, median", 3},
                                                    {"e_rel", "of all", 3},
                                                    {"false_percent", "false %", 1},
                                                    {"missed_percent", "missed %", 1},
                                                    {"contacts_e_rel_p50", "by contacts, median", 3},
                                                    {"contacts_e_rel", "of all", 3},
                                                    {"response_e_rel_p50", "by the response, median", 3},
                                                    {"response_e_rel", "of all", 3}};

const std::vector<io::StudyColumn> kNoiseColumns = {
    {"separation_mm", "separations mm", 1}, {"point_mm", "points mm", 0}, {"normal_mrad", "normals mrad", 0},
    {"e_rel_p50", "E_rel, median", 3},      {"e_rel", "of all", 3},       {"false_percent", "false %", 1},
    {"missed_percent", "missed %", 1}};

std::vector<io::StudyCell> level_row(const std::string& level, const CrowdFrames& frames) {
  return {level,
          std::uint64_t{frames.whole.frames()},
          std::uint64_t{frames.not_converged},
          cell_of(frames.whole.median()),
          cell_of(frames.whole.together()),
          cell_of(100 * frames.whole.false_share()),
          cell_of(100 * frames.whole.missed_share()),
          cell_of(frames.contacts.median()),
          cell_of(frames.contacts.together()),
          cell_of(frames.response.median()),
          cell_of(frames.response.together())};
}

std::vector<io::StudyCell> noise_row(const simulation::ContactNoise& noise, const CrowdErrors& errors) {
  return {1e3 * noise.separation_m,
          1e3 * noise.point_m,
          1e3 * noise.normal_rad,
          cell_of(errors.median()),
          cell_of(errors.together()),
          cell_of(100 * errors.false_share()),
          cell_of(100 * errors.missed_share())};
}

std::vector<LineChart> crowd_charts(const io::StudyTable& table) {
  LineChart chart{"crowd", "E_rel, median", "How far steps are from their references", "deepest level", {}};
  std::vector<std::string> names;
  for (const auto& row : table.rows) names.push_back(std::get<std::string>(row[0]));
  for (const auto& [column, label] :
       {std::pair("e_rel_p50", "the step"), std::pair("contacts_e_rel_p50", "its contacts, response converged"),
        std::pair("response_e_rel_p50", "its response")}) {
    const auto at = std::ranges::find(kLevelColumns, column, &io::StudyColumn::name) - kLevelColumns.begin();
    ChartLine line{label, {}, LineMarks::Dots};
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      if (const auto* value = std::get_if<double>(&table.rows[i][static_cast<std::size_t>(at)]))
        line.points.push_back({static_cast<double>(i), *value, {}, {}});
    }
    chart.lines.push_back(std::move(line));
  }
  name_places(chart, std::move(names), "deepest level");
  return {std::move(chart)};
}

Result<io::StudyTable> measured(const StudyCrowdOptions& o, const StudyScene& study, Progress& progress) {
  const Scene& scene = study.scene();
  const std::uint64_t frames = o.common.frames.value_or(kCrowdFrames);
  const std::uint64_t seeds = o.seeds.value_or(kCrowdSeeds);
  io::StudyTable table = begin_study("crowd", "poise study crowd");
  table.columns = kLevelColumns;
  table.facts = {{"scene", study.name()}, {"bodies", o.bodies.value_or(kCrowdBodies)},
                 {"frames", frames},      {"every", o.every.value_or(kCrowdEvery)},
                 {"seeds", seeds},        {"threads", static_cast<std::uint64_t>(study.threads())}};
  io::StudySummary noise{"noise", kNoiseColumns, {}};
  StepInput input;
  input.dt_s = scene.dt_s;
  input.backtracking = scene.backtracking;
  const auto begin = [&](std::uint64_t seed) {
    SceneRunOptions start = study.start_options();
    start.bodies = o.bodies.value_or(kCrowdBodies);
    start.seed = seed;
    start.world.sleeping = false;
    start.world.islands_wait = IslandsWait::Never;
    return SceneRun::create(scene, start);
  };
  Result<SceneRun> first = begin(1);
  if (!first) return first.error();
  for (const CrowdLevel& level : levels_of(first.value())) {
    const std::string name = level.polygons ? "polygons" : fmt::format("{}", level.max_level);
    CrowdFrames all;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      Result<SceneRun> run = begin(seed);
      if (!run) return run.error();
      const Status done = add_crowd_frames(
          run.value(), input, level, frames, o.every.value_or(kCrowdEvery),
          level.polygons ? std::span<const simulation::ContactNoise>(kNoises)
                         : std::span<const simulation::ContactNoise>(),
          [&](double share) { progress.share(fmt::format("to level {}, seed {}", name, seed), share); }, all);
      if (!done) return done.error();
    }
    table.rows.push_back(level_row(name, all));
    for (std::size_t n = 0; n < all.disturbed.size(); ++n)
      noise.rows.push_back(noise_row(kNoises[n], all.disturbed[n]));
  }
  table.summary = std::move(noise);
  return table;
}

}  // namespace

void add_study_crowd_options(CLI::App& command, StudyCrowdOptions& o) {
  add_whole(command, "--bodies", o.bodies, 1, kCrowdMostBodies, fmt::format("Population (default {})", kCrowdBodies));
  add_whole(command, "--frames", o.common.frames, 1, kMaxSceneFrames,
            fmt::format("Frames of each run (default {})", kCrowdFrames));
  add_whole(command, "--every", o.every, 1, kMaxSceneFrames,
            fmt::format("Compares each N-th frame (default {})", kCrowdEvery));
  add_whole(command, "--seeds", o.seeds, 1, 1000,
            fmt::format("Runs of each level, seeds 1 to N (default {})", kCrowdSeeds));
  command
      .add_option("--scene", o.common.scene,
                  fmt::format("A scene with generators, by file or name (default {})", kCrowdScene))
      ->type_name("SCENE");
  add_study_tables(command, o.common);
  command.footer(
      "Each row is of runs that refine every pair to one level. Their steps are compared with the converged response "
      "to\n"
      "the contacts of the polygons (the reference); by contacts: the converged response to the contacts of the "
      "level,\n"
      "likewise; by the response: the steps with that. The second table is of the runs by polygons: the converged\n"
      "response to contacts with random errors of these sizes.");
}

int study_crowd(const StudyCrowdOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound)
    return refuse("study crowd", sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  const Result<StudyScene> scene = StudyScene::make(o.common, kCrowdScene);
  if (!scene) return refuse("study crowd", scene.error());
  Progress progress(!o.common.quiet);
  const Result<io::StudyTable> table = measured(o, scene.value(), progress);
  progress.end();
  if (!table) return refuse("study crowd", table.error());
  const Status written = write_study(o.common, table.value(), crowd_charts(table.value()), 1);
  return written ? kExitDone : refuse("study crowd", written.error());
}

}  // namespace poise::app
