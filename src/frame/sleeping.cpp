// SPDX-License-Identifier: MIT
#include "frame/sleeping.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "frame/sleeping_sets.h"
#include "parallel/disjoint_sets.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kIslandGrain = 1024;
// Chosen: long enough for a body that turns back at the end of a swing to be seen moving.
constexpr double kStillForS = 0.5;
// Of sqrt(g R). Chosen: what a settled pile jitters by is below, and what it drifts in kStillForS cannot be seen.
constexpr double kStillSpeed = 0.01;
// Of what gravity adds in kStillForS: whatever falls is faster for longer, however large it is. Chosen: what turns back
// at its highest point is slower for two fifths of kStillForS.
constexpr double kStillShareOfFall = 0.2;
// Static bodies wake what is nearer to them than this share of the sleeper's radius.
constexpr double kNear = 0.02;

void request_island_wake(const SleepAccess& access, std::uint32_t slot) {
  access.sleeping.wake_requested[access.sleeping.island[slot]] = 1;
  access.sleeping.any_wake_requested = true;
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

// Counts on for bodies that are still, and from zero for the others. Is any still for long enough?
bool count_still(const FallAsleepInput& input, const SleepAccess& access, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = access.bodies;
  const double gravity = input.gravity_mps2;
  const double falls_mps = kStillShareOfFall * kStillForS * gravity;
  std::vector<double>& still_s = access.sleeping.still_s;
  parallel::Shared<int> any(0);
  const std::vector<std::uint32_t>& visited = input.motion.visited;
  parallel::parallel_for(executor, visited.size(), kIslandGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = visited[k];
      if (bodies.dynamic[i] == 0) continue;
      const double radius = bodies.shape[i]->bounding_radius_m;
      const double speed = std::min(kStillSpeed * std::sqrt(gravity * radius), falls_mps);
      const StepMotion& motion = input.motions.of_slot[i];
      const bool still = bodies.velocity(i).norm() <= speed && radius * bodies.spin(i).norm() <= speed &&
                         motion.moved_m.norm() <= speed * input.dt_s && motion.turned_m <= speed * input.dt_s;
      still_s[i] = still ? still_s[i] + input.dt_s : 0.0;
      if (still_s[i] >= kStillForS && any.get() == 0) any.set(1);
    }
  });
  return any.get() != 0;
}

// Each slot's root is the lowest slot of its island.
parallel::DisjointSets find_islands(const PairTable& table, const SleepAccess& access, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = access.bodies;
  std::vector<std::uint32_t>& parent = access.sleeping.parent;
  parent.resize(bodies.slot_count());
  parallel::parallel_for(executor, parent.size(), kIslandGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) parent[i] = static_cast<std::uint32_t>(i);
  });
  parallel::DisjointSets islands(parent);
  table.for_each_near_bodies(executor, [&](std::uint32_t a, std::uint32_t b) {
    if (bodies.dynamic[a] != 0 && bodies.dynamic[b] != 0) islands.unite(a, b);
  });
  return islands;
}

// What a moving kinematic body touches or is near does not sleep.
void keep_driven_awake(const PairTable& table, const SleepAccess& access, const parallel::DisjointSets& islands,
                       parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = access.bodies;
  std::vector<std::uint8_t>& restless = access.sleeping.restless;
  table.for_each_near_bodies(executor, [&](std::uint32_t a, std::uint32_t b) {
    if (bodies.moves_by_itself(a)) parallel::raise(restless[islands.root(b)]);
    if (bodies.moves_by_itself(b)) parallel::raise(restless[islands.root(a)]);
  });
}

// Puts the islands to sleep of which every body has been still for long enough. How many bodies that is.
std::size_t put_islands_to_sleep(const PairTable& table, const SleepAccess& access, parallel::Executor& executor) {
  dynamics::BodyStore& bodies = access.bodies;
  SleepingState& sleep = access.sleeping;
  const parallel::DisjointSets islands = find_islands(table, access, executor);
  sleep.restless.assign(bodies.slot_count(), 0);
  parallel::parallel_for(executor, bodies.slot_count(), kIslandGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (bodies.dynamic[i] != 0 && sleep.still_s[i] < kStillForS)
        parallel::raise(sleep.restless[islands.root(static_cast<std::uint32_t>(i))]);
    }
  });
  if (bodies.kinematic_count() > 0) keep_driven_awake(table, access, islands, executor);
  parallel::select(
      executor, bodies.slot_count(), kIslandGrain, sleep.counts,
      [&](std::size_t i) {
        return bodies.dynamic[i] != 0 && sleep.restless[islands.root(static_cast<std::uint32_t>(i))] == 0;
      },
      [&](std::size_t count) { sleep.slots.resize(count); },
      [&](std::size_t i, std::size_t position) { sleep.slots[position] = static_cast<std::uint32_t>(i); });
  if (sleep.slots.empty()) return 0;
  const std::uint32_t set = set_that_wakes(sleep, SleepingSet::kNever);
  parallel::serial_for(executor, sleep.slots.size(), kIslandGrain, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t slot : std::span(sleep.slots).subspan(begin, end - begin)) {
      add_to_set(sleep, set, slot, islands.root(slot));
      bodies.put_to_sleep(slot);
    }
  });
  take_pairs_of_sleepers(access, executor);
  return sleep.slots.size();
}

}  // namespace

void request_wake(const SleepAccess& access, std::uint32_t slot) {
  if (!in_use(access)) return;
  reserve_slots(access);
  if (access.bodies.asleep[slot] != 0) {
    request_island_wake(access, slot);
    wake_body(access, slot);
    return;
  }
  access.sleeping.still_s[slot] = 0;
  if (access.bodies.dynamic[slot] == 0) access.sleeping.changed_statics.push_back(slot);
}

void wake_all(const SleepAccess& access, parallel::Executor& executor) {
  if (!in_use(access)) return;
  reserve_slots(access);
  for (std::uint32_t slot = 0; slot < access.bodies.slot_count(); ++slot) {
    if (access.bodies.asleep[slot] != 0) request_island_wake(access, slot);
  }
  if (access.sleeping.any_wake_requested) wake_requested_islands(access, executor);
}

void wake_near_changes(const SleepAccess& access, parallel::Executor& executor) {
  if (!in_use(access)) return;
  SleepingState& sleep = access.sleeping;
  reserve_slots(access);
  if (!sleep.any_wake_requested && sleep.changed_statics.empty()) return;
  std::sort(sleep.changed_statics.begin(), sleep.changed_statics.end());
  sleep.changed_statics.erase(std::unique(sleep.changed_statics.begin(), sleep.changed_statics.end()),
                              sleep.changed_statics.end());
  const auto changed_statics = [&](std::uint32_t slot) {
    return std::binary_search(sleep.changed_statics.begin(), sleep.changed_statics.end(), slot);
  };
  for (const SleepingSet& set : sleep.sets) {
    if (sleep.changed_statics.empty()) break;
    for (const CachedPair& pair : set.pairs) {
      if (access.bodies.asleep[pair.low] != 0 && changed_statics(pair.high)) request_island_wake(access, pair.low);
      if (access.bodies.asleep[pair.high] != 0 && changed_statics(pair.low)) request_island_wake(access, pair.high);
    }
  }
  for (const std::uint32_t slot : sleep.changed_statics) {
    if (access.bodies.asleep_count() > 0 && access.bodies.alive[slot] != 0 && access.bodies.dynamic[slot] == 0)
      request_wake_around(access, slot);
  }
  sleep.changed_statics.clear();
  if (sleep.any_wake_requested) wake_requested_islands(access, executor);
}

bool wake_touched(const PairTable& table, const SleepAccess& access, parallel::Executor& executor) {
  if (!in_use(access)) return false;
  const dynamics::BodyStore& bodies = access.bodies;
  if (bodies.asleep_count() == 0) return false;
  SleepingState& sleep = access.sleeping;
  parallel::Shared<int> any(0);
  const auto wake = [&](std::uint32_t slot) {
    parallel::raise(sleep.wake_requested[sleep.island[slot]]);
    if (any.get() == 0) any.set(1);
  };
  table.for_each_near_bodies(executor, [&](std::uint32_t a, std::uint32_t b) {
    if (bodies.asleep[a] != 0 && moves(bodies, b)) wake(a);
    if (bodies.asleep[b] != 0 && moves(bodies, a)) wake(b);
  });
  sleep.any_wake_requested = sleep.any_wake_requested || any.get() != 0;
  if (!access.sleeping.any_wake_requested) return false;
  wake_requested_islands(access, executor);
  return true;
}

void fall_asleep(const FallAsleepInput& input, const SleepAccess& access, FrameReport& report,
                 parallel::Executor& executor) {
  if (!access.sleeping.on) return;
  SleepingState& sleep = access.sleeping;
  // The memory that an island will need, before it sleeps.
  reserve_sets(access, executor);
  if (count_still(input, access, executor)) {
    report.fell_asleep = put_islands_to_sleep(input.table, access, executor);
  }
  report.asleep = access.bodies.asleep_count() - access.bodies.paused_count();
  report.woken = std::exchange(sleep.woken, 0);
}

}  // namespace poise::simulation
