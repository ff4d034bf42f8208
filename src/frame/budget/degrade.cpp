// SPDX-License-Identifier: MIT
#include "frame/budget/degrade.h"

#include <algorithm>

#include "poise/scheduler/policy.h"

namespace poise::simulation {
namespace {

// How far two bodies may have moved against each other since, in radii of the smaller one: beyond it, what touched is
// elsewhere.
constexpr double kReusePlaces = 1.0;
// A pair that was apart must not sink in so far that it cannot be told from one that passes through. Chosen, as kHold
// in pairs.cpp.
constexpr double kReuseApart = 0.5;

bool reusable(const WorldState& world, const ActivePair& pair) {
  // Without a reach nothing was found out, or the caller has put a body elsewhere since.
  if (pair.cached != CacheUse::None || pair.memory.reach_m <= 0 || !pair.refinable() || pair.exact) return false;
  const double radius_m =
      std::min(world.buffers.body_bounds[pair.a].radius_m, world.buffers.body_bounds[pair.b].plane
                                                               ? world.buffers.body_bounds[pair.a].radius_m
                                                               : world.buffers.body_bounds[pair.b].radius_m);
  if (pair.memory.apart) return pair.memory.moved_m <= kReuseApart * radius_m;
  // Balls roll, and the normal that they met with rolls along.
  return pair.memory.level > 0 && pair.memory.point_count > 0 && pair.memory.moved_m <= kReusePlaces * radius_m;
}

double seen(const scheduler::Policy& policy, const scheduler::PairCues& cues) {
  // How long a pair has waited says nothing about how well it is seen.
  scheduler::PairCues now = cues;
  now.frames_waited = 0;
  // Nor does what a host thinks of it; and a replay, which has the number of these pairs, chooses them without the
  // host.
  now.host = 1;
  return scheduler::cue_weight(policy, now) * now.angle_radpm;
}

// Those that may be reused, in canonical order, and what they save in all.
double list_reusable(WorldState& world, double apart_ns, double places_ns) {
  FrameBuffers& buffers = world.buffers;
  buffers.least_seen.clear();
  double all_ns = 0;
  for (std::size_t chunk = 0; chunk < buffers.chunks(); ++chunk) {
    if (buffers.known_of_chunk[chunk].outdated == 0) continue;
    for (std::size_t i = buffers.begin_of(chunk); i < buffers.end_of(chunk); ++i) {
      const ActivePair& pair = buffers.pairs[i];
      if (!reusable(world, pair)) continue;
      buffers.least_seen.push_back({seen(world.settings.policy, buffers.cues[i]), static_cast<std::uint32_t>(i),
                                    pair.memory.apart ? apart_ns : places_ns});
      all_ns += buffers.least_seen.back().saves_ns;
    }
  }
  return all_ns;
}

void sort_least_seen(WorldState& world) {
  std::vector<FrameBuffers::LeastSeen>& list = world.buffers.least_seen;
  std::sort(list.begin(), list.end(), [](const FrameBuffers::LeastSeen& x, const FrameBuffers::LeastSeen& y) {
    return x.weight != y.weight ? x.weight < y.weight : x.pair < y.pair;
  });
}

// Impulses are kept by the substep.
void scale_impulses(ContactCache& points, double factor) {
  for (solver::AccumulatedImpulse& load : points.loads) {
    load.impulse_ns *= factor;
    load.friction_ns *= factor;
  }
}

void use_substeps(WorldState& world, int substeps) {
  if (substeps <= 0 || substeps >= world.settings.substeps) return;
  world.substeps = substeps;
  scale_impulses(world.points, static_cast<double>(world.settings.substeps) / substeps);
}

void reuse(WorldState& world, ActivePair& pair) {
  KnownCount& known = world.buffers.known_of_chunk.back();
  pair.cached = pair.memory.apart ? CacheUse::Separated : CacheUse::Expired;
  --known.unknown;
  if (pair.memory.apart) --known.present;
}

}  // namespace

std::size_t pairs_to_reuse(WorldState& world, Nanoseconds late, double apart_ns, double places_ns) {
  double left_ns = static_cast<double>(late.count());
  if (list_reusable(world, apart_ns, places_ns) <= left_ns) return world.buffers.least_seen.size();
  sort_least_seen(world);
  std::size_t count = 0;
  while (count < world.buffers.least_seen.size() && left_ns > 0) left_ns -= world.buffers.least_seen[count++].saves_ns;
  return count;
}

void degrade(WorldState& world, const Degraded& degraded) {
  use_substeps(world, degraded.substeps);
  if (degraded.pairs_reused == 0) return;
  list_reusable(world, 0, 0);
  const std::size_t count = std::min(degraded.pairs_reused, world.buffers.least_seen.size());
  if (count < world.buffers.least_seen.size()) sort_least_seen(world);
  for (std::size_t k = 0; k < count; ++k) {
    reuse(world, world.buffers.pairs[world.buffers.least_seen[k].pair]);
  }
}

bool degrade_as_recorded(WorldState& world, const FrameDecisions& decisions, Degraded& degraded) {
  degraded = {};
  bool there = decisions.substeps < static_cast<std::uint32_t>(world.settings.substeps);
  if (there) degraded.substeps = static_cast<int>(decisions.substeps);
  use_substeps(world, degraded.substeps);
  for (const std::uint32_t index : decisions.reused) {
    if (index >= world.buffers.pairs.size() || !reusable(world, world.buffers.pairs[index])) {
      there = false;
      continue;
    }
    reuse(world, world.buffers.pairs[index]);
    ++degraded.pairs_reused;
  }
  return there;
}

void restore(WorldState& world) {
  if (world.substeps == world.settings.substeps) return;
  scale_impulses(world.points, static_cast<double>(world.substeps) / world.settings.substeps);
  world.substeps = world.settings.substeps;
}

}  // namespace poise::simulation
