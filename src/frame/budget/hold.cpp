// SPDX-License-Identifier: MIT
#include "frame/budget/hold.h"

#include <algorithm>
#include <functional>
#include <span>

#include "parallel/ranges.h"

namespace poise::simulation {
namespace {

// Islands that are held one after another before the executor may stop.
constexpr std::size_t kRootGrain = 8192;

// Holds the islands of levels.held.roots.
std::size_t hold(const RefineInput& input, const Islands& islands, CompletedLevels& levels,
                 parallel::Executor& executor) {
  HeldIslands& held = levels.held;
  const dynamics::BodyStore& bodies = input.scene.bodies;
  parallel::serial_for(executor, held.roots.size(), kRootGrain, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t root : std::span(held.roots).subspan(begin, end - begin)) {
      IslandSums::Island& island = islands[root];
      island.held = true;
      held.bodies += island.bodies;
      held.pairs += island.pairs;
      held.open += island.open;
      levels.known.present -= island.contacts;
      levels.known.unknown -= island.unknown;
    }
  });
  held.slots.resize(bodies.slot_count());
  const std::vector<std::uint32_t>& visited = input.motion.visited;
  islands.each(visited.size(), [&](std::uint32_t k) {
    const std::uint32_t slot = visited[k];
    held.slots[slot] = bodies.dynamic[slot] != 0 && islands[islands.root_of(slot)].held ? 1 : 0;
  });
  islands.each(input.table.size(), [&](std::uint32_t i) {
    levels.progress[i].held = held.slots[islands.dynamic_of(input.table.pairs[i])] != 0;
  });
  return held.bodies;
}

}  // namespace

std::size_t hold_islands(const RefineInput& input, std::uint64_t contacts, CompletedLevels& levels,
                         parallel::Executor& executor) {
  HeldIslands& held = levels.held;
  held.clear();
  if (!Islands::any_may_wait(input) || contacts == 0) return 0;
  Islands islands(input, levels.islands, executor);
  if (!islands.worth_a_look()) return 0;
  islands.find(levels.progress);
  islands.for_each_that_may_wait([&](std::uint32_t root) {
    if (islands[root].contacts > 0) held.roots.push_back(root);
  });
  if (held.roots.size() > 1) islands.weigh_pairs(levels.progress);
  islands.sort_by_turn(held.roots);
  std::uint64_t spared = 0;
  std::size_t count = 0;
  while (count < held.roots.size() && spared < contacts) spared += islands[held.roots[count++]].contacts;
  held.roots.resize(count);
  parallel::sort(executor, held.roots, levels.islands.sorting, std::less<>());
  return count > 0 ? hold(input, islands, levels, executor) : 0;
}

bool hold_as_recorded(const RefineInput& input, std::span<const std::uint32_t> roots, CompletedLevels& levels,
                      Degraded& degraded, parallel::Executor& executor) {
  HeldIslands& held = levels.held;
  held.clear();
  if (roots.empty()) return true;
  if (!Islands::any_may_wait(input)) return false;
  Islands islands(input, levels.islands, executor);
  islands.find(levels.progress);
  for (const std::uint32_t root : roots) {
    if (root < input.scene.bodies.slot_count() && islands.may_wait(root)) held.roots.push_back(root);
  }
  if (!held.roots.empty()) degraded.bodies_held = hold(input, islands, levels, executor);
  return held.roots.size() == roots.size();
}

}  // namespace poise::simulation
