// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "app/files/output_files.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "frame/stage_list.h"
#include "parallel/interrupt.h"
#include "scene/run/percentiles.h"
#include "studies/study_timing.h"

namespace poise::app {
namespace {

// Every kEvery-th frame starts without cached data; the frames between use that of the previous frames.
constexpr std::uint64_t kEvery = 4;
constexpr double kCacheStepS = 1.0 / 60;

using simulation::kStages;

struct TimedCache {
  std::array<std::vector<double>, kStages.size()> stage_ms;
  std::vector<double> finding_ms, all_ms, cached_pairs, levels;

  void add(const FrameReport& report) {
    const auto ms = [](Nanoseconds time) { return static_cast<double>(time.count()) / 1e6; };
    double all = 0;
    for (std::size_t i = 0; i < kStages.size(); ++i) {
      stage_ms[i].push_back(ms(report.times.*kStages[i].time));
      all += stage_ms[i].back();
    }
    finding_ms.push_back(ms(report.times.coarse + report.times.refine));
    all_ms.push_back(all);
    cached_pairs.push_back(static_cast<double>(report.cached_separations + report.cached_contacts));
    levels.push_back(static_cast<double>(report.jobs_done));
  }
};

}  // namespace

int study_cache(const StudyTimingOptions& o) {
  const auto refuse_cache = [](const Error& error) {
    print_error("poise study cache: {}\n", error.message);
    return exit_code_of(error);
  };
  const Status sound = check_timing_options(o);
  if (!sound) return refuse_cache(sound.error());
  const Status writable = can_write({o.json, o.markdown});
  if (!writable) return refuse_cache(writable.error());
  const parallel::Interrupt interrupt;
  io::CacheDocument document;
  document.scene = o.scene;
  document.bodies = o.bodies.empty() ? 10000 : o.bodies.front();
  const std::uint64_t settle = o.settle.value_or(1300);
  const std::uint64_t total = settle + kEvery * o.frames.value_or(40);
  Result<SceneRun> run = timed_scene(o, document.bodies, static_cast<int>(o.threads.value_or(0)));
  if (!run) return refuse_cache(run.error());
  TimedCache cached;
  TimedCache anew;
  Progress progress(!o.quiet);
  for (std::uint64_t frame = 0; frame < total; ++frame) {
    if (interrupt.asked()) return refuse_cache(stopped_error());
    progress.share(fmt::format("{} bodies", document.bodies), static_cast<double>(frame) / static_cast<double>(total));
    Status ready = run.value().before_frame(frame);
    const bool forgets = frame >= settle && frame % kEvery == 0;
    if (ready && forgets) ready = forget_pairs(run.value());
    if (!ready) return refuse_cache(ready.error());
    StepInput input;
    input.dt_s = kCacheStepS;
    const FrameReport report = run.value().world().step(input);
    if (report.status != StepStatus::Done)
      return refuse_cache(bad_input("the step was refused: its input is out of range"));
    if (frame >= settle) (forgets ? anew : cached).add(report);
  }
  progress.end();
  const auto row = [&](const char* stage, const std::vector<double>& with, const std::vector<double>& without) {
    document.rows.push_back({stage, simulation::percentile(with, 0.5), simulation::percentile(without, 0.5)});
  };
  for (std::size_t i = 0; i < kStages.size(); ++i) row(kStages[i].name, cached.stage_ms[i], anew.stage_ms[i]);
  row("coarse and refine", cached.finding_ms, anew.finding_ms);
  row("all of these", cached.all_ms, anew.all_ms);
  document.frames_retained = cached.all_ms.size();
  document.frames_anew = anew.all_ms.size();
  document.cached_pairs = simulation::percentile(cached.cached_pairs, 0.5);
  document.levels_retained = simulation::percentile(cached.levels, 0.5);
  document.levels_anew = simulation::percentile(anew.levels, 0.5);
  document.by = measured_by(o, run.value().world().threads());
  return write_timing(o, "cache", io::cache_json(document), io::cache_markdown(document), io::cache_charts(document));
}

}  // namespace poise::app
