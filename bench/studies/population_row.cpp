// SPDX-License-Identifier: MIT
#include <algorithm>
#include <span>

#include "studies/study_population.h"

namespace poise::app {

std::vector<io::StudyColumn> population_columns() {
  return {{"bodies", "bodies", 0},
          {"islands_wait", "islands wait", 0},
          {"frames", "frames", 0},
          {"infeasible", "late: infeasible", 0},
          {"machine", "machine", 0},
          {"own", "forecast + overrun", 0},
          {"infeasible_last", "last third: infeasible", 0},
          {"machine_last", "machine", 0},
          {"own_last", "forecast + overrun", 0},
          {"p50_ms", "p50 ms", 2},
          {"p99_ms", "p99 ms", 2},
          {"p50_last_ms", "p50 ms in the last third", 2},
          {"level_last", "level in the last third", 2},
          {"frames_a_step_last", "frames a step in the last third", 1},
          {"held_mean", "bodies that waited", 0},
          {"asleep_mean", "asleep", 0},
          {"e_seen_mps", "E seen m/s", 4},
          {"e_seen_rel", "E seen / change", 3},
          {"pairs_mean", "", 0},
          {"memory_bytes", "", 0},
          {"bytes_per_body", "bytes a body", 0},
          {"bytes_per_pair", "bytes a pair", 0},
          {"load_s", "load s", 3}};
}

std::vector<io::StudyCell> population_row(const StudyRun& run, const StudyRunCost& cost,
                                          const std::vector<simulation::RunFrame>& frames) {
  const std::span<const simulation::RunFrame> all = frames;
  const std::size_t third = all.size() - all.size() / 3;
  const simulation::RunFigures whole = simulation::run_figures(all, {run.deadline});
  const simulation::RunFigures last = simulation::run_figures(all.subspan(third), {run.deadline});
  std::vector<double> e_seen_rel;
  double most_pairs = 0;
  for (const simulation::RunFrame& frame : all) {
    most_pairs = std::max(most_pairs, static_cast<double>(frame.report.candidate_pairs));
    const auto& reference = frame.report.reference;
    if (reference && reference->converged && reference->e_seen_mps && reference->change_mps.value_or(0) > 0)
      e_seen_rel.push_back(*reference->e_seen_mps / *reference->change_mps);
  }
  const auto cell = [](bool defined, auto value) { return defined ? io::StudyCell(value) : io::StudyCell(); };
  const auto misses = [&](const simulation::RunFigures& f, std::uint64_t simulation::MissFigures::*cause) {
    return f.misses ? io::StudyCell((*f.misses).*cause) : io::StudyCell();
  };
  const auto own = [&](const simulation::RunFigures& f) {
    return f.misses ? io::StudyCell(f.misses->overrun + f.misses->forecast) : io::StudyCell();
  };
  const auto bytes = static_cast<double>(cost.memory_bytes);
  return {
      run.bodies,
      run.islands_wait,
      static_cast<std::uint64_t>(all.size()),
      misses(whole, &simulation::MissFigures::infeasible),
      misses(whole, &simulation::MissFigures::machine),
      own(whole),
      misses(last, &simulation::MissFigures::infeasible),
      misses(last, &simulation::MissFigures::machine),
      own(last),
      whole.frame_ms.p50,
      whole.frame_ms.p99,
      last.frame_ms.p50,
      cell(last.level_mean.has_value(), last.level_mean.value_or(0)),
      cell(last.frames_a_step().has_value(), last.frames_a_step().value_or(0)),
      whole.held_mean(),
      whole.sleep.asleep_mean,
      cell(whole.reference.e_seen_mps.has_value(), whole.reference.e_seen_mps.value_or(simulation::Percentiles{}).p50),
      cell(!e_seen_rel.empty(), simulation::percentile(e_seen_rel, 0.5)),
      whole.work.candidate_pairs_mean,
      cell(cost.memory_bytes > 0, cost.memory_bytes),
      cell(cost.memory_bytes > 0, bytes / static_cast<double>(run.bodies)),
      cell(cost.memory_bytes > 0 && most_pairs > 0, most_pairs > 0 ? bytes / most_pairs : 0),
      cost.load_ms / 1000};
}

}  // namespace poise::app
