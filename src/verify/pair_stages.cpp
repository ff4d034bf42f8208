// SPDX-License-Identifier: MIT
#include "verify/pair_stages.h"

#include <limits>

namespace poise::simulation {

PairStages::PairStages(const WorldState& world) : world_(world) {
  pools_.emplace_back(world.settings.max_front_entries);
}

void PairStages::find(ProbeLevel level, double dt_s) {
  const StepInput step = step_to(level, dt_s);
  terms_ = terms_of(world_.settings, step);
  parallel::Executor& executor = *world_.executor;
  // Other frames may have passed since the last time.
  frame_.motion.everything = true;
  frame_.velocities.everything = true;
  predict({world_.scene(), terms_}, frame_.motion, executor);
  find_candidates({world_.scene(), frame_.motion, {world_.settings.max_partners, world_.settings.max_pairs}},
                  broad_phase_, frame_.candidates, executor);
  find_active_pairs({world_.scene(), terms_, frame_.motion, frame_.candidates, {}, world_.pair_filter}, frame_.table,
                    pools_, executor);
  begin_levels(frame_.table, frame_.levels, executor);
  pools_[0].clear();
}

bool PairStages::refine_all(bool keep_fronts) {
  const PairRefiner refiner{world_.scene(), terms_.contact, world_.settings.policy.quantum_units};
  bool fits = true;
  for (std::size_t i = 0; i < frame_.table.size(); ++i) {
    if (!keep_fronts) pools_[0].clear();
    fits = refine_pair(refiner, posed(frame_.motion, frame_.table.pairs[i]), frame_.levels.progress[i],
                       frame_.levels.found, pools_, 0) &&
           fits;
  }
  return fits;
}

void PairStages::meet_all() {
  for (ActivePair& pair : frame_.table.pairs) pair.margin_m = std::numeric_limits<double>::max();
}

SolveInput PairStages::solve_input() const {
  return {world_.scene(), terms_, frame_.motion, frame_.table, frame_.levels, frame_.manifolds, pools_, 1, {}};
}

void PairStages::make_rows() {
  FrameReport report;
  // Pairs are not cached between queries.
  points_.released.clear();
  for (std::vector<std::uint32_t>& free : points_.free) free.clear();
  points_.points.clear();
  points_.forces.clear();
  make_manifolds({world_.scene(), terms_, frame_.motion, frame_.table, frame_.levels, 0}, points_, frame_.manifolds,
                 report, *world_.executor);
  begin_solve(solve_input(), frame_.velocities, *world_.executor);
  fill_rows(solve_input(), points_, frame_.velocities, *world_.executor);
}

void PairStages::close_gaps() {
  for (solver::ContactRow& row : frame_.velocities.rows) row.gap_m = -std::numeric_limits<double>::max();
}

void PairStages::solve() {
  solver::solve_impacts(impact_system(solve_input(), frame_.velocities), solve_input().settings(), *world_.executor);
}

}  // namespace poise::simulation
