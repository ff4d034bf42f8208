// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "frame/coarse.h"
#include "frame/refine/observe_gains.h"
#include "frame/refine/refine.h"
#include "scenes.h"
#include "verify/world_access.h"
#include "world/learned_gains.h"

namespace poise {
namespace {

using simulation::ActivePair;
using simulation::CachedPair;
using simulation::PairTable;
using simulation::WorldState;
using Slots = std::pair<std::uint32_t, std::uint32_t>;

// A heap of jacks that forms and comes to rest in a tray.
struct JackHeap {
  JackHeap() : stage(settings(), 0.2) { stage.jacks(150, 5); }
  static WorldSettings settings() {
    WorldSettings made;
    made.gravity_mps2 = Vec3(0, 0, -9.81);
    return made;
  }
  WorldState& state() { return simulation::WorldAccess::of(stage.world); }
  Stage stage;
};

Slots slots_of(const ActivePair& pair) { return {pair.low(), pair.high()}; }
Slots slots_of(const CachedPair& pair) { return {pair.low, pair.high}; }

// The near pairs of the last step found again, as if none of them were known to be apart.
PairTable found_again(WorldState& world, const simulation::StepTerms& terms) {
  PairTable table;
  simulation::find_active_pairs({world.scene(), terms, world.outputs.motion, world.outputs.candidates,
                                 world.cache.previous_pairs, world.pair_filter, true},
                                table, world.pools, *world.executor);
  return table;
}

TEST(NearPairs, AreActiveOrApartAndInOneOrder) {
  JackHeap heap;
  const StepInput input = step_of(1.0 / 60);
  std::size_t apart_pairs = 0;
  std::size_t planes = 0;
  for (int i = 0; i < 300; ++i) {
    const FrameReport report = heap.stage.world.step(input);
    WorldState& world = heap.state();
    const PairTable& table = world.outputs.table;
    const PairTable all = found_again(world, simulation::terms_of(world.settings, input));
    ASSERT_EQ(all.apart_count(), 0U);
    ASSERT_EQ(all.size(), table.near_count()) << i;
    ASSERT_EQ(report.coarse_pairs, table.near_count());
    std::size_t at = 0;
    table.for_each_near(
        [&](std::size_t k) {
          ASSERT_EQ(slots_of(table.pairs[k]), slots_of(all.pairs[at]));
          ASSERT_EQ(table.pairs[k].margin_m, all.pairs[at].margin_m);
          ASSERT_EQ(table.pairs[k].reach_m, all.pairs[at].reach_m);
          ++at;
        },
        [&](const CachedPair& pair) {
          const ActivePair shown = simulation::near_pair(simulation::terms_of(world.settings, input),
                                                         world.outputs.motion, {pair.low, pair.high}, pair);
          planes += world.outputs.motion.body_bounds[shown.b].plane ? 1U : 0U;
          ASSERT_FALSE(world.outputs.motion.body_bounds[shown.a].plane) << "a plane is second";
          ASSERT_EQ(shown.margin_m, all.pairs[at].margin_m);
          ASSERT_EQ(slots_of(pair), slots_of(all.pairs[at]));
          ASSERT_EQ(&pair, all.pairs[at].cached);
          ASSERT_EQ(all.start[at].cached, simulation::CacheUse::Separated) << "it is known for sure";
          ++at;
          ++apart_pairs;
        });
    ASSERT_EQ(at, all.size());
  }
  EXPECT_GT(apart_pairs, 5000U) << "of a heap at rest many are";
  EXPECT_GT(planes, 0U) << "and some of these are of a body and a wall";
}

// What is known for sure needs no place in the table, unless its bodies have just parted or are fast.
TEST(NearPairs, ThatAreKnownToBeSeparatedAreNotActive) {
  JackHeap heap;
  std::size_t active = 0;
  for (int i = 0; i < 150; ++i) {
    heap.stage.world.step(step_of(1.0 / 60));
    const simulation::Frame& frame = heap.state().outputs;
    for (std::size_t k = 0; k < frame.table.size(); ++k) {
      if (frame.table.start[k].cached != simulation::CacheUse::Separated) continue;
      ++active;
      EXPECT_TRUE(frame.table.pairs[k].cached->touching || frame.table.pairs[k].cached->slot != simulation::kNoSlot);
    }
  }
  EXPECT_LT(active, 100U);
}

TEST(NearPairs, AreCachedForTheNextStepEachOnceAndWithTheirMotion) {
  JackHeap heap;
  for (int i = 0; i < 150; ++i) {
    heap.stage.world.step(step_of(1.0 / 60));
    const WorldState& world = heap.state();
    const PairTable& table = world.outputs.table;
    ASSERT_EQ(world.cache.pairs.size(), table.near_count());
    std::size_t at = 0;
    table.for_each_near([&](std::size_t k) { ASSERT_EQ(slots_of(world.cache.pairs[at++]), slots_of(table.pairs[k])); },
                        [&](const CachedPair& before) {
                          const CachedPair& after = world.cache.pairs[at++];
                          const simulation::StepMotion& a = world.outputs.motions.of_slot[before.low];
                          const simulation::StepMotion& b = world.outputs.motions.of_slot[before.high];
                          ASSERT_EQ(slots_of(after), slots_of(before));
                          ASSERT_TRUE(after.apart);
                          ASSERT_EQ(after.reach_m, before.reach_m);
                          ASSERT_EQ(after.moved_m,
                                    before.moved_m + ((b.moved_m - a.moved_m).norm() + a.turned_m + b.turned_m));
                        });
  }
}

// What is known of pairs that are apart holds: that is an observation like any other.
TEST(NearPairs, ThatAreApartTellHowLongWhatIsKnownHolds) {
  JackHeap heap;
  for (int i = 0; i < 280; ++i) heap.stage.world.step(step_of(1.0 / 60));
  WorldState& world = heap.state();
  const StepInput input = step_of(1.0 / 60);
  const auto observed = [&](const PairTable& table) {
    const simulation::RefineInput of_step{world.scene(),         simulation::terms_of(world.settings, input),
                                          world.outputs.motion,  table,
                                          world.settings.policy, input};
    std::vector<simulation::GainObservation> made;
    simulation::observe_gains(of_step, world.outputs.levels, made);
    return made;
  };
  const PairTable& table = world.outputs.table;
  PairTable active_only = table;
  for (simulation::KnownCount& known : active_only.known_of_chunk) known.apart_begin = 0;
  ASSERT_EQ(active_only.near_count(), table.size());
  std::vector<simulation::GainObservation> of_apart = observed(table);
  of_apart.erase(of_apart.begin(), of_apart.begin() + static_cast<std::ptrdiff_t>(observed(active_only).size()));
  std::size_t expected = 0;
  table.for_each_near([](std::size_t) {},
                      [&](const CachedPair& pair) { expected += pair.level > 0 && pair.frames_waited == 0 ? 1U : 0U; });
  ASSERT_GT(expected, 50U);
  ASSERT_EQ(of_apart.size(), expected);
  for (const simulation::GainObservation& seen : of_apart) {
    ASSERT_EQ(seen.life, simulation::GainObservation::Life::Valid);
    ASSERT_GT(seen.life_level, 0U);
    ASSERT_EQ(seen.level, 0U) << "it was not refined";
  }
}

// That a driven body is near is no less so where the two are known not to touch.
TEST(NearPairs, WhatADrivenBodyIsNearDoesNotWaitAlsoWhereItIsApart) {
  WorldSettings settings = JackHeap::settings();
  settings.islands_wait = IslandsWait::NearRest;
  Stage stage(settings, 0.2);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId shape = stage.jack();
  stage.add(shape, Vec3(0, 0, 1));
  for (int i = 0; i < 240; ++i) stage.world.step(step_of(1.0 / 60));
  BodyDefinition driven;
  driven.shape = shape;
  driven.material = stage.material;
  driven.motion = MotionType::Kinematic;
  // Past the arms of the other one.
  driven.position_m = stage.at(stage.bodies.front()).position_m + Vec3(1.1, 1.1, 0);
  const BodyId driver = stage.world.add_body(driven).value();
  for (const double speed_mps : {0.0, 1e-4}) {
    ASSERT_TRUE(stage.world.set_velocity(driver, Vec3(0, speed_mps, 0), Vec3::Zero()).ok());
    for (int i = 0; i < 3; ++i) stage.world.step(step_of(1.0 / 60));
    ASSERT_EQ(simulation::WorldAccess::of(stage.world).outputs.table.apart_count(), 1U);
    EXPECT_EQ(stage.world.step(hopeless()).degraded.bodies_held, speed_mps > 0 ? 0U : 1U);
  }
}

TEST(NearPairs, AllHaveTheirBodiesVisited) {
  JackHeap heap;
  for (int i = 0; i < 120; ++i) heap.stage.world.step(step_of(1.0 / 60));
  const PairTable& table = heap.state().outputs.table;
  ASSERT_GT(table.apart_count(), 0U);
  std::vector<Slots> visited;
  std::mutex mutex;
  table.for_each_near_bodies(*heap.state().executor, [&](std::uint32_t a, std::uint32_t b) {
    const std::lock_guard lock(mutex);
    visited.emplace_back(std::min(a, b), std::max(a, b));
  });
  std::vector<Slots> expected;
  for (const CachedPair& pair : heap.state().cache.pairs) expected.push_back(slots_of(pair));
  std::sort(visited.begin(), visited.end());
  EXPECT_EQ(visited, expected);
}

}  // namespace
}  // namespace poise
