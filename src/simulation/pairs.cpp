// SPDX-License-Identifier: MIT
#include <algorithm>
#include <numeric>

#include "parallel/shared.h"
#include "simulation/cues.h"
#include "simulation/stages.h"

namespace poise::simulation {
namespace {

// Gaps below this share of the smaller body count as touching. Chosen: half a percent is below what a coarse level can
// tell apart, and keeps resting contacts from flickering.
constexpr double kSkin = 5e-3;
constexpr std::size_t kGrain = 128;

double motion_bound_m(const WorldState& world, std::size_t slot, const StepInput& input) {
  if (world.bodies.dynamic[slot] == 0) return 0;
  const double speed = world.bodies.velocity(slot).norm();
  double pull = world.settings.gravity_mps2.norm();
  if (world.bodies.pushed[slot] != 0) pull += world.bodies.force(slot).norm() * world.bodies.inverse_mass[slot];
  return (speed + pull * input.dt_s) * input.dt_s;
}

// How much the gap of two bodies may close in the step, by their own motion.
double margin_m(const WorldState& world, std::size_t a, std::size_t b, double skin_m, const StepInput& input) {
  const dynamics::BodyStore& bodies = world.bodies;
  const double h = input.dt_s;
  double closing = (bodies.velocity(a) - bodies.velocity(b)).norm() * h;
  for (const std::size_t i : {a, b}) {
    // The surface moves by the spin at most across the body.
    const double radius = bodies.shape[i]->bounding_radius_m;
    closing += std::min(bodies.spin(i).norm() * h, 2.0) * radius;
    if (bodies.pushed[i] != 0) closing += bodies.force(i).norm() * bodies.inverse_mass[i] * h * h;
  }
  // Gravity closes only what it does not pull alike.
  if (bodies.dynamic[a] == 0 || bodies.dynamic[b] == 0) closing += world.settings.gravity_mps2.norm() * h * h;
  return closing + skin_m;
}

const PairMemory* remembered(const std::vector<PairMemory>& memory, std::uint32_t low, std::uint32_t high) {
  const auto at = std::lower_bound(memory.begin(), memory.end(), std::pair(low, high),
                                   [](const PairMemory& m, const std::pair<std::uint32_t, std::uint32_t>& key) {
                                     return std::pair(m.low, m.high) < key;
                                   });
  return at != memory.end() && at->low == low && at->high == high ? &*at : nullptr;
}

// Slots and margins of a candidate; nothing that needs its shapes refined.
ActivePair outlined(const WorldState& world, const collision::CandidatePair& candidate, const StepInput& input) {
  const auto is_plane = [&](std::uint32_t slot) { return world.bodies.shape[slot]->kind == ShapeKind::Plane; };
  ActivePair pair;
  pair.low = candidate.low;
  pair.high = candidate.high;
  pair.a = is_plane(candidate.low) ? candidate.high : candidate.low;
  pair.b = is_plane(candidate.low) ? candidate.low : candidate.high;
  const double radius_a = world.bodies.shape[pair.a]->bounding_radius_m;
  const double radius_b = is_plane(pair.b) ? radius_a : world.bodies.shape[pair.b]->bounding_radius_m;
  pair.skin_m = kSkin * std::min(radius_a, radius_b);
  pair.margin_m = margin_m(world, pair.a, pair.b, pair.skin_m, input);
  return pair;
}

void fill(const WorldState& world, const StepInput& input, ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  const dynamics::BodyStore& bodies = world.bodies;
  pair.level = collision::coarsest_level(frame_of(world, pair), buffers.poses[pair.a].rotation, input.max_level);
  if (const PairMemory* memory = remembered(world.memory, pair.low, pair.high)) {
    pair.memory = *memory;
  } else {
    pair.memory = {pair.low, pair.high, 0, false, 0};
  }
  if (!pair.level.refinable()) return;
  const ShapeFacts& facts_a = world.shapes[world.shape_of[pair.a]];
  const ShapeFacts& facts_b = world.shapes[world.shape_of[pair.b]];
  for (std::size_t level = 0; level < pair.error_m.size(); ++level) {
    pair.error_m[level] = facts_a.error_m[level] + facts_b.error_m[level];
  }
  PairSighting sighting;
  sighting.point_m = bodies.position(pair.a) + pair.level.contact.arm_m;
  sighting.normal = pair.level.contact.direction;
  sighting.extent_m = pair.skin_m / kSkin;
  sighting.closing_mps = pair.level.contact.direction.dot(bodies.velocity(pair.a) - bodies.velocity(pair.b));
  sighting.importance = bodies.importance[pair.a] * bodies.importance[pair.b];
  sighting.frames_waited = pair.memory.frames_waited;
  pair.cues = cues_of(input.view, sighting);
}

}  // namespace

collision::PairFrame frame_of(const WorldState& world, const ActivePair& pair) {
  const FrameBuffers& buffers = world.buffers;
  return collision::make_pair_frame(*world.bodies.shape[pair.a], buffers.poses[pair.a], *world.bodies.shape[pair.b],
                                    buffers.poses[pair.b], pair.margin_m, pair.skin_m);
}

void predict(WorldState& world, const StepInput& input) {
  const dynamics::BodyStore& bodies = world.bodies;
  FrameBuffers& buffers = world.buffers;
  const std::size_t slots = bodies.slot_count();
  buffers.poses.resize(slots);
  buffers.inverse_inertia.resize(slots);
  buffers.bounds.clear();
  buffers.planes.clear();
  for (std::size_t i = 0; i < slots; ++i) {
    if (bodies.alive[i] == 0) continue;
    collision::MotionBound bound;
    bound.slot = static_cast<std::uint32_t>(i);
    if (bodies.shape[i]->kind == ShapeKind::Tree) buffers.bounds.push_back(bound);
  }
  parallel::parallel_for(*world.executor, slots, 4 * kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (bodies.alive[i] == 0) continue;
      buffers.poses[i] = {bodies.position(i), bodies.orientation(i).toRotationMatrix()};
      buffers.inverse_inertia[i] = dynamics::inverse_inertia_world(bodies, i);
    }
  });
  parallel::parallel_for(*world.executor, buffers.bounds.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      collision::MotionBound& bound = buffers.bounds[k];
      const std::size_t i = bound.slot;
      const double radius = bodies.shape[i]->bounding_radius_m;
      bound = {bodies.position(i), radius * (1.0 + kSkin) + motion_bound_m(world, i, input), bound.slot,
               bodies.group[i],    bodies.collides_with[i],                                  bodies.dynamic[i] != 0};
    }
  });
  for (std::size_t i = 0; i < slots; ++i) {
    if (bodies.alive[i] == 0 || bodies.shape[i]->kind != ShapeKind::Plane) continue;
    const Vec3 normal = buffers.poses[i].rotation * bodies.shape[i]->plane_normal;
    buffers.planes.push_back({normal, normal.dot(bodies.position(i)) + bodies.shape[i]->plane_offset_m,
                              static_cast<std::uint32_t>(i), bodies.group[i], bodies.collides_with[i]});
  }
}

void find_pairs(WorldState& world, const StepInput& input, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  const TimePoint start = SteadyClock::now();
  const collision::BroadPhase::Result found =
      world.broad_phase.find(buffers.bounds, buffers.planes, world.settings.max_partners, *world.executor);
  report.times.broad_phase = SteadyClock::now() - start;
  report.pairs_dropped = found.dropped;
  report.candidate_pairs = found.pairs.size();
  report.work_mandatory = found.pairs.size();

  const std::size_t count = found.pairs.size();
  const std::size_t chunks = (count + kGrain - 1) / kGrain;
  buffers.active_of_chunk.assign(chunks + 1, 0);
  buffers.active_candidate.resize(count);
  parallel::parallel_for(*world.executor, count, kGrain, [&](std::size_t begin, std::size_t end, int) {
    std::uint32_t active = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (!collision::roots_overlap(frame_of(world, outlined(world, found.pairs[i], input)))) continue;
      buffers.active_candidate[begin + active++] = static_cast<std::uint32_t>(i);
    }
    buffers.active_of_chunk[begin / kGrain + 1] = active;
  });
  std::partial_sum(buffers.active_of_chunk.begin(), buffers.active_of_chunk.end(), buffers.active_of_chunk.begin());
  buffers.pairs.resize(buffers.active_of_chunk[chunks]);
  parallel::parallel_for(*world.executor, chunks, 1, [&](std::size_t chunk, std::size_t, int) {
    const std::uint32_t first = buffers.active_of_chunk[chunk];
    for (std::uint32_t k = first; k < buffers.active_of_chunk[chunk + 1]; ++k) {
      const std::uint32_t candidate = buffers.active_candidate[chunk * kGrain + (k - first)];
      buffers.pairs[k] = outlined(world, found.pairs[candidate], input);
      fill(world, input, buffers.pairs[k]);
    }
  });
  for (const ActivePair& pair : buffers.pairs) report.coarse_pairs += pair.level.apart ? 0 : 1;
  report.times.coarse = SteadyClock::now() - start - report.times.broad_phase;
}

}  // namespace poise::simulation
