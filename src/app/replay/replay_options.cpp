// SPDX-License-Identifier: MIT
#include "app/replay/replay_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/files/output_files.h"
#include "app/files/scene_input.h"
#include "app/options/option_values.h"
#include "app/options/suggestions.h"
#include "app/report/report_files.h"
#include "app/run/body_table.h"
#include "poise/scene/scene.h"

namespace poise::app {
namespace {

// Calls check(all files that a replay writes).
template <class Check>
Status with_outputs(const ReplayOptions& options, Check&& check) {
  const std::string page = report_page_of(options.report);
  const std::string bodies = body_table_of(options.states);
  return check({{"--json", options.json},
                {"--states", options.states},
                {"the bodies of --states", bodies},
                {"--capture", options.capture.file},
                {"--picture", options.picture.file},
                {"--report", page}});
}

}  // namespace

void add_replay_options(CLI::App& command, ReplayOptions& options) {
  command.add_option("record", options.record, "A file of poise run --record")->required()->type_name("RECORD");
  add_whole(command, "--explain", options.explain, 0, kMaxSceneFrames,
            "Replay up to this frame (from 0, warm-up included) and tell which pairs it refined, in which order and "
            "why, and what it left coarse");
  add_whole(command, "--limit", options.limit, 0, UINT64_MAX,
            fmt::format("Rows of each list of --explain, 0 = all (default {})", kExplainedRows));
  command
      .add_option("--frames", options.frames,
                  "Replay at most N frames; or up to frame B, with captures, pictures and pages of A to B alone")
      ->type_name("N|A..B");
  add_whole(command, "--threads", options.threads, 0, 256, "Threads, 0 = as many as the machine has (default 0)");
  command.add_option("--executor", options.executor, "Threads by tbb, threads or serial (default: tbb where built in)")
      ->check(one_of({"tbb", "threads", "serial"}))
      ->type_name("E");
  add_path(command, "--files", options.files,
           "The folder that the scene's files are relative to (default: where it was when recorded)");
  add_path(command, "--json", options.json, "Write the result as JSON (poise.replay/2), - for the standard output");
  add_path(command, "--states", options.states,
           "Write every body after every frame as CSV, and beside it what each body is (FILE.bodies.csv)");
  add_capture_options(command, options.capture);
  add_path(command, "--report", options.report,
           "Write a page into this folder that shows the run: charts and a replay (docs/viewing.md); its capture goes "
           "there too, unless --capture names a file");
  add_picture_options(command, options.picture, "the last frame, or that of --frame");
  add_whole(command, "--frame", options.frame, 0, kMaxSceneFrames,
            "Replay up to this frame and draw it (--picture); 0 is the start");
  add_frames_dir(command, options.picture, "those of --frames");
  add_whole(command, "--frames-every", options.frames_every, 1, kMaxSceneFrames,
            "With --frames-dir: each N-th of them alone (default 1)");
  add_tree_cache_options(command, options.tree_cache);
  command.add_flag("--quiet", options.quiet, "No progress and no table");
}

Result<FrameRange> replayed_frames(const ReplayOptions& options) {
  if (options.frame) return FrameRange{0, *options.frame};
  if (options.frames.empty()) return FrameRange{};
  if (options.frames.find_first_not_of("0123456789") != std::string::npos)
    return parse_frame_range(options.frames, "N >= 1, ");
  const Result<FrameRange> up_to = parse_frame_range(".." + options.frames);
  if (!up_to || up_to.value().to == 0) return parse_frame_range(options.frames, "N >= 1, ");
  return up_to;
}

Status check_replay_options(const ReplayOptions& options) {
#ifndef POISE_APP_HAVE_TBB
  if (options.executor == "tbb") return bad_input("--executor tbb: this program was built without oneTBB");
#endif
  if (options.report == "-") return bad_input("--report must be a folder");
  if (options.states == "-") return bad_input("--states must be a file; only --json can go to the standard output");
  if (options.explain && !options.frames.empty())
    return bad_input("--frames has no meaning with --explain, which replays up to its frame");
  if (options.limit && !options.explain) return bad_input("--limit needs --explain");
  if (options.frame && options.picture.file.empty()) return bad_input("--frame needs --picture");
  if (options.frame && !options.frames.empty()) return bad_input("--frame and --frames cannot both be given");
  if (options.frame && options.explain) return bad_input("--frame and --explain cannot both be given");
  if (options.frames_every && options.picture.frames_dir.empty()) return bad_input("--frames-every needs --frames-dir");
  const Result<FrameRange> frames = replayed_frames(options);
  if (!frames) return frames.error();
  const Result<TreeCacheSettings> cache = tree_cache_settings(options.tree_cache);
  if (!cache) return cache.error();
  // A page holds a capture.
  CaptureOptions capture = options.capture;
  if (capture.file.empty() && !options.report.empty()) capture.file = report_capture_of(options.report);
  const Status captured = check_capture_options(capture);
  if (!captured) return captured;
  const Status pictures = check_picture_options(options.picture);
  if (!pictures) return pictures;
  return with_outputs(options, [&](std::initializer_list<NamedFile> outputs) {
    return check_outputs(outputs, {{"RECORD", options.record}});
  });
}

Status check_replay_files(const ReplayOptions& options, const Scene& scene) {
  return with_outputs(options,
                      [&](std::initializer_list<NamedFile> outputs) { return check_scene_files(outputs, scene); });
}

}  // namespace poise::app
