// SPDX-License-Identifier: MIT
// The kernels of the broad phase, on each instruction set of this machine: they lose no partner and invent none.
#include "collision/broad_phase/near_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/order_kernel.h"
#include "collision/brute_force.h"
#include "collision/instruction_sets.h"
#include "collision/shapes.h"

namespace poise::collision {
namespace {

// What the broad phase has to tell apart: balls that all meet, and every `others`-th with groups or at rest.
std::vector<MotionBound> mixed_bounds(std::mt19937_64& random, std::size_t n, double spread_m, const Vec3& middle_m,
                                      std::size_t others) {
  std::vector<MotionBound> bounds(n);
  for (std::size_t i = 0; i < n; ++i) {
    MotionBound& bound = bounds[i];
    bound.center_m = middle_m + random_vector(random, spread_m);
    bound.radius_m = std::exp2(uniform(random, -3, 0));
    bound.slot = static_cast<std::uint32_t>(i);
    if (i % others != others - 1) continue;
    bound.dynamic = random() % 2 == 0;
    bound.group = 1U << (random() % 3);
    bound.collides_with = static_cast<std::uint32_t>(random() % 8);
  }
  return bounds;
}

// Balls on a lattice that touch their neighbours, or miss or overlap them by `by`.
std::vector<MotionBound> touching_bounds(int side, const Vec3& corner_m, double by) {
  std::vector<MotionBound> bounds;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) {
        MotionBound bound;
        bound.center_m = corner_m + Vec3(x, y, z);
        bound.radius_m = 0.5 + by;
        bound.slot = static_cast<std::uint32_t>(bounds.size());
        bounds.push_back(bound);
      }
    }
  }
  return bounds;
}

void expect_all_pairs(std::span<const MotionBound> bounds, const std::string& what) {
  const auto expected = brute_force(bounds, {});
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  const int sets = on_every_instruction_set([&](const char* name) {
    BroadPhase broad;
    const auto result = broad.find(bounds, {}, {65536}, *executor);
    EXPECT_EQ(std::vector<CandidatePair>(result.pairs.begin(), result.pairs.end()), expected) << what << ", " << name;
    EXPECT_EQ(result.discarded, 0U);
  });
  EXPECT_GE(sets, 2);
}

TEST(NearKernel, EachInstructionSetFindsExactlyTheOverlappingPairs) {
  std::mt19937_64 random(3);
  for (const double spread_m : {1.5, 4.0, 9.0}) {
    for (const std::size_t others : {std::size_t{1}, std::size_t{20}, std::size_t{5000}}) {
      const auto bounds = mixed_bounds(random, 1200, spread_m, Vec3::Zero(), others);
      expect_all_pairs(bounds, "spread " + std::to_string(spread_m) + ", others " + std::to_string(others));
    }
  }
}

TEST(NearKernel, FarFromTheOriginAndNearlyTouchingItIsDecidedInDoublePrecision) {
  std::mt19937_64 random(4);
  for (const double far_m : {1e3, 1e6, 1e8, 1e13})
    expect_all_pairs(mixed_bounds(random, 600, 4.0, {far_m, -far_m, 0.3 * far_m}, 5000), std::to_string(far_m));
  for (const double by : {0.0, 1e-13, -1e-13, 1e-9, -1e-9, 1e-7, -1e-7}) {
    expect_all_pairs(touching_bounds(9, Vec3::Zero(), by), "touching by " + std::to_string(by));
    expect_all_pairs(touching_bounds(9, {1000.1, -70.3, 0.7}, by), "far and touching by " + std::to_string(by));
  }
}

// Coordinates beyond single precision, or none: what is not told apart is tested in double precision.
TEST(NearKernel, BallsBeyondSinglePrecisionAreNeitherApartNorSureToOverlap) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const NearBall usual = near_ball(Vec3(1, 2, 3), 0.5, true);
  EXPECT_GT(usual.least_m, 0.499F);
  EXPECT_LT(near_ball(Vec3(1, 2, 3), 0.5, false).least_m + 1e17F, 0);
  for (const Vec3& center_m : {Vec3(1e30, 0, 0), Vec3(0, -1e300, 0), Vec3(0, 0, none)}) {
    const NearBall far = near_ball(center_m, 0.5, true);
    EXPECT_GT(far.most_m, 9e17F);
    EXPECT_LT(far.least_m, -9e17F);
    EXPECT_EQ(far.x, 0);
  }
}

TEST(NearKernel, ListsOfAnyLengthAreOrdered) {
  std::mt19937_64 random(5);
  const int sets = on_every_instruction_set([&](const char* name) {
    std::vector<std::uint32_t> high;
    std::vector<std::uint32_t> ends;
    std::vector<CandidatePair> expected;
    for (std::uint32_t low = 7; low < 7 + 2 * kLongestOrdered; ++low) {
      const std::uint32_t count = (low * 13) % (kLongestOrdered + 1);
      std::vector<std::uint32_t> list(count);
      // Slots use all bits.
      for (std::uint32_t k = 0; k < count; ++k) list[k] = 0xffffffffU - (k * 0x05000000U) - low;
      std::shuffle(list.begin(), list.end(), random);
      high.insert(high.end(), list.begin(), list.end());
      ends.push_back(static_cast<std::uint32_t>(high.size()));
      std::sort(list.begin(), list.end());
      for (const std::uint32_t slot : list) expected.push_back({low, slot});
    }
    high.resize(high.size() + PartnerLists::kPast);
    std::vector<CandidatePair> pairs(expected.size());
    EXPECT_TRUE(order_partners({7, 0, ends, high.data()}, pairs.data()));
    EXPECT_EQ(pairs, expected) << name;
    ends.push_back(ends.back() + kLongestOrdered + 1);
    high.resize(high.size() + kLongestOrdered + 1);
    EXPECT_FALSE(order_partners({7, 0, ends, high.data()}, pairs.data()));
    EXPECT_EQ(pairs, expected) << name;
  });
  EXPECT_GE(sets, 2);
}

// Planes have far more partners than bodies.
TEST(NearKernel, ManyPartnersOfOneAreInOrder) {
  std::mt19937_64 random(6);
  for (const std::uint32_t apart : {1U, 3U, 100000U}) {
    auto bounds = mixed_bounds(random, 500, 30.0, Vec3::Zero(), 5000);
    for (MotionBound& bound : bounds) bound.slot = 5 + bound.slot * apart;
    const std::vector<PlaneBound> planes = {{Vec3::UnitZ(), 0.0, 2, 1, 0xffffffffU}};
    const auto executor = parallel::make_executor(ExecutorKind::Threads, 3);
    BroadPhase broad;
    for (int again = 0; again < 2; ++again) {
      const auto result = broad.find(bounds, planes, {65536}, *executor);
      const auto of_plane =
          std::count_if(result.pairs.begin(), result.pairs.end(), [](const auto& pair) { return pair.low == 2; });
      EXPECT_EQ(of_plane, std::count_if(bounds.begin(), bounds.end(),
                                        [](const auto& bound) { return bound.center_m.z() < bound.radius_m; }));
      EXPECT_GT(of_plane, 100);
      EXPECT_TRUE(std::is_sorted(result.pairs.begin(), result.pairs.end(), [](const auto& x, const auto& y) {
        return std::pair(x.low, x.high) < std::pair(y.low, y.high);
      }));
    }
  }
}

}  // namespace
}  // namespace poise::collision
