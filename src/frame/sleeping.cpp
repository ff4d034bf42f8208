// SPDX-License-Identifier: MIT
#include "frame/sleeping.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kIslandGrain = 1024;
// Chosen: long enough for a body that turns back at the end of a swing to be seen moving.
constexpr double kStillForS = 0.5;
// Of sqrt(g R). Chosen: what a settled pile jitters by is below, and what it drifts in kStillForS cannot be seen.
constexpr double kStillSpeed = 0.01;
// Static bodies wake what is nearer to them than this share of the sleeper's radius.
constexpr double kNear = 0.02;

void reserve_slots(const SleepAccess& access) {
  const std::size_t slots = access.bodies.slot_count();
  if (access.sleeping.still_s.size() >= slots) return;
  access.sleeping.still_s.resize(slots, 0.0);
  access.sleeping.island.resize(slots, 0);
  access.sleeping.wake_requested.resize(slots, 0);
}

bool sleeps(const SleepAccess& access, const CachedPair& pair) {
  return access.bodies.asleep[pair.low] != 0 || access.bodies.asleep[pair.high] != 0;
}

void request_island_wake(const SleepAccess& access, std::uint32_t slot) {
  access.sleeping.wake_requested[access.sleeping.island[slot]] = 1;
  access.sleeping.any_wake_requested = true;
}

// The body's own part of waking.
void wake_body(const SleepAccess& access, std::uint32_t slot) {
  access.bodies.wake(slot);
  access.sleeping.still_s[slot] = 0;
  ++access.sleeping.woken;
}

// Puts cached pairs where they belong: aside where a body of the pair sleeps, else to the pairs of the last step.
void sort_cached(const SleepAccess& access) {
  SleepingState& sleep = access.sleeping;
  sleep.next_awake.clear();
  sleep.next_sleeping_pairs.clear();
  const auto move = [&](const CachedPair& pair) {
    (sleeps(access, pair) ? sleep.next_sleeping_pairs : sleep.next_awake).push_back(pair);
  };
  const auto key = [](const CachedPair& pair) { return std::pair(pair.low, pair.high); };
  auto sleeping_pairs = sleep.sleeping_pairs.begin();
  for (const CachedPair& pair : access.cache.pairs) {
    for (; sleeping_pairs != sleep.sleeping_pairs.end() && key(*sleeping_pairs) < key(pair); ++sleeping_pairs)
      move(*sleeping_pairs);
    move(pair);
  }
  for (; sleeping_pairs != sleep.sleeping_pairs.end(); ++sleeping_pairs) move(*sleeping_pairs);
  std::swap(sleep.sleeping_pairs, sleep.next_sleeping_pairs);
  std::swap(access.cache.pairs, sleep.next_awake);
}

void wake_requested_islands(const SleepAccess& access) {
  SleepingState& sleep = access.sleeping;
  for (std::uint32_t slot = 0; slot < access.bodies.slot_count(); ++slot) {
    if (access.bodies.asleep[slot] != 0 && sleep.wake_requested[sleep.island[slot]] != 0) wake_body(access, slot);
  }
  std::fill(sleep.wake_requested.begin(), sleep.wake_requested.end(), std::uint8_t{0});
  sleep.any_wake_requested = false;
  sort_cached(access);
}

// Wakes what sleeps at a static body where it is now.
void request_wake_around(const SleepAccess& access, std::uint32_t slot) {
  const dynamics::BodyStore& bodies = access.bodies;
  const Shape& shape = *bodies.shape[slot];
  const Vec3 normal = bodies.orientation(slot) * shape.plane_normal;
  for (std::uint32_t i = 0; i < bodies.slot_count(); ++i) {
    if (bodies.asleep[i] == 0) continue;
    const Vec3 between = bodies.position(i) - bodies.position(slot);
    const double reach = (1.0 + kNear) * bodies.shape[i]->bounding_radius_m;
    const bool near = shape.kind == ShapeKind::Plane ? normal.dot(between) - shape.plane_offset_m < reach
                                                     : between.norm() < shape.bounding_radius_m + reach;
    if (near) request_island_wake(access, i);
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
bool count_still(const FallAsleepInput& input, const SleepAccess& access, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = access.bodies;
  const double gravity = input.gravity_mps2;
  std::vector<double>& still_s = access.sleeping.still_s;
  parallel::parallel_for(executor, bodies.slot_count(), kIslandGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (bodies.dynamic[i] == 0) continue;
      const double radius = bodies.shape[i]->bounding_radius_m;
      const double speed = kStillSpeed * std::sqrt(gravity * radius);
      const StepMotion& motion = input.motions.of_slot[i];
      const bool still = bodies.velocity(i).norm() <= speed && radius * bodies.spin(i).norm() <= speed &&
                         motion.moved_m.norm() <= speed * input.dt_s && motion.turned_m <= speed * input.dt_s;
      still_s[i] = still ? still_s[i] + input.dt_s : 0.0;
    }
  });
  for (std::size_t i = 0; i < bodies.slot_count(); ++i) {
    if (bodies.dynamic[i] != 0 && still_s[i] >= kStillForS) return true;
  }
  return false;
}

// Each slot's parent is at last the lowest slot of its island.
void find_islands(const PairTable& table, const SleepAccess& access) {
  const dynamics::BodyStore& bodies = access.bodies;
  std::vector<std::uint32_t>& parent = access.sleeping.parent;
  parent.resize(bodies.slot_count());
  std::iota(parent.begin(), parent.end(), 0U);
  for (const ActivePair& pair : table.pairs) {
    if (bodies.dynamic[pair.low()] == 0 || bodies.dynamic[pair.high()] == 0) continue;
    const std::uint32_t low = root_of(parent, pair.low());
    const std::uint32_t high = root_of(parent, pair.high());
    parent[std::max(low, high)] = std::min(low, high);
  }
}

// Puts the islands to sleep of which every body has been still for long enough. How many bodies that is.
// What a moving kinematic body touches or is near does not sleep.
void keep_driven_awake(const PairTable& table, const SleepAccess& access) {
  const dynamics::BodyStore& bodies = access.bodies;
  SleepingState& sleep = access.sleeping;
  for (const ActivePair& pair : table.pairs) {
    if (bodies.moves_by_itself(pair.low())) sleep.restless[root_of(sleep.parent, pair.high())] = 1;
    if (bodies.moves_by_itself(pair.high())) sleep.restless[root_of(sleep.parent, pair.low())] = 1;
  }
}

std::size_t put_islands_to_sleep(const PairTable& table, const SleepAccess& access) {
  dynamics::BodyStore& bodies = access.bodies;
  SleepingState& sleep = access.sleeping;
  find_islands(table, access);
  sleep.restless.assign(bodies.slot_count(), 0);
  for (std::uint32_t slot = 0; slot < bodies.slot_count(); ++slot) {
    if (bodies.dynamic[slot] != 0 && sleep.still_s[slot] < kStillForS) sleep.restless[root_of(sleep.parent, slot)] = 1;
  }
  if (bodies.kinematic_count() > 0) keep_driven_awake(table, access);
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

void request_wake(const SleepAccess& access, std::uint32_t slot) {
  if (!access.sleeping.on) return;
  reserve_slots(access);
  if (access.bodies.asleep[slot] != 0) {
    request_island_wake(access, slot);
    wake_body(access, slot);
    return;
  }
  access.sleeping.still_s[slot] = 0;
  if (access.bodies.dynamic[slot] == 0) access.sleeping.changed_statics.push_back(slot);
}

void wake_all(const SleepAccess& access) {
  if (!access.sleeping.on) return;
  reserve_slots(access);
  for (std::uint32_t slot = 0; slot < access.bodies.slot_count(); ++slot) {
    if (access.bodies.asleep[slot] != 0) request_island_wake(access, slot);
  }
  if (access.sleeping.any_wake_requested) wake_requested_islands(access);
}

void wake_near_changes(const SleepAccess& access) {
  if (!access.sleeping.on) return;
  SleepingState& sleep = access.sleeping;
  reserve_slots(access);
  if (!sleep.any_wake_requested && sleep.changed_statics.empty()) return;
  std::sort(sleep.changed_statics.begin(), sleep.changed_statics.end());
  sleep.changed_statics.erase(std::unique(sleep.changed_statics.begin(), sleep.changed_statics.end()),
                              sleep.changed_statics.end());
  const auto changed_statics = [&](std::uint32_t slot) {
    return std::binary_search(sleep.changed_statics.begin(), sleep.changed_statics.end(), slot);
  };
  for (const CachedPair& pair : sleep.sleeping_pairs) {
    if (access.bodies.asleep[pair.low] != 0 && changed_statics(pair.high)) request_island_wake(access, pair.low);
    if (access.bodies.asleep[pair.high] != 0 && changed_statics(pair.low)) request_island_wake(access, pair.high);
  }
  for (const std::uint32_t slot : sleep.changed_statics) {
    if (access.bodies.asleep_count() > 0 && access.bodies.alive[slot] != 0 && access.bodies.dynamic[slot] == 0)
      request_wake_around(access, slot);
  }
  sleep.changed_statics.clear();
  if (sleep.any_wake_requested) wake_requested_islands(access);
}

bool wake_touched(const PairTable& table, const SleepAccess& access) {
  if (!access.sleeping.on) return false;
  const dynamics::BodyStore& bodies = access.bodies;
  if (bodies.asleep_count() == 0) return false;
  for (const ActivePair& pair : table.pairs) {
    if (bodies.asleep[pair.low()] != 0 && moves(bodies, pair.high())) request_island_wake(access, pair.low());
    if (bodies.asleep[pair.high()] != 0 && moves(bodies, pair.low())) request_island_wake(access, pair.high());
  }
  if (!access.sleeping.any_wake_requested) return false;
  wake_requested_islands(access);
  return true;
}

void fall_asleep(const FallAsleepInput& input, const SleepAccess& access, FrameReport& report,
                 parallel::Executor& executor) {
  if (!access.sleeping.on) return;
  SleepingState& sleep = access.sleeping;
  // The memory that an island will need, before it sleeps.
  for (CachedPairList* cached :
       {&sleep.sleeping_pairs, &sleep.next_awake, &sleep.next_sleeping_pairs})
    cached->reserve(access.cache.pairs.capacity());
  sleep.parent.reserve(access.bodies.slot_count());
  sleep.restless.reserve(access.bodies.slot_count());
  if (count_still(input, access, executor)) {
    report.fell_asleep = put_islands_to_sleep(input.table, access);
    if (report.fell_asleep > 0) sort_cached(access);
  }
  report.asleep = access.bodies.asleep_count();
  report.woken = std::exchange(sleep.woken, 0);
}

}  // namespace poise::simulation
