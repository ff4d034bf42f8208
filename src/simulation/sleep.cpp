// SPDX-License-Identifier: MIT
#include "simulation/sleep.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace poise::simulation {
namespace {

constexpr std::size_t kGrain = 1024;
// Chosen: long enough for a body that turns back at the end of a swing to be seen moving.
constexpr double kStillForS = 0.5;
// Of sqrt(g R). Chosen: what a settled pile jitters by is below, and what it drifts in kStillForS cannot be seen.
constexpr double kStillSpeed = 0.01;
// Static bodies wake what is nearer to them than this share of the sleeper's radius.
constexpr double kNear = 0.02;

void make_room(WorldState& world) {
  const std::size_t slots = world.bodies.slot_count();
  if (world.sleep.still_s.size() >= slots) return;
  world.sleep.still_s.resize(slots, 0.0);
  world.sleep.island.resize(slots, 0);
  world.sleep.roused.resize(slots, 0);
}

bool sleeps(const WorldState& world, const PairMemory& pair) {
  return world.bodies.asleep[pair.low] != 0 || world.bodies.asleep[pair.high] != 0;
}

void rouse(WorldState& world, std::uint32_t slot) {
  world.sleep.roused[world.sleep.island[slot]] = 1;
  world.sleep.any_roused = true;
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
  sleep.next_aside.clear();
  const auto move = [&](const PairMemory& pair) {
    (sleeps(world, pair) ? sleep.next_aside : sleep.next_awake).push_back(pair);
  };
  const auto key = [](const PairMemory& pair) { return std::pair(pair.low, pair.high); };
  auto aside = sleep.aside.begin();
  for (const PairMemory& pair : world.memory) {
    for (; aside != sleep.aside.end() && key(*aside) < key(pair); ++aside) move(*aside);
    move(pair);
  }
  for (; aside != sleep.aside.end(); ++aside) move(*aside);
  std::swap(sleep.aside, sleep.next_aside);
  std::swap(world.memory, sleep.next_awake);
}

void wake_roused(WorldState& world) {
  Sleep& sleep = world.sleep;
  for (std::uint32_t slot = 0; slot < world.bodies.slot_count(); ++slot) {
    if (world.bodies.asleep[slot] != 0 && sleep.roused[sleep.island[slot]] != 0) wake_body(world, slot);
  }
  std::fill(sleep.roused.begin(), sleep.roused.end(), std::uint8_t{0});
  sleep.any_roused = false;
  sort_memory(world);
}

// Rouses what sleeps at a static body where it is now.
void rouse_around(WorldState& world, std::uint32_t slot) {
  const dynamics::BodyStore& bodies = world.bodies;
  const Shape& shape = *bodies.shape[slot];
  const Vec3 normal = bodies.orientation(slot) * shape.plane_normal;
  for (std::uint32_t i = 0; i < bodies.slot_count(); ++i) {
    if (bodies.asleep[i] == 0) continue;
    const Vec3 between = bodies.position(i) - bodies.position(slot);
    const double reach = (1.0 + kNear) * bodies.shape[i]->bounding_radius_m;
    const bool near = shape.kind == ShapeKind::Plane ? normal.dot(between) - shape.plane_offset_m < reach
                                                     : between.norm() < shape.bounding_radius_m + reach;
    if (near) rouse(world, i);
  }
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
  parallel::parallel_for(*world.executor, bodies.slot_count(), kGrain, [&](std::size_t begin, std::size_t end, int) {
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

// Puts the islands to sleep of which every body has been still for long enough. How many bodies that is.
std::size_t put_islands_to_sleep(WorldState& world) {
  dynamics::BodyStore& bodies = world.bodies;
  Sleep& sleep = world.sleep;
  find_islands(world);
  sleep.restless.assign(bodies.slot_count(), 0);
  for (std::uint32_t slot = 0; slot < bodies.slot_count(); ++slot) {
    if (bodies.dynamic[slot] != 0 && sleep.still_s[slot] < kStillForS) sleep.restless[root_of(sleep.parent, slot)] = 1;
  }
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

void stir(WorldState& world, std::uint32_t slot) {
  if (!world.settings.sleeping) return;
  make_room(world);
  if (world.bodies.asleep[slot] != 0) {
    rouse(world, slot);
    wake_body(world, slot);
    return;
  }
  world.sleep.still_s[slot] = 0;
  if (world.bodies.dynamic[slot] == 0) world.sleep.stirred.push_back(slot);
}

void wake_all(WorldState& world) {
  if (!world.settings.sleeping) return;
  make_room(world);
  for (std::uint32_t slot = 0; slot < world.bodies.slot_count(); ++slot) {
    if (world.bodies.asleep[slot] != 0) rouse(world, slot);
  }
  if (world.sleep.any_roused) wake_roused(world);
}

void wake_stirred(WorldState& world) {
  Sleep& sleep = world.sleep;
  make_room(world);
  if (!sleep.any_roused && sleep.stirred.empty()) return;
  std::sort(sleep.stirred.begin(), sleep.stirred.end());
  sleep.stirred.erase(std::unique(sleep.stirred.begin(), sleep.stirred.end()), sleep.stirred.end());
  const auto stirred = [&](std::uint32_t slot) {
    return std::binary_search(sleep.stirred.begin(), sleep.stirred.end(), slot);
  };
  for (const PairMemory& pair : sleep.aside) {
    if (world.bodies.asleep[pair.low] != 0 && stirred(pair.high)) rouse(world, pair.low);
    if (world.bodies.asleep[pair.high] != 0 && stirred(pair.low)) rouse(world, pair.high);
  }
  for (const std::uint32_t slot : sleep.stirred) {
    if (world.bodies.asleep_count() > 0 && world.bodies.alive[slot] != 0 && world.bodies.dynamic[slot] == 0)
      rouse_around(world, slot);
  }
  sleep.stirred.clear();
  if (sleep.any_roused) wake_roused(world);
}

bool wake_touched(WorldState& world) {
  const dynamics::BodyStore& bodies = world.bodies;
  if (bodies.asleep_count() == 0) return false;
  for (const ActivePair& pair : world.buffers.pairs) {
    if (bodies.asleep[pair.low()] != 0 && bodies.dynamic[pair.high()] != 0) rouse(world, pair.low());
    if (bodies.asleep[pair.high()] != 0 && bodies.dynamic[pair.low()] != 0) rouse(world, pair.high());
  }
  if (!world.sleep.any_roused) return false;
  wake_roused(world);
  return true;
}

void fall_asleep(WorldState& world, double dt_s, FrameReport& report) {
  Sleep& sleep = world.sleep;
  // The room that an island will need, before it sleeps.
  for (parallel::LargeVector<PairMemory>* kept : {&sleep.aside, &sleep.next_awake, &sleep.next_aside})
    kept->reserve(world.memory.capacity());
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
