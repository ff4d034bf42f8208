// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>

#include "app/files/output_files.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "frame/stage_list.h"
#include "parallel/executor.h"
#include "parallel/interrupt.h"
#include "scene/run/milliseconds.h"
#include "scene/run/percentiles.h"
#include "scene/run/run_report.h"
#include "studies/study_timing.h"

namespace poise::app {
namespace {

// The mandatory stages: all except refinement.
constexpr auto kMandatory = [] {
  std::array<simulation::StageMember, simulation::kStages.size() - 1> stages{};
  std::copy_if(simulation::kStages.begin(), simulation::kStages.end(), stages.begin(),
               [](const auto& stage) { return stage.time != &StageTimes::refine; });
  return stages;
}();

/// Frames of one population in one state, over all rounds.
struct Timed {
  std::array<std::vector<double>, kMandatory.size() + 1> stage_ms;  ///< the last one is the sum
  std::vector<double> candidate_pairs, contacts;

  void add(const FrameReport& report) {
    double sum = 0;
    for (std::size_t i = 0; i < kMandatory.size(); ++i) {
      const double time = ms(report.times.*kMandatory[i].time);
      stage_ms[i].push_back(time);
      sum += time;
    }
    stage_ms.back().push_back(sum);
    candidate_pairs.push_back(static_cast<double>(report.candidate_pairs));
    contacts.push_back(static_cast<double>(report.contact_pairs));
  }
  void rows(std::uint64_t bodies, bool settled, std::vector<io::CostRow>& out) const {
    for (std::size_t i = 0; i < stage_ms.size(); ++i) {
      io::CostRow row;
      row.bodies = bodies;
      row.settled = settled;
      row.stage = i < kMandatory.size() ? kMandatory[i].name : "all of these";
      row.stage_ms = simulation::percentile(stage_ms[i], 0.5);
      row.candidate_pairs = simulation::percentile(candidate_pairs, 0.5);
      row.contacts = simulation::percentile(contacts, 0.5);
      row.frames = stage_ms[i].size();
      out.push_back(row);
    }
  }
};

Result<FrameReport> next_frame(SceneRun& run, const StudyTimingOptions& o, std::uint64_t frame) {
  constexpr double kStepS = 1.0 / 60;
  const Status ready = run.before_frame(frame);
  if (!ready) return ready.error();
  StepInput input;
  input.dt_s = kStepS;
  input.view = run.view();
  if (o.deadline_ms) input.budget = Budget::within(Nanoseconds(static_cast<std::int64_t>(1e6 * *o.deadline_ms)));
  const FrameReport report = run.world().step(input);
  if (report.status != StepStatus::Done) return bad_input("the step was refused: its input is out of range");
  return report;
}

}  // namespace

int study_cost(const StudyTimingOptions& o) {
  const Status sound = check_timing_options(o);
  if (!sound) return refuse("study cost", kExitBadUsage, sound.error().message);
  const Status writable = can_write({o.json, o.markdown});
  if (!writable) return refuse("study cost", exit_code_of(writable.error()), writable.error().message);
  const parallel::Interrupt interrupt;
  const std::vector<std::uint64_t> populations =
      o.bodies.empty() ? std::vector<std::uint64_t>{2000, 8000, 20000} : o.bodies;
  const std::uint64_t frames = o.frames.value_or(60);
  const std::uint64_t skip = o.skip.value_or(40);
  const std::uint64_t settle = std::max(o.settle.value_or(600), skip + frames);
  std::vector<std::array<Timed, 2>> timed(populations.size());
  Progress progress(!o.quiet);
  int threads = static_cast<int>(o.threads.value_or(0));
  for (std::uint64_t round = 0; round < o.rounds.value_or(1); ++round) {
    for (std::size_t p = 0; p < populations.size(); ++p) {
      Result<SceneRun> run = timed_scene(o, populations[p], threads);
      if (!run) return refuse("study cost", exit_code_of(run.error()), run.error().message);
      threads = run.value().world().threads();
      for (std::uint64_t frame = 0; frame < settle + frames; ++frame) {
        if (interrupt.asked()) return refuse("study cost", stopped_error());
        progress.share(fmt::format("round {}, {} bodies", round + 1, populations[p]),
                       static_cast<double>(frame) / static_cast<double>(settle + frames));
        const Result<FrameReport> report = next_frame(run.value(), o, frame);
        if (!report) return refuse("study cost", exit_code_of(report.error()), report.error().message);
        if (frame >= skip && frame < skip + frames) timed[p][0].add(report.value());
        if (frame >= settle) timed[p][1].add(report.value());
      }
    }
  }
  progress.end();
  io::CostDocument document;
  document.scene = o.scene;
  document.period_ms = 1e3 / 60;
  for (std::size_t p = 0; p < populations.size(); ++p) {
    for (const bool settled : {false, true}) timed[p][settled ? 1 : 0].rows(populations[p], settled, document.rows);
  }
  document.by = measured_by(o, threads);
  return write_timing(o, "cost", io::cost_json(document), io::cost_markdown(document), io::cost_charts(document));
}

int study_scaling(const StudyTimingOptions& o) {
  if (o.span) return study_span(o);
  const Status sound = check_timing_options(o);
  if (!sound) return refuse("study scaling", kExitBadUsage, sound.error().message);
  const Status writable = can_write({o.json, o.markdown});
  if (!writable) return refuse("study scaling", exit_code_of(writable.error()), writable.error().message);
  const parallel::Interrupt interrupt;
  std::vector<std::uint64_t> counts = o.thread_counts;
  for (std::uint64_t n = 1; o.thread_counts.empty() &&
                            n <= std::min<std::uint64_t>(16, static_cast<std::uint64_t>(parallel::available_threads()));
       n *= 2)
    counts.push_back(n);
  const std::uint64_t bodies = o.bodies.empty() ? 4000 : o.bodies.front();
  const std::uint64_t settle = o.settle.value_or(400);
  const std::uint64_t total = settle + o.frames.value_or(40);
  Progress progress(!o.quiet);
  std::vector<SceneRun> runs;
  for (const std::uint64_t threads : counts) {
    Result<SceneRun> run = timed_scene(o, bodies, static_cast<int>(threads));
    if (!run) return refuse("study scaling", exit_code_of(run.error()), run.error().message);
    runs.push_back(std::move(run).value());
  }
  std::vector<std::vector<double>> rates(runs.size());
  std::vector<double> work;
  for (std::uint64_t frame = 0; frame < total; ++frame) {
    for (std::size_t r = 0; r < runs.size(); ++r) {
      if (interrupt.asked()) return refuse("study scaling", stopped_error());
      Status ready = runs[r].before_frame(frame);
      if (ready && frame >= settle) ready = forget_pairs(runs[r]);
      if (!ready) return refuse("study scaling", exit_code_of(ready.error()), ready.error().message);
      StepInput input;
      input.dt_s = 1.0 / 60;
      input.view = runs[r].view();
      // The clock affects only the order of refinement: there is time for all of it.
      if (frame >= settle) input.budget = Budget::within(std::chrono::minutes(1));
      const FrameReport report = runs[r].world().step(input);
      if (report.status != StepStatus::Done)
        return refuse("study scaling", kExitBadInput, "the step was refused: its input is out of range");
      const double refine_us = 1e3 * ms(report.times.refine);
      if (frame < settle || refine_us <= 0) continue;
      rates[r].push_back(static_cast<double>(report.work_refine) / refine_us);
      if (r == 0) work.push_back(static_cast<double>(report.work_refine));
    }
    progress.share("frames on each number of threads in turn", static_cast<double>(frame) / static_cast<double>(total));
  }
  progress.end();
  io::ScalingDocument document;
  document.scene = o.scene;
  document.bodies = bodies;
  document.units_a_frame = work.empty() ? 0 : simulation::percentile(work, 0.5);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    io::ScalingRow row;
    row.threads = runs[r].world().threads();
    row.units_per_us = simulation::percentile(rates[r], 0.5);
    row.p10 = simulation::percentile(rates[r], 0.1);
    row.p90 = simulation::percentile(rates[r], 0.9);
    row.frames = rates[r].size();
    const double first = document.rows.empty() ? row.units_per_us : document.rows.front().units_per_us;
    row.times_one = first > 0 ? row.units_per_us / first : 0;
    document.rows.push_back(row);
  }
  document.by = measured_by(o, document.rows.empty() ? 1 : document.rows.back().threads);
  return write_timing(o, "scaling", io::scaling_json(document), io::scaling_markdown(document),
                      io::scaling_charts(document));
}

}  // namespace poise::app
