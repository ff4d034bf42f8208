// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include "parallel/shared.h"
#include "simulation/stages.h"
#include "simulation/swept.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kGrain = 256;
// Overlap that is left alone, as a share of the skin. Chosen: keeps contacts closed without being seen.
constexpr double kSlopOfSkin = 1e-4;

PlacedPair placed_pair(const WorldState& world, const ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  const Shape& shape_b = *world.bodies.shape[pair.b];
  PlacedPair made{buffers.poses[pair.a], buffers.poses[pair.b], shape_b.kind == ShapeKind::Plane, 0};
  if (made.plane) made.height_m = (made.b.rotation * shape_b.plane_normal).dot(made.b.position_m) + shape_b.plane_offset_m;
  return made;
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

// How many places a pair has in this frame. The first answers impacts; it rests at the others, or at the first where that is alone.
std::uint8_t count_places(const ActivePair& pair) {
  if (pair.apart()) return 0;
  if (pair.by_kept()) return pair.memory.place_count;
  if (pair.level.level == 0) return 1;
  return static_cast<std::uint8_t>(1 + pair.level.patches.count);
}

std::span<KeptPlace> resting(std::span<KeptPlace> places) { return places.size() > 1 ? places.subspan(1) : places; }

// New places take over the impulses of the old ones that are nearest to them and look the same way.
void hand_over(std::span<const KeptPlace> old, double size_m, std::span<KeptPlace> places) {
  constexpr double kLike = 0.7;
  std::array<bool, collision::kMaxPatches + 1> taken{};
  for (KeptPlace& place : places) {
    double least = size_m * size_m;
    std::size_t nearest = old.size();
    for (std::size_t k = 0; k < old.size(); ++k) {
      const double square = (old[k].on_a_m - place.on_a_m).squaredNorm();
      if (taken[k] || square >= least || old[k].normal.dot(place.normal) < kLike) continue;
      least = square;
      nearest = k;
    }
    if (nearest == old.size()) continue;
    taken[nearest] = true;
    place.impulse_ns = old[nearest].impulse_ns;
    place.friction_ns = old[nearest].friction_ns;
  }
}

// The places of a pair, fixed to its bodies and where they are now.
void set_places(WorldState& world, ActivePair& pair) {
  // New places within this many skins of old ones are taken for them: a quarter of the smaller body's radius.
  constexpr double kSameOfSkin = 50;
  FrameBuffers& buffers = world.buffers;
  const std::span<KeptPlace> places = std::span(buffers.places).subspan(pair.place_begin, pair.place_count);
  const std::span<response::RestPatch> patches = std::span(buffers.rest_patches).subspan(pair.place_begin, pair.place_count);
  const std::span<KeptPlace> old = std::span(world.places).subspan(pair.memory.place_begin, pair.memory.place_count);
  const PlacedPair where = placed_pair(world, pair);
  if (pair.by_kept()) {
    std::copy(old.begin(), old.end(), places.begin());
  } else {
    if (pair.level.level == 0 && !pair.exact) pair.level.contact = coarsest_contact_of(world, pair);
    places[0] = keep(where, collision::lone_patch(pair.level.contact, where.a.rotation));
    for (std::size_t k = 0; k < pair.level.patches.count && pair.level.level > 0; ++k) places[k + 1] = keep(where, pair.level.patches.patch[k]);
    hand_over(resting(old), kSameOfSkin * pair.skin_m, resting(places));
  }
  pair.answered = false;
  for (std::size_t k = 0; k < places.size(); ++k) {
    patches[k] = placed(where, places[k]);
    pair.answered = pair.answered || patches[k].gap_m < pair.margin_m;
  }
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

// Places of all pairs, one pair after another.
void lay_out_places(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  std::uint32_t places = 0;
  for (ActivePair& pair : buffers.pairs) {
    pair.place_begin = places;
    pair.place_count = count_places(pair);
    places += pair.place_count;
  }
  // A pair may gain places in any later frame; room for the most that it can have costs no memory until it is used.
  const std::size_t room = buffers.pairs.capacity() * (collision::kMaxPatches + 1);
  buffers.places.reserve(room);
  buffers.rest_patches.reserve(room);
  buffers.places.resize(places);
  buffers.rest_patches.resize(places);
  parallel::parallel_for(*world.executor, buffers.pairs.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      buffers.pairs[i].answered = false;
      if (buffers.pairs[i].place_count > 0) set_places(world, buffers.pairs[i]);
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
  const std::size_t room = buffers.pairs.capacity();
  buffers.row_pair.reserve(room);
  buffers.edges.reserve(room);
  buffers.points_begin.reserve(room + 1);
  buffers.rows.reserve(room);
  buffers.rest_pairs.reserve(room);
  buffers.scratch.gates.reserve(room);
  std::uint32_t points = 0;
  const bool by_points = world.settings.contact == ContactModel::Paper;
  for (std::size_t i = 0; i < buffers.pairs.size(); ++i) {
    const ActivePair& pair = buffers.pairs[i];
    if (!pair.apart() && pair.refinable()) ++report.pairs_left;
    if (pair.kept == Kept::Apart) ++report.kept_apart;
    if (!pair.answered) continue;
    if (pair.by_kept()) ++report.kept_contacts;
    ++report.level_histogram[pair.by_polygons() ? kPolygonPlace : pair.answered_level()];
    buffers.row_pair.push_back(static_cast<std::uint32_t>(i));
    buffers.edges.push_back({pair.a, pair.b, world.bodies.dynamic[pair.a] != 0, world.bodies.dynamic[pair.b] != 0});
    buffers.points_begin.push_back(points);
    if (by_points && !pair.by_polygons()) points += pair.level.front_entries;
  }
  buffers.points_begin.push_back(points);
  buffers.points.resize(points);
  buffers.coloring.reserve(room);
  buffers.coloring.color(buffers.edges, world.bodies.slot_count());
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

Material mixed(const WorldState& world, const ActivePair& pair) {
  const Material& a = world.materials[world.bodies.material[pair.a]];
  const Material& b = world.materials[world.bodies.material[pair.b]];
  Material both;
  both.restitution = std::max(a.restitution, b.restitution);
  both.friction = std::sqrt(a.friction * b.friction);
  return both;
}

// What every row has.
void outline_row(const WorldState& world, std::uint32_t place, response::ContactRow& row) {
  const FrameBuffers& buffers = world.buffers;
  row.pair = buffers.row_pair[place];
  const ActivePair& pair = buffers.pairs[row.pair];
  const Material material = mixed(world, pair);
  row.a = pair.a;
  row.b = pair.b;
  row.bounces = false;
  row.gap_m = buffers.rest_patches[pair.place_begin].gap_m;
  // The paper answers the spheres themselves; the others answer the surfaces that are likely inside them.
  if (world.settings.contact == ContactModel::Paper && !pair.by_kept()) row.gap_m = pair.level.contact.spheres_m;
  row.restitution = material.restitution;
  row.friction = material.friction;
  row.total_ns = 0;
  row.point_impulse_ns.setZero();
}

// May the bodies of a row close so fast that it is an impact, at any of their points?
bool may_be_fast(const WorldState& world, const response::ContactRow& row, double still_mps) {
  const response::SolverBody& a = world.buffers.solver_bodies[row.a];
  const response::SolverBody& b = world.buffers.solver_bodies[row.b];
  const auto reach_m = [&](std::uint32_t slot) {
    const Shape& shape = *world.bodies.shape[slot];
    return shape.kind == ShapeKind::Plane ? 0.0 : shape.bounding_radius_m;
  };
  const double closing = (a.velocity_mps - b.velocity_mps).norm() + a.spin_radps.norm() * reach_m(row.a) + b.spin_radps.norm() * reach_m(row.b);
  return closing > still_mps;
}

// What an impact needs.
class PairRows final : public response::RowSource {
 public:
  PairRows(WorldState& world, parallel::Tickets& degenerate) : world_(world), degenerate_(degenerate) {}
  void fill(std::size_t k) const override {
    FrameBuffers& buffers = world_.buffers;
    response::ContactRow& row = buffers.rows[k];
    const ActivePair& pair = buffers.pairs[row.pair];
    row.a_to_b_m = buffers.poses[pair.b].position_m - buffers.poses[pair.a].position_m;
    row.points_begin = row.points_end = row.patches_begin = row.patches_end = 0;
    if (pair.place_count > 1) {
      row.patches_begin = pair.place_begin + 1;
      row.patches_end = pair.place_begin + pair.place_count;
    }
    if (pair.by_kept()) {
      const response::RestPatch& kept = buffers.rest_patches[pair.place_begin];
      row.direction = kept.normal;
      row.arm_m = kept.arm_m;
      row.moment_a_m = row.arm_m.cross(row.direction);
      row.moment_b_m = (row.arm_m - row.a_to_b_m).cross(row.direction);
    } else {
      const collision::PairContact& contact = pair.level.contact;
      row.direction = contact.direction;
      row.arm_m = contact.arm_m;
      row.moment_a_m = contact.moment_a_m;
      row.moment_b_m = contact.moment_b_m;
    }
    const auto& inverse_mass = world_.bodies.inverse_mass;
    if (!response::prepare_row(row, inverse_mass[pair.a], buffers.inverse_inertia[pair.a], inverse_mass[pair.b], buffers.inverse_inertia[pair.b])) {
      degenerate_.take(1);
    }
    if (world_.settings.contact == ContactModel::Paper) fill_points(world_, pair, buffers.coloring.order()[k], row);
  }

 private:
  WorldState& world_;
  parallel::Tickets& degenerate_;
};

// What of a pair may rest, once impacts are over.
response::RestPair rest_pair(const WorldState& world, const response::ContactRow& row) {
  const ActivePair& pair = world.buffers.pairs[row.pair];
  response::RestPair rest;
  rest.a = row.a;
  rest.b = row.b;
  const bool lone = pair.place_count == 1;
  rest.patch_begin = pair.place_begin + (lone ? 0 : 1);
  // A pair that is about to rebound is the business of the impact phase.
  rest.patch_count = row.bounces ? 0 : lone ? 1 : pair.place_count - 1U;
  rest.friction = row.friction;
  rest.restitution = row.restitution;
  rest.slop_m = kSlopOfSkin * pair.skin_m;
  rest.a_to_b_m = world.buffers.poses[pair.b].position_m - world.buffers.poses[pair.a].position_m;
  return rest;
}

}  // namespace

void make_rows(WorldState& world, double still_mps, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  lay_out_places(world);
  list_rows(world, report);
  report.contact_pairs = buffers.row_pair.size();
  report.colors_full = buffers.row_pair.size() - buffers.coloring.serial_begin();
  fill_bodies(world);
  buffers.rows.resize(buffers.row_pair.size());
  buffers.scratch.gates.resize(buffers.rows.size());
  parallel::parallel_for(*world.executor, buffers.rows.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      response::ContactRow& row = buffers.rows[k];
      outline_row(world, buffers.coloring.order()[k], row);
      buffers.scratch.gates[k] = {row.a, row.b, may_be_fast(world, row, still_mps), false};
    }
  });
}

response::System system_of(FrameBuffers& buffers) {
  return {buffers.solver_bodies, buffers.rows, buffers.points, buffers.rest_patches, buffers.inverse_inertia, buffers.coloring, buffers.scratch};
}

void fill_rows(WorldState& world) {
  parallel::Tickets degenerate;
  const PairRows source(world, degenerate);
  for (std::size_t k = 0; k < world.buffers.rows.size(); ++k) source.fill(k);
}

response::Convergence respond(WorldState& world, const StepInput& input, FrameReport& report,
                              const response::Stopping& stopping) {
  const response::SolveSettings settings{input.dt_s, world.settings.gravity_mps2, world.settings.substeps, stopping};
  make_rows(world, response::still_mps(settings), report);
  FrameBuffers& buffers = world.buffers;
  parallel::Tickets degenerate;
  const PairRows source(world, degenerate);
  response::System impact = system_of(buffers);
  impact.source = &source;
  const response::Convergence impacts = response::solve_impacts(impact, settings, *world.executor);
  report.degenerate = degenerate.take(0);
  buffers.rest_pairs.resize(buffers.rows.size());
  parallel::parallel_for(*world.executor, buffers.rows.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) buffers.rest_pairs[k] = rest_pair(world, buffers.rows[k]);
  });
  const response::RestSystem system{buffers.solver_bodies, buffers.accelerations, buffers.inverse_inertia,
                                    buffers.rest_pairs,    buffers.rest_patches,  buffers.coloring};
  const response::Convergence rest = world.rest_solver.solve(system, settings, *world.executor);
  if (input.backtracking) answer_swept(world, input, report);
  return {impacts.reached && rest.reached, impacts.sweeps + rest.sweeps};
}

// What resting contact came to goes into the memory of the pairs.
void keep_impulses(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  parallel::parallel_for(*world.executor, buffers.pairs.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const ActivePair& pair = buffers.pairs[i];
      if (pair.place_count == 0) continue;
      const std::span<KeptPlace> places = resting(std::span(buffers.places).subspan(pair.place_begin, pair.place_count));
      const PlacedPair where = placed_pair(world, pair);
      const std::size_t first = pair.place_begin + (pair.place_count == 1 ? 0U : 1U);
      for (std::size_t k = 0; k < places.size(); ++k) {
        if (pair.answered) {
          keep_impulse(where, buffers.rest_patches[first + k], places[k]);
        } else {
          places[k].impulse_ns = 0;
          places[k].friction_ns.setZero();
        }
      }
    }
  });
}

}  // namespace poise::simulation
