// SPDX-License-Identifier: MIT
#include <algorithm>

#include "parallel/shared.h"
#include "response/solve.h"
#include "response/sweep.h"

namespace poise::response {
namespace {

// Is this step the one whose start is nearest to the moment when the surfaces meet? Waiting for overlap would answer
// half a step late on average, and a late rebound loses speed: it has to climb out of the overlap.
bool meets_now(double gap_m, double closing_mps, double dt_s) { return gap_m <= 0.5 * closing_mps * dt_s; }

// DO eq. 1-3, contact by contact in canonical order, each with the approach speed taken anew.
bool answer_points(const System& system, ContactRow& row, double dt_s, double still_mps) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  bool answered = false;
  for (std::uint32_t p = row.points_begin; p < row.points_end; ++p) {
    const PointContact& point = system.points[p];
    const Vec3& n = point.normal;
    const Vec3 velocity =
        a.velocity_mps + a.spin_radps.cross(point.arm_a_m) - b.velocity_mps - b.spin_radps.cross(point.arm_b_m);
    const double closing = n.dot(velocity);
    if (closing <= still_mps || !meets_now(point.gap_m, closing, dt_s)) continue;
    ContactRow single = row;
    single.direction = n;
    single.moment_a_m = point.arm_a_m.cross(n);
    single.moment_b_m = point.arm_b_m.cross(n);
    if (!prepare_row(single, row.inverse_mass_a, system.inverse_inertia[row.a], row.inverse_mass_b,
                     system.inverse_inertia[row.b])) {
      continue;
    }
    const double e = row.restitution * closing > still_mps ? row.restitution : 0.0;
    const double lambda = (1.0 + e) * closing * single.effective_mass;
    apply_impulse(single, lambda, a, b);
    row.point_impulse_ns += lambda * n;
    answered = true;
  }
  return answered;
}

// Coulomb friction of one impulse along the wrench: what stops the slip at the place of contact, or as much as the cone
// allows.
void rub(const System& system, ContactRow& row, double lambda_ns) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  const Vec3 arm_b = row.arm_m - row.a_to_b_m;
  const Vec3 normal = row.direction.normalized();
  Vec3 slip = b.velocity_mps + b.spin_radps.cross(arm_b) - a.velocity_mps - a.spin_radps.cross(row.arm_m);
  slip -= slip.dot(normal) * normal;
  const double speed = slip.norm();
  if (!(speed > 0)) return;
  ContactRow across = row;
  across.direction = -slip / speed;
  across.moment_a_m = row.arm_m.cross(across.direction);
  across.moment_b_m = arm_b.cross(across.direction);
  if (!prepare_row(across, row.inverse_mass_a, system.inverse_inertia[row.a], row.inverse_mass_b,
                   system.inverse_inertia[row.b]))
    return;
  const double given_ns = std::min(speed * across.effective_mass, row.friction * lambda_ns * row.direction.norm());
  apply_impulse(across, given_ns, a, b);
  row.point_impulse_ns += given_ns * across.direction;
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
  if (row.friction > 0) rub(system, row, lambda);
  return true;
}

// Places of the pair that overlap beyond doubt and would rebound: rest cannot take these, since it rebounds nothing.
bool answer_places(const System& system, ContactRow& row, double still_mps) {
  SolverBody& a = system.bodies[row.a];
  SolverBody& b = system.bodies[row.b];
  bool answered = false;
  for (std::uint32_t p = row.places_begin; p < row.places_end; ++p) {
    const PlaceNow place = place_now(system.poses[row.a], system.poses[row.b], system.places[p]);
    if (place.surely_m > 0) continue;
    ContactRow single = row;
    single.arm_m = place.arm_m;
    single.direction = place.normal;
    single.moment_a_m = place.arm_m.cross(place.normal);
    single.moment_b_m = (place.arm_m - row.a_to_b_m).cross(place.normal);
    const double closing = approach_mps(single, a, b);
    if (row.restitution * closing <= still_mps) continue;
    if (!prepare_row(single, row.inverse_mass_a, system.inverse_inertia[row.a], row.inverse_mass_b,
                     system.inverse_inertia[row.b]))
      continue;
    const double lambda = (1.0 + row.restitution) * closing * single.effective_mass;
    apply_impulse(single, lambda, a, b);
    row.point_impulse_ns += lambda * place.normal;
    answered = true;
  }
  return answered;
}

void note_rebound(const System& system, ContactRow& row, double still_mps) {
  row.bounces = row.restitution * approach_mps(row, system.bodies[row.a], system.bodies[row.b]) > still_mps;
}

}  // namespace

Convergence solve_impacts(const System& system, const SolveSettings& settings, parallel::Executor& executor) {
  const double still_mps = response::still_mps(settings);
  const Stopping& stopping = settings.stopping;
  const std::uint32_t most = stopping.converges() ? stopping.max_sweeps : kImpactSweeps;
  std::vector<double>& change_ns = system.scratch.change_ns;
  Convergence ended{!stopping.converges(), 0};
  std::vector<std::uint32_t>& changed = system.scratch.changed;
  std::vector<RowGate>& gates = system.scratch.gates;
  if (system.source == nullptr) {
    gates.clear();
    for (const ContactRow& row : system.rows) gates.push_back({row.a, row.b, true, true});
  } else if (std::none_of(gates.begin(), gates.end(), [](const RowGate& gate) { return gate.fast; })) {
    ended.reached = true;
    return ended;
  }
  changed.assign(system.bodies.size(), 0);
  for (std::uint32_t round = 1; round <= most; ++round) {
    ++ended.sweeps;
    if (stopping.converges()) change_ns.assign(system.rows.size(), 0.0);
    parallel::Shared<int> answered(0);
    sweep(system, executor, [&](std::size_t i) {
      // What neither body's velocity has changed since the last round needs no other look, and at first only what is
      // fast.
      RowGate& gate = gates[i];
      const bool touched = std::max(changed[gate.a], changed[gate.b]) + 1 >= round;
      if (round == 1 ? !gate.fast && changed[gate.a] == 0 && changed[gate.b] == 0 : !touched) return;
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
      const bool there =
          row.restitution > 0 && row.places_begin < row.places_end && answer_places(system, row, still_mps);
      if (!here && !there) return;
      if (row.inverse_mass_a > 0) changed[row.a] = round;
      if (row.inverse_mass_b > 0) changed[row.b] = round;
      if (answered.get() == 0) answered.set(1);
      if (stopping.converges()) change_ns[i] = row.total_ns - before_ns;
    });
    if (answered.get() == 0 || (stopping.converges() && settled(system, stopping, &ContactRow::total_ns))) {
      ended.reached = true;
      break;
    }
  }
  // A pair that closes fast enough to rebound keeps its speed until it meets, in this step's sweeps or in the next's.
  // The first sweep has noted it; what impulses have changed since is looked at again.
  sweep(system, executor, [&](std::size_t i) {
    if (changed[gates[i].a] == 0 && changed[gates[i].b] == 0) return;
    if (gates[i].ready) note_rebound(system, system.rows[i], still_mps);
  });
  return ended;
}

}  // namespace poise::response
