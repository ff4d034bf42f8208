// SPDX-License-Identifier: MIT
#include "app/run/run_table.h"

#include <fmt/format.h>

#include <iterator>

#include "parallel/interrupt.h"
#include "scene/run/milliseconds.h"

namespace poise::app {
namespace {

using Out = std::back_insert_iterator<std::string>;

void head(const io::RunDocument& d, Out out) {
  const std::string most =
      d.dynamic_bodies_max > d.dynamic_bodies ? fmt::format(" ({} at most)", d.dynamic_bodies_max) : std::string();
  fmt::format_to(out, "{}: {} bodies, {} of them moving{}; {} frames of {:.4g} ms{}\n", d.scene, d.bodies,
                 d.dynamic_bodies, most, d.figures.frames, 1000 * d.dt_s,
                 d.stopped ? fmt::format(", stopped by {}", parallel::stop_name()) : "");
  if (!d.affinity.empty()) fmt::format_to(out, "bound to the processors {}\n", fmt::join(d.affinity, ", "));
  if (d.realtime_priority > 0) fmt::format_to(out, "real-time priority {}\n", d.realtime_priority);
  fmt::format_to(out, "{} threads ({}), policy {}, contact model {}, ", d.threads, d.executor, d.policy, d.contact);
  if (d.deadline_ms) {
    fmt::format_to(out, "deadline {:.4g} ms{}", *d.deadline_ms,
                   d.paced ? " from each release of a fixed grid" : " from each start");
    if (d.render_load_ms > 0) fmt::format_to(out, ", {:.4g} ms of simulated drawing in it", d.render_load_ms);
    if (d.host_work_ms > 0) fmt::format_to(out, ", {:.4g} ms of it kept for the host", d.host_work_ms);
    fmt::format_to(out, "\n");
  } else if (d.budget_work) {
    fmt::format_to(out, "{} work units of refinement a frame\n", *d.budget_work);
  } else {
    fmt::format_to(out, "refinement unlimited\n");
  }
}

void times(const simulation::RunFigures& f, Out out) {
  fmt::format_to(out, "\nms a frame          p50       p90       p99     p99.9       max\n");
  for (const simulation::StageFigures& stage : f.stages) {
    const simulation::Percentiles& p = stage.ms;
    fmt::format_to(out, "  {:<12} {:9.3f} {:9.3f} {:9.3f} {:9.3f} {:9.3f}\n", stage.name, p.p50, p.p90, p.p99, p.p99_9,
                   p.max);
  }
  if (f.warm_up_frames > 0) fmt::format_to(out, "  {} warm-up frames are not in these figures\n", f.warm_up_frames);
}

void misses(const simulation::RunFigures& f, Out out) {
  if (!f.misses) {
    fmt::format_to(out, "\nmisses         not defined on the work clock\n");
    return;
  }
  const simulation::MissFigures& m = *f.misses;
  fmt::format_to(out, "\nmisses         {} of {} ({:.2f} %; 95 % sure: {:.2f} to {:.2f} %), at most {} in a row\n",
                 m.count, m.releases, 100 * m.rate, 100 * m.interval_95.low, 100 * m.interval_95.high, m.longest_run);
  const auto row = [&](MissCause cause, std::uint64_t count) {
    fmt::format_to(out, "  {:<12} {:<6} {}\n", simulation::cause_name(cause), count, simulation::cause_text(cause));
  };
  row(MissCause::Infeasible, m.infeasible);
  row(MissCause::Machine, m.machine);
  row(MissCause::Overrun, m.overrun);
  row(MissCause::Forecast, m.forecast);
  if (m.release > 0) row(MissCause::Release, m.release);
  if (m.skipped_releases > 0)
    fmt::format_to(out, "  {} of them are releases that passed while a late frame ran\n", m.skipped_releases);
  if (m.tardiness_ms.max > 0) {
    fmt::format_to(out, "  late frames were late by {:.3f} ms (p50), {:.3f} ms at most\n", m.tardiness_ms.p50,
                   m.tardiness_ms.max);
  }
}

void worst(const io::RunDocument& d, Out out) {
  const std::vector<simulation::WorstFrame>& frames = d.figures.worst_frames;
  if (frames.empty()) return;
  fmt::format_to(out, "\nworst frames   late by ms  cause       longest stage, ms\n");
  for (const simulation::WorstFrame& frame : frames) {
    fmt::format_to(out, "  {:<12} {:10.3f}  {:<11} {} {:.3f}", frame.frame, ms(frame.lateness),
                   simulation::cause_name(frame.cause), frame.stage, ms(frame.stage_time));
    if (frame.piece) {
      fmt::format_to(out, "; a piece of {:.3f}, bodies {} and {}", ms(frame.piece_time), frame.piece->body_a,
                     frame.piece->body_b);
    }
    // Not to be told where it explains nothing.
    if (2 * frame.release_delay >= frame.lateness) fmt::format_to(out, "; began {:.3f} late", ms(frame.release_delay));
    fmt::format_to(out, "\n");
  }
  if (d.record.empty()) {
    fmt::format_to(out, "  what such a frame did: run with --record FILE, then poise replay FILE --explain FRAME\n");
  } else {
    fmt::format_to(out, "  what it did: poise replay {} --explain {}\n", d.record, frames.front().frame);
  }
}

void refinement(const simulation::RunFigures& f, Out out) {
  const simulation::WorkFigures& w = f.work;
  fmt::format_to(out, "\ncontacts       {:.4g} a frame, from {:.4g} candidate pairs\n", f.contacts_mean,
                 w.candidate_pairs_mean);
  fmt::format_to(out, "levels         ");
  auto sum = static_cast<double>(f.polygon_contacts);
  for (const std::uint64_t count : f.level_histogram) sum += static_cast<double>(count);
  if (sum > 0) {
    const char* separator = "";
    if (f.level_mean) {
      fmt::format_to(out, "{:.3f} in the mean", *f.level_mean);
      separator = "; ";
    }
    for (std::size_t level = 0; level < f.level_histogram.size(); ++level) {
      if (f.level_histogram[level] == 0) continue;
      fmt::format_to(out, "{}{:.1f} % at {}", separator, 100 * static_cast<double>(f.level_histogram[level]) / sum,
                     level);
      separator = ", ";
    }
    if (f.polygon_contacts > 0) {
      fmt::format_to(out, "{}{:.1f} % by polygons", separator, 100 * static_cast<double>(f.polygon_contacts) / sum);
    }
    fmt::format_to(out, "\n");
  } else {
    fmt::format_to(out, "no contact\n");
  }
  if (f.levels.frames > 0 && sum > 0) {
    const auto list = [&](const char* name, const auto& points, double whole) {
      if (whole <= 0) return;
      fmt::format_to(out, "{:<15}", name);
      const char* separator = "";
      for (std::size_t place = 0; place < points.size(); ++place) {
        const double share = static_cast<double>(points[place]) / whole;
        if (share <= 0) continue;
        fmt::format_to(out, "{}{:.1f} % {}", separator, 100 * share,
                       place == kPolygonBin ? std::string("by polygons") : fmt::format("at {}", place));
        separator = ", ";
      }
      fmt::format_to(out, "\n");
    };
    double bodies = 0;
    for (const std::uint64_t count : f.levels.bodies) bodies += static_cast<double>(count);
    list("  by body", f.levels.bodies, bodies);
    double weight = 0;
    for (const double share : f.levels.weight) weight += share;
    list("  by weight", f.levels.weight, weight);
  }
  fmt::format_to(out,
                 "refinement     {:.0f} work units a frame, {} levels completed, {} discarded, {} pairs found apart\n",
                 w.refine_mean, w.jobs_done, w.jobs_discarded, w.pairs_separated);
  if (f.refinement_used) {
    fmt::format_to(out, "               {:.1f} % of its time used in the {} frames that left pairs coarse\n",
                   100 * *f.refinement_used, w.frames_with_pairs_left);
    fmt::format_to(
        out,
        "               {:.4g} pairs a frame left for want of time, {:.4g} of room; at most {} frames at level 0\n",
        f.levels.left_for_time_mean, f.levels.left_for_capacity_mean, f.levels.longest_wait);
  } else if (w.frames_with_pairs_left == 0) {
    fmt::format_to(out, "               every pair was refined to its end in every frame\n");
  }
  if (f.longest_job) {
    fmt::format_to(out, "               longest piece {:.3f} ms: bodies {} and {} in frame {}\n", f.longest_job_ms_max,
                   f.longest_job->body_a, f.longest_job->body_b, f.longest_job->frame);
  }
  if (f.misses && f.misses->overrun > 0) {
    fmt::format_to(
        out,
        "               if it is the same pair in every run, its shapes are too dear for this deadline: give them a "
        "shallower tree (depth), a simpler mesh, or no polygons; if not, the machine held a thread up\n");
  }
  if (f.tail.frames > 0) {
    fmt::format_to(out, "reserve        held in {:.2f} % of frames, {:.2f} times what was needed\n",
                   100 * f.tail.coverage, f.tail.reserve_over_actual);
  }
}

void degraded(const simulation::RunFigures& f, Out out) {
  if (f.degraded.infeasible_forecast == 0 && f.degraded.frames == 0) return;
  fmt::format_to(out,
                 "degraded       {} frames were forecast not to fit; {} with fewer iterations, {} with fewer substeps, "
                 "{} pairs reused what they had found\n",
                 f.degraded.infeasible_forecast, f.degraded.fewer_iterations, f.degraded.fewer_substeps,
                 f.degraded.pairs_reused);
  if (f.degraded.fewer_partners > 0)
    fmt::format_to(out, "               in {} frames bodies in crowds kept fewer pairs\n", f.degraded.fewer_partners);
  if (f.degraded.frames_unfinished > 0) {
    fmt::format_to(out, "               steps in slices: {} frames ended without the end of their step\n",
                   f.degraded.frames_unfinished);
  }
  if (f.degraded.frames_held == 0) return;
  const auto frames = static_cast<double>(f.degraded.frames_held);
  fmt::format_to(
      out, "               islands waited in {} frames, {:.0f} bodies in the mean of these, {:.0f} not looked at\n",
      f.degraded.frames_held, static_cast<double>(f.degraded.bodies_held) / frames,
      static_cast<double>(f.degraded.bodies_paused) / frames);
}

void swept(const simulation::RunFigures& f, Out out) {
  if (f.swept.pairs == 0) return;
  fmt::format_to(out, "backtracking   {} pairs with a fast body, {} met within a step, {} stopped short\n",
                 f.swept.pairs, f.swept.hits, f.swept.cut);
}

void reference(const io::RunDocument& d, Out out) {
  if (!d.reference_every) return;
  const simulation::ReferenceRunFigures& r = d.figures.reference;
  fmt::format_to(out, "\nreference      {} frames done again at full depth, to convergence: one in {}\n", r.frames,
                 *d.reference_every);
  if (r.frames == 0) return;
  fmt::format_to(out, "                     p50        p90        max\n");
  const auto row = [&](const char* name, const std::optional<simulation::Percentiles>& p, const char* unit) {
    if (p) fmt::format_to(out, "  {:<12} {:10.4g} {:10.4g} {:10.4g} {}\n", name, p->p50, p->p90, p->max, unit);
  };
  row("E", r.e_mps, "m/s");
  row("E_rel", r.e_rel, "");
  row("E_seen", r.e_seen_mps, "m/s");
  row("gap, mean", r.gap_mean_mm, "mm");
  row("gap, largest", r.gap_max_mm, "mm");
  row("", r.gap_max_px, "px of 1080");
  const auto percent = [](const std::optional<double>& share) {
    return share ? fmt::format("{:.2f} %", 100 * *share) : std::string("not defined");
  };
  fmt::format_to(out, "  contacts     {} in the run, {} of them false ({}), {} with true surfaces apart\n",
                 r.run_contacts, r.false_contacts, percent(r.false_share), r.contacts_apart);
  fmt::format_to(out, "               {} in the reference, {} of them missed ({})\n", r.reference_contacts,
                 r.missed_contacts, percent(r.missed_share));
  if (r.not_converged > 0) fmt::format_to(out, "  {} references did not converge\n", r.not_converged);
  if (r.pairs_not_finest > 0)
    fmt::format_to(out, "  {} pairs had no room to reach their finest level\n", r.pairs_not_finest);
  fmt::format_to(out, "\n");
}

void state(const io::RunDocument& d, Out out) {
  fmt::format_to(out, "energy         {:.6g} J at the start, {:.6g} J at the end, {:.6g} J at most\n",
                 d.start.kinetic_j + d.start.potential_j, d.end.kinetic_j + d.end.potential_j, d.energy_max_j);
  const simulation::SleepFigures& s = d.figures.sleep;
  if (d.sleeping) {
    fmt::format_to(out, "sleeping       {} bodies at the end, {:.6g} on average, {} fell asleep, {} woke\n",
                   s.asleep_end, s.asleep_mean, s.fell_asleep, s.woken);
  }
  const simulation::CapacityFigures& c = d.figures.capacity;
  if (c.colors_full > 0) {
    fmt::format_to(
        out, "shared         {} contacts in all frames, of bodies with more partners than colours; solved on copies\n",
        c.colors_full);
  }
  if (c.pairs_discarded + c.fronts_full + c.degenerate > 0) {
    fmt::format_to(out, "full           {} pairs left out, {} fronts without room, {} degenerate contacts\n",
                   c.pairs_discarded, c.fronts_full, c.degenerate);
  }
  const simulation::OutOfRangeFigures& lost = d.figures.out_of_range;
  if (lost.bodies > 0) {
    fmt::format_to(
        out,
        "out of range   {} times a body was put to rest where it was, since a step took it beyond 1e12 m, 1e9 "
        "m/s or 1e9 rad/s; first body {} in frame {}\n",
        lost.bodies, lost.first_body, lost.first_frame);
  }
  if (d.capture) {
    fmt::format_to(out, "capture        {} frames, {:.1f} kB", d.capture->frames,
                   static_cast<double>(d.capture->bytes) / 1e3);
    if (d.capture->left_out > 0)
      fmt::format_to(out, "; {} frames left out, since the file was written too slowly", d.capture->left_out);
    fmt::format_to(out, "\n");
  }
  fmt::format_to(out, "state hash     {:016x}\n", d.state_hash);
}

}  // namespace

std::string run_table(const io::RunDocument& document) {
  std::string text;
  const Out out = std::back_inserter(text);
  head(document, out);
  times(document.figures, out);
  misses(document.figures, out);
  worst(document, out);
  refinement(document.figures, out);
  degraded(document.figures, out);
  swept(document.figures, out);
  reference(document, out);
  state(document, out);
  return text;
}

}  // namespace poise::app
