// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "simulation/stages.h"

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
    return collision::PlacedRoot{world.bodies.shape[slot].get(), buffers.glances[slot].root_center_m,
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
std::uint8_t count_places(const WorldState& world, const ActivePair& pair, const collision::LevelContact& found) {
  if (pair.apart()) return 0;
  if (pair.by_kept()) return pair.memory.place_count;
  if (pair.level.level == 0) return pair.exact || coarsest_near(world, pair) ? 1 : 0;
  return static_cast<std::uint8_t>(1 + found.patches.count);
}

template <class T>
std::span<T> resting(std::span<T> places) {
  return places.size() > 1 ? places.subspan(1) : places;
}

// New places take over the loads of the old ones that are nearest to them and look the same way.
void hand_over(std::span<const response::RestPlace> old, std::span<const response::RestLoad> borne, double size_m,
               std::span<const response::RestPlace> places, std::span<response::RestLoad> loads) {
  constexpr double kLike = 0.7;
  std::array<bool, kPlacesOfPair> taken{};
  for (std::size_t i = 0; i < places.size(); ++i) {
    double least = size_m * size_m;
    std::size_t nearest = old.size();
    for (std::size_t k = 0; k < old.size(); ++k) {
      const double square = (old[k].on_a_m - places[i].on_a_m).squaredNorm();
      if (taken[k] || square >= least || old[k].normal.dot(places[i].normal) < kLike) continue;
      least = square;
      nearest = k;
    }
    if (nearest == old.size()) continue;
    taken[nearest] = true;
    loads[i] = borne[nearest];
  }
}

// Places that this frame has found out, fixed to the bodies of their pair.
void find_places(WorldState& world, const ActivePair& pair, collision::LevelContact& found) {
  // New places within this many skins of old ones are taken for them: a quarter of the smaller body's radius.
  constexpr double kSameOfSkin = 50;
  const std::span<response::RestPlace> places = world.places.places_of(pair.memory.room, pair.place_count);
  const std::span<response::RestLoad> loads = world.places.loads_of(pair.memory.room, pair.place_count);
  std::array<response::RestPlace, kPlacesOfPair> old;
  std::array<response::RestLoad, kPlacesOfPair> borne;
  const std::size_t olds = pair.memory.place_count;
  std::copy_n(world.places.places.begin() + static_cast<std::ptrdiff_t>(PlaceStore::begin(pair.memory.room)), olds,
              old.begin());
  std::copy_n(world.places.loads.begin() + static_cast<std::ptrdiff_t>(PlaceStore::begin(pair.memory.room)), olds,
              borne.begin());
  const PlacedPair where = placed_pair(world, pair);
  if (pair.level.level == 0 && !pair.exact) found.contact = coarsest_contact_of(world, pair);
  places[0] = keep(where, collision::lone_patch(found.contact, where.a.rotation));
  for (std::size_t k = 1; k < places.size(); ++k) places[k] = keep(where, found.patches.patch[k - 1]);
  std::fill(loads.begin(), loads.end(), response::RestLoad{});
  hand_over(resting(std::span<const response::RestPlace>(old).first(olds)),
            resting(std::span<const response::RestLoad>(borne).first(olds)), kSameOfSkin * pair.skin_m,
            resting(std::span<const response::RestPlace>(places)), resting(loads));
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
void look_at_places(WorldState& world, ActivePair& pair) {
  PairMemory& memory = pair.memory;
  const bool known = pair.by_kept() && std::abs(memory.nearest_m - pair.margin_m) > memory.changed_m();
  if (!known) {
    const collision::Pose& a = world.buffers.poses[pair.a];
    const collision::Pose& b = world.buffers.poses[pair.b];
    const std::span<const response::RestPlace> places = world.places.places_of(pair.memory.room, pair.place_count);
    const Mat3 a_in_b = b.rotation.transpose() * a.rotation;
    const Vec3 from_b = b.rotation.transpose() * (a.position_m - b.position_m);
    memory.nearest_m = std::numeric_limits<double>::max();
    for (std::size_t k = 0; k < places.size(); ++k) {
      const double gap_m = places[k].normal.dot(places[k].on_b_m - from_b - a_in_b * places[k].on_a_m);
      memory.nearest_m = std::min(memory.nearest_m, gap_m);
      if (k == 0) memory.lone_m = gap_m;
    }
    memory.looked_m = pair.by_kept() ? memory.moved_m : 0.0;
  }
  pair.answered = memory.nearest_m < pair.margin_m;
  if (pair.answered || (pair.by_kept() && !memory.answered)) return;
  // Nothing holds it: what it bore is over.
  for (response::RestLoad& load : world.places.loads_of(pair.memory.room, pair.place_count)) load = {};
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
response::RestPair rest_pair(const WorldState& world, std::size_t i, bool fast) {
  const ActivePair& pair = world.buffers.pairs[i];
  const Material material = mixed(world, pair);
  const bool lone = pair.place_count == 1;
  response::RestPair rest;
  rest.a = pair.a;
  rest.b = pair.b;
  rest.place_begin = static_cast<std::uint32_t>(PlaceStore::begin(pair.memory.room) + (lone ? 0U : 1U));
  rest.pair = static_cast<std::uint32_t>(i);
  rest.place_count = lone ? std::uint8_t{1} : static_cast<std::uint8_t>(pair.place_count - 1);
  rest.fast = fast;
  rest.friction = material.friction;
  rest.restitution = material.restitution;
  rest.slop_m = kSlopOfSkin * pair.skin_m;
  return rest;
}

}  // namespace

void lay_out_places(WorldState& world, double dt_s, double still_mps) {
  FrameBuffers& buffers = world.buffers;
  buffers.answered_of_chunk.assign(buffers.chunks(), AnsweredCount{});
  buffers.rest_of_chunk.reserve(buffers.pairs.capacity());
  buffers.rest_of_chunk.resize(buffers.pairs.size());
  const auto for_chunks = [&](auto&& visit) {
    parallel::parallel_for(*world.executor, buffers.chunks(), 2, [&](std::size_t first, std::size_t past, int) {
      for (std::size_t chunk = first; chunk < past; ++chunk) visit(chunk, buffers.answered_of_chunk[chunk]);
    });
  };
  for_chunks([&](std::size_t chunk, AnsweredCount& count) {
    if (buffers.known_of_chunk[chunk].roomless == 0) return;
    for (std::size_t i = buffers.begin_of(chunk); i < buffers.end_of(chunk); ++i) {
      const ActivePair& pair = buffers.pairs[i];
      if (pair.memory.room == kNoRoom && count_places(world, pair, buffers.found[i]) > 0) ++count.new_rooms;
    }
  });
  std::uint32_t rooms = 0;
  for (AnsweredCount& count : buffers.answered_of_chunk)
    count.new_rooms = std::exchange(rooms, rooms + count.new_rooms);
  // A pair may gain places in any later frame; room for these costs no memory until it is used.
  world.places.reserve(2 * buffers.pairs.capacity());
  world.places.make_room(rooms);
  for_chunks([&](std::size_t chunk, AnsweredCount& count) {
    for (std::size_t i = buffers.begin_of(chunk); i < buffers.end_of(chunk); ++i) {
      ActivePair& pair = buffers.pairs[i];
      pair.place_count = count_places(world, pair, buffers.found[i]);
      pair.answered = false;
      if (pair.place_count > 0) {
        if (pair.memory.room == kNoRoom) pair.memory.room = world.places.room(count.new_rooms++);
        if (!pair.by_kept()) find_places(world, pair, buffers.found[i]);
        look_at_places(world, pair);
      }
      if (!pair.apart() && pair.refinable()) ++count.left;
      if (pair.kept == Kept::Apart) ++count.kept_apart;
      if (!pair.answered) continue;
      const response::RestPair rest = rest_pair(world, i, may_be_fast(world, pair, dt_s, still_mps));
      count.any_fast = count.any_fast || rest.fast;
      buffers.rest_of_chunk[buffers.begin_of(chunk) + count.answered++] = rest;
      count.rest_places += rest.place_count;
      if (pair.by_kept()) ++count.kept_contacts;
      ++count.levels[pair.by_polygons() ? kPolygonPlace : pair.answered_level()];
    }
  });
  world.places.use_up(rooms);
}

void list_answered(WorldState& world, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  std::uint32_t answered = 0;
  buffers.rest_places = 0;
  for (AnsweredCount& count : buffers.answered_of_chunk) {
    count.before = answered;
    answered += count.answered;
    buffers.rest_places += count.rest_places;
    report.pairs_left += count.left;
    report.kept_apart += count.kept_apart;
    report.kept_contacts += count.kept_contacts;
    for (std::size_t level = 0; level < count.levels.size(); ++level)
      report.level_histogram[level] += count.levels[level];
  }
  // All grow with the pairs, so that later frames whose share of answered pairs is larger need no room of their own.
  const std::size_t room = buffers.pairs.capacity();
  buffers.rest_pairs.reserve(room);
  buffers.edges.reserve(room);
  buffers.given_ns.reserve(room);
  buffers.coloring.reserve(room);
  buffers.rows.reserve(room);
  buffers.scratch.gates.reserve(room);
  buffers.rest_pairs.resize(answered);
  buffers.edges.resize(answered);
  buffers.given_ns.resize(answered);
  buffers.impacts = std::any_of(buffers.answered_of_chunk.begin(), buffers.answered_of_chunk.end(),
                                [](const AnsweredCount& count) { return count.any_fast; });
  parallel::parallel_for(*world.executor, buffers.chunks(), 2, [&](std::size_t first, std::size_t past, int) {
    for (std::size_t chunk = first; chunk < past; ++chunk) {
      const AnsweredCount& count = buffers.answered_of_chunk[chunk];
      for (std::uint32_t k = 0; k < count.answered; ++k) {
        const response::RestPair& rest = buffers.rest_of_chunk[buffers.begin_of(chunk) + k];
        buffers.rest_pairs[count.before + k] = rest;
        buffers.edges[count.before + k] = {rest.a, rest.b, world.bodies.dynamic[rest.a] != 0,
                                           world.bodies.dynamic[rest.b] != 0, rest.place_count};
      }
    }
  });
  buffers.coloring.color(buffers.edges, world.bodies.slot_count());
  report.contact_pairs = answered;
  report.colors_full = answered - buffers.coloring.serial_begin();
}

}  // namespace poise::simulation
