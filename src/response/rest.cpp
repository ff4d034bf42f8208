// SPDX-License-Identifier: MIT
#include <algorithm>

#include "response/solve.h"
#include "response/sweep.h"

namespace poise::response {
namespace {

// Share of a certain overlap that a substep takes back, and the greatest speed of that. Faster, and a pair that has just
// been refined pops.
constexpr double kPushShare = 0.1;
constexpr double kMaxPushMps = 0.5;

// The gap now, to first order in the motion of the step so far.
double gap_change(const ContactRow& row, const SolverBody& a, const SolverBody& b) {
  return row.direction.dot(b.moved_m - a.moved_m) + row.moment_b_m.dot(b.turned_rad) -
         row.moment_a_m.dot(a.turned_rad);
}

void mark(const ContactRow& row, SolverBody& a, SolverBody& b) {
  if (row.inverse_mass_a > 0) a.answered = true;
  if (row.inverse_mass_b > 0) b.answered = true;
}

// Keeps a pair from closing further than its gap in this substep. Returns the impulse that this took, in N s.
double solve_velocity(const System& system, ContactRow& row, double h_s) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  const double gap_m = std::max(0.0, row.gap_m + gap_change(row, a, b));
  const double wanted = row.impulse_ns + (approach_mps(row, a, b) - gap_m / h_s) * row.effective_mass;
  const double lambda = std::max(0.0, wanted) - row.impulse_ns;
  if (lambda == 0) return 0;
  row.impulse_ns += lambda;
  row.total_ns += lambda;
  apply_impulse(row, lambda, a, b);
  mark(row, a, b);
  return lambda;
}

bool counts(const ContactRow& row) { return row.effective_mass != 0 && !row.bounces; }

// Sweeps over the velocities of one substep.
void solve_velocities(const System& system, double h_s, const Stopping& stopping, parallel::Executor& executor,
                      Convergence& ended) {
  if (!stopping.converges()) {
    ++ended.sweeps;
    sweep(system, executor, [&](std::size_t i) {
      ContactRow& row = system.rows[i];
      if (counts(row)) solve_velocity(system, row, h_s);
    });
    return;
  }
  system.scratch.change_ns.resize(system.rows.size());
  for (std::uint32_t round = 0; round < stopping.max_sweeps; ++round) {
    ++ended.sweeps;
    sweep(system, executor, [&](std::size_t i) {
      ContactRow& row = system.rows[i];
      system.scratch.change_ns[i] = counts(row) ? solve_velocity(system, row, h_s) : 0.0;
    });
    if (settled(system, stopping, &ContactRow::impulse_ns)) return;
  }
  ended.reached = false;
}

// Takes a part of an overlap that is certain back, in place alone: no speed comes of it.
void push_apart(const System& system, const ContactRow& row, double h_s, double still_mps) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  const double overlap_m = -(row.surely_m + gap_change(row, a, b) + row.slop_m);
  // A pair that parts by itself need not be pushed.
  if (overlap_m <= 0 || approach_mps(row, a, b) < -still_mps) return;
  const double lambda = std::min(kPushShare * overlap_m, kMaxPushMps * h_s) * row.effective_mass;
  if (row.inverse_mass_a > 0) {
    a.moved_m -= (lambda * row.inverse_mass_a) * row.direction;
    a.turned_rad -= lambda * row.turn_a;
  }
  if (row.inverse_mass_b > 0) {
    b.moved_m += (lambda * row.inverse_mass_b) * row.direction;
    b.turned_rad += lambda * row.turn_b;
  }
  mark(row, a, b);
}

}  // namespace

Convergence solve_rest(const System& system, const SolveSettings& settings, parallel::Executor& executor) {
  constexpr std::size_t kGrain = 512;
  const double h_s = settings.dt_s / settings.substeps;
  Convergence ended;
  for (int substep = 0; substep < settings.substeps; ++substep) {
    parallel::parallel_for(executor, system.bodies.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) {
        SolverBody& body = system.bodies[i];
        body.velocity_mps += h_s * system.accelerations[i].linear_mps2;
        body.spin_radps += h_s * system.accelerations[i].angular_radps2;
      }
    });
    sweep(system, executor, [&](std::size_t i) {
      ContactRow& row = system.rows[i];
      if (!counts(row)) {
        row.impulse_ns = 0;
        return;
      }
      if (row.impulse_ns == 0) return;
      // Warm start with what held the pair last time, if something still presses: without a load it would add energy.
      if (system.accelerations[row.a].none() && system.accelerations[row.b].none()) {
        row.impulse_ns = 0;
        return;
      }
      row.total_ns += row.impulse_ns;
      apply_impulse(row, row.impulse_ns, system.bodies[row.a], system.bodies[row.b]);
      mark(row, system.bodies[row.a], system.bodies[row.b]);
    });
    solve_velocities(system, h_s, settings.stopping, executor, ended);
    parallel::parallel_for(executor, system.bodies.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) {
        SolverBody& body = system.bodies[i];
        body.moved_m += h_s * body.velocity_mps;
        body.turned_rad += h_s * body.spin_radps;
      }
    });
    sweep(system, executor, [&](std::size_t i) {
      if (!system.scratch.gates[i].may_push) return;
      const ContactRow& row = system.rows[i];
      if (counts(row)) push_apart(system, row, h_s, still_mps(settings));
    });
  }
  return ended;
}

}  // namespace poise::response
