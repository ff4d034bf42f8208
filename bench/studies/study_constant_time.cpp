// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cstdio>

#include "app/options/option_values.h"
#include "app/process/exit_codes.h"
#include "app/process/refusal.h"
#include "studies/study_forecast.h"

namespace poise::app {
namespace {

constexpr const char* kConstantTimeScene = "pile";
constexpr std::uint64_t kConstantTimeFrames = 300;
constexpr std::uint64_t kConstantTimeWarmUp = 120;
constexpr std::uint64_t kConstantTimeMaxBodies = 200'000;
// Without a deadline, populations whose frames take longer than this number of deadlines are skipped: a run would take
// hours.
constexpr double kTooLong = 12;

std::vector<LineChart> constant_time_charts(const io::StudyTable& table, double deadline_ms) {
  LineChart times{"frame-time",
                  "99 of 100 frames take at most, ms",
                  "Without a deadline every pair is refined to its end.",
                  "bodies",
                  {{"under the deadline", io::study_points(table, "bodies", "deadline_p99_ms", {})},
                   {"without", io::study_points(table, "bodies", "full_p99_ms", {})}},
                  {{"deadline", deadline_ms, {}}},
                  true,
                  true};
  LineChart levels{"levels",
                   "mean level under the deadline",
                   "What the deadline costs.",
                   "bodies",
                   {{"mean level", io::study_points(table, "bodies", "level_mean", {})}},
                   {},
                   true};
  return {std::move(times), std::move(levels)};
}

}  // namespace

void add_study_constant_time_options(CLI::App& command, StudyConstantTimeOptions& o) {
  add_study_times_options(command, o.common, kConstantTimeScene, kConstantTimeFrames, kConstantTimeWarmUp);
  add_whole(command, "--most-bodies", o.most_bodies, 100, kConstantTimeMaxBodies,
            "Largest population (default 200000)");
  command.footer(
      "Examples:\n"
      "  poise study constant-time --markdown constant-time.md --picture constant-time.png      a quarter of an hour "
      "and more\n"
      "  poise study constant-time --scene jacks --most-bodies 4000 --frames 60 --json -\n\n"
      "From 100 bodies on, half as many again or twice as many each time, until more than half of the frames are "
      "infeasible: what every frame must\n"
      "do does not fit before the deadline.");
}

int study_constant_time(const StudyConstantTimeOptions& o) {
  const Status sound = check_study_times(o.common);
  if (!sound)
    return refuse("study constant-time",
                  sound.error().kind == ErrorKind::OutputFailed ? kExitOutputFailed : kExitBadUsage,
                  sound.error().message);
  const Result<StudyScene> scene = StudyScene::make(o.common, kConstantTimeScene);
  if (!scene) return refuse("study constant-time", scene.error());
  Progress progress(!o.common.quiet);
  io::StudyTable table = begin_study("constant-time", "poise study constant-time");
  table.columns = {{"bodies", "bodies", 0},
                   {"deadline_p50_ms", "p50 ms under the deadline", 2},
                   {"deadline_p99_ms", "p99 ms", 2},
                   {"miss_rate", "misses %", 2},
                   {"infeasible", "infeasible", 0},
                   {"machine", "machine", 0},
                   {"own", "forecast + overrun", 0},
                   {"degraded_frames", "degraded", 0},
                   {"level_mean", "mean level", 2},
                   {"frames_a_step", "frames a step", 1},
                   {"held_mean", "bodies that waited", 0},
                   {"full_p50_ms", "p50 ms without", 2},
                   {"full_p99_ms", "p99 ms", 2}};
  const double deadline_ms = scene.value().deadline_ms();
  table.facts = {{"scene", scene.value().name()},
                 {"frames", o.common.frames.value_or(kConstantTimeFrames)},
                 {"deadline_ms", deadline_ms},
                 {"threads", static_cast<std::uint64_t>(scene.value().threads())}};
  bool full = true;
  for (std::uint64_t step = 0, bodies = 100; bodies <= o.most_bodies.value_or(kConstantTimeMaxBodies);
       ++step, bodies = std::uint64_t{step % 2 == 0 ? 100U : 150U} << (step / 2)) {
    StudyRun run;
    run.bodies = bodies;
    run.frames = o.common.frames.value_or(kConstantTimeFrames);
    run.warm_up = o.common.warmup.value_or(kConstantTimeWarmUp);
    const auto kept = scene.value().run(run, fmt::format("{} bodies under the deadline", bodies), progress);
    run.deadline = false;
    const auto whole = full && kept ? scene.value().run(run, fmt::format("{} bodies without", bodies), progress)
                                    : Result<std::vector<simulation::RunFrame>>(std::vector<simulation::RunFrame>());
    if (!kept || !whole) {
      progress.end();
      return refuse("study constant-time", kept ? whole.error() : kept.error());
    }
    const simulation::RunFigures f = simulation::run_figures(kept.value(), {true});
    const simulation::MissFigures& m = *f.misses;
    const simulation::RunFigures w = simulation::run_figures(whole.value(), {false});
    const auto of_full = [&](double ms) { return full ? io::StudyCell(ms) : io::StudyCell(); };
    table.rows.push_back({bodies, f.frame_ms.p50, f.frame_ms.p99, 100 * m.rate, m.infeasible, m.machine,
                          m.overrun + m.forecast, f.degraded.frames,
                          f.level_mean ? io::StudyCell(*f.level_mean) : io::StudyCell(),
                          f.frames_a_step() ? io::StudyCell(*f.frames_a_step()) : io::StudyCell(), f.held_mean(),
                          of_full(w.frame_ms.p50), of_full(w.frame_ms.p99)});
    full = full && w.frame_ms.p50 < kTooLong * deadline_ms;
    if (2 * m.infeasible > m.releases) break;
  }
  progress.end();
  const Status written = write_study(o.common, table, constant_time_charts(table, deadline_ms), 2);
  return written ? kExitDone : refuse("study constant-time", written.error());
}

}  // namespace poise::app
