// SPDX-License-Identifier: MIT
#include "collision/broad_phase/resting_grid.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "collision/shapes.h"

namespace poise::collision {
namespace {

constexpr std::uint32_t kAll = 0xffffffffU;

MotionBound random_bound(std::mt19937_64& random, std::uint32_t slot, double spread_m) {
  MotionBound bound;
  bound.center_m = random_vector(random, spread_m);
  bound.radius_m = std::exp2(uniform(random, -6, 2));
  bound.slot = slot;
  bound.dynamic = false;
  return bound;
}

// Slots that a search visits; each must be visited once.
std::vector<std::uint32_t> visited(const RestingGrid& grid, const MotionBound& around) {
  std::vector<std::uint32_t> slots;
  std::uint32_t room = kAll;
  EXPECT_EQ(grid.visit_near(around.center_m, around.radius_m, room,
                            [&](std::uint32_t slot, const RestingGrid::Entry&) { slots.push_back(slot); }),
            0U);
  std::sort(slots.begin(), slots.end());
  EXPECT_TRUE(std::adjacent_find(slots.begin(), slots.end()) == slots.end());
  return slots;
}

bool overlap(const MotionBound& a, const MotionBound& b) {
  const double reach = a.radius_m + b.radius_m;
  return (a.center_m - b.center_m).squaredNorm() < reach * reach;
}

RC_GTEST_PROP(RestingGrid, VisitsEachBoundThatOverlapsOnceWhateverWasPutInAndTakenOut, ()) {
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  const double spread_m = *rc::gen::element(1.0, 30.0, 1e6);
  const auto executor = parallel::make_executor(ExecutorKind::Threads, 2);
  RestingGrid grid;
  std::vector<MotionBound> in(600);
  std::set<std::uint32_t> held;
  for (int round = 0; round < 6; ++round) {
    std::vector<std::uint32_t> taken;
    std::vector<MotionBound> put;
    for (std::uint32_t slot = 0; slot < in.size(); ++slot) {
      const bool out = held.contains(slot) && random() % 3 == 0;
      if (out) taken.push_back(slot);
      if ((out && random() % 2 == 0) || (!held.contains(slot) && random() % 2 == 0)) {
        in[slot] = random_bound(random, slot, spread_m);
        put.push_back(in[slot]);
        held.insert(slot);
      } else if (out) {
        held.erase(slot);
      }
    }
    grid.change(taken, put, *executor);
    RC_ASSERT(grid.size() == held.size());
    for (int search = 0; search < 50; ++search) {
      const MotionBound around = random_bound(random, 1000, spread_m);
      const std::vector<std::uint32_t> slots = visited(grid, around);
      for (const std::uint32_t slot : held)
        RC_ASSERT(!overlap(in[slot], around) || std::binary_search(slots.begin(), slots.end(), slot));
      for (const std::uint32_t slot : slots) RC_ASSERT(held.contains(slot));
    }
  }
}

TEST(RestingGrid, OneFarLargerThanTheRestMeetsAllOfThem) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  std::vector<MotionBound> put(1000);
  for (std::uint32_t slot = 0; slot < put.size(); ++slot)
    put[slot] = {Vec3(0.1 * slot, 0, 0), 0.01, slot, 1, kAll, false};
  RestingGrid grid;
  grid.change({}, put, *executor);
  EXPECT_EQ(visited(grid, {Vec3::Zero(), 1000, 5000, 1, kAll, true}).size(), put.size());
}

TEST(RestingGrid, InACrowdASearchLooksAtNoMoreThanItHasRoomForAndCountsTheRest) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  std::vector<MotionBound> put(10000);
  for (std::uint32_t slot = 0; slot < put.size(); ++slot) put[slot] = {Vec3::Zero(), 0.5, slot, 1, kAll, false};
  RestingGrid grid;
  grid.change({}, put, *executor);
  std::uint32_t room = 64;
  std::size_t seen = 0;
  const std::size_t left =
      grid.visit_near(Vec3::Zero(), 0.5, room, [&](std::uint32_t, const RestingGrid::Entry&) { ++seen; });
  EXPECT_EQ(seen, 64U);
  EXPECT_EQ(room, 0U);
  EXPECT_EQ(left, put.size() - 64);
}

RC_GTEST_PROP(RestingGrid, WhatRestsAndWhatMovesIsFoundAsInOneGrid, ()) {
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  const auto executor = parallel::make_executor(ExecutorKind::Threads, 2);
  std::vector<MotionBound> all(400);
  std::vector<MotionBound> moving, resting;
  for (std::uint32_t slot = 0; slot < all.size(); ++slot) {
    all[slot] = random_bound(random, slot, 10);
    all[slot].dynamic = random() % 3 != 0;
    all[slot].group = 1U << (random() % 3);
    all[slot].collides_with = static_cast<std::uint32_t>(random() % 8);
    (all[slot].dynamic ? moving : resting).push_back(all[slot]);
  }
  RestingGrid grid;
  grid.change({}, resting, *executor);
  BroadPhase one;
  BroadPhase two;
  const auto together = one.find(all, {}, {kAll / 32}, *executor);
  const auto apart = two.find(moving, {}, {kAll / 32}, *executor, {}, &grid);
  RC_ASSERT(std::equal(together.pairs.begin(), together.pairs.end(), apart.pairs.begin(), apart.pairs.end()));
}

}  // namespace
}  // namespace poise::collision
