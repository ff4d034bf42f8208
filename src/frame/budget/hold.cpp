// SPDX-License-Identifier: MIT
#include "frame/budget/hold.h"

#include <algorithm>
#include <cmath>

#include "frame/refine/pair_cues.h"
#include "parallel/disjoint_sets.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"
#include "poise/scheduler/policy.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kGrain = 1024;
// Near rest, in what gravity adds in a step. Chosen: a heap that has just come down still trembles.
constexpr double kSlow = 2, kFast = 8, kFlying = 32;
constexpr std::uint32_t kFewOf = 2, kVeryFewOf = 10;
// Fewer slow bodies than this share of all are not worth a look.
constexpr std::size_t kSlowOf = 4;
// Weights are summed as whole numbers, whose sum does not depend on the order.
constexpr double kWeightUnit = 1e-3;

double speed_mps(const dynamics::BodyStore& bodies, std::size_t slot) {
  return std::max(bodies.velocity(slot).norm(), bodies.shape[slot]->bounding_radius_m * bodies.spin(slot).norm());
}

// The islands of a frame, and which of them are near rest.
class Islands {
 public:
  Islands(const RefineInput& input, HeldIslands& work, parallel::Executor& executor)
      : input_(input),
        bodies_(input.scene.bodies),
        gravity_mps_(input.terms.gravity_mps2.norm() * input.terms.dt_s),
        work_(work),
        executor_(executor),
        roots_(work.parent) {}

  // May an island wait at all? Near rest, only if there are so many slow bodies.
  [[nodiscard]] bool any() const {
    if (input_.islands_wait == IslandsWait::Any) return true;
    parallel::Tickets slow;
    parallel::for_ranges(
        executor_, {bodies_.slot_count(), kGrain}, [&](std::size_t, std::size_t begin, std::size_t end) {
          std::size_t count = 0;
          for (std::size_t i = begin; i < end; ++i)
            count += bodies_.dynamic[i] != 0 && speed_mps(bodies_, i) <= kSlow * gravity_mps_ ? 1U : 0U;
          slow.take(count);
        });
    return kSlowOf * slow.take(0) >= std::max<std::size_t>(bodies_.dynamic_count(), 1);
  }

  void find(const parallel::UnsetVector<PairProgress>& progress) {
    const PairTable& table = input_.table;
    for_bodies([&](std::uint32_t slot) {
      work_.parent[slot] = slot;
      work_.islands[slot] = {};
    });
    for_pairs([&](std::uint32_t i) {
      const ActivePair& pair = table.pairs[i];
      if (bodies_.dynamic[pair.a] != 0 && bodies_.dynamic[pair.b] != 0) roots_.unite(pair.a, pair.b);
    });
    sum(bodies_.slot_count(), [&](std::uint32_t slot, auto&& island_of) {
      if (bodies_.dynamic[slot] == 0) return;
      HeldIslands::Island& island = island_of(slot);
      ++island.bodies;
      const double speed = speed_mps(bodies_, slot);
      if (speed > kSlow * gravity_mps_) ++island.moving;
      if (speed > kFast * gravity_mps_) ++island.fast;
      if (speed > kFlying * gravity_mps_) ++island.flying;
      if (bodies_.pushed[slot] != 0 || bodies_.frames_held[slot] >= kMostFramesHeld) island.restless = 1;
    });
    sum(table.size(), [&](std::uint32_t i, auto&& island_of) {
      const ActivePair& pair = table.pairs[i];
      HeldIslands::Island& island = island_of(bodies_.dynamic[pair.a] != 0 ? pair.a : pair.b);
      ++island.pairs;
      if (progress[i].refinable()) ++island.open;
      if (bodies_.moves_by_itself(pair.a) || bodies_.moves_by_itself(pair.b)) island.restless = 1;
      if (!progress[i].apart()) {
        ++island.contacts;
        if (progress[i].cached == CacheUse::None) ++island.unknown;
      }
    });
  }

  // How well the islands are seen. A pair of which nothing is left to find out adds nothing.
  void weigh(const parallel::UnsetVector<PairProgress>& progress) {
    const PairTable& table = input_.table;
    const PairCueSource cues(input_);
    sum(table.size(), [&](std::uint32_t i, auto&& island_of) {
      if (!progress[i].refinable()) return;
      const ActivePair& pair = table.pairs[i];
      const double seen = cues.seen(i) / kWeightUnit;
      island_of(bodies_.dynamic[pair.a] != 0 ? pair.a : pair.b).seen +=
          static_cast<std::uint64_t>(std::clamp(seen, 0.0, 1e9));
    });
  }

  [[nodiscard]] bool may_wait(std::uint32_t root) const {
    const HeldIslands::Island& island = work_.islands[root];
    return work_.parent[root] == root && island.bodies > 0 && island.restless == 0 &&
           (input_.islands_wait == IslandsWait::Any || near_rest(root));
  }
  [[nodiscard]] bool near_rest(std::uint32_t root) const {
    const HeldIslands::Island& island = work_.islands[root];
    return island.flying == 0 && island.moving * kFewOf <= island.bodies && island.fast * kVeryFewOf <= island.bodies;
  }

  // Holds the islands of `work_.roots`.
  std::size_t hold(CompletedLevels& levels) const {
    for (const std::uint32_t root : work_.roots) {
      work_.islands[root].held = true;
      work_.bodies += work_.islands[root].bodies;
      work_.pairs += work_.islands[root].pairs;
      work_.open += work_.islands[root].open;
    }
    work_.slots.resize(bodies_.slot_count());
    for_bodies([&](std::uint32_t slot) {
      work_.slots[slot] = bodies_.dynamic[slot] != 0 && work_.islands[roots_.root(slot)].held ? 1 : 0;
    });
    for_pairs([&](std::uint32_t i) {
      const ActivePair& pair = input_.table.pairs[i];
      levels.progress[i].held = work_.slots[bodies_.dynamic[pair.a] != 0 ? pair.a : pair.b] != 0;
    });
    for (const std::uint32_t root : work_.roots) {
      levels.known.present -= work_.islands[root].contacts;
      levels.known.unknown -= work_.islands[root].unknown;
    }
    return work_.bodies;
  }

 private:
  // Calls use(i, island_of) for all i; what it adds to island_of(slot) is added up. Neighbours are mostly of the same
  // island, so each thread adds up what it can before it gives it to all.
  template <class Use>
  void sum(std::size_t count, Use&& use) {
    parallel::parallel_for(executor_, count, kGrain, [&](std::size_t begin, std::size_t end, int) {
      HeldIslands::Island sums;
      std::uint32_t root = 0;
      const auto give = [&] { work_.islands[root].add(sums); };
      for (std::size_t i = begin; i < end; ++i) {
        use(static_cast<std::uint32_t>(i), [&](std::uint32_t slot) -> HeldIslands::Island& {
          const std::uint32_t of_slot = roots_.root(slot);
          if (of_slot != root) {
            give();
            sums = {};
            root = of_slot;
          }
          return sums;
        });
      }
      give();
    });
  }
  template <class Use>
  void for_bodies(Use&& use) const {
    each(bodies_.slot_count(), use);
  }
  template <class Use>
  void for_pairs(Use&& use) const {
    each(input_.table.size(), use);
  }
  template <class Use>
  void each(std::size_t count, Use& use) const {
    parallel::parallel_for(executor_, count, kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) use(static_cast<std::uint32_t>(i));
    });
  }

  const RefineInput& input_;
  const dynamics::BodyStore& bodies_;
  const double gravity_mps_;
  HeldIslands& work_;
  parallel::Executor& executor_;
  parallel::DisjointSets roots_;
};

bool none_may_wait(const RefineInput& input) {
  return input.islands_wait == IslandsWait::Never || input.terms.backtracking || input.terms.gravity_mps2.isZero(0);
}

}  // namespace

void HeldIslands::Island::add(const Island& part) {
  parallel::add_shared(seen, part.seen);
  parallel::add_shared(bodies, part.bodies);
  parallel::add_shared(pairs, part.pairs);
  parallel::add_shared(open, part.open);
  parallel::add_shared(moving, part.moving);
  parallel::add_shared(fast, part.fast);
  parallel::add_shared(flying, part.flying);
  parallel::add_shared(contacts, part.contacts);
  parallel::add_shared(unknown, part.unknown);
  parallel::add_shared(restless, part.restless);
}

std::size_t hold_islands(const RefineInput& input, std::uint64_t contacts, CompletedLevels& levels,
                         parallel::Executor& executor) {
  HeldIslands& work = levels.held;
  work.clear();
  if (none_may_wait(input) || contacts == 0) return 0;
  work.resize(input.scene.bodies.slot_count());
  Islands islands(input, work, executor);
  if (!islands.any()) return 0;
  islands.find(levels.progress);
  for (std::uint32_t root = 0; root < work.parent.size(); ++root) {
    if (islands.may_wait(root) && work.islands[root].contacts > 0) work.roots.push_back(root);
  }
  if (work.roots.size() > 1) islands.weigh(levels.progress);
  std::sort(work.roots.begin(), work.roots.end(), [&](std::uint32_t x, std::uint32_t y) {
    const bool rests_x = islands.near_rest(x);
    if (rests_x != islands.near_rest(y)) return rests_x;
    const std::uint64_t seen_x = work.islands[x].seen;
    const std::uint64_t seen_y = work.islands[y].seen;
    return seen_x != seen_y ? seen_x < seen_y : x < y;
  });
  std::uint64_t spared = 0;
  std::size_t count = 0;
  while (count < work.roots.size() && spared < contacts) spared += work.islands[work.roots[count++]].contacts;
  work.roots.resize(count);
  std::sort(work.roots.begin(), work.roots.end());
  return count > 0 ? islands.hold(levels) : 0;
}

bool hold_as_recorded(const RefineInput& input, std::span<const std::uint32_t> roots, CompletedLevels& levels,
                      Degraded& degraded, parallel::Executor& executor) {
  HeldIslands& work = levels.held;
  work.clear();
  if (roots.empty()) return true;
  if (none_may_wait(input)) return false;
  work.resize(input.scene.bodies.slot_count());
  Islands islands(input, work, executor);
  islands.find(levels.progress);
  for (const std::uint32_t root : roots) {
    if (root < work.parent.size() && islands.may_wait(root)) work.roots.push_back(root);
  }
  if (!work.roots.empty()) degraded.bodies_held = islands.hold(levels);
  return work.roots.size() == roots.size();
}

}  // namespace poise::simulation
