// SPDX-License-Identifier: MIT
#include "frame/sleeping.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace poise::simulation {
namespace {

constexpr std::size_t kIslandGrain = 1024;
// Chosen: long enough for a body that turns back at the end of a swing to be seen moving.
constexpr double kStillForS = 0.5;
// Of sqrt(g R). Chosen: what a settled pile jitters by is below, and what it drifts in kStillForS cannot be seen.
constexpr double kStillSpeed = 0.01;
// Static bodies wake what is nearer to them than this share of the sleeper's radius.
constexpr double kNear = 0.02;

void reserve_slots(WorldState& world) {
  const std::size_t slots = world.bodies.slot_count();
  if (world.sleep.still_s.size() >= slots) return;
  world.sleep.still_s.resize(slots, 0.0);
  world.sleep.island.resize(slots, 0);
  world.sleep.wake_requested.resize(slots, 0);
}

bool sleeps(const WorldState& world, const CachedPair& pair) {
  return world.bodies.asleep[pair.low] != 0 || world.bodies.asleep[pair.high] != 0;
}

void request_island_wake(WorldState& world, std::uint32_t slot) {
  world.sleep.wake_requested[world.sleep.island[slot]] = 1;
  world.sleep.any_wake_requested = true;
}

// The body's own part of waking.
void wake_body(WorldState& world, std::uint32_t slot) {
  world.bodies.wake(slot);
  world.sleep.still_s[slot] = 0;
  ++world.sleep.woken;
}

// Puts what pairs keep where it belongs: aside where a body of the pair sleeps, else to the pairs of the last step.
void sort_memory(WorldState& world) {
  Sleep& sleep = world.sleep;
  sleep.next_awake.clear();
  sleep.next_sleeping_pairs.clear();
  const auto move = [&](const CachedPair& pair) {
    (sleeps(world, pair) ? sleep.next_sleeping_pairs : sleep.next_awake).push_back(pair);
  };
  const auto key = [](const CachedPair& pair) { return std::pair(pair.low, pair.high); };
  auto sleeping_pairs = sleep.sleeping_pairs.begin();
  for (const CachedPair& pair : world.memory) {
    for (; sleeping_pairs != sleep.sleeping_pairs.end() && key(*sleeping_pairs) < key(pair); ++sleeping_pairs)
      move(*sleeping_pairs);
    move(pair);
  }
  for (; sleeping_pairs != sleep.sleeping_pairs.end(); ++sleeping_pairs) move(*sleeping_pairs);
  std::swap(sleep.sleeping_pairs, sleep.next_sleeping_pairs);
  std::swap(world.memory, sleep.next_awake);
}

void wake_requested_islands(WorldState& world) {
  Sleep& sleep = world.sleep;
  for (std::uint32_t slot = 0; slot < world.bodies.slot_count(); ++slot) {
    if (world.bodies.asleep[slot] != 0 && sleep.wake_requested[sleep.island[slot]] != 0) wake_body(world, slot);
  }
  std::fill(sleep.wake_requested.begin(), sleep.wake_requested.end(), std::uint8_t{0});
  sleep.any_wake_requested = false;
  sort_memory(world);
}

// Rouses what sleeps at a static body where it is now.
void request_wake_around(WorldState& world, std::uint32_t slot) {
  const dynamics::BodyStore& bodies = world.bodies;
  const Shape& shape = *bodies.shape[slot];
  const Vec3 normal = bodies.orientation(slot) * shape.plane_normal;
  for (std::uint32_t i = 0; i < bodies.slot_count(); ++i) {
    if (bodies.asleep[i] == 0) continue;
    const Vec3 between = bodies.position(i) - bodies.position(slot);
    const double reach = (1.0 + kNear) * bodies.shape[i]->bounding_radius_m;
    const bool near = shape.kind == ShapeKind::Plane ? normal.dot(between) - shape.plane_offset_m < reach
                                                     : between.norm() < shape.bounding_radius_m + reach;
    if (near) request_island_wake(world, i);
  }
}

bool moves(const dynamics::BodyStore& bodies, std::uint32_t slot) {
  return bodies.dynamic[slot] != 0 || bodies.moves_by_itself(slot);
}

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t slot) {
  while (parent[slot] != slot) {
    parent[slot] = parent[parent[slot]];
    slot = parent[slot];
  }
  return slot;
}

// Counts on for bodies that are still, and from zero for the others. Is any still for long enough?
bool count_still(WorldState& world, double dt_s) {
  const dynamics::BodyStore& bodies = world.bodies;
  const double gravity = world.settings.gravity_mps2.norm();
  std::vector<double>& still_s = world.sleep.still_s;
  parallel::parallel_for(
      *world.executor, bodies.slot_count(), kIslandGrain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
          if (bodies.dynamic[i] == 0) continue;
          const double radius = bodies.shape[i]->bounding_radius_m;
          const double speed = kStillSpeed * std::sqrt(gravity * radius);
          const StepMotion& motion = world.buffers.motions[i];
          const bool still = bodies.velocity(i).norm() <= speed && radius * bodies.spin(i).norm() <= speed &&
                             motion.moved_m.norm() <= speed * dt_s && motion.turned_m <= speed * dt_s;
          still_s[i] = still ? still_s[i] + dt_s : 0.0;
        }
      });
  for (std::size_t i = 0; i < bodies.slot_count(); ++i) {
    if (bodies.dynamic[i] != 0 && still_s[i] >= kStillForS) return true;
  }
  return false;
}

// Each slot's parent is at last the lowest slot of its island.
void find_islands(WorldState& world) {
  const dynamics::BodyStore& bodies = world.bodies;
  std::vector<std::uint32_t>& parent = world.sleep.parent;
  parent.resize(bodies.slot_count());
  std::iota(parent.begin(), parent.end(), 0U);
  for (const ActivePair& pair : world.buffers.pairs) {
    if (bodies.dynamic[pair.low()] == 0 || bodies.dynamic[pair.high()] == 0) continue;
    const std::uint32_t low = root_of(parent, pair.low());
    const std::uint32_t high = root_of(parent, pair.high());
    parent[std::max(low, high)] = std::min(low, high);
  }
}

// What a moving kinematic body touches or is near does not sleep.
void keep_driven_awake(WorldState& world) {
  const dynamics::BodyStore& bodies = world.bodies;
  Sleep& sleep = world.sleep;
  for (const ActivePair& pair : world.buffers.pairs) {
    if (bodies.moves_by_itself(pair.low())) sleep.restless[root_of(sleep.parent, pair.high())] = 1;
    if (bodies.moves_by_itself(pair.high())) sleep.restless[root_of(sleep.parent, pair.low())] = 1;
  }
}

// Puts the islands to sleep of which every body has been still for long enough. How many bodies that is.
std::size_t put_islands_to_sleep(WorldState& world) {
  dynamics::BodyStore& bodies = world.bodies;
  Sleep& sleep = world.sleep;
  find_islands(world);
  sleep.restless.assign(bodies.slot_count(), 0);
  for (std::uint32_t slot = 0; slot < bodies.slot_count(); ++slot) {
    if (bodies.dynamic[slot] != 0 && sleep.still_s[slot] < kStillForS) sleep.restless[root_of(sleep.parent, slot)] = 1;
  }
  if (bodies.kinematic_count() > 0) keep_driven_awake(world);
  std::size_t count = 0;
  for (std::uint32_t slot = 0; slot < bodies.slot_count(); ++slot) {
    if (bodies.dynamic[slot] == 0) continue;
    const std::uint32_t root = root_of(sleep.parent, slot);
    if (sleep.restless[root] != 0) continue;
    sleep.island[slot] = root;
    bodies.put_to_sleep(slot);
    ++count;
  }
  return count;
}

}  // namespace

void request_wake(WorldState& world, std::uint32_t slot) {
  if (!world.settings.sleeping) return;
  reserve_slots(world);
  if (world.bodies.asleep[slot] != 0) {
    request_island_wake(world, slot);
    wake_body(world, slot);
    return;
  }
  world.sleep.still_s[slot] = 0;
  if (world.bodies.dynamic[slot] == 0) world.sleep.changed_statics.push_back(slot);
}

void wake_all(WorldState& world) {
  if (!world.settings.sleeping) return;
  reserve_slots(world);
  for (std::uint32_t slot = 0; slot < world.bodies.slot_count(); ++slot) {
    if (world.bodies.asleep[slot] != 0) request_island_wake(world, slot);
  }
  if (world.sleep.any_wake_requested) wake_requested_islands(world);
}

void wake_near_changes(WorldState& world) {
  Sleep& sleep = world.sleep;
  reserve_slots(world);
  if (!sleep.any_wake_requested && sleep.changed_statics.empty()) return;
  std::sort(sleep.changed_statics.begin(), sleep.changed_statics.end());
  sleep.changed_statics.erase(std::unique(sleep.changed_statics.begin(), sleep.changed_statics.end()),
                              sleep.changed_statics.end());
  const auto changed_statics = [&](std::uint32_t slot) {
    return std::binary_search(sleep.changed_statics.begin(), sleep.changed_statics.end(), slot);
  };
  for (const CachedPair& pair : sleep.sleeping_pairs) {
    if (world.bodies.asleep[pair.low] != 0 && changed_statics(pair.high)) request_island_wake(world, pair.low);
    if (world.bodies.asleep[pair.high] != 0 && changed_statics(pair.low)) request_island_wake(world, pair.high);
  }
  for (const std::uint32_t slot : sleep.changed_statics) {
    if (world.bodies.asleep_count() > 0 && world.bodies.alive[slot] != 0 && world.bodies.dynamic[slot] == 0)
      request_wake_around(world, slot);
  }
  sleep.changed_statics.clear();
  if (sleep.any_wake_requested) wake_requested_islands(world);
}

bool wake_touched(WorldState& world) {
  const dynamics::BodyStore& bodies = world.bodies;
  if (bodies.asleep_count() == 0) return false;
  for (const ActivePair& pair : world.buffers.pairs) {
    if (bodies.asleep[pair.low()] != 0 && moves(bodies, pair.high())) request_island_wake(world, pair.low());
    if (bodies.asleep[pair.high()] != 0 && moves(bodies, pair.low())) request_island_wake(world, pair.high());
  }
  if (!world.sleep.any_wake_requested) return false;
  wake_requested_islands(world);
  return true;
}

void fall_asleep(WorldState& world, double dt_s, FrameReport& report) {
  Sleep& sleep = world.sleep;
  // The room that an island will need, before it sleeps.
  for (parallel::LargeVector<CachedPair>* cached :
       {&sleep.sleeping_pairs, &sleep.next_awake, &sleep.next_sleeping_pairs})
    cached->reserve(world.memory.capacity());
  sleep.parent.reserve(world.bodies.slot_count());
  sleep.restless.reserve(world.bodies.slot_count());
  if (count_still(world, dt_s)) {
    report.fell_asleep = put_islands_to_sleep(world);
    if (report.fell_asleep > 0) sort_memory(world);
  }
  report.asleep = world.bodies.asleep_count();
  report.woken = std::exchange(sleep.woken, 0);
}

}  // namespace poise::simulation
