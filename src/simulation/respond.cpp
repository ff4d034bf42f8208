// SPDX-License-Identifier: MIT
#include <algorithm>

#include "parallel/shared.h"
#include "simulation/stages.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kGrain = 256;
// Overlap that is left alone, as a share of the smaller body's radius. Chosen: keeps contacts closed without being seen.
constexpr double kSlopOfSkin = 0.2;

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

// The pairs that are answered, in canonical order, coloured by the bodies that yield.
void list_rows(WorldState& world, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  buffers.row_pair.clear();
  buffers.edges.clear();
  buffers.points_begin.clear();
  // All grow with the pairs, so that later frames whose share of answered pairs is larger need no room of their own.
  buffers.row_pair.reserve(buffers.pairs.capacity());
  buffers.edges.reserve(buffers.pairs.capacity());
  buffers.points_begin.reserve(buffers.pairs.capacity() + 1);
  buffers.rows.reserve(buffers.pairs.capacity());
  buffers.scratch.gates.reserve(buffers.pairs.capacity());
  std::uint32_t points = 0;
  const bool by_points = world.settings.contact == ContactModel::Paper;
  for (std::size_t i = 0; i < buffers.pairs.size(); ++i) {
    const ActivePair& pair = buffers.pairs[i];
    if (pair.level.apart) continue;
    ++report.level_histogram[pair.level.by_polygons() ? kPolygonPlace : pair.level.level];
    if (pair.level.refinable()) ++report.pairs_left;
    buffers.row_pair.push_back(static_cast<std::uint32_t>(i));
    buffers.edges.push_back({pair.a, pair.b, world.bodies.dynamic[pair.a] != 0, world.bodies.dynamic[pair.b] != 0});
    buffers.points_begin.push_back(points);
    if (by_points && !pair.level.by_polygons()) points += pair.level.front_entries;
  }
  buffers.points_begin.push_back(points);
  buffers.points.resize(points);
  buffers.coloring.reserve(buffers.pairs.capacity());
  buffers.coloring.color(buffers.edges, world.bodies.slot_count());
}

void fill_points(WorldState& world, const ActivePair& pair, std::uint32_t place, response::ContactRow& row) {
  FrameBuffers& buffers = world.buffers;
  row.points_begin = row.points_end = buffers.points_begin[place];
  if (pair.level.by_polygons()) return;  // one contact, exact: the row itself
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

collision::PairContact coarsest_contact_of(const WorldState& world, const ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  const auto placed = [&](std::uint32_t slot) {
    return collision::PlacedRoot{world.bodies.shape[slot].get(), buffers.root_center_m[slot],
                                 buffers.poses[slot].position_m};
  };
  const Shape& shape_b = *world.bodies.shape[pair.b];
  if (shape_b.kind == ShapeKind::Tree) return collision::coarsest_contact(placed(pair.a), placed(pair.b));
  const Vec3 normal = buffers.poses[pair.b].rotation * shape_b.plane_normal;
  const double height = normal.dot(buffers.poses[pair.b].position_m) + shape_b.plane_offset_m;
  return collision::coarsest_plane_contact(placed(pair.a), normal, height);
}

response::ContactRow make_row(WorldState& world, std::uint32_t place, std::size_t& degenerate) {
  FrameBuffers& buffers = world.buffers;
  ActivePair& pair = buffers.pairs[buffers.row_pair[place]];
  collision::PairContact& contact = pair.level.contact;
  if (pair.level.level == 0) {
    contact = coarsest_contact_of(world, pair);
  }
  response::ContactRow row;
  row.a = pair.a;
  row.b = pair.b;
  row.pair = buffers.row_pair[place];
  row.direction = contact.direction;
  row.moment_a_m = contact.moment_a_m;
  row.moment_b_m = contact.moment_b_m;
  row.surely_m = contact.surely_m;
  // The paper answers the spheres themselves; the wrench answers the surfaces that are likely inside them.
  row.gap_m = world.settings.contact == ContactModel::Paper ? contact.spheres_m : contact.likely_m;
  row.slop_m = kSlopOfSkin * pair.skin_m;
  row.restitution = std::max(world.materials[world.bodies.material[pair.a]].restitution,
                             world.materials[world.bodies.material[pair.b]].restitution);
  row.impulse_ns = pair.memory.impulse_ns;
  if (!response::prepare_row(row, world.bodies.inverse_mass[pair.a], buffers.inverse_inertia[pair.a],
                             world.bodies.inverse_mass[pair.b], buffers.inverse_inertia[pair.b])) {
    ++degenerate;
  }
  if (world.settings.contact == ContactModel::Paper) fill_points(world, pair, place, row);
  return row;
}

}  // namespace

void make_rows(WorldState& world, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  list_rows(world, report);
  report.contact_pairs = buffers.row_pair.size();
  report.colors_full = buffers.row_pair.size() - buffers.coloring.serial_begin();
  fill_bodies(world);
  buffers.rows.resize(buffers.row_pair.size());
  parallel::Tickets degenerate;
  parallel::parallel_for(*world.executor, buffers.rows.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    std::size_t found = 0;
    for (std::size_t k = begin; k < end; ++k) buffers.rows[k] = make_row(world, buffers.coloring.order()[k], found);
    if (found > 0) degenerate.take(found);
  });
  report.degenerate = degenerate.take(0);
}

response::System system_of(FrameBuffers& buffers) {
  return {buffers.solver_bodies, buffers.accelerations,   buffers.rows,    buffers.points,
          buffers.inverse_inertia, buffers.coloring, buffers.scratch};
}

// Impacts are over: rows whose pair rests by another wrench take that one, unless they have rebounded or would along it: a rebound is
// the business of the impact phase, which knows one direction alone.
void rest_by_own_wrench(WorldState& world, double still_mps) {
  FrameBuffers& buffers = world.buffers;
  parallel::parallel_for(*world.executor, buffers.rows.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      response::ContactRow& row = buffers.rows[k];
      const collision::PairContact& contact = buffers.pairs[row.pair].level.contact;
      if (contact.rest_direction.isZero(0) || row.bounces) continue;
      response::ContactRow rest = row;
      rest.direction = contact.rest_direction;
      rest.moment_a_m = contact.rest_moment_a_m;
      rest.moment_b_m = contact.rest_moment_b_m;
      response::prepare_row(rest, row.inverse_mass_a, buffers.inverse_inertia[row.a], row.inverse_mass_b, buffers.inverse_inertia[row.b]);
      if (rest.effective_mass == 0) continue;  // opposed directions cancel: one of them is better than none
      const double closing = response::approach_mps(rest, buffers.solver_bodies[row.a], buffers.solver_bodies[row.b]);
      if (row.restitution * closing > still_mps) continue;
      rest.point_impulse_ns += row.total_ns * row.direction;
      rest.total_ns = 0;
      row = rest;
    }
  });
}

response::Convergence respond(WorldState& world, const StepInput& input, FrameReport& report,
                              const response::Stopping& stopping) {
  make_rows(world, report);
  const response::System system = system_of(world.buffers);
  const response::SolveSettings settings{input.dt_s, world.settings.gravity_mps2, world.settings.substeps, stopping};
  const response::Convergence impacts = response::solve_impacts(system, settings, *world.executor);
  if (world.settings.contact == ContactModel::Fitted) rest_by_own_wrench(world, response::still_mps(settings));
  const response::Convergence rest = response::solve_rest(system, settings, *world.executor);
  return {impacts.reached && rest.reached, impacts.sweeps + rest.sweeps};
}

}  // namespace poise::simulation
