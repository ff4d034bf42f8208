// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>

#include "response/solve.h"
#include "response/sweep.h"

namespace poise::response {
namespace {

// How stiff a contact is: as stiff as the substep allows, and at most 30 Hz; far overdamped. (Catto's values.)
constexpr double kMaxFrequencyHz = 30.0;
constexpr double kDampingRatio = 10.0;
// Greatest speed at which overlapping bodies are pushed apart. Faster, and a pair that has just been refined pops.
constexpr double kMaxPushMps = 0.5;

struct Softness {
  double rate_per_s, mass_scale, impulse_scale;
};

Softness softness(double h_s) {
  const double omega = 2.0 * std::numbers::pi * std::min(kMaxFrequencyHz, 0.25 / h_s);
  const double a1 = 2.0 * kDampingRatio + h_s * omega;
  const double a2 = h_s * omega * a1;
  const double a3 = 1.0 / (1.0 + a2);
  return {omega / a1, a2 * a3, a3};
}

// The gap now, to first order in the motion of the step so far.
double gap_change(const ContactRow& row, const SolverBody& a, const SolverBody& b) {
  return row.direction.dot(b.moved_m - a.moved_m) + row.moment_b_m.dot(b.turned_rad) -
         row.moment_a_m.dot(a.turned_rad);
}

void mark(const ContactRow& row, SolverBody& a, SolverBody& b) {
  if (row.inverse_mass_a > 0) a.answered = true;
  if (row.inverse_mass_b > 0) b.answered = true;
}

void solve_row(const System& system, ContactRow& row, double h_s, const Softness& soft, bool push) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  const double change = gap_change(row, a, b);
  double bias_mps = 0;
  double mass_scale = 1;
  double impulse_scale = 0;
  if (row.gap_m + change > 0) {
    bias_mps = (row.gap_m + change) / h_s;
  } else if (push) {
    bias_mps = std::max(soft.rate_per_s * std::min(row.surely_m + change + row.slop_m, 0.0), -kMaxPushMps);
    mass_scale = soft.mass_scale;
    impulse_scale = soft.impulse_scale;
  }
  const double separating = -approach_mps(row, a, b);
  const double wanted = row.impulse_ns - mass_scale * (separating + bias_mps) * row.effective_mass -
                        impulse_scale * row.impulse_ns;
  const double lambda = std::max(0.0, wanted) - row.impulse_ns;
  if (lambda == 0) return;
  row.impulse_ns += lambda;
  row.total_ns += lambda;
  apply_impulse(row, lambda, a, b);
  mark(row, a, b);
}

}  // namespace

void solve_rest(const System& system, const SolveSettings& settings, parallel::Executor& executor) {
  constexpr std::size_t kGrain = 512;
  const double h_s = settings.dt_s / settings.substeps;
  const Softness soft = softness(h_s);
  const auto counts = [](const ContactRow& row) { return row.effective_mass != 0 && !row.bounces; };
  for (int substep = 0; substep < settings.substeps; ++substep) {
    parallel::parallel_for(executor, system.bodies.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) {
        SolverBody& body = system.bodies[i];
        body.velocity_mps += h_s * system.accelerations[i].linear_mps2;
        body.spin_radps += h_s * system.accelerations[i].angular_radps2;
      }
    });
    sweep(system, executor, [&](ContactRow& row) {
      if (!counts(row)) {
        row.impulse_ns = 0;
        return;
      }
      if (row.impulse_ns == 0) return;
      // Warm start with what held the pair last time.
      row.total_ns += row.impulse_ns;
      apply_impulse(row, row.impulse_ns, system.bodies[row.a], system.bodies[row.b]);
      mark(row, system.bodies[row.a], system.bodies[row.b]);
    });
    sweep(system, executor, [&](ContactRow& row) {
      if (counts(row)) solve_row(system, row, h_s, soft, true);
    });
    parallel::parallel_for(executor, system.bodies.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) {
        SolverBody& body = system.bodies[i];
        body.moved_m += h_s * body.velocity_mps;
        body.turned_rad += h_s * body.spin_radps;
      }
    });
    sweep(system, executor, [&](ContactRow& row) {
      if (counts(row)) solve_row(system, row, h_s, soft, false);
    });
  }
}

}  // namespace poise::response
