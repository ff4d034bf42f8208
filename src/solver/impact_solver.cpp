// SPDX-License-Identifier: MIT
#include <algorithm>

#include "parallel/prefetch.h"
#include "parallel/shared_counters.h"
#include "solver/solver.h"
#include "solver/solver_iteration.h"

namespace poise::solver {
namespace {

// True if the start of this step is nearer to the time of impact than that of the next one. Waiting for overlap would
// answer half a step late on average, and a late rebound loses speed: it has to climb out of the overlap.
bool meets_now(double gap_m, double closing_mps, double dt_s) { return gap_m <= 0.5 * closing_mps * dt_s; }

// Fills a wrench between the bodies of a row.
bool prepared(const System& system, const ContactRow& row, Wrench& wrench) {
  return prepare_row(wrench, system.bodies[row.a].inverse_mass, system.inverse_inertia[row.a],
                     system.bodies[row.b].inverse_mass, system.inverse_inertia[row.b]);
}

// DO eq. 1-3, contact by contact in canonical order, each with the approach speed taken anew.
bool answer_points(const System& system, ContactRow& row, double dt_s, double still_mps) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  bool solved = false;
  for (std::uint32_t p = row.points_begin; p < row.points_end; ++p) {
    const PointContact& point = system.points[p];
    const Vec3& n = point.normal;
    const Vec3 velocity =
        a.velocity_mps + a.spin_radps.cross(point.arm_a_m) - b.velocity_mps - b.spin_radps.cross(point.arm_b_m);
    const double closing = n.dot(velocity);
    if (closing <= still_mps || !meets_now(point.gap_m, closing, dt_s)) continue;
    Wrench single;
    single.direction = n;
    single.moment_a_m = point.arm_a_m.cross(n);
    single.moment_b_m = point.arm_b_m.cross(n);
    if (!prepared(system, row, single)) continue;
    const double e = row.restitution * closing > still_mps ? row.restitution : 0.0;
    const double lambda = (1.0 + e) * closing * single.effective_mass;
    apply_impulse(single, lambda, a, b);
    row.point_impulse_ns += lambda * n;
    solved = true;
  }
  return solved;
}

// Coulomb friction of one impulse along the wrench: what stops the slip at the contact point, or as much as the cone
// allows.
void apply_friction(const System& system, ContactRow& row, double lambda_ns) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  const Vec3 arm_b = row.arm_m - row.a_to_b_m;
  const Vec3 normal = row.direction.normalized();
  Vec3 slip = b.velocity_mps + b.spin_radps.cross(arm_b) - a.velocity_mps - a.spin_radps.cross(row.arm_m);
  slip -= slip.dot(normal) * normal;
  const double speed = slip.norm();
  if (!(speed > 0)) return;
  Wrench across;
  across.direction = -slip / speed;
  across.moment_a_m = row.arm_m.cross(across.direction);
  across.moment_b_m = arm_b.cross(across.direction);
  if (!prepared(system, row, across)) return;
  const double applied_impulse_ns =
      std::min(speed * across.effective_mass, row.friction * lambda_ns * row.direction.norm());
  apply_impulse(across, applied_impulse_ns, a, b);
  row.point_impulse_ns += applied_impulse_ns * across.direction;
}

bool answer_wrench(const System& system, ContactRow& row, double dt_s, double still_mps) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  const double closing = approach_mps(row, a, b);
  if (closing <= still_mps) return false;
  const bool rebounds = row.restitution * closing > still_mps;
  double lambda = 0;
  if (meets_now(row.gap_m, closing, dt_s)) {
    lambda = (1.0 + (rebounds ? row.restitution : 0.0)) * closing * row.effective_mass;
  } else if (!rebounds && closing * dt_s > row.gap_m) {
    lambda = (closing - row.gap_m / dt_s) * row.effective_mass;
  }
  if (lambda <= 0) return false;
  apply_impulse(row, lambda, a, b);
  row.total_ns += lambda;
  if (row.friction > 0) apply_friction(system, row, lambda);
  return true;
}

// Solves contact points of the pair that certainly penetrate and would rebound: resting contact has no restitution.
bool answer_overlaps(const System& system, ContactRow& row, double still_mps) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  bool solved = false;
  for (std::uint32_t p = row.overlap_begin; p < row.overlap_begin + row.overlap_count; ++p) {
    const OverlapPoint& point = system.overlaps[p];
    const double closing = approach_mps(point.normal, point.moment_a_m, point.moment_b_m, a, b);
    if (row.restitution * closing <= still_mps) continue;
    Wrench single;
    single.direction = point.normal;
    single.moment_a_m = point.moment_a_m;
    single.moment_b_m = point.moment_b_m;
    if (!prepared(system, row, single)) continue;
    const double lambda = (1.0 + row.restitution) * closing * single.effective_mass;
    apply_impulse(single, lambda, a, b);
    row.point_impulse_ns += lambda * point.normal;
    solved = true;
  }
  return solved;
}

// Rows that an iteration needs, and their bodies, lie anywhere in memory: prefetched some rows ahead, and then what
// the rows name.
constexpr std::size_t kRowsAhead = 4;
constexpr std::size_t kOverlapsAhead = 2;
HWY_INLINE void prefetch_row(const System& system, const RowActivation& gate, std::size_t i) {
  constexpr std::size_t kLine = 64;
  const auto* const row = reinterpret_cast<const std::byte*>(&system.rows[i]);
  for (std::size_t line = 0; line < 3; ++line) hwy::Prefetch(row + line * kLine);
  hwy::Prefetch(&system.bodies[gate.a]);
  hwy::Prefetch(&system.bodies[gate.b]);
}
HWY_INLINE void prefetch_overlaps(const System& system, const ContactRow& row) {
  for (std::uint32_t p = row.overlap_begin; p < row.overlap_begin + row.overlap_count; ++p)
    parallel::prefetch(system.overlaps[p]);
}

void note_rebound(const System& system, ContactRow& row, double still_mps) {
  row.bounces = row.restitution * approach_mps(row, system.bodies[row.a], system.bodies[row.b]) > still_mps;
}

}  // namespace

Convergence solve_impacts(const System& system, const SolveSettings& settings, parallel::Executor& executor) {
  const double still_mps = solver::still_mps(settings);
  const Stopping& stopping = settings.stopping;
  const std::uint32_t most = stopping.converges() ? stopping.max_iterations : kImpactIterations;
  std::vector<double>& change_ns = system.scratch.change_ns;
  Convergence ended{!stopping.converges(), 0};
  std::vector<std::uint32_t>& changed = system.scratch.changed;
  std::vector<RowActivation>& activations = system.scratch.activations;
  if (system.source == nullptr) {
    activations.clear();
    for (const ContactRow& row : system.rows) activations.push_back({row.a, row.b, true, true});
  } else if (std::none_of(activations.begin(), activations.end(),
                          [](const RowActivation& gate) { return gate.fast; })) {
    ended.reached = true;
    return ended;
  }
  const bool distant = system.rows.size() > parallel::kPairsAtHand;
  changed.assign(system.bodies.size(), 0);
  for (std::uint32_t round = 1; round <= most; ++round) {
    ++ended.iterations;
    if (stopping.converges()) change_ns.assign(system.rows.size(), 0.0);
    parallel::Shared<int> solved(0);
    // Skips rows whose bodies kept their velocities since the last round, and in the first round those that are not
    // fast.
    const auto skips = [&](const RowActivation& gate) {
      const bool touched = std::max(changed[gate.a], changed[gate.b]) + 1 >= round;
      return round == 1 ? !gate.fast && changed[gate.a] == 0 && changed[gate.b] == 0 : !touched;
    };
    const auto needs = [&](std::size_t i, std::size_t end) {
      return i < end && activations[i].ready && !skips(activations[i]);
    };
    for_each_row(system, executor, [&](std::size_t i, std::size_t end) {
      if (distant && needs(i + kRowsAhead, end)) prefetch_row(system, activations[i + kRowsAhead], i + kRowsAhead);
      if (distant && needs(i + kOverlapsAhead, end)) prefetch_overlaps(system, system.rows[i + kOverlapsAhead]);
      RowActivation& gate = activations[i];
      if (skips(gate)) return;
      ContactRow& row = system.rows[i];
      if (!gate.ready) {
        system.source->fill(i);
        gate.ready = true;
      }
      if (round == 1) note_rebound(system, row, still_mps);
      if (row.effective_mass == 0) return;
      const double before_ns = row.total_ns;
      const bool here = row.points_begin < row.points_end
                            ? round == 1 && answer_points(system, row, settings.dt_s, still_mps)
                            : answer_wrench(system, row, settings.dt_s, still_mps);
      const bool there = answer_overlaps(system, row, still_mps);
      if (!here && !there) return;
      if (system.bodies[row.a].inverse_mass > 0) changed[row.a] = round;
      if (system.bodies[row.b].inverse_mass > 0) changed[row.b] = round;
      if (solved.get() == 0) solved.set(1);
      if (stopping.converges()) change_ns[i] = row.total_ns - before_ns;
    });
    if (solved.get() == 0 || (stopping.converges() && settled(system, stopping, &ContactRow::total_ns))) {
      ended.reached = true;
      break;
    }
  }
  // A pair that closes fast enough to rebound keeps its speed until it meets, in this step or the next. The first
  // iteration has noted it; rows that impulses changed since are checked again.
  for_each_row(system, executor, [&](std::size_t i, std::size_t) {
    if (changed[activations[i].a] == 0 && changed[activations[i].b] == 0) return;
    if (activations[i].ready) note_rebound(system, system.rows[i], still_mps);
  });
  return ended;
}

}  // namespace poise::solver
