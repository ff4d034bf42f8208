// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "parallel/shared.h"
#include "simulation/frame_time.h"
#include "simulation/stages.h"
#include "simulation/swept.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kGrain = 256;
// Room for the single contacts of each pair that the paper's model answers.
void lay_out_points(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  if (world.settings.contact != ContactModel::Paper) return;
  std::uint32_t points = 0;
  buffers.points_begin.reserve(buffers.pairs.capacity());
  buffers.points_begin.clear();
  for (const response::RestPair& rest : buffers.rest_pairs) {
    const ActivePair& pair = buffers.pairs[rest.pair];
    buffers.points_begin.push_back(points);
    if (!pair.by_polygons()) points += pair.level.front_entries;
  }
  buffers.points.resize(points);
}

void fill_bodies(WorldState& world) {
  const dynamics::BodyStore& bodies = world.bodies;
  FrameBuffers& buffers = world.buffers;
  buffers.solver_bodies.resize(bodies.slot_count());
  buffers.accelerations.resize(bodies.slot_count());
  parallel::parallel_for(*world.executor, bodies.slot_count(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      response::SolverBody& body = buffers.solver_bodies[i];
      body = response::SolverBody{};
      buffers.accelerations[i] = response::Acceleration{};
      if (bodies.dynamic[i] == 0) continue;
      body.velocity_mps = bodies.velocity(i);
      body.spin_radps = bodies.spin(i);
      body.inverse_mass = bodies.inverse_mass[i];
      buffers.accelerations[i].linear_mps2 = world.settings.gravity_mps2;
      if (bodies.pushed[i] == 0) continue;
      buffers.accelerations[i].linear_mps2 += bodies.inverse_mass[i] * bodies.force(i);
      buffers.accelerations[i].angular_radps2 = buffers.inverse_inertia[i] * bodies.torque(i);
    }
  });
}

void fill_points(WorldState& world, const ActivePair& pair, std::uint32_t place, response::ContactRow& row) {
  FrameBuffers& buffers = world.buffers;
  row.points_begin = row.points_end = buffers.points_begin[place];
  if (pair.by_polygons()) return;  // one contact, exact: the row itself
  const collision::PairFrame frame = frame_of(world, pair);
  const Mat3& turn = buffers.poses[pair.a].rotation;
  collision::for_each_segment(buffers.pools, pair.level.front, [&](std::span<const collision::FrontEntry> entries) {
    for (const collision::FrontEntry entry : entries) {
      const collision::SphereContact contact = collision::sphere_contact(frame, entry);
      buffers.points[row.points_end++] = {turn * contact.normal, turn * contact.point_m,
                                          turn * (contact.point_m - frame.offset_m), contact.gap_m};
    }
  });
}

// What an impact needs.
class PairRows final : public response::RowSource {
 public:
  PairRows(WorldState& world, parallel::Tickets& degenerate) : world_(world), degenerate_(degenerate) {}
  void fill(std::size_t k) const override {
    FrameBuffers& buffers = world_.buffers;
    const std::uint32_t place = buffers.coloring.order()[k];
    const response::RestPair& rest = buffers.rest_pairs[place];
    const ActivePair& pair = buffers.pairs[rest.pair];
    const collision::PairContact& contact = buffers.found[rest.pair].contact;
    const response::PlaceNow lone = lone_place(world_, pair);
    response::ContactRow& row = buffers.rows[k];
    row = response::ContactRow{};
    row.a = rest.a;
    row.b = rest.b;
    row.pair = rest.pair;
    row.gap_m = answered_gap_m(world_, rest.pair);
    row.restitution = rest.restitution;
    row.friction = rest.friction;
    row.a_to_b_m = buffers.poses[pair.b].position_m - buffers.poses[pair.a].position_m;
    if (pair.place_count > 1) {
      row.places_begin = rest.place_begin;
      row.places_end = rest.place_begin + rest.place_count;
    }
    if (pair.by_kept()) {
      row.direction = lone.normal;
      row.arm_m = lone.arm_m;
      row.moment_a_m = row.arm_m.cross(row.direction);
      row.moment_b_m = (row.arm_m - row.a_to_b_m).cross(row.direction);
    } else {
      row.direction = contact.direction;
      row.arm_m = contact.arm_m;
      row.moment_a_m = contact.moment_a_m;
      row.moment_b_m = contact.moment_b_m;
    }
    const auto& inverse_mass = world_.bodies.inverse_mass;
    if (!response::prepare_row(row, inverse_mass[pair.a], buffers.inverse_inertia[pair.a], inverse_mass[pair.b],
                               buffers.inverse_inertia[pair.b])) {
      degenerate_.take(1);
    }
    if (world_.settings.contact == ContactModel::Paper) fill_points(world_, pair, place, row);
  }

 private:
  WorldState& world_;
  parallel::Tickets& degenerate_;
};

// A gate for each row, none of them filled.
void close_gates(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  buffers.rows.resize(std::max(buffers.rows.size(), buffers.rest_pairs.size()));
  buffers.scratch.gates.resize(buffers.rest_pairs.size());
  const std::span<const std::uint32_t> order = buffers.coloring.order();
  parallel::parallel_for(*world.executor, order.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const response::RestPair& rest = buffers.rest_pairs[order[k]];
      buffers.scratch.gates[k] = {rest.a, rest.b, rest.fast, false};
    }
  });
}

// What comes in fast enough to rebound is the business of the impact phase, not of rest.
void leave_bouncing(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  for (std::size_t k = 0; k < buffers.rest_pairs.size(); ++k) {
    if (!buffers.scratch.gates[k].ready || !buffers.rows[k].bounces) continue;
    response::RestPair& rest = buffers.rest_pairs[buffers.coloring.order()[k]];
    buffers.rest_places -= rest.place_count;
    rest.place_count = 0;
  }
}

// How many places a substep may visit: as many as the solver does by itself, or before a deadline as many as fit, or as
// another run decided.
std::uint32_t visits_of_step(WorldState& world, const StepInput& input, const FrameReport& report) {
  std::uint32_t most = response::kMostVisits;
  if (input.replay != nullptr) {
    if (input.replay->visits > 0) most = input.replay->visits;
  } else if (input.budget.kind == Budget::Kind::Deadline) {
    most = visits_in_time(world, input, report);
    if (input.record) world.decisions->visits(most < response::kMostVisits ? most : 0);
  }
  return most;
}

}  // namespace

response::PlaceNow lone_place(const WorldState& world, const ActivePair& pair) {
  return response::place_now(world.buffers.poses[pair.a], world.buffers.poses[pair.b],
                             world.places.places[PlaceStore::begin(pair.memory.room)]);
}

double answered_gap_m(const WorldState& world, std::uint32_t pair) {
  const ActivePair& active = world.buffers.pairs[pair];
  // The paper answers the spheres themselves; the others answer the surfaces that are likely inside them.
  if (world.settings.contact == ContactModel::Paper && !active.by_kept())
    return world.buffers.found[pair].contact.spheres_m;
  return lone_place(world, active).gap_m;
}

void list_contact_pairs(WorldState& world, double dt_s, double still_mps, FrameReport& report) {
  lay_out_places(world, dt_s, still_mps);
  list_answered(world, report);
  lay_out_points(world);
  fill_bodies(world);
}

response::System impact_system(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  return {buffers.solver_bodies, std::span(buffers.rows).first(buffers.rest_pairs.size()),
          buffers.points,        world.places.places,
          buffers.poses,         buffers.inverse_inertia,
          buffers.coloring,      buffers.scratch};
}

void fill_rows(WorldState& world) {
  parallel::Tickets degenerate;
  const PairRows source(world, degenerate);
  close_gates(world);
  for (std::size_t k = 0; k < world.buffers.rest_pairs.size(); ++k) source.fill(k);
}

response::Convergence respond(WorldState& world, const StepInput& input, FrameReport& report,
                              const response::Stopping& stopping) {
  response::SolveSettings settings{input.dt_s, world.settings.gravity_mps2, world.substeps, stopping};
  list_contact_pairs(world, input.dt_s, response::still_mps(settings), report);
  FrameBuffers& buffers = world.buffers;
  response::Convergence ended;
  if (buffers.impacts) {
    parallel::Tickets degenerate;
    const PairRows source(world, degenerate);
    close_gates(world);
    response::System impact = impact_system(world);
    impact.source = &source;
    ended = response::solve_impacts(impact, settings, *world.executor);
    report.degenerate = degenerate.take(0);
    leave_bouncing(world);
  }
  if (!stopping.converges()) settings.visits = visits_of_step(world, input, report);
  const response::RestSystem system{
      buffers.solver_bodies, buffers.accelerations, buffers.inverse_inertia, buffers.poses,    buffers.rest_pairs,
      world.places.places,   world.places.loads,    buffers.given_ns,        buffers.coloring, buffers.rest_places};
  const response::Convergence rest = world.rest_solver.solve(system, settings, *world.executor);
  report.patch_visits = rest.visits;
  if (rest.cut_short) report.degraded.visits = settings.visits;
  if (input.backtracking) answer_swept(world, input, report);
  return {ended.reached && rest.reached, ended.sweeps + rest.sweeps};
}

}  // namespace poise::simulation
