// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "frame/budget/frame_time.h"
#include "frame/ccd/swept.h"
#include "frame/stages.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kRowGrain = 256;
// Room for the single contacts of each pair that the paper's model answers.
void reserve_sphere_points(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  if (world.settings.contact != ContactModel::Paper) return;
  std::uint32_t points = 0;
  buffers.points_begin.reserve(buffers.pairs.capacity());
  buffers.points_begin.clear();
  for (const solver::Manifold& rest : buffers.manifolds) {
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
  parallel::parallel_for(*world.executor, bodies.slot_count(), kRowGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      solver::SolverBody& body = buffers.solver_bodies[i];
      body = solver::SolverBody{};
      buffers.accelerations[i] = solver::Acceleration{};
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

void fill_points(WorldState& world, const ActivePair& pair, std::uint32_t place, solver::ContactRow& row) {
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
class PairRows final : public solver::RowSource {
 public:
  PairRows(WorldState& world, parallel::Tickets& degenerate) : world_(world), degenerate_(degenerate) {}
  void fill(std::size_t k) const override {
    FrameBuffers& buffers = world_.buffers;
    const std::uint32_t place = buffers.coloring.order()[k];
    const solver::Manifold& rest = buffers.manifolds[place];
    const ActivePair& pair = buffers.pairs[rest.pair];
    const collision::PairContact& contact = buffers.found[rest.pair].contact;
    const solver::PlacedPoint single = impact_point_of(world_, pair);
    solver::ContactRow& row = buffers.rows[k];
    row = solver::ContactRow{};
    row.a = rest.a;
    row.b = rest.b;
    row.pair = rest.pair;
    row.gap_m = solved_gap_m(world_, rest.pair);
    row.restitution = rest.restitution;
    row.friction = rest.friction;
    row.a_to_b_m = buffers.poses[pair.b].position_m - buffers.poses[pair.a].position_m;
    if (pair.point_count > 1) {
      row.point_begin = rest.point_begin;
      row.point_end = rest.point_begin + rest.point_count;
    }
    if (pair.from_cache()) {
      row.direction = single.normal;
      row.arm_m = single.arm_m;
      row.moment_a_m = row.arm_m.cross(row.direction);
      row.moment_b_m = (row.arm_m - row.a_to_b_m).cross(row.direction);
    } else {
      row.direction = contact.direction;
      row.arm_m = contact.arm_m;
      row.moment_a_m = contact.moment_a_m;
      row.moment_b_m = contact.moment_b_m;
    }
    const auto& inverse_mass = world_.bodies.inverse_mass;
    if (!solver::prepare_row(row, inverse_mass[pair.a], buffers.inverse_inertia[pair.a], inverse_mass[pair.b],
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
void deactivate_rows(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  buffers.rows.resize(std::max(buffers.rows.size(), buffers.manifolds.size()));
  buffers.scratch.activations.resize(buffers.manifolds.size());
  const std::span<const std::uint32_t> order = buffers.coloring.order();
  parallel::parallel_for(*world.executor, order.size(), kRowGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const solver::Manifold& rest = buffers.manifolds[order[k]];
      buffers.scratch.activations[k] = {rest.a, rest.b, rest.fast, false};
    }
  });
}

// What comes in fast enough to rebound is the business of the impact phase, not of rest.
void leave_bouncing(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  for (std::size_t k = 0; k < buffers.manifolds.size(); ++k) {
    if (!buffers.scratch.activations[k].ready || !buffers.rows[k].bounces) continue;
    solver::Manifold& rest = buffers.manifolds[buffers.coloring.order()[k]];
    buffers.manifold_points -= rest.point_count;
    rest.point_count = 0;
  }
}

// How many places a substep may visit: as many as the solver does by itself, or before a deadline as many as fit, or as
// another run decided.
std::uint32_t iterations_of_step(WorldState& world, const StepInput& input, const FrameReport& report) {
  std::uint32_t most = solver::kMaxPointIterations;
  if (input.replay != nullptr) {
    if (input.replay->point_iterations > 0) most = input.replay->point_iterations;
  } else if (input.budget.kind == Budget::Kind::Deadline) {
    most = iterations_in_time(world, input, report);
    if (input.record) world.decisions->point_iterations(most < solver::kMaxPointIterations ? most : 0);
  }
  return most;
}

}  // namespace

solver::PlacedPoint impact_point_of(const WorldState& world, const ActivePair& pair) {
  return solver::placed_point(world.buffers.poses[pair.a], world.buffers.poses[pair.b],
                              world.points.points[ContactCache::begin(pair.memory.room)]);
}

double solved_gap_m(const WorldState& world, std::uint32_t pair) {
  const ActivePair& active = world.buffers.pairs[pair];
  // The paper answers the spheres themselves; the others answer the surfaces that are likely inside them.
  if (world.settings.contact == ContactModel::Paper && !active.from_cache())
    return world.buffers.found[pair].contact.spheres_m;
  return impact_point_of(world, active).gap_m;
}

void list_contact_pairs(WorldState& world, double dt_s, double still_mps, FrameReport& report) {
  find_manifold_points(world, dt_s, still_mps);
  list_solved(world, report);
  reserve_sphere_points(world);
  fill_bodies(world);
}

solver::System impact_system(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  return {buffers.solver_bodies, std::span(buffers.rows).first(buffers.manifolds.size()),
          buffers.points,        world.points.points,
          buffers.poses,         buffers.inverse_inertia,
          buffers.coloring,      buffers.scratch};
}

void fill_rows(WorldState& world) {
  parallel::Tickets degenerate;
  const PairRows source(world, degenerate);
  deactivate_rows(world);
  for (std::size_t k = 0; k < world.buffers.manifolds.size(); ++k) source.fill(k);
}

solver::Convergence respond(WorldState& world, const StepInput& input, FrameReport& report,
                            const solver::Stopping& stopping) {
  solver::SolveSettings settings{input.dt_s, world.settings.gravity_mps2, world.substeps, stopping};
  list_contact_pairs(world, input.dt_s, solver::still_mps(settings), report);
  FrameBuffers& buffers = world.buffers;
  solver::Convergence ended;
  if (buffers.impacts) {
    parallel::Tickets degenerate;
    const PairRows source(world, degenerate);
    deactivate_rows(world);
    solver::System impact = impact_system(world);
    impact.source = &source;
    ended = solver::solve_impacts(impact, settings, *world.executor);
    report.degenerate = degenerate.take(0);
    leave_bouncing(world);
  }
  if (!stopping.converges()) settings.point_iterations = iterations_of_step(world, input, report);
  const solver::ContactSystem system{buffers.solver_bodies,  buffers.accelerations,      buffers.inverse_inertia,
                                     buffers.poses,          buffers.manifolds,          world.points.points,
                                     world.points.loads,     buffers.applied_impulse_ns, buffers.coloring,
                                     buffers.manifold_points};
  const solver::Convergence rest = world.contact_solver.solve(system, settings, *world.executor);
  report.point_iterations = rest.point_iterations;
  if (rest.cut_short) report.degraded.point_iterations = settings.point_iterations;
  if (input.backtracking) solve_swept(world, input, report);
  return {ended.reached && rest.reached, ended.iterations + rest.iterations};
}

}  // namespace poise::simulation
