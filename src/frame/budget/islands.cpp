// SPDX-License-Identifier: MIT
#include "frame/budget/islands.h"

#include <algorithm>

#include "frame/refine/pair_cues.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// Near rest, in what gravity adds in a step. Chosen: a heap that has just come down still trembles.
constexpr double kSlow = 2, kFast = 8, kFlying = 32;
constexpr std::uint32_t kFewOf = 2, kVeryFewOf = 10;
// Fewer slow bodies than this share of all are not worth a look.
constexpr std::size_t kSlowOf = 4;
// Weights are summed as whole numbers, whose sum does not depend on the order.
constexpr double kWeightUnit = 1e-3;

// Memory for all slots, before anything holds a place in it.
IslandSums& sized(IslandSums& sums, std::size_t slots) {
  sums.parent.resize(slots);
  sums.islands.resize(slots);
  return sums;
}

}  // namespace

void IslandSums::Island::add(const Island& part) {
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
  parallel::raise_shared(angle_urad, part.angle_urad);
}

Islands::Islands(const RefineInput& input, IslandSums& sums, parallel::Executor& executor)
    : input_(input),
      bodies_(input.scene.bodies),
      gravity_mps_(input.terms.gravity_mps2.norm() * input.terms.dt_s),
      sums_(sized(sums, bodies_.slot_count())),
      executor_(executor),
      roots_(sums.parent) {}

std::uint32_t visible_angle_urad(const ViewQuery& view_query, const Vec3& center_m, double radius_m) {
  if (!view_query.view.present || !in_frustum(view_query, center_m, radius_m)) return 0;
  const double distance_m = std::max((center_m - view_query.view.position_m).norm(), 1e-9);
  return static_cast<std::uint32_t>(std::clamp(1e6 * radius_m / distance_m, 1.0, 1e9));
}

std::size_t most_turns(const View& view, std::uint32_t angle_urad) {
  if (!view.present) return kMostTurns;
  if (angle_urad == 0) return kMostTurnsUnseen;
  constexpr double kDegreeUrad = 17453;
  const double turns = static_cast<double>(kMostTurns) * kDegreeUrad / angle_urad;
  return static_cast<std::size_t>(
      std::clamp(turns, static_cast<double>(kMostTurns), static_cast<double>(kMostTurnsUnseen)));
}

bool Islands::any_may_wait(const RefineInput& input) {
  return input.islands_wait != IslandsWait::Never && !input.terms.backtracking && !input.terms.gravity_mps2.isZero(0);
}

double Islands::speed_mps(std::size_t slot) const {
  return std::max(bodies_.velocity(slot).norm(), bodies_.shape[slot]->bounding_radius_m * bodies_.spin(slot).norm());
}

bool Islands::worth_a_look() const {
  if (input_.islands_wait == IslandsWait::Any) return true;
  const std::vector<std::uint32_t>& visited = input_.motion.visited;
  parallel::Tickets slow;
  parallel::for_ranges(executor_, {visited.size(), kGrain}, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = visited[k];
      count += bodies_.dynamic[i] != 0 && speed_mps(i) <= kSlow * gravity_mps_ ? 1U : 0U;
    }
    slow.take(count);
  });
  return kSlowOf * slow.take(0) >= std::max<std::size_t>(bodies_.dynamic_count(), 1);
}

// Calls use(i, island_of) for all i; what it adds to island_of(slot) is added up. Neighbours are mostly of the same
// island, so each thread adds up what it can before it gives it to all.
template <class Use>
void Islands::sum(std::size_t count, Use&& use) {
  parallel::parallel_for(executor_, count, kGrain, [&](std::size_t begin, std::size_t end, int) {
    IslandSums::Island sums;
    constexpr std::uint32_t kNone = 0xffffffffU;
    std::uint32_t root = kNone;
    const auto give = [&] {
      if (root != kNone) sums_.islands[root].add(sums);
    };
    for (std::size_t i = begin; i < end; ++i) {
      use(static_cast<std::uint32_t>(i), [&](std::uint32_t slot) -> IslandSums::Island& {
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

// By cells of space: what is in one, or in the next, is one island. Cells are about as wide as bodies reach in the
// time.
void Islands::unite_near(double apart_s) {
  const std::vector<std::uint32_t>& visited = input_.motion.visited;
  // In whole millimetres, whose sum does not depend on the order.
  parallel::Tickets reach_mm;
  parallel::for_ranges(executor_, {visited.size(), kGrain}, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::size_t sum_mm = 0;
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t slot = visited[k];
      if (bodies_.dynamic[slot] == 0) continue;
      const double reach_m = bodies_.shape[slot]->bounding_radius_m + bodies_.velocity(slot).norm() * apart_s;
      sum_mm += static_cast<std::size_t>(1e3 * std::min(reach_m, 1e6));
    }
    reach_mm.take(sum_mm);
  });
  constexpr double kCellOfReach = 3;
  const double mean_mm = static_cast<double>(reach_mm.take(0)) / static_cast<double>(bodies_.dynamic_count());
  const double cells_per_m = 1e3 / (kCellOfReach * std::max(1.0, mean_mm));
  sums_.cells.begin(visited.size(), executor_);
  each(visited.size(), [&](std::uint32_t k) {
    const std::uint32_t slot = visited[k];
    if (bodies_.dynamic[slot] == 0) return;
    const std::uint32_t first = sums_.cells.add(bodies_.position(slot), cells_per_m, slot);
    if (first != slot) roots_.unite(first, slot);
  });
  each(sums_.cells.size(), [&](std::uint32_t place) {
    sums_.cells.for_neighbours(place, [&](std::uint32_t a, std::uint32_t b) { roots_.unite(a, b); });
  });
}

// Pairs are near or not by how their bodies move against each other. What follows another at its speed runs into it
// if that one stands still.
void Islands::unite_in_reach() {
  const std::span<const collision::CandidatePair> candidates = input_.candidates;
  const parallel::UnsetVector<BodyBounds>& bounds = input_.motion.body_bounds;
  each(candidates.size(), [&](std::uint32_t i) {
    const auto [low, high] = std::pair(candidates[i].low, candidates[i].high);
    if (bodies_.dynamic[low] == 0 || bodies_.dynamic[high] == 0) return;
    const BodyBounds& a = bounds[low];
    const BodyBounds& b = bounds[high];
    const double moved_m = std::max(a.bound_m - a.radius_m, b.bound_m - b.radius_m);
    const double reach_m = a.radius_m + b.radius_m + moved_m;
    if ((b.position_m - a.position_m).squaredNorm() < reach_m * reach_m) roots_.unite(low, high);
  });
}

void Islands::find(const parallel::UnsetVector<PairProgress>& progress, double apart_s) {
  const PairTable& table = input_.table;
  const std::vector<std::uint32_t>& visited = input_.motion.visited;
  each(visited.size(), [&](std::uint32_t k) {
    sums_.parent[visited[k]] = visited[k];
    sums_.islands[visited[k]] = {};
  });
  table.for_each_near_bodies(executor_, [&](std::uint32_t a, std::uint32_t b) {
    if (bodies_.dynamic[a] != 0 && bodies_.dynamic[b] != 0) roots_.unite(a, b);
  });
  if (apart_s == 0) unite_in_reach();
  if (apart_s > 0 && bodies_.dynamic_count() > 0) unite_near(apart_s);
  sum(visited.size(), [&](std::uint32_t k, auto&& island_of) {
    const std::uint32_t slot = visited[k];
    if (bodies_.dynamic[slot] == 0) return;
    IslandSums::Island& island = island_of(slot);
    ++island.bodies;
    const double speed = speed_mps(slot);
    if (speed > kSlow * gravity_mps_) ++island.moving;
    if (speed > kFast * gravity_mps_) ++island.fast;
    if (speed > kFlying * gravity_mps_) ++island.flying;
    if (bodies_.pushed[slot] != 0 || bodies_.frames_held[slot] >= kMostFramesHeld) island.restless = 1;
  });
  sum(table.size(), [&](std::uint32_t i, auto&& island_of) {
    const ActivePair& pair = table.pairs[i];
    // After the step, of what has just fallen asleep.
    if (bodies_.dynamic[pair.a] == 0 && bodies_.dynamic[pair.b] == 0) return;
    IslandSums::Island& island = island_of(dynamic_of(pair));
    ++island.pairs;
    if (progress[i].refinable()) ++island.open;
    if (!progress[i].apart()) {
      ++island.contacts;
      if (progress[i].cached == CacheUse::None) ++island.unknown;
    }
  });
  note_driven();
}

// Those near a body that moves by itself.
void Islands::note_driven() {
  if (bodies_.kinematic_count() == 0) return;
  input_.table.for_each_near_bodies(executor_, [&](std::uint32_t a, std::uint32_t b) {
    for (const auto& [driver, driven] : {std::pair(a, b), std::pair(b, a)}) {
      if (bodies_.moves_by_itself(driver) && bodies_.dynamic[driven] != 0)
        parallel::raise_shared(sums_.islands[roots_.root(driven)].restless, 1U);
    }
  });
}

void Islands::weigh_bodies() {
  const std::vector<std::uint32_t>& visited = input_.motion.visited;
  const ViewQuery view_query(input_.step.view);
  sum(visited.size(), [&](std::uint32_t k, auto&& island_of) {
    const std::uint32_t slot = visited[k];
    if (bodies_.dynamic[slot] == 0) return;
    PairView view;
    view.point_m = bodies_.position(slot);
    view.normal = input_.terms.gravity_mps2.normalized();
    view.extent_m = bodies_.shape[slot]->bounding_radius_m;
    view.closing_mps = bodies_.velocity(slot).norm();
    view.importance = bodies_.importance[slot];
    const scheduler::PairCues cues = cues_of(view_query, view, input_.policy);
    const double seen = scheduler::cue_weight(input_.policy, cues) * cues.angle_radpm / kWeightUnit;
    IslandSums::Island& island = island_of(slot);
    island.seen += static_cast<std::uint64_t>(std::clamp(seen, 0.0, 1e9));
    island.angle_urad = std::max(island.angle_urad, visible_angle_urad(view_query, view.point_m, view.extent_m));
  });
}

void Islands::weigh_pairs(const parallel::UnsetVector<PairProgress>& progress) {
  const PairTable& table = input_.table;
  const PairCueSource cues(input_);
  sum(table.size(), [&](std::uint32_t i, auto&& island_of) {
    if (!progress[i].refinable()) return;
    const double seen = cues.seen(i) / kWeightUnit;
    island_of(dynamic_of(table.pairs[i])).seen += static_cast<std::uint64_t>(std::clamp(seen, 0.0, 1e9));
  });
}

bool Islands::may_wait(std::uint32_t root) const {
  if (bodies_.dynamic[root] == 0 || sums_.parent[root] != root) return false;
  return sums_.islands[root].restless == 0 && (input_.islands_wait == IslandsWait::Any || near_rest(root));
}

bool Islands::near_rest(std::uint32_t root) const {
  const IslandSums::Island& island = sums_.islands[root];
  return island.flying == 0 && island.moving * kFewOf <= island.bodies && island.fast * kVeryFewOf <= island.bodies;
}

void Islands::sort_by_turn(std::vector<std::uint32_t>& roots) const {
  parallel::sort(executor_, roots, sums_.sorting,
                 [this](std::uint32_t x, std::uint32_t y) { return waits_before(x, y); });
}

bool Islands::waits_before(std::uint32_t x, std::uint32_t y) const {
  const bool rests_x = near_rest(x);
  if (rests_x != near_rest(y)) return rests_x;
  const std::uint64_t seen_x = sums_.islands[x].seen;
  const std::uint64_t seen_y = sums_.islands[y].seen;
  return seen_x != seen_y ? seen_x < seen_y : x < y;
}

}  // namespace poise::simulation
