// SPDX-License-Identifier: MIT
#include "world/candidate_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "geometry/primitives/random.h"

namespace poise::simulation {
namespace {

using collision::CandidatePair;
using collision::MotionBound;

std::vector<MotionBound> cloud(std::size_t count) {
  geometry::Random random(5);
  std::vector<MotionBound> bounds(count);
  for (std::size_t i = 0; i < count; ++i) {
    bounds[i].center_m = Vec3(10 * random.unit(), 10 * random.unit(), 10 * random.unit());
    bounds[i].radius_m = 0.6;
    bounds[i].slot = static_cast<std::uint32_t>(i);
  }
  return bounds;
}

bool meet(const MotionBound& a, const MotionBound& b) {
  const double reach = a.radius_m + b.radius_m;
  return (a.center_m - b.center_m).squaredNorm() < reach * reach;
}

TEST(CandidateCache, HoldEveryPairOfLaterFramesWhileBoundsMoveLittleAndAfterTheyMovedFar) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  collision::BroadPhase broad_phase;
  CandidateCache cached;
  geometry::Random random(6);
  std::vector<MotionBound> bounds = cloud(300);
  std::size_t reused = 0;
  std::vector<CandidatePair> before;
  for (int frame = 0; frame < 60; ++frame) {
    // At rest at first, then a jolt, then at rest again.
    const double step = frame == 30 ? 0.5 : 2e-4;
    for (MotionBound& bound : bounds)
      bound.center_m += step * Vec3(random.symmetric(), random.symmetric(), random.symmetric());
    const auto found = cached.find(broad_phase, bounds, {}, {}, {}, {256}, *executor);
    const std::vector<CandidatePair> pairs(found.pairs.begin(), found.pairs.end());
    EXPECT_EQ(found.discarded, 0U);
    for (std::uint32_t i = 0; i < bounds.size(); ++i) {
      for (std::uint32_t j = i + 1; j < bounds.size(); ++j) {
        if (!meet(bounds[i], bounds[j])) continue;
        ASSERT_TRUE(std::find(pairs.begin(), pairs.end(), CandidatePair{i, j}) != pairs.end()) << frame;
      }
    }
    reused += pairs == before ? 1U : 0U;
    before = pairs;
  }
  EXPECT_GT(reused, 40U);
}

TEST(CandidateCache, OfAFewThatLeaveTheirBoundsThePairsAreLookedForOneByOne) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  collision::BroadPhase broad_phase;
  CandidateCache cached;
  std::vector<MotionBound> bounds = cloud(3000);
  const auto find = [&] { return cached.find(broad_phase, bounds, {}, {}, {}, {256}, *executor); };
  find();
  const std::size_t of_all = find().looked_at;
  EXPECT_GT(of_all, bounds.size());
  std::size_t anew = 0;
  for (int frame = 0; frame < 100; ++frame) {
    // Ten cross the cloud, and one changes its size.
    for (std::size_t i = 0; i < 10; ++i) bounds[i * 300].center_m += Vec3(0.05, 0.02, 0.03);
    bounds[77].radius_m = 0.6 + 0.004 * frame;
    const auto found = find();
    anew += found.looked_at > 11 ? 1U : 0U;
    const auto before = [](const CandidatePair& a, const CandidatePair& b) {
      return std::pair(a.low, a.high) < std::pair(b.low, b.high);
    };
    ASSERT_TRUE(std::is_sorted(found.pairs.begin(), found.pairs.end(), before));
    for (std::uint32_t i = 0; i < bounds.size(); ++i) {
      // The resting ones have not changed among each other.
      if (i % 300 != 0 && i != 77) continue;
      for (std::uint32_t j = 0; j < bounds.size(); ++j) {
        if (i == j || !meet(bounds[i], bounds[j])) continue;
        ASSERT_TRUE(std::binary_search(found.pairs.begin(), found.pairs.end(),
                                       CandidatePair{std::min(i, j), std::max(i, j)}, before))
            << frame;
      }
    }
  }
  EXPECT_EQ(anew, 0U);
}

TEST(CandidateCache, NothingIsLeftOfAStepWithSweptBodies) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  collision::BroadPhase broad_phase;
  CandidateCache cached;
  const std::vector<MotionBound> bounds = cloud(300);
  for (int frame = 0; frame < 3; ++frame) cached.find(broad_phase, bounds, {}, {}, {}, {256}, *executor);
  const std::vector<collision::SweptBound> swept = {{bounds.front(), Vec3(3, 0, 0)}};
  cached.find(broad_phase, std::span(bounds).subspan(1), {}, swept, {}, {256}, *executor);
  EXPECT_TRUE(cached.find(broad_phase, {}, {}, {}, {}, {256}, *executor).pairs.empty());
}

TEST(CandidateCache, AreFoundAnewWhenABodyComesOrChangesItsGroup) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  collision::BroadPhase broad_phase;
  CandidateCache cached;
  std::vector<MotionBound> bounds = cloud(300);
  const auto count = [&] { return cached.find(broad_phase, bounds, {}, {}, {}, {256}, *executor).pairs.size(); };
  for (int frame = 0; frame < 3; ++frame) count();
  const std::size_t all = count();
  for (MotionBound& bound : bounds) bound.collides_with = 0;
  EXPECT_EQ(count(), 0U);
  for (MotionBound& bound : bounds) bound.collides_with = 0xffffffffU;
  count();
  EXPECT_EQ(count(), all);
  bounds.pop_back();
  EXPECT_LT(count(), all);
}

}  // namespace
}  // namespace poise::simulation
