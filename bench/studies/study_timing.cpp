// SPDX-License-Identifier: MIT
#include "studies/study_timing.h"

#include <fmt/format.h>

#include <cstdio>

#include "app/files/output_files.h"
#include "app/files/scene_files.h"
#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/run/run_options.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

void add_shared(CLI::App& command, StudyTimingOptions& o, bool timed) {
  if (timed) {
    command.add_option("--scene", o.scene, "A scene with generators (default jacks)")->type_name("SCENE");
    command.add_option("--executor", o.executor, "Threads by tbb, threads or serial (default: tbb where built in)")
        ->check(CLI::IsMember({"tbb", "threads", "serial"}))
        ->type_name("E");
    add_tree_cache_options(command, o.tree_cache);
  }
  add_path(command, "--json", o.json, "Write the rows as JSON, - for the standard output");
  add_path(command, "--markdown", o.markdown, "Write the table for docs, - for the standard output");
  command.add_flag("--quiet", o.quiet, "No table and no progress");
}

}  // namespace

void add_study_cost_options(CLI::App& command, StudyTimingOptions& o) {
  command.add_option("--bodies", o.bodies, "Populations (default 2000 8000 20000)")
      ->check(CLI::Range(std::uint64_t{1}, kMaxSceneBodies))
      ->type_name("N...");
  add_whole(command, "--frames", o.frames, 1, kMaxSceneFrames,
            "Frames that are timed in each state and round (default 60)");
  add_whole(command, "--skip", o.skip, 0, kMaxSceneFrames, "Frames before the falling ones (default 40)");
  add_whole(command, "--settle", o.settle, 0, kMaxSceneFrames,
            "Frames before the settled ones, from the start (default 600)");
  add_number(command, "--deadline", o.deadline_ms, 0, true, 1e6,
             "Deadline of a frame in ms (default: none, every pair is refined)");
  add_whole(command, "--rounds", o.rounds, 1, 100, "How often all populations are run in turn (default 1)");
  add_whole(command, "--threads", o.threads, 0, 256, "Threads, 0 = as many as the machine has (default 0)");
  add_shared(command, o, true);
  command.footer(
      "Example:\n"
      "  poise study cost --markdown cost.md --json cost.json     what docs/deadlines.md shows; takes minutes\n"
      "  poise study cost --bodies 200 --frames 10 --settle 60 --markdown -\n\n"
      "Under a deadline that does not fit, islands wait, and stages do less. Times are of the wall: run it on a quiet "
      "machine.");
}

void add_study_cache_options(CLI::App& command, StudyTimingOptions& o) {
  command.add_option("--bodies", o.bodies, "Population (default 10000)")
      ->expected(1)
      ->check(CLI::Range(std::uint64_t{1}, kMaxSceneBodies))
      ->type_name("N");
  add_whole(command, "--frames", o.frames, 1, kMaxSceneFrames,
            "Frames that start anew (default 40); three times as many do not");
  add_whole(command, "--settle", o.settle, 0, kMaxSceneFrames, "Frames before those (default 1300)");
  add_whole(command, "--threads", o.threads, 0, 256, "Threads, 0 = as many as the machine has (default 0)");
  add_shared(command, o, true);
  command.footer(
      "Example:\n"
      "  poise study cache --markdown cache.md     what docs/deadlines.md shows; takes a minute\n\n"
      "Without a limit, so that all pairs are at their deepest level in both. To start anew, every body is moved away "
      "and back before the frame.");
}

void add_study_scaling_options(CLI::App& command, StudyTimingOptions& o) {
  command
      .add_option("--threads", o.thread_counts,
                  "Numbers of threads (default 1 2 4 8 16 as far as the machine has them)")
      ->check(CLI::Range(1, 256))
      ->type_name("N...");
  command.add_option("--bodies", o.bodies, "Population (default 4000; 20000 with --span)")
      ->expected(1)
      ->check(CLI::Range(std::uint64_t{1}, kMaxSceneBodies))
      ->type_name("N");
  add_whole(command, "--frames", o.frames, 1, kMaxSceneFrames,
            "Frames that are timed for each number (default 40; 60 in each state with --span)");
  add_whole(command, "--settle", o.settle, 0, kMaxSceneFrames,
            "Frames before them (default 400; 600 before the settled ones with --span)");
  command.add_flag("--span", o.span,
                   "Count work and critical path of whole frames on one thread instead, stage by stage");
  add_whole(command, "--skip", o.skip, 0, kMaxSceneFrames, "With --span: frames before the falling ones (default 100)");
  add_shared(command, o, true);
  command.footer(
      "Example:\n"
      "  poise study scaling --threads 1 2 --markdown scaling.md\n"
      "  poise study scaling --span --markdown span.md\n\n"
      "A World for each number of threads, all in the same state; they step in turn, so that what the machine does "
      "meanwhile meets all of them alike. Each timed frame starts\n"
      "anew and has time for every level of every pair, in the order of the policy.\n"
      "With --span one thread does all work and times each chunk of each parallel loop, and what is between loops. The "
      "span is what is left on any number of cores: the\n"
      "serial parts and the longest chunk of each loop.");
}

void add_study_free_options(CLI::App& command, StudyTimingOptions& o) {
  command.add_option("--bodies", o.bodies, "Population (default 40)")
      ->expected(1)
      ->check(CLI::Range(std::uint64_t{2}, std::uint64_t{100000}))
      ->type_name("N");
  add_whole(command, "--frames", o.frames, 1, 100000, "Frames (default 20)");
  add_shared(command, o, false);
  command.footer(
      "Example:\n"
      "  poise study free --markdown free.md     what docs/deadlines.md shows; needs valgrind, takes about a "
      "minute\n\n"
      "Runs this program under valgrind's callgrind, on one thread and by the work clock, and counts the instructions "
      "inside World::step. Exit code 1 where\n"
      "a feature that is off has a function of its own called.");
}

Status check_timing_options(const StudyTimingOptions& o) {
  if (o.json == "-" && o.markdown == "-")
    return bad_input("only one of --json and --markdown can go to the standard output");
  if (o.span && !o.thread_counts.empty()) return bad_input("--threads has no meaning with --span: one thread counts");
#ifndef POISE_APP_HAVE_TBB
  if (o.executor == "tbb") return bad_input("--executor tbb: this program was built without oneTBB");
#endif
  const Result<TreeCacheSettings> cache = tree_cache_settings(o.tree_cache);
  if (!cache) return cache.error();
  return check_outputs({{"--json", o.json}, {"--markdown", o.markdown}}, {{"--scene", o.scene}});
}

ExecutorKind timed_executor(const StudyTimingOptions& o, int threads) {
  if (threads == 1) return ExecutorKind::Serial;
  RunOptions run;
  run.executor = o.executor;
  return executor_kind(run);
}

Result<SceneRun> timed_scene(const StudyTimingOptions& o, std::uint64_t bodies, int threads) {
  const Result<std::filesystem::path> file = find_scene(o.scene);
  if (!file) return file.error();
  const Result<Scene> scene = read_scene(file.value());
  if (!scene) return scene.error();
  if (scene.value().generators.empty())
    return bad_input("--scene " + o.scene + ": must have generators, so that it can have any number of bodies");
  SceneRunOptions start;
  start.world.policy = scene.value().policy;
  start.world.executor = timed_executor(o, threads);
  start.world.threads = threads;
  start.bodies = bodies;
  start.tree_cache = tree_cache_settings(o.tree_cache).value();
  return SceneRun::create(scene.value(), start);
}

Status forget_pairs(SceneRun& run) {
  World& world = run.world();
  for (const RunBody& body : run.bodies()) {
    if (body.motion != MotionType::Dynamic) continue;
    const Result<BodyState> state = world.state(body.id);
    if (!state) return state.error();
    BodyState away = state.value();
    away.position_m.x() += 1.0;
    Status moved = world.set_state(body.id, away);
    if (moved) moved = world.set_state(body.id, state.value());
    if (!moved) return moved;
  }
  return Done{};
}

io::MeasuredBy measured_by(const StudyTimingOptions& o, int threads) {
  io::MeasuredBy by;
  by.machine = io::this_machine();
  by.build = io::this_build();
  by.threads = threads;
  by.executor = executor_name(timed_executor(o, threads));
  return by;
}

int write_timing(const StudyTimingOptions& o, const char* study, const std::string& json, const std::string& markdown,
                 std::vector<LineChart> charts) {
  if (o.page_charts != nullptr) *o.page_charts = std::move(charts);
  Status written = write_to(o.json, json);
  add_failure(write_to(o.markdown, markdown), written);
  if (o.json != "-" && o.markdown != "-" && !o.quiet) add_failure(io::write_stdout(markdown), written);
  if (written) return kExitDone;
  print_error("poise study {}: {}\n", study, written.error().message);
  return exit_code_of(written.error());
}

}  // namespace poise::app
