// SPDX-License-Identifier: MIT
#include "app/run/run_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "app/capture/run_capture.h"
#include "app/files/scene_input.h"
#include "app/process/exit_codes.h"
#include "app/process/process_memory.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/report/report_files.h"
#include "app/run/run_loop.h"
#include "app/run/run_options.h"
#include "app/run/run_outputs.h"
#include "app/run/run_trace.h"
#include "capture/observe.h"
#include "parallel/executor.h"
#include "parallel/interrupt.h"
#include "poise/scene/scene.h"
#include "scene/run/policy_name.h"
#include "scene/run/requirement.h"
#include "scene/run/run_document.h"
#include "scene/scene_gaze.h"

namespace poise::app {
namespace {

LoopSettings loop_settings(const RunOptions& options, const Scene& scene) {
  LoopSettings loop;
  loop.frames = options.frames.value_or(scene.frames);
  loop.warm_up = options.warmup.value_or(0);
  loop.dt_s = scene.dt_s;
  loop.wall_clock = options.clock == "wall";
  const auto of_ms = [](double ms) { return Nanoseconds(static_cast<std::int64_t>(ms * 1e6)); };
  loop.deadline = of_ms(options.deadline_ms.value_or(scene.deadline_ms.value_or(1000 * scene.dt_s)));
  loop.paced = options.paced;
  const std::optional<double> reserve_ms = scene.host_work ? scene.host_work->reserve_ms : std::nullopt;
  loop.host_work = of_ms(options.host_work_ms.value_or(reserve_ms.value_or(0)));
  if (loop.wall_clock) loop.render_load = render_load_of(options.time, scene, options.seed.value_or(scene.seed));
  loop.learn_host_work = loop.render_load.any() && !options.host_work_ms && !reserve_ms;
  loop.budget_work = options.budget_work;
  loop.max_level = static_cast<Level>(options.max_level.value_or(scene.max_level));
  loop.polygons = options.max_level ? options.polygons : scene.polygons;
  loop.backtracking = scene.backtracking;
  loop.reference_every = options.reference_every;
  loop.states_every = options.states_every.value_or(1);
  return loop;
}

/// Everything that is known before the first frame.
io::RunDocument document_of(const RunOptions& options, const Scene& scene, const SceneRun& run,
                            const LoopSettings& loop) {
  io::RunDocument d;
  d.scene = scene.name;
  d.scene_file = scene.source;
  d.frames_asked = loop.frames;
  d.dt_s = loop.dt_s;
  d.seed = options.seed.value_or(scene.seed);
  d.threads = run.world().threads();
  const WorldSettings world = world_settings(options, scene);
  d.executor = executor_name(world.executor);
  d.policy = io::policy_name(world.policy.kind);
  d.policy_weights = world.policy;
  d.contact = options.contact;
  d.clock = options.clock;
  d.affinity = world.processors;
  d.realtime_priority = world.realtime_priority;
  d.spin_us = static_cast<double>(world.spin.count()) / 1e3;
  d.paced = loop.paced;
  if (loop.wall_clock) d.deadline_ms = static_cast<double>(loop.deadline.count()) / 1e6;
  d.host_work_ms = static_cast<double>(loop.host_work.count()) / 1e6;
  d.host_work_learned = loop.learn_host_work;
  d.render_load_ms = static_cast<double>(loop.render_load.mean.count()) / 1e6;
  d.render_load_jitter_ms = static_cast<double>(loop.render_load.jitter.count()) / 1e6;
  d.alpha = world.alpha;
  d.budget_work = loop.budget_work;
  d.max_level = loop.max_level;
  d.polygons = loop.polygons;
  d.backtracking = loop.backtracking;
  d.sleeping = world.sleeping;
  d.islands_wait = world.islands_wait;
  d.reference_every = loop.reference_every;
  d.tray_side_m = run.tray_side_m();
  d.machine = io::this_machine();
  d.build = io::this_build();
  for (std::size_t i = 0; i < scene.shapes.size(); ++i) {
    const bool at_origin = std::holds_alternative<SphereSource>(scene.shapes[i].source) ||
                           std::holds_alternative<PlaneSource>(scene.shapes[i].source);
    if (!at_origin) d.origin_offsets_m.emplace_back(scene.shapes[i].name, run.shapes()[i]->origin_offset_m);
  }
  d.warnings = run.warnings();
  d.tree_cache_use = run.tree_cache_use();
  d.requirement = options.require;
  d.record = options.record;
  d.figures = simulation::run_figures({}, {loop.wall_clock, world.alpha});
  return d;
}

io::TimePriorsKey priors_key_of(const io::RunDocument& d) {
  return {d.machine.processor + ", " + d.machine.system, d.machine.cores, d.threads, d.executor, d.contact, d.alpha};
}

void add_results(const SceneRun& run, const LoopSettings& loop, const LoopResult& result, io::RunDocument& d) {
  d.bodies = run.bodies().size();
  for (const RunBody& body : run.bodies()) d.dynamic_bodies += body.motion == MotionType::Dynamic ? 1 : 0;
  for (const simulation::RunFrame& frame : result.frames)
    d.dynamic_bodies_max = std::max(d.dynamic_bodies_max, frame.report.bodies);
  d.stopped = result.stopped;
  d.figures = simulation::run_figures(result.frames, {loop.wall_clock, d.alpha});
  d.start = result.start;
  d.end = result.end;
  d.energy_max_j = result.energy_max_j;
  d.state_hash = run.world().state_hash();
}

/// What the system does not permit, with the option that asked for it.
std::string placing_refused(const RunOptions& options, const Error& error) {
  const bool both = !options.affinity.empty() && options.realtime;
  return fmt::format("{}: {}",
                     both               ? "--affinity, --realtime"
                     : options.realtime ? "--realtime"
                                        : "--affinity",
                     error.message);
}

Status begin_capture(const io::RunDocument& document, const LoopSettings& loop, const Scene& scene, SceneRun& run,
                     RunCapture& capture) {
  if (!capture.on()) return Done{};
  capture::CaptureHeader header = capture::header_of(scene, run);
  header.dt_s = document.dt_s;
  header.deadline_ms = document.deadline_ms;
  header.paced = document.paced;
  header.frames_asked = loop.warm_up + loop.frames;
  header.policy = document.policy;
  header.contact = document.contact;
  return capture.begin(scene, run, std::move(header),
                       document.paced ? RunCapture::WhenFull::LeaveOut : RunCapture::WhenFull::Wait);
}

/// From a scene that stands to the exit code.
int run_prepared(const RunOptions& options, const io::Requirement& requirement, const Scene& scene,
                 const std::string& scene_text, SceneRun& run, RunOutputs& outputs,
                 const parallel::Interrupt& interrupt, Progress& progress) {
  LoopSettings loop = loop_settings(options, scene);
  std::optional<Trace> trace;
  if (outputs.trace) loop.trace = &trace.emplace(kTraceRoom);
  io::RunDocument document = document_of(options, scene, run, loop);
  for (const std::string& warning : document.warnings) {
    progress.end();
    print_error("poise run: warning: {}\n", warning);
  }
  const Status known = io::check_names(requirement, io::named_figures(document));
  if (!known) return refuse("run", kExitBadUsage, "--require: " + known.error().message);

  const std::filesystem::path priors_folder =
      loop.wall_clock ? time_priors_folder(options.time) : std::filesystem::path();
  const io::TimePriorsKey priors_key = priors_key_of(document);
  if (const auto priors = io::read_time_priors(priors_folder, priors_key)) {
    run.world().set_time_priors(*priors);
    document.time_priors_frames = priors->frames;
  }
  // From here on there is a first frame, and all files of it.
  if (interrupt.asked()) return refuse("run", stopped_error(kStoppedLoading));
  for (const Status& begun : {outputs.record.begin(options, scene, scene_text, run, loop),
                              begin_capture(document, loop, scene, run, outputs.capture)}) {
    // What cannot be written is told by its sink and at the end, and takes nothing from the others.
    if (!begun && begun.error().kind != ErrorKind::OutputFailed) return refuse("run", begun.error());
  }
  std::uint64_t missed = 0;
  std::uint64_t done = 0;
  const auto told = [&](const simulation::RunFrame& frame) {
    missed += frame.releases_skipped + (frame.report.lateness.count() > 0 ? 1 : 0);
    progress.frame(++done, loop.warm_up + loop.frames, missed, run.bodies().size());
  };
  const RunSinks sinks = sinks_of(scene, run, loop, outputs, progress);
  const Result<LoopResult> result = run_loop(run, loop, interrupt, sinks.states, told, sinks.record, sinks.capture);
  progress.end();
  if (!result) return refuse("run", result.error());

  const scheduler::TimePriors learned = run.world().time_priors();
  if (learned.frames >= kFramesToKeep) io::write_time_priors(priors_folder, priors_key, learned);
  add_results(run, loop, result.value(), document);
  const Status written = write_results(
      {options, requirement, scene, run, loop, result.value(), trace ? &*trace : nullptr}, document, outputs);
  for (const std::string& failed : document.requirements_failed) print_error("poise run: --require: {}\n", failed);
  if (!written) return refuse("run", written.error());
  if (document.stopped) return exit_stopped();
  return document.requirements_failed.empty() ? kExitDone : kExitRequirementFailed;
}

int run_scene(const RunOptions& options) {
  const Status sound = check_run_options(options);
  if (!sound) return refuse("run", kExitBadUsage, sound.error().message);
  io::Requirement requirement;
  if (options.require) {
    Result<io::Requirement> parsed = io::parse_requirement(*options.require);
    if (!parsed) return refuse("run", kExitBadUsage, "--require: " + parsed.error().message);
    requirement = std::move(parsed).value();
  }
  const Result<SceneText> text = read_scene_argument(options.scene, "run", options.quiet);
  if (!text) return refuse("run", text.error());
  std::vector<std::string> errors;
  Result<Scene> scene = parse_scene_text(text.value(), errors);
  for (const std::string& error : errors) refuse("run", kExitBadInput, error);
  if (!scene) return exit_code_of(scene.error());
  const Status apart = check_run_files(options, scene.value());
  if (!apart) return refuse("run", kExitBadUsage, apart.error().message);
  const Status policy = apply_to_scene(options, scene.value(), errors);
  for (const std::string& error : errors) refuse("run", kExitBadInput, error);
  if (!policy) return exit_code_of(policy.error());
  if (options.bodies && scene.value().generators.empty()) {
    return refuse("run", kExitBadUsage, "--bodies: the scene " + scene.value().name + " has no generators");
  }
  if (!options.gaze.empty() && !scene.value().camera)
    return refuse("run", kExitBadUsage, "--gaze: the scene " + scene.value().name + " has no camera");
  if (!options.gaze.empty()) {
    Result<SceneGaze> gaze = io::read_gaze_file(options.gaze, scene.value().camera->resolution_px);
    if (!gaze) return refuse("run", gaze.error());
    scene.value().gaze = std::move(gaze).value();
  }
  const Status gaze_read = read_gaze(scene.value());
  if (!gaze_read) return refuse("run", gaze_read.error());
  const Status kept =
      check_memory_of_frames(loop_settings(options, scene.value()), max_memory_bytes(options.max_memory_mib));
  if (!kept) return refuse("run", kept.error());
  // Before the first file is made, so that no signal leaves one.
  const parallel::Interrupt interrupt;
  Result<RunOutputs> outputs = RunOutputs::open(options);
  // A pipe that nobody reads is waited for, until a signal.
  if (!outputs) return refuse("run", interrupt.asked() ? stopped_error() : outputs.error());
  Progress progress(!options.quiet);
  progress.say("loading shapes and building sphere trees");
  SceneRunOptions start;
  start.world = world_settings(options, scene.value());
  start.bodies = options.bodies;
  start.seed = options.seed;
  start.max_memory_bytes = max_memory_bytes(options.max_memory_mib);
  start.stop = interrupt.token();
  start.tree_progress = [&progress](double share) {
    progress.share("loading shapes and building sphere trees", share);
  };
  if (!options.quiet) warn_of_threads("run", start.world.threads);
  const Result<TreeCacheSettings> cache = tree_cache_settings(options.tree_cache);
  if (!cache) return refuse("run", kExitBadUsage, cache.error().message);
  start.tree_cache = cache.value();
  // Told before the shapes are loaded. The main thread is placed last, because threads inherit its place.
  parallel::ExecutorSettings threads;
  threads.kind = start.world.executor;
  threads.processors = start.world.processors;
  threads.realtime_priority = start.world.realtime_priority;
  const Status permitted = parallel::check_executor(threads);
  if (!permitted) return refuse("run", kExitBadInput, placing_refused(options, permitted.error()));
  Result<SceneRun> run = SceneRun::create(scene.value(), start);
  if (run) {
    const Status placed = parallel::place_this_thread(threads.processors.empty() ? -1 : threads.processors.front(),
                                                      threads.realtime_priority);
    if (!placed) return refuse("run", kExitBadInput, placing_refused(options, placed.error()));
  }
  if (!run) {
    progress.end();
    return interrupt.asked() ? refuse("run", stopped_error(kStoppedLoading)) : refuse("run", run.error());
  }
  if (run.value().tree_cache_use().not_writable > 0) {
    progress.end();
    print_error("poise run: warning: {}\n", tree_cache_warning(cache.value()));
  }
  return run_prepared(options, requirement, scene.value(), text.value().text, run.value(), outputs.value(), interrupt,
                      progress);
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Simulate a scene under a deadline");
  add_run_options(*command, *options);
  command->footer(
      "Examples:\n"
      "  poise run pile --deadline 16 --paced --json report.json\n"
      "  poise run jacks --bodies 500 --deadline 8 --report out   and then open out/report.html\n"
      "  poise run jacks --bodies 5000 --frames 300 --require 'miss_rate < 0.01'\n"
      "  poise run gas --clock work --budget-work 2000 --states states.csv\n"
      "  poise run pile --deadline 4 --record pile.poise   and then   poise replay pile.poise --explain 200\n"
      "  poise run pile --deadline 4 --reference every=60 --require 'reference.e_rel_p50 < 0.2'\n\n"
      "Exit codes: 0 done, 1 --require does not hold, 2 bad usage, 3 bad input, 4 output failed, 130 stopped by "
      "Ctrl-C, 143 by SIGTERM.");
  command->callback([options, &exit_code] { exit_code = run_scene(with_report(*options)); });
}

}  // namespace poise::app
