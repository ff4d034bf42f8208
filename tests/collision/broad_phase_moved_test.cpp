// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/resting_grid.h"
#include "collision/brute_force.h"
#include "collision/shapes.h"

namespace poise::collision {
namespace {

using PairList = std::vector<CandidatePair>;

bool in_order(const CandidatePair& a, const CandidatePair& b) {
  return std::pair(a.low, a.high) < std::pair(b.low, b.high);
}

std::optional<PairList> pairs_of(const std::optional<BroadPhase::Result>& found) {
  if (!found) return std::nullopt;
  return PairList(found->pairs.begin(), found->pairs.end());
}

/// Bounds in a cloud, and which of them have moved.
struct Cloud {
  std::vector<MotionBound> bounds;
  std::vector<std::uint32_t> moved;

  Cloud(std::size_t n, double spread_m) : bounds(n) {
    for (std::size_t i = 0; i < n; ++i) {
      bounds[i].center_m = random_vector(random, spread_m);
      bounds[i].radius_m = 0.5;
      bounds[i].slot = static_cast<std::uint32_t>(i);
    }
  }
  // Each of the first `count` to another place.
  void move(std::size_t count, double spread_m) {
    moved.clear();
    for (std::size_t i = 0; i < count; ++i) {
      bounds[i].center_m = random_vector(random, spread_m);
      moved.push_back(static_cast<std::uint32_t>(i));
    }
  }
  // Each of the first `count` by a little.
  void nudge(std::size_t count) {
    moved.clear();
    for (std::size_t i = 0; i < count; ++i) {
      bounds[i].center_m.x() += 1e-6;
      moved.push_back(static_cast<std::uint32_t>(i));
    }
  }
  std::mt19937_64 random{5};
};

RC_GTEST_PROP(MovedBounds, AllPairsThatOverlapAreFoundInOrderAndNoOthersAreAdded, ()) {
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  const auto n = *rc::gen::inRange<std::size_t>(1, 500);
  const double spread = *rc::gen::element(1.0, 2.0, 4.0);
  // As many octaves as cells may be wide of what is found anywhere.
  std::vector<MotionBound> bounds = random_bounds(random, n, spread, *rc::gen::element(0, 1, 2));
  const std::vector<PlaneBound> planes = {{Vec3(0.6, 0, 0.8), 0.2, 0, 1, 0xffffffffU}, {Vec3::UnitY(), -1.0, 2, 6, 3}};
  const auto executor = parallel::make_executor(ExecutorKind::Threads, *rc::gen::element(1, 3));
  // Every fifth rests.
  std::vector<MotionBound> rests;
  std::erase_if(bounds, [&](const MotionBound& bound) {
    if (bound.slot % 5 != 0) return false;
    rests.push_back(bound);
    rests.back().dynamic = false;
    return true;
  });
  RestingGrid resting;
  resting.change({}, rests, *executor);
  const auto overlapping = [&] {
    std::vector<MotionBound> all = bounds;
    all.insert(all.end(), rests.begin(), rests.end());
    PairList pairs = brute_force(all, planes);
    // What rests searches for nothing.
    const auto moves = [&](std::uint32_t slot) {
      return std::any_of(bounds.begin(), bounds.end(), [&](const MotionBound& bound) { return bound.slot == slot; });
    };
    std::erase_if(pairs, [&](const CandidatePair& pair) { return !moves(pair.low) && !moves(pair.high); });
    return pairs;
  };
  std::vector<double> radius_m;
  for (const MotionBound& bound : bounds) radius_m.push_back(bound.radius_m);
  BroadPhase broad;
  const BroadPhase::Result first = broad.find(bounds, planes, {65536}, *executor, {}, &resting);
  PairList expected = overlapping();
  RC_ASSERT(PairList(first.pairs.begin(), first.pairs.end()) == expected);
  int frames_added_to = 0;
  for (int frame = 0; frame < 5; ++frame) {
    std::vector<std::uint32_t> moved;
    for (std::uint32_t i = 0; i < bounds.size(); ++i) {
      if (random() % 100 != 0) continue;
      bounds[i].center_m += random_vector(random, 0.3 * spread);
      bounds[i].radius_m = uniform(random, 0.8, 1.2) * radius_m[i];
      moved.push_back(i);
    }
    const auto found = pairs_of(broad.find_moved(bounds, moved, planes, {65536}, *executor, &resting));
    if (!found) {
      // Too many have moved, or they have added too many pairs.
      broad.find(bounds, planes, {65536}, *executor, {}, &resting);
      expected = overlapping();
      continue;
    }
    frames_added_to += moved.empty() ? 0 : 1;
    RC_ASSERT(std::is_sorted(found->begin(), found->end(), in_order));
    RC_ASSERT(std::adjacent_find(found->begin(), found->end()) == found->end());
    const PairList now = overlapping();
    RC_ASSERT(std::includes(found->begin(), found->end(), now.begin(), now.end(), in_order));
    // All others overlapped at some time, or with where one was that has moved.
    for (const CandidatePair& pair : *found) {
      const auto has_moved = [&](std::uint32_t slot) {
        return std::any_of(moved.begin(), moved.end(), [&](std::uint32_t i) { return bounds[i].slot == slot; });
      };
      const bool was = std::binary_search(expected.begin(), expected.end(), pair, in_order);
      RC_ASSERT(was || has_moved(pair.low) || has_moved(pair.high));
    }
    expected = *found;
  }
  RC_CLASSIFY(frames_added_to > 0);
}

TEST(MovedBounds, AnyNumberOfThreadsGivesTheSamePairs) {
  std::vector<PairList> found;
  for (const int threads : {1, 2, 4}) {
    const auto executor = parallel::make_executor(ExecutorKind::Threads, threads);
    Cloud cloud(20000, 12);
    BroadPhase broad;
    broad.find(cloud.bounds, {}, {256}, *executor);
    for (int frame = 0; frame < 3; ++frame) {
      cloud.move(60, 12);
      const auto pairs = pairs_of(broad.find_moved(cloud.bounds, cloud.moved, {}, {256}, *executor));
      ASSERT_TRUE(pairs.has_value());
      ASSERT_TRUE(std::is_sorted(pairs->begin(), pairs->end(), in_order));
      ASSERT_TRUE(std::adjacent_find(pairs->begin(), pairs->end()) == pairs->end());
      BroadPhase another;
      const auto now = pairs_of(another.find(cloud.bounds, {}, {256}, *executor));
      ASSERT_TRUE(std::includes(pairs->begin(), pairs->end(), now->begin(), now->end(), in_order));
      found.push_back(*pairs);
    }
  }
  for (std::size_t k = 3; k < found.size(); ++k) EXPECT_EQ(found[k], found[k % 3]);
  EXPECT_GT(found[1].size(), found[0].size());
}

TEST(MovedBounds, AreFoundAnewWhereTooManyHaveMoved) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  Cloud cloud(3200, 6);
  BroadPhase broad;
  broad.find(cloud.bounds, {}, {256}, *executor);
  constexpr std::uint32_t kMostMoved = 200;
  EXPECT_EQ(BroadPhase::most_moved(cloud.bounds.size()), kMostMoved);
  cloud.nudge(kMostMoved);
  EXPECT_TRUE(broad.find_moved(cloud.bounds, cloud.moved, {}, {256}, *executor).has_value());
  // The same again are not more; one more is.
  cloud.nudge(kMostMoved);
  EXPECT_TRUE(broad.find_moved(cloud.bounds, cloud.moved, {}, {256}, *executor).has_value());
  const std::uint32_t another = 2999;
  EXPECT_FALSE(broad.find_moved(cloud.bounds, {&another, 1}, {}, {256}, *executor).has_value());
  broad.find(cloud.bounds, {}, {256}, *executor);
  EXPECT_TRUE(broad.find_moved(cloud.bounds, {&another, 1}, {}, {256}, *executor).has_value());
}

TEST(MovedBounds, AreFoundAnewWhereManyPairsStayThatNoLongerOverlap) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  Cloud cloud(3200, 6);
  BroadPhase broad;
  const std::size_t found = broad.find(cloud.bounds, {}, {4096}, *executor).pairs.size();
  // One that goes to and fro has pairs along its whole way.
  std::size_t pairs = found;
  const std::uint32_t one = 5;
  bool added = true;
  int steps = 0;
  for (; added && steps < 10000; ++steps) {
    cloud.bounds[one].center_m = random_vector(cloud.random, 6);
    const auto moved = broad.find_moved(cloud.bounds, {&one, 1}, {}, {4096}, *executor);
    added = moved.has_value();
    if (added) pairs = moved->pairs.size();
  }
  EXPECT_FALSE(added);
  EXPECT_GT(steps, 10);
  EXPECT_GT(pairs, found + found / 20);
  EXPECT_LE(pairs, found + found / 16);
}

TEST(MovedBounds, AreFoundAnewWherePairsMightHaveToBeDiscarded) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  constexpr std::uint32_t kMost = 20;
  const PlaneBound floor{Vec3::UnitZ(), 100, 6000, 1, 0xffffffffU};
  const std::span<const PlaneBound> planes(&floor, 1);
  Cloud cloud(5000, 10);
  BroadPhase broad;
  EXPECT_EQ(broad.find(cloud.bounds, planes, {kMost}, *executor).discarded, 0U);
  // One after another comes to the same place; with the plane all pair anyway.
  bool added = true;
  std::uint32_t came = 0;
  while (added && came < 2 * kMost) {
    cloud.bounds[came].center_m = Vec3::Zero();
    added = broad.find_moved(cloud.bounds, {&came, 1}, planes, {kMost}, *executor).has_value();
    ++came;
  }
  EXPECT_FALSE(added);
  EXPECT_GT(came, kMost / 4);
  EXPECT_LE(came, kMost + 1);
  // Where all may have more partners none is left out, nor where all together may have more.
  const std::uint32_t last = 4999;
  const auto one_more = [&](const PartnerLimits& limits) {
    broad.find(cloud.bounds, planes, {256}, *executor);
    MotionBound& bound = cloud.bounds[last];
    const Vec3 was = std::exchange(bound.center_m, Vec3::Zero());
    const bool found = broad.find_moved(cloud.bounds, {&last, 1}, planes, limits, *executor).has_value();
    bound.center_m = was;
    return found;
  };
  const std::size_t all = brute_force(cloud.bounds, planes).size();
  EXPECT_TRUE(one_more({256}));
  EXPECT_FALSE(one_more({256, all}));
  EXPECT_TRUE(one_more({256, 2 * all}));
}

TEST(MovedBounds, OfPlanesNoPartnersAreLeftOut) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  const PlaneBound floor{Vec3::UnitZ(), -100, 6000, 1, 0xffffffffU};
  const std::span<const PlaneBound> planes(&floor, 1);
  constexpr std::uint32_t kMost = 50;
  // Some far away from the others, which have the pairs of which a sixteenth may be added.
  Cloud cloud(3200, 6);
  for (std::uint32_t i = 0; i < 100; ++i) cloud.bounds[i].center_m = Vec3(100 + 3.0 * i, 0, 0);
  BroadPhase broad;
  broad.find(cloud.bounds, planes, {kMost}, *executor);
  // They come down to the plane one after another.
  for (std::uint32_t i = 0; i < 100; ++i) {
    cloud.bounds[i].center_m.z() = -99.8;
    const auto found = pairs_of(broad.find_moved(cloud.bounds, {&i, 1}, planes, {kMost}, *executor));
    ASSERT_TRUE(found.has_value()) << i;
    ASSERT_TRUE(std::binary_search(found->begin(), found->end(), CandidatePair{i, floor.slot}, in_order));
  }
}

// Where crowds are thinned out a body may keep few partners for sure.
TEST(MovedBounds, InACrowdAllAreFoundAnew) {
  struct Crowds final : CrowdedBodies {
    [[nodiscard]] std::uint32_t most_partners(std::uint32_t /*slot*/) const override { return 300; }
  };
  const Crowds crowds;
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  PartnerLimits limits{256};
  limits.crowds = &crowds;
  limits.of_crowded = 8;
  const std::uint32_t one = 5;
  // With partners as a heap has, and with some hundred.
  for (const double spread_m : {6.0, 2.0}) {
    Cloud cloud(3200, spread_m);
    BroadPhase broad;
    broad.find(cloud.bounds, {}, limits, *executor);
    cloud.bounds[one].center_m.x() += 1e-6;
    EXPECT_EQ(broad.find_moved(cloud.bounds, {&one, 1}, {}, limits, *executor).has_value(), spread_m > 5);
  }
}

TEST(MovedBounds, AreFoundAnewForOneThatIsFarLargerThanTheOthers) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  Cloud cloud(500, 4);
  cloud.bounds[7].radius_m = 20;
  BroadPhase broad;
  broad.find(cloud.bounds, {}, {1024}, *executor);
  const std::uint32_t large = 7;
  EXPECT_FALSE(broad.find_moved(cloud.bounds, {&large, 1}, {}, {1024}, *executor).has_value());
  // A small one next to it is no trouble.
  broad.find(cloud.bounds, {}, {1024}, *executor);
  const std::uint32_t small = 8;
  EXPECT_TRUE(broad.find_moved(cloud.bounds, {&small, 1}, {}, {1024}, *executor).has_value());
}

}  // namespace
}  // namespace poise::collision
