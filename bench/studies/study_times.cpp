// SPDX-License-Identifier: MIT
#include "studies/study_times.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/files/output_files.h"
#include "app/files/scene_files.h"
#include "app/options/option_values.h"
#include "app/process/process_memory.h"
#include "app/process/refusal.h"
#include "app/run/run_options.h"
#include "parallel/executor.h"
#include "scene/result_file.h"
#include "scene/run/milliseconds.h"
#include "studies/gnuplot.h"
#include "studies/study_draw.h"

namespace poise::app {

void add_study_outputs(CLI::App& command, StudyTimesOptions& o, const std::string& default_scene,
                       std::uint64_t default_threads) {
  command
      .add_option("--scene", o.scene,
                  fmt::format("A scene with generators, by file or name (default {})", default_scene))
      ->type_name("SCENE");
  add_study_files(command, o, "Draw the figures as a PNG (needs gnuplot)", default_threads);
  add_path(command, "--svg", o.picture.svg, "The same as an SVG, light or dark as the browser prefers");
}

void add_study_tables(CLI::App& command, StudyTimesOptions& o, std::uint64_t default_threads) {
  add_whole(command, "--threads", o.threads, 0, 256,
            fmt::format("Threads, 0 = as many as the machine has (default {})", default_threads));
  add_path(command, "--json", o.json, "Write the rows as JSON, - for the standard output");
  add_path(command, "--markdown", o.markdown, "Write the table for docs, - for the standard output");
  add_tree_cache_options(command, o.tree_cache);
  command.add_flag("--quiet", o.quiet, "No table and no progress");
}

void add_study_files(CLI::App& command, StudyTimesOptions& o, const std::string& picture,
                     std::uint64_t default_threads) {
  add_plot_files(command, o.picture, picture);
  add_study_tables(command, o, default_threads);
}

void add_study_clock(CLI::App& command, std::string& clock) {
  command
      .add_option("--clock", clock,
                  "wall: keep deadlines; work: count work, the same bits on any number of threads (default wall)")
      ->check(CLI::IsMember({"wall", "work"}))
      ->type_name("CLOCK");
}

void add_study_deadline(CLI::App& command, StudyTimesOptions& o) {
  add_number(command, "--deadline", o.deadline_ms, 0, true, 1e6,
             "Deadline of a frame in ms (default: the scene's, else its time step)");
}

void add_study_times_options(CLI::App& command, StudyTimesOptions& o, const std::string& default_scene,
                             std::uint64_t default_frames, std::uint64_t default_warm_up) {
  add_whole(command, "--frames", o.frames, 2, kMaxSceneFrames,
            fmt::format("Measured frames a run (default {})", default_frames));
  add_whole(command, "--warmup", o.warmup, 0, kMaxSceneFrames,
            fmt::format("Frames before those, apart from the figures (default {})", default_warm_up));
  add_study_deadline(command, o);
  add_study_outputs(command, o, default_scene);
}

Status check_study_times(const StudyTimesOptions& o) {
  if (o.json == "-" && o.markdown == "-")
    return bad_input("only one of --json and --markdown can go to the standard output");
  const Status picture = check_plot_files(o.picture);
  if (!picture) return picture;
  const Result<TreeCacheSettings> cache = tree_cache_settings(o.tree_cache);
  if (!cache) return cache.error();
  const Status apart = check_outputs({{"--json", o.json},
                                      {"--markdown", o.markdown},
                                      {"--picture", o.picture.png},
                                      {"--picture-dark", o.picture.png_dark},
                                      {"--svg", o.picture.svg}},
                                     {{"--scene", o.scene}});
  return apart ? can_write({o.json, o.markdown, o.picture.png, o.picture.png_dark, o.picture.svg}) : apart;
}

Result<StudyScene> StudyScene::make(const StudyTimesOptions& options, const std::string& default_scene) {
  const Result<std::filesystem::path> file = find_scene(options.scene.empty() ? default_scene : options.scene);
  if (!file) return file.error();
  Result<Scene> scene = read_scene(file.value());
  if (!scene) return scene.error();
  if (scene.value().generators.empty())
    return bad_input(
        fmt::format("--scene: {} has no generators, so its population cannot be chosen", scene.value().name));
  StudyScene made;
  made.scene_ = std::move(scene).value();
  made.options_ = options;
  return made;
}

double StudyScene::deadline_ms() const {
  return options_.deadline_ms.value_or(scene_.deadline_ms.value_or(1000 * scene_.dt_s));
}

int StudyScene::threads() const {
  const auto asked = static_cast<int>(options_.threads.value_or(0));
  return asked > 0 ? asked : parallel::available_threads();
}

SceneRunOptions StudyScene::start_options() const {
  SceneRunOptions start;
  start.world = world_settings(RunOptions{}, scene_);
  start.world.threads = static_cast<int>(options_.threads.value_or(0));
  start.tree_cache = tree_cache_settings(options_.tree_cache).value();
  return start;
}

Result<std::vector<simulation::RunFrame>> StudyScene::run(const StudyRun& run, const std::string& doing,
                                                          Progress& progress, StudyRunCost* cost) const {
  progress.say(doing);
  SceneRunOptions start = start_options();
  start.world.alpha = run.alpha;
  if (!run.islands_wait) start.world.islands_wait = IslandsWait::Never;
  start.world.sleeping = start.world.sleeping || run.sleeping;
  start.bodies = run.bodies;
  const parallel::Interrupt interrupt;
  start.stop = interrupt.token();
  forget_peak_memory();
  const std::uint64_t before_bytes = peak_memory_bytes();
  const SteadyClock::time_point begin = SteadyClock::now();
  Result<SceneRun> made = SceneRun::create(scene_, start);
  if (!made) return interrupt.asked() ? stopped_error() : made.error();
  const double load_ms = ms(SteadyClock::now() - begin);
  LoopSettings loop;
  loop.frames = run.frames;
  loop.warm_up = run.warm_up;
  loop.dt_s = scene_.dt_s;
  loop.wall_clock = run.deadline;
  loop.deadline = Nanoseconds(static_cast<std::int64_t>(deadline_ms() * 1e6));
  loop.budget_work = run.budget_work;
  loop.paced = run.paced;
  loop.max_level = scene_.max_level;
  loop.polygons = scene_.polygons;
  loop.backtracking = scene_.backtracking;
  loop.reference_every = run.reference_every;
  std::uint64_t done = 0;
  const auto told = [&](const simulation::RunFrame&) {
    ++done;
    progress.share(doing, static_cast<double>(done) / static_cast<double>(run.frames + run.warm_up));
  };
  Result<LoopResult> result = run_loop(made.value(), loop, interrupt, {}, told);
  if (!result) return result.error();
  if (result.value().stopped) return stopped_error();
  if (cost != nullptr) {
    // The reports of the frames belong to the study.
    const std::uint64_t own_bytes = before_bytes + result.value().frames.size() * sizeof(simulation::RunFrame);
    *cost = {load_ms, std::max(peak_memory_bytes(), own_bytes) - own_bytes};
  }
  return std::move(result.value().frames);
}

io::StudyTable begin_study(const std::string& name, const std::string& command) {
  io::StudyTable table;
  table.schema = fmt::format("poise.{}/1", name);
  table.command = command;
  table.machine = io::this_machine();
  table.build = io::this_build();
  return table;
}

Status write_study(const StudyTimesOptions& o, const io::StudyTable& table, std::vector<LineChart> charts,
                   std::size_t columns) {
  leave_out_empty(charts);
  const std::string plot = charts_plot(charts, columns);
  return write_study(o, table, std::move(charts), plot, columns);
}

Status write_study(const StudyTimesOptions& o, const io::StudyTable& table, std::vector<LineChart> charts,
                   const std::string& plot, std::size_t columns) {
  leave_out_empty(charts);
  Status written = write_to(o.json, with_charts(io::study_json(table), charts, columns));
  add_failure(write_to(o.markdown, io::study_markdown(table)), written);
  if (o.json != "-" && o.markdown != "-" && !o.quiet) add_failure(io::write_stdout(io::study_text(table)), written);
  if (o.page_charts != nullptr) *o.page_charts = std::move(charts);
  if (!o.picture.any()) return written;
  const parallel::Interrupt interrupt;
  add_failure(plot.empty() ? Status(bad_input("--picture: the study has no figures to draw"))
                           : draw_by_gnuplot(plot, o.picture, interrupt),
              written);
  return written;
}

}  // namespace poise::app
