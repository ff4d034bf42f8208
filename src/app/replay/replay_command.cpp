// SPDX-License-Identifier: MIT
#include "app/replay/replay_command.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "app/files/output_files.h"
#include "app/options/tree_cache_options.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/process/until_it_fails.h"
#include "app/replay/replay_files.h"
#include "app/replay/replay_loop.h"
#include "app/replay/replay_options.h"
#include "app/run/run_options.h"
#include "app/run/states_writer.h"
#include "parallel/interrupt.h"
#include "record/record_shapes.h"
#include "scene/result_file.h"

namespace poise::app {
namespace {

/// The scene of a record, with its files where they are now.
Result<Scene> scene_of(const ReplayOptions& options, const io::RecordHeader& header) {
  const std::string folder = options.files.empty() ? header.scene_folder : options.files;
  Result<Scene> scene = parse_scene(header.scene_text, options.record + ": scene " + header.scene_source, folder);
  if (!scene) return scene;
  if (header.gaze) {
    const std::string name = options.record + ": gaze";
    if (!scene.value().camera) return bad_input(name + ": the recorded scene has no camera");
    Result<std::vector<GazeKey>> path = parse_gaze(*header.gaze, name, scene.value().camera->resolution_px);
    if (!path) return path.error();
    scene.value().gaze = SceneGaze{std::move(path).value(), true, header.gaze_loop, {}, *header.gaze};
  }
  const Status files = io::check_files(scene.value(), header.shapes);
  if (!files) return files.error();
  return scene;
}

Result<SceneRun> run_of(const ReplayOptions& options, const io::RecordHeader& header, const Scene& scene,
                        const parallel::Interrupt& interrupt, Progress& progress) {
  RunOptions threads;
  threads.executor = options.executor;
  SceneRunOptions start;
  start.world = replay_world(header, executor_kind(threads), static_cast<int>(options.threads.value_or(0)));
  start.bodies = header.bodies;
  start.seed = header.seed;
  start.tree_cache = tree_cache_settings(options.tree_cache).value();
  start.stop = interrupt.token();
  start.tree_progress = [&progress](double share) {
    progress.share("loading shapes and building sphere trees", share);
  };
  Result<SceneRun> run = SceneRun::create(scene, start);
  if (!run) return run;
  const Status shapes = io::check_shapes(scene, run.value().shapes(), header.shapes);
  if (!shapes) return shapes.error();
  const std::uint64_t hash = run.value().world().state_hash();
  if (hash != header.start_hash) {
    return bad_input(
        fmt::format("{}: the bodies stand otherwise at the start: state hash {:016x}, must be {:016x}: this program "
                    "places them otherwise than the one "
                    "that recorded",
                    options.record, hash, header.start_hash));
  }
  return run;
}

const char* build_of(const io::RecordHeader& header) {
  const io::BuildFacts build = io::this_build();
  return header.build.commit == build.commit && header.build.version == build.version ? "the same build"
                                                                                      : "another build";
}

std::string report(const ReplayResult& r) {
  if (r.differs) {
    return fmt::format("DIFFERENT after frame {}: state hash {:016x}, the record has {:016x}\n", *r.differs,
                       r.state_hash, r.recorded_hash);
  }
  std::string text = fmt::format("{} frames done again, the state the same to the bit after each; state hash {:016x}\n",
                                 r.frames, r.state_hash);
  if (r.damage) {
    text += fmt::format("DAMAGED after {} frames, at byte {} of the record: {}\n", r.frames, r.damage->byte,
                        r.damage->what);
  } else if (r.at_end) {
    text += r.run_stopped ? "the record is whole; its run was stopped by Ctrl-C or SIGTERM\n" : "the record is whole\n";
  }
  return text;
}

std::string table(const ReplayOptions& options, const io::RecordHeader& h, const ReplayResult& r, const World& world) {
  std::string text =
      fmt::format("{}: {}, recorded on {} threads ({}), {} clock, {}, {}\n", options.record, h.scene_name,
                  h.world.threads, executor_name(h.world.executor), h.clock, h.machine.processor, h.machine.system);
  text += fmt::format("made by poise {} commit {}, replayed on {} threads by {}\n", h.build.version, h.build.commit,
                      world.threads(), build_of(h));
  text += report(r);
  if (r.explained) text += "\n" + io::explain_table(*r.explained, options.limit.value_or(kExplainedRows));
  return text;
}

std::string json_of(const ReplayOptions& options, const io::RecordHeader& h, const ReplayResult& r,
                    const World& world) {
  using Json = nlohmann::ordered_json;
  Json damage = nullptr;
  if (r.damage) damage = {{"after_frames", r.frames}, {"byte", r.damage->byte}, {"what", r.damage->what}};
  Json json = {{"schema", "poise.replay/2"},
               {"record", options.record},
               {"scene", h.scene_name},
               {"recorded",
                {{"frames_asked", h.frames},
                 {"threads", h.world.threads},
                 {"executor", executor_name(h.world.executor)},
                 {"clock", h.clock},
                 {"version", h.build.version},
                 {"commit", h.build.commit},
                 {"processor", h.machine.processor},
                 {"system", h.machine.system}}},
               {"threads", world.threads()},
               {"frames", r.frames},
               {"same", !r.differs},
               {"first_difference", r.differs ? Json(*r.differs) : Json(nullptr)},
               {"whole", r.at_end   ? Json(true)
                         : r.damage ? Json(false)
                                    : Json(nullptr)},
               {"damage", damage},
               {"stopped", r.stopped},
               {"state_hash", fmt::format("{:016x}", r.state_hash)},
               {"explain", r.explained ? io::explain_json(*r.explained) : Json(nullptr)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

int exit_code(const ReplayOptions& options, const ReplayResult& r) {
  if (r.differs) return kExitRequirementFailed;
  if (r.stopped) return exit_stopped();
  if (r.damage)
    return refuse("replay", kExitBadInput,
                  fmt::format("{}: damaged at byte {}, after {} frames: {}", options.record, r.damage->byte, r.frames,
                              r.damage->what));
  if (options.explain && !r.explained) {
    return refuse("replay", kExitBadInput,
                  fmt::format("--explain {}: the record ends after frame {}", *options.explain,
                              r.frames == 0 ? 0 : r.frames - 1));
  }
  return kExitDone;
}

Status write_text(std::optional<io::AtomicFile>& file, const std::string& text) {
  const Status written = file->write(text);
  return written ? file->commit() : written;
}

int replay(const ReplayOptions& options) {
  const Status sound = check_replay_options(options);
  if (!sound) return refuse("replay", kExitBadUsage, sound.error().message);
  Result<io::RecordReader> record = io::RecordReader::open(options.record);
  if (!record) return refuse("replay", record.error());
  const io::RecordHeader& header = record.value().header();
  const Result<Scene> scene = scene_of(options, header);
  if (!scene) return refuse("replay", scene.error());
  const Status apart = check_replay_files(options, scene.value());
  if (!apart) return refuse("replay", kExitBadUsage, apart.error().message);
  const parallel::Interrupt interrupt;
  Status all = Done{};
  std::optional<io::AtomicFile> json = open_file(options.json, all);
  Result<StatesWriter> states = StatesWriter::open(options.states);
  if (!states) add_failure(states.error(), all);
  Result<ReplayFiles> outputs = ReplayFiles::open(options);
  if (!outputs) add_failure(outputs.error(), all);
  // A pipe that nobody reads is waited for, until a signal.
  if (!all) return refuse("replay", interrupt.asked() ? stopped_error() : all.error());
  if (!options.quiet) warn_of_threads("replay", static_cast<int>(options.threads.value_or(0)));
  Progress progress(!options.quiet);
  progress.say("loading shapes and building sphere trees");
  Result<SceneRun> run = run_of(options, header, scene.value(), interrupt, progress);
  if (!run) {
    progress.end();
    return refuse("replay", interrupt.asked() ? stopped_error(kStoppedLoading) : run.error());
  }
  if (interrupt.asked()) return refuse("replay", stopped_error(kStoppedLoading));
  const Status begun = outputs.value().begin(header, scene.value(), run.value());
  if (!begun && begun.error().kind != ErrorKind::OutputFailed) return refuse("replay", begun.error());
  const auto tell = [&](std::uint64_t frame, std::span<const io::NumberedState> now) {
    return states.value().add(scene.value(), run.value(), frame, static_cast<double>(frame) * header.dt_s, now);
  };
  const auto told = [&](std::uint64_t done, std::uint64_t of) {
    progress.share("replaying", of > 0 ? std::min(1.0, static_cast<double>(done) / static_cast<double>(of)) : 1.0);
  };
  const FrameRange frames = replayed_frames(options).value();
  const ReplaySettings settings{frames.to == FrameRange{}.to ? std::nullopt : std::optional(frames.to), options.explain,
                                interrupt.token(), options.capture.pairs ? std::optional(frames.from) : std::nullopt};
  const Result<ReplayResult> result =
      replay_loop(record.value(), scene.value(), run.value(), settings,
                  {until_it_fails("replay", states.value().on() ? ReplayStates(tell) : ReplayStates(), progress),
                   until_it_fails("replay", outputs.value().capture_sink(), progress),
                   until_it_fails("replay", outputs.value().picture_sink(), progress), told});
  progress.end();
  if (!result) return refuse("replay", result.error());
  const World& world = run.value().world();
  Status written = Done{};
  const std::string document = options.json.empty() ? std::string() : json_of(options, header, result.value(), world);
  if (json) written = write_text(json, document);
  if (options.json == "-") written = io::write_stdout(document);
  add_failure(states.value().finish(), written);
  const Status derived = outputs.value().finish(result.value());
  add_failure(derived, written);
  if (!options.quiet && options.json != "-" && (derived || derived.error().kind == ErrorKind::OutputFailed))
    add_failure(io::write_stdout(table(options, header, result.value(), world) + outputs.value().told()), written);
  if (!written) return refuse("replay", written.error());
  if (options.quiet && result.value().differs) print_error("poise replay: {}", report(result.value()));
  return exit_code(options, result.value());
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command = app.add_subcommand("replay", "Do a recorded run again, bit for bit, and explain a frame");
  add_replay_options(*command, *options);
  command->footer(
      "Examples:\n"
      "  poise run pile --deadline 4 --record pile.poise\n"
      "  poise replay pile.poise --threads 1\n"
      "  poise replay pile.poise --explain 200 --limit 40\n"
      "  poise replay pile.poise --picture heap.png --frame 200 --camera 9,-9,6:0,0,1\n"
      "  poise replay pile.poise --report out --frames 100..200   and then open out/report.html\n"
      "  poise replay pile.poise --frames-dir film --frames-every 2\n\n"
      "Exit codes: 0 the state is that of the record after each frame, 1 it differs, 2 bad usage, 3 bad input or a "
      "record that is cut short or "
      "damaged (what could be read was replayed), 4 output failed, 130 stopped by Ctrl-C, 143 by SIGTERM.");
  command->callback([options, &exit_code] { exit_code = replay(*options); });
}

}  // namespace poise::app
