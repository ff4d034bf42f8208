// SPDX-License-Identifier: MIT
#include "scene/run/run_report.h"

#include <algorithm>
#include <deque>
#include <functional>
#include <utility>

#include "frame/stage_list.h"
#include "scene/run/milliseconds.h"

namespace poise::simulation {
namespace {

std::uint64_t misses_of(const RunFrame& frame) {
  return frame.releases_skipped + (frame.report.lateness.count() > 0 ? 1U : 0U);
}

template <class F>
std::vector<double> collect(std::span<const RunFrame> frames, F&& value) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const RunFrame& frame : frames) values.push_back(value(frame));
  return values;
}

void add_cause(MissFigures& misses, MissCause cause, std::uint64_t count) {
  switch (cause) {
    // A release can be skipped behind a frame that was itself in time, because of what the caller did after it.
    case MissCause::None:
    case MissCause::Release:
      misses.release += count;
      break;
    case MissCause::Infeasible:
      misses.infeasible += count;
      break;
    case MissCause::Machine:
      misses.machine += count;
      break;
    case MissCause::Overrun:
      misses.overrun += count;
      break;
    case MissCause::Forecast:
      misses.forecast += count;
      break;
  }
}

MissFigures miss_figures(std::span<const RunFrame> frames) {
  MissFigures misses;
  std::vector<double> tardiness_ms;
  std::deque<std::uint64_t> window;
  std::uint64_t in_window = 0;
  std::uint64_t run = 0;
  double late_ms = 0;
  double total_ms = 0;
  for (const RunFrame& frame : frames) {
    const std::uint64_t missed = misses_of(frame);
    misses.count += missed;
    misses.releases += 1 + frame.releases_skipped;
    misses.skipped_releases += frame.releases_skipped;
    add_cause(misses, frame.report.cause, missed);
    total_ms += ms(frame.report.times.total);
    if (frame.report.lateness.count() > 0) {
      tardiness_ms.push_back(ms(frame.report.lateness));
      late_ms += ms(frame.report.lateness);
      run += missed;
    } else {
      run = frame.releases_skipped;
    }
    misses.longest_run = std::max(misses.longest_run, run);
    window.push_back(missed);
    in_window += missed;
    if (window.size() > 1000) {
      in_window -= window.front();
      window.pop_front();
    }
    misses.worst_1000 = std::max(misses.worst_1000, in_window);
  }
  if (misses.releases > 0) misses.rate = static_cast<double>(misses.count) / static_cast<double>(misses.releases);
  misses.interval_95 = clopper_pearson(misses.count, misses.releases, 0.95);
  misses.tardiness_ms = percentiles(std::move(tardiness_ms));
  if (total_ms > 0) misses.share_of_time_late = late_ms / total_ms;
  return misses;
}

TailFigures tail_figures(std::span<const RunFrame> frames, double alpha) {
  TailFigures tail;
  double covered = 0;
  double needed_ms = 0;
  double used_ms = 0;
  double reserved_ms = 0;
  double loss_ms = 0;
  std::vector<double> against_forecast;
  for (const RunFrame& frame : frames) {
    const FrameReport& report = frame.report;
    if (report.tail_forecast.count() <= 0 || report.tail_needed().count() <= 0) continue;
    ++tail.frames;
    if (report.tail_needed() <= report.reserve_at_cut) covered += 1;
    needed_ms += ms(report.tail_needed());
    used_ms += ms(std::min(report.tail_actual, report.reserve_at_cut));
    reserved_ms += ms(report.reserve_at_cut);
    const double short_by_ms = ms(report.tail_needed() - report.reserve_at_cut);
    loss_ms += std::max((1 - alpha) * short_by_ms, -alpha * short_by_ms);
    against_forecast.push_back(ms(report.tail_needed()) / ms(report.tail_forecast));
    tail.margin_last = report.cut_margin;
    if (report.tail_beyond_clip) ++tail.beyond_clip;
  }
  if (tail.frames > 0) {
    tail.coverage = covered / static_cast<double>(tail.frames);
    tail.pinball_loss_ms = loss_ms / static_cast<double>(tail.frames);
    tail.reserve_over_actual = reserved_ms / needed_ms;
  }
  if (reserved_ms > 0) tail.reserve_used = used_ms / reserved_ms;
  tail.actual_over_forecast = percentiles(std::move(against_forecast));
  return tail;
}

void add_work(std::span<const RunFrame> frames, RunFigures& figures) {
  WorkFigures& work = figures.work;
  std::uint64_t candidates = 0;
  std::uint64_t coarse = 0;
  std::uint64_t left = 0;
  std::uint64_t contacts = 0;
  std::uint64_t asleep = 0;
  for (const RunFrame& frame : frames) {
    const FrameReport& report = frame.report;
    work.mandatory += report.work_mandatory;
    work.refine += report.work_refine;
    work.jobs_done += report.jobs_done;
    work.jobs_discarded += report.jobs_discarded;
    work.jobs_abandoned += report.jobs_abandoned;
    work.cached_separations += report.cached_separations;
    work.cached_contacts += report.cached_contacts;
    work.pairs_separated += report.pairs_separated;
    candidates += report.candidate_pairs;
    coarse += report.coarse_pairs;
    left += report.pairs_left;
    contacts += report.contact_pairs;
    if (report.pairs_left > 0) ++work.frames_with_pairs_left;
    for (std::size_t i = 0; i < figures.level_histogram.size(); ++i)
      figures.level_histogram[i] += report.level_histogram[i];
    figures.polygon_contacts += report.level_histogram[kPolygonBin];
    figures.capacity.pairs_discarded += report.pairs_discarded;
    figures.capacity.fronts_full += report.fronts_full;
    figures.capacity.colors_full += report.colors_full;
    figures.capacity.degenerate += report.degenerate;
    figures.swept.pairs += report.swept_pairs;
    figures.swept.hits += report.swept_hits;
    figures.swept.cut += report.swept_cut;
    figures.sleep.fell_asleep += report.fell_asleep;
    figures.sleep.woken += report.woken;
    asleep += report.asleep;
    if (report.degraded.any()) ++figures.degraded.frames;
    if (report.degraded.point_iterations > 0) ++figures.degraded.fewer_iterations;
    if (report.degraded.substeps > 0) ++figures.degraded.fewer_substeps;
    if (report.degraded.crowded_partners > 0) ++figures.degraded.fewer_partners;
    figures.degraded.pairs_reused += report.degraded.pairs_reused;
    if (report.degraded.bodies_held > 0) ++figures.degraded.frames_held;
    figures.degraded.bodies_held += report.degraded.bodies_held;
    figures.degraded.bodies_paused += report.degraded.bodies_paused;
    if (report.unfinished) ++figures.degraded.frames_unfinished;
    if (report.infeasible_forecast) ++figures.degraded.infeasible_forecast;
    figures.off_cpu_ms_max = std::max(figures.off_cpu_ms_max, ms(report.off_cpu));
    if (ms(report.longest_job) > figures.longest_job_ms_max) {
      figures.longest_job_ms_max = ms(report.longest_job);
      figures.longest_job = {report.frame, frame.longest_job_bodies[0], frame.longest_job_bodies[1]};
    }
  }
  if (frames.empty()) return;
  const auto mean_of = [](std::uint64_t sum, std::uint64_t count) {
    return static_cast<double>(sum) / static_cast<double>(std::max<std::uint64_t>(count, 1));
  };
  // What a step did stands in the frame that ended it.
  const auto mean = [&](std::uint64_t sum) { return mean_of(sum, frames.size() - figures.degraded.frames_unfinished); };
  work.mandatory_mean = mean(work.mandatory);
  work.refine_mean = mean(work.refine);
  work.candidate_pairs_mean = mean(candidates);
  work.coarse_pairs_mean = mean(coarse);
  work.pairs_left_mean = mean(left);
  figures.contacts_mean = mean(contacts);
  figures.sleep.asleep_mean = mean_of(asleep, frames.size());
  figures.sleep.asleep_end = frames.back().report.asleep;
}

std::optional<double> level_mean(const RunFigures& figures) {
  double sum = 0;
  double count = 0;
  for (std::size_t level = 0; level < figures.level_histogram.size(); ++level) {
    sum += static_cast<double>(level) * static_cast<double>(figures.level_histogram[level]);
    count += static_cast<double>(figures.level_histogram[level]);
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

std::optional<double> refinement_used(std::span<const RunFrame> frames, bool all) {
  double used_ms = 0;
  double available_ms = 0;
  // Of a step that took several frames the time available stands in the frame that ended it.
  double of_step_ms = 0;
  for (const RunFrame& frame : frames) {
    of_step_ms += ms(frame.report.times.refine);
    if (frame.report.unfinished) continue;
    const double step_ms = std::exchange(of_step_ms, 0.0);
    if (frame.report.refine_available.count() <= 0 || (!all && frame.report.pairs_left == 0)) continue;
    used_ms += step_ms;
    available_ms += ms(frame.report.refine_available);
  }
  if (available_ms <= 0) return std::nullopt;
  return used_ms / available_ms;
}

LevelFigures level_figures(std::span<const RunFrame> frames) {
  LevelFigures figures;
  double weight = 0;
  std::uint64_t for_time = 0;
  std::uint64_t for_room = 0;
  for (const RunFrame& frame : frames) {
    if (!frame.report.levels) continue;
    const LevelsReached& reached = *frame.report.levels;
    ++figures.frames;
    for (std::size_t place = 0; place < reached.bodies.size(); ++place) {
      figures.bodies[place] += reached.bodies[place];
      figures.weight[place] += reached.weight[place];
      weight += reached.weight[place];
    }
    for_time += reached.left_for_time;
    for_room += reached.left_for_capacity;
    figures.longest_wait = std::max(figures.longest_wait, reached.longest_wait);
  }
  for (double& share : figures.weight) share = weight > 0 ? share / weight : 0;
  if (figures.frames > 0) {
    figures.left_for_time_mean = static_cast<double>(for_time) / static_cast<double>(figures.frames);
    figures.left_for_capacity_mean = static_cast<double>(for_room) / static_cast<double>(figures.frames);
  }
  return figures;
}

/// Frames a second over the slowest `one_in`-th part of the frames, at least one frame.
double low_fps(std::vector<double> frame_ms, std::size_t one_in) {
  if (frame_ms.empty()) return 0;
  std::sort(frame_ms.begin(), frame_ms.end(), std::greater<>());
  const std::size_t count = std::max<std::size_t>(1, frame_ms.size() / one_in);
  double sum_ms = 0;
  for (std::size_t i = 0; i < count; ++i) sum_ms += frame_ms[i];
  return sum_ms > 0 ? 1000 * static_cast<double>(count) / sum_ms : 0;
}

}  // namespace

RunFigures run_figures(std::span<const RunFrame> all, const RunTerms& terms) {
  RunFigures figures;
  std::vector<RunFrame> kept;
  kept.reserve(all.size());
  for (const RunFrame& frame : all) {
    OutOfRangeFigures& out = figures.out_of_range;
    if (out.bodies == 0 && frame.report.out_of_range > 0) {
      out.first_frame = frame.report.frame;
      out.first_body = frame.out_of_range_body;
    }
    out.bodies += frame.report.out_of_range;
    if (!frame.warm_up) {
      kept.push_back(frame);
      continue;
    }
    ++figures.warm_up_frames;
    if (terms.deadlines) figures.warm_up_misses += misses_of(frame);
  }
  const std::span<const RunFrame> frames(kept);
  figures.frames = frames.size();
  std::vector<double> frame_ms = collect(frames, [](const RunFrame& frame) { return ms(frame.report.times.total); });
  figures.low_1_percent_fps = low_fps(frame_ms, 100);
  figures.low_0_1_percent_fps = low_fps(frame_ms, 1000);
  figures.frame_ms = percentiles(std::move(frame_ms));
  figures.release_delay_ms =
      percentiles(collect(frames, [](const RunFrame& frame) { return ms(frame.report.release_delay); }));
  if (terms.deadlines) figures.misses = miss_figures(frames);
  if (terms.deadlines) figures.worst_frames = worst_frames(frames);
  figures.refinement_used = refinement_used(frames, false);
  figures.refinement_used_all = refinement_used(frames, true);
  figures.tail = tail_figures(frames, terms.alpha);
  figures.levels = level_figures(frames);
  const auto stage = [&](const StageMember& of) {
    return StageFigures{
        of.name, percentiles(collect(frames, [&](const RunFrame& frame) { return ms(frame.report.times.*of.time); }))};
  };
  std::transform(kStages.begin(), kStages.end(), figures.stages.begin(), stage);
  figures.stages.back() = stage({"total", &StageTimes::total});
  add_work(frames, figures);
  std::vector<ReferenceFigures> references;
  for (const RunFrame& frame : frames) {
    if (frame.report.reference) references.push_back(*frame.report.reference);
  }
  figures.reference = reference_run_figures(references);
  figures.level_mean = level_mean(figures);
  return figures;
}

}  // namespace poise::simulation
