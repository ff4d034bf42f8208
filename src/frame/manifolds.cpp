// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "frame/stages.h"

namespace poise::simulation {
namespace {

// Overlap that is left alone, as a share of the skin. Chosen: keeps contacts closed without being seen.
constexpr double kSlopOfSkin = 1e-4;

PlacedPair placed_pair(const WorldState& world, const ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  const Shape& shape_b = *world.bodies.shape[pair.b];
  PlacedPair made{buffers.poses[pair.a], buffers.poses[pair.b], shape_b.kind == ShapeKind::Plane, 0};
  if (made.plane)
    made.height_m = (made.b.rotation * shape_b.plane_normal).dot(made.b.position_m) + shape_b.plane_offset_m;
  return made;
}

collision::PairContact coarsest_contact_of(const WorldState& world, const ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  const auto placed = [&](std::uint32_t slot) {
    return collision::PlacedRoot{world.bodies.shape[slot].get(), buffers.body_bounds[slot].root_center_m,
                                 buffers.poses[slot].position_m};
  };
  const Shape& shape_b = *world.bodies.shape[pair.b];
  if (shape_b.kind == ShapeKind::Tree) return collision::coarsest_contact(placed(pair.a), placed(pair.b));
  const Vec3 normal = buffers.poses[pair.b].rotation * shape_b.plane_normal;
  const double height = normal.dot(buffers.poses[pair.b].position_m) + shape_b.plane_offset_m;
  return collision::coarsest_plane_contact(placed(pair.a), normal, height);
}

// How many places a pair has in this frame. The first answers impacts; it rests at the others, or at the first where
// that is alone.
std::uint8_t count_points(const WorldState& world, const ActivePair& pair, const collision::LevelContact& found) {
  if (pair.apart()) return 0;
  if (pair.from_cache()) return pair.memory.point_count;
  if (pair.level.level == 0) return pair.exact || coarsest_near(world, pair) ? 1 : 0;
  return static_cast<std::uint8_t>(1 + found.manifold_points.count);
}

template <class T>
std::span<T> resting(std::span<T> points) {
  return points.size() > 1 ? points.subspan(1) : points;
}

// New places take over the loads of the old ones that are nearest to them and look the same way.
void hand_over(std::span<const solver::ContactPoint> old, std::span<const solver::AccumulatedImpulse> borne,
               double size_m, std::span<const solver::ContactPoint> points,
               std::span<solver::AccumulatedImpulse> loads) {
  constexpr double kLike = 0.7;
  std::array<bool, kPointsOfPair> taken{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    double least = size_m * size_m;
    std::size_t nearest = old.size();
    for (std::size_t k = 0; k < old.size(); ++k) {
      const double square = (old[k].on_a_m - points[i].on_a_m).squaredNorm();
      if (taken[k] || square >= least || old[k].normal.dot(points[i].normal) < kLike) continue;
      least = square;
      nearest = k;
    }
    if (nearest == old.size()) continue;
    taken[nearest] = true;
    loads[i] = borne[nearest];
  }
}

// Places that this frame has found out, fixed to the bodies of their pair.
void find_points(WorldState& world, const ActivePair& pair, collision::LevelContact& found) {
  // New places within this many skins of old ones are taken for them: a quarter of the smaller body's radius.
  constexpr double kSameOfSkin = 50;
  const std::span<solver::ContactPoint> points = world.points.points_of(pair.memory.room, pair.point_count);
  const std::span<solver::AccumulatedImpulse> loads = world.points.impulses_of(pair.memory.room, pair.point_count);
  std::array<solver::ContactPoint, kPointsOfPair> old;
  std::array<solver::AccumulatedImpulse, kPointsOfPair> borne;
  const std::size_t olds = pair.memory.point_count;
  std::copy_n(world.points.points.begin() + static_cast<std::ptrdiff_t>(ContactCache::begin(pair.memory.room)), olds,
              old.begin());
  std::copy_n(world.points.loads.begin() + static_cast<std::ptrdiff_t>(ContactCache::begin(pair.memory.room)), olds,
              borne.begin());
  const PlacedPair where = placed_pair(world, pair);
  if (pair.level.level == 0 && !pair.exact) found.contact = coarsest_contact_of(world, pair);
  points[0] = keep(where, collision::impact_point(found.contact, where.a.rotation));
  for (std::size_t k = 1; k < points.size(); ++k) points[k] = keep(where, found.manifold_points.point[k - 1]);
  std::fill(loads.begin(), loads.end(), solver::AccumulatedImpulse{});
  hand_over(resting(std::span<const solver::ContactPoint>(old).first(olds)),
            resting(std::span<const solver::AccumulatedImpulse>(borne).first(olds)), kSameOfSkin * pair.skin_m,
            resting(std::span<const solver::ContactPoint>(points)), resting(loads));
}

// May the bodies of a pair close so fast that it is an impact, at any of their points? What its margin was made of says
// so.
bool may_be_fast(const WorldState& world, const ActivePair& pair, double dt_s, double still_mps) {
  double closing_m = pair.margin_m - pair.skin_m;
  if (pair.exact) return true;  // its margin is another
  if (world.bodies.dynamic[pair.a] == 0 || world.bodies.dynamic[pair.b] == 0)
    closing_m -= world.settings.gravity_mps2.norm() * dt_s * dt_s;
  return closing_m > still_mps * dt_s;
}

// Is one of its places nearer than the margin? Where the last look still says so for sure, no other is needed.
void update_separations(WorldState& world, ActivePair& pair) {
  CachedPair& memory = pair.memory;
  const bool known = pair.from_cache() && std::abs(memory.nearest_m - pair.margin_m) > memory.changed_m();
  if (!known) {
    const collision::Pose& a = world.buffers.poses[pair.a];
    const collision::Pose& b = world.buffers.poses[pair.b];
    const std::span<const solver::ContactPoint> points = world.points.points_of(pair.memory.room, pair.point_count);
    const Mat3 a_in_b = b.rotation.transpose() * a.rotation;
    const Vec3 from_b = b.rotation.transpose() * (a.position_m - b.position_m);
    memory.nearest_m = std::numeric_limits<double>::max();
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double gap_m = points[k].normal.dot(points[k].on_b_m - from_b - a_in_b * points[k].on_a_m);
      memory.nearest_m = std::min(memory.nearest_m, gap_m);
      if (k == 0) memory.impact_gap_m = gap_m;
    }
    memory.looked_m = pair.from_cache() ? memory.moved_m : 0.0;
  }
  pair.solved = memory.nearest_m < pair.margin_m;
  if (pair.solved || (pair.from_cache() && !memory.solved)) return;
  // Nothing holds it: what it bore is over.
  for (solver::AccumulatedImpulse& load : world.points.impulses_of(pair.memory.room, pair.point_count)) load = {};
}

Material mixed(const WorldState& world, const ActivePair& pair) {
  const Material& a = world.materials[world.bodies.material[pair.a]];
  const Material& b = world.materials[world.bodies.material[pair.b]];
  Material both;
  both.restitution = std::max(a.restitution, b.restitution);
  both.friction = std::sqrt(a.friction * b.friction);
  return both;
}

// Where a pair may rest, once impacts are over.
solver::Manifold make_manifold(const WorldState& world, std::size_t i, bool fast) {
  const ActivePair& pair = world.buffers.pairs[i];
  const Material material = mixed(world, pair);
  const bool single = pair.point_count == 1;
  solver::Manifold rest;
  rest.a = pair.a;
  rest.b = pair.b;
  rest.point_begin = static_cast<std::uint32_t>(ContactCache::begin(pair.memory.room) + (single ? 0U : 1U));
  rest.pair = static_cast<std::uint32_t>(i);
  rest.point_count = single ? std::uint8_t{1} : static_cast<std::uint8_t>(pair.point_count - 1);
  rest.fast = fast;
  rest.friction = material.friction;
  rest.restitution = material.restitution;
  rest.slop_m = kSlopOfSkin * pair.skin_m;
  return rest;
}

}  // namespace

void find_manifold_points(WorldState& world, double dt_s, double still_mps) {
  FrameBuffers& buffers = world.buffers;
  buffers.solved_of_chunk.assign(buffers.chunks(), SolvedCount{});
  buffers.manifolds_of_chunk.reserve(buffers.pairs.capacity());
  buffers.manifolds_of_chunk.resize(buffers.pairs.size());
  const auto for_chunks = [&](auto&& visit) {
    parallel::parallel_for(*world.executor, buffers.chunks(), 2, [&](std::size_t first, std::size_t past, int) {
      for (std::size_t chunk = first; chunk < past; ++chunk) visit(chunk, buffers.solved_of_chunk[chunk]);
    });
  };
  for_chunks([&](std::size_t chunk, SolvedCount& count) {
    if (buffers.known_of_chunk[chunk].without_slot == 0) return;
    for (std::size_t i = buffers.begin_of(chunk); i < buffers.end_of(chunk); ++i) {
      const ActivePair& pair = buffers.pairs[i];
      if (pair.memory.room == kNoSlot && count_points(world, pair, buffers.found[i]) > 0) ++count.new_slots;
    }
  });
  std::uint32_t rooms = 0;
  for (SolvedCount& count : buffers.solved_of_chunk) count.new_slots = std::exchange(rooms, rooms + count.new_slots);
  // A pair may gain places in any later frame; room for these costs no memory until it is used.
  world.points.reserve(2 * buffers.pairs.capacity());
  world.points.reserve_slots(rooms);
  for_chunks([&](std::size_t chunk, SolvedCount& count) {
    for (std::size_t i = buffers.begin_of(chunk); i < buffers.end_of(chunk); ++i) {
      ActivePair& pair = buffers.pairs[i];
      pair.point_count = count_points(world, pair, buffers.found[i]);
      pair.solved = false;
      if (pair.point_count > 0) {
        if (pair.memory.room == kNoSlot) pair.memory.room = world.points.room(count.new_slots++);
        if (!pair.from_cache()) find_points(world, pair, buffers.found[i]);
        update_separations(world, pair);
      }
      if (!pair.apart() && pair.refinable()) ++count.left;
      if (pair.cached == CacheUse::Separated) ++count.cached_separations;
      if (!pair.solved) continue;
      const solver::Manifold rest = make_manifold(world, i, may_be_fast(world, pair, dt_s, still_mps));
      count.any_fast = count.any_fast || rest.fast;
      buffers.manifolds_of_chunk[buffers.begin_of(chunk) + count.solved++] = rest;
      count.manifold_points += rest.point_count;
      if (pair.from_cache()) ++count.cached_contacts;
      ++count.levels[pair.by_polygons() ? kPolygonBin : pair.solved_level()];
    }
  });
  world.points.use_up(rooms);
}

void list_solved(WorldState& world, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  std::uint32_t solved = 0;
  buffers.manifold_points = 0;
  for (SolvedCount& count : buffers.solved_of_chunk) {
    count.before = solved;
    solved += count.solved;
    buffers.manifold_points += count.manifold_points;
    report.pairs_left += count.left;
    report.cached_separations += count.cached_separations;
    report.cached_contacts += count.cached_contacts;
    for (std::size_t level = 0; level < count.levels.size(); ++level)
      report.level_histogram[level] += count.levels[level];
  }
  // All grow with the pairs, so that later frames whose share of answered pairs is larger need no room of their own.
  const std::size_t room = buffers.pairs.capacity();
  buffers.manifolds.reserve(room);
  buffers.edges.reserve(room);
  buffers.applied_impulse_ns.reserve(room);
  buffers.coloring.reserve(room);
  buffers.rows.reserve(room);
  buffers.scratch.activations.reserve(room);
  buffers.manifolds.resize(solved);
  buffers.edges.resize(solved);
  buffers.applied_impulse_ns.resize(solved);
  buffers.impacts = std::any_of(buffers.solved_of_chunk.begin(), buffers.solved_of_chunk.end(),
                                [](const SolvedCount& count) { return count.any_fast; });
  parallel::parallel_for(*world.executor, buffers.chunks(), 2, [&](std::size_t first, std::size_t past, int) {
    for (std::size_t chunk = first; chunk < past; ++chunk) {
      const SolvedCount& count = buffers.solved_of_chunk[chunk];
      for (std::uint32_t k = 0; k < count.solved; ++k) {
        const solver::Manifold& rest = buffers.manifolds_of_chunk[buffers.begin_of(chunk) + k];
        buffers.manifolds[count.before + k] = rest;
        buffers.edges[count.before + k] = {rest.a, rest.b, world.bodies.dynamic[rest.a] != 0,
                                           world.bodies.dynamic[rest.b] != 0, rest.point_count};
      }
    }
  });
  buffers.coloring.color(buffers.edges, world.bodies.slot_count());
  report.contact_pairs = solved;
  report.colors_full = solved - buffers.coloring.serial_begin();
}

}  // namespace poise::simulation
