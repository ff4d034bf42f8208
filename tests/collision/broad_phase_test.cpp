// SPDX-License-Identifier: MIT
#include "collision/broad_phase/broad_phase.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "collision/brute_force.h"

namespace poise::collision {
namespace {

constexpr std::uint32_t kMany = 65536;

std::vector<CandidatePair> found(BroadPhase& broad, std::span<const MotionBound> bounds,
                                 std::span<const PlaneBound> planes, parallel::Executor& executor) {
  const auto result = broad.find(bounds, planes, {kMany}, executor);
  return {result.pairs.begin(), result.pairs.end()};
}

RC_GTEST_PROP(BroadPhase, FindsExactlyThePairsOfOverlappingBounds, ()) {
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  const auto n = *rc::gen::inRange<std::size_t>(0, 300);
  const double spread = *rc::gen::element(0.1, 2.0, 10.0, 1e4);
  const int octaves = *rc::gen::element(0, 1, 6, 12);
  const auto bounds = random_bounds(random, n, spread, octaves);
  const std::vector<PlaneBound> planes = {{Vec3(0.6, 0, 0.8), 0.2, 0, 1, 0xffffffffU}, {Vec3::UnitY(), -1.0, 2, 6, 3}};
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  BroadPhase broad;
  RC_ASSERT(found(broad, bounds, planes, *executor) == brute_force(bounds, planes));
  // Once more, with the buffers of the first call.
  RC_ASSERT(found(broad, bounds, planes, *executor) == brute_force(bounds, planes));
}

TEST(BroadPhase, FarFromTheOriginAndBeyondTheCellsPairsAreStillFound) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  BroadPhase broad;
  for (const double far : {1e7, 1e12}) {
    std::vector<MotionBound> bounds(3);
    for (std::uint32_t i = 0; i < 3; ++i) {
      bounds[i] = {Vec3(far, -far, far), 0.5, i, 1, 0xffffffffU, true};
    }
    bounds[2].center_m = -bounds[2].center_m;
    EXPECT_EQ(found(broad, bounds, {}, *executor), (std::vector<CandidatePair>{{0, 1}}));
  }
}

TEST(BroadPhase, AnyNumberOfThreadsGivesTheSamePairs) {
  std::mt19937_64 random(8);
  const auto bounds = random_bounds(random, 5000, 12, 4);
  const auto serial = parallel::make_executor(ExecutorKind::Serial, 1);
  BroadPhase broad;
  const auto expected = found(broad, bounds, {}, *serial);
  EXPECT_GT(expected.size(), 500U);
  for (const int threads : {2, 3, 8}) {
    const auto executor = parallel::make_executor(ExecutorKind::Threads, threads);
    EXPECT_EQ(found(broad, bounds, {}, *executor), expected);
  }
}

TEST(BroadPhase, OfManyBoundsExactlyTheOverlappingPairsAreFoundInOrder) {
  std::mt19937_64 random(5);
  const std::vector<MotionBound> bounds = random_bounds(random, 6000, 6, 2);
  const std::vector<PlaneBound> planes = {{Vec3::UnitZ(), -5, 0, 7, 7}};
  const std::vector<CandidatePair> expected = brute_force(bounds, planes);
  ASSERT_GT(expected.size(), bounds.size());
  const auto executor = parallel::make_executor(ExecutorKind::Threads, 3);
  BroadPhase broad;
  EXPECT_EQ(found(broad, bounds, planes, *executor), expected);
  EXPECT_EQ(found(broad, std::span(bounds).first(500), {}, *executor), brute_force(std::span(bounds).first(500), {}))
      << "after more";
}

TEST(BroadPhase, PartnersBeyondTheLimitAreCountedNotLostInSilence) {
  std::vector<MotionBound> bounds(40);
  for (std::uint32_t i = 0; i < 40; ++i) bounds[i] = {Vec3::Zero(), 1, i, 1, 0xffffffffU, true};
  const auto executor = parallel::make_executor(ExecutorKind::Threads, 3);
  BroadPhase broad;
  const auto result = broad.find(bounds, {}, {10}, *executor);
  EXPECT_EQ(result.pairs.size() + result.discarded, 40U * 39U / 2U);
  EXPECT_GT(result.discarded, 0U);
  std::vector<int> partners(40, 0);
  for (const CandidatePair& pair : result.pairs) {
    ++partners[pair.low];
    ++partners[pair.high];
  }
  for (const int count : partners) EXPECT_GE(count, 10);
}

TEST(BroadPhase, PairsBeyondTheLimitOfAllAreSharedEqually) {
  std::vector<MotionBound> bounds(40);
  for (std::uint32_t i = 0; i < 40; ++i) bounds[i] = {Vec3::Zero(), 1, i, 1, 0xffffffffU, true};
  const auto executor = parallel::make_executor(ExecutorKind::Threads, 3);
  BroadPhase broad;
  const std::size_t all = 40U * 39U / 2U;
  EXPECT_EQ(broad.find(bounds, {}, {256, all}, *executor).pairs.size(), all);
  const auto result = broad.find(bounds, {}, {256, all - 1}, *executor);
  EXPECT_EQ(result.pairs.size() + result.discarded, all);
  EXPECT_LE(result.pairs.size(), all - 1);
  EXPECT_GE(result.pairs.size(), all / 2);
  EXPECT_LE(broad.find(bounds, {}, {256, 1}, *executor).pairs.size(), 40U) << "one each, however few there may be";
}

TEST(BroadPhase, OfTooManyPartnersTheNearestAreKept) {
  // Balls in a row, of which only the first moves: each of the others is a little farther away than the one before.
  std::vector<MotionBound> bounds(40);
  for (std::uint32_t i = 0; i < 40; ++i) bounds[i] = {Vec3(0.02 * i, 0, 0), 1, i, 1, 0xffffffffU, i == 0};
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  BroadPhase broad;
  const auto result = broad.find(bounds, {}, {10}, *executor);
  std::vector<CandidatePair> nearest;
  for (std::uint32_t i = 1; i <= 10; ++i) nearest.push_back({0, i});
  EXPECT_EQ((std::vector<CandidatePair>{result.pairs.begin(), result.pairs.end()}), nearest);
  EXPECT_EQ(result.discarded, 29U);
}

TEST(BroadPhase, InACrowdEachLooksAtBoundedlyManyAndKeepsNeighbours) {
  // All bounds overlap all others: 8,000 within one cell.
  constexpr std::uint32_t kCrowd = 8000;
  constexpr std::uint32_t kMost = 8;
  std::mt19937_64 random(3);
  std::vector<MotionBound> bounds(kCrowd);
  for (std::uint32_t i = 0; i < kCrowd; ++i)
    bounds[i] = {Vec3(10.5, 10.5, 10.5) + random_vector(random, 0.2), 1, i, 1, 0xffffffffU, true};
  const auto executor = parallel::make_executor(ExecutorKind::Threads, 2);
  BroadPhase broad;
  const auto result = broad.find(bounds, {}, {kMost}, *executor);
  EXPECT_LE(result.pairs.size(), std::size_t{kCrowd} * kMost);
  EXPECT_GT(result.pairs.size(), std::size_t{kCrowd - 100} * kMost);
  EXPECT_EQ(result.pairs.size() + result.discarded, std::size_t{kCrowd} * (kCrowd - 1) / 2);
  double mean_m = 0;
  for (const CandidatePair& pair : result.pairs)
    mean_m += (bounds[pair.low].center_m - bounds[pair.high].center_m).norm();
  mean_m /= static_cast<double>(result.pairs.size());
  // The eight nearest of all 8,000 are 0.02 m away, eight that are chosen blindly 0.2 m.
  EXPECT_LT(mean_m, 0.05);
  // Bodies in the very same place are no harder.
  for (MotionBound& bound : bounds) bound.center_m = Vec3::Zero();
  EXPECT_LE(broad.find(bounds, {}, {kMost}, *executor).pairs.size(), std::size_t{kCrowd} * kMost);
}

// Those from a slot on may have more partners than others.
class CrowdsBeforeSlot final : public CrowdedBodies {
 public:
  explicit CrowdsBeforeSlot(std::uint32_t end) : end_(end) {}
  [[nodiscard]] std::uint32_t most_partners(std::uint32_t slot) const override { return slot < end_ ? kLeast : 1000; }

 private:
  std::uint32_t end_;
};

TEST(BroadPhase, OnlyBodiesInACrowdKeepFewerPartners) {
  // Three places, in each all bounds overlap: 600 solid bodies, 30, and 300 of which more may be in one place.
  std::mt19937_64 random(3);
  std::vector<MotionBound> bounds(930);
  for (std::uint32_t i = 0; i < 930; ++i) {
    const double x_m = i < 600 ? 0 : i < 630 ? 10 : 20;
    bounds[i] = {Vec3(x_m + 0.5, 0.5, 0.5) + random_vector(random, 0.2), 1, i, 1, 0xffffffffU, true};
  }
  const CrowdsBeforeSlot crowds(630);
  const auto executor = parallel::make_executor(ExecutorKind::Threads, 2);
  BroadPhase broad;
  for (const std::uint32_t of_crowded : {1U, 20U}) {
    const auto result =
        broad.find(bounds, {}, {.of_body = 1000, .crowds = &crowds, .of_crowded = of_crowded}, *executor);
    std::size_t of_place[3] = {};
    for (const CandidatePair& pair : result.pairs) ++of_place[pair.low < 600 ? 0 : pair.low < 630 ? 1 : 2];
    const std::size_t kept = std::max(of_crowded, CrowdedBodies::kLeast / 4);
    EXPECT_LE(of_place[0], 600 * kept + 32 * 32 / 2);
    EXPECT_GE(of_place[0], 560 * kept);
    EXPECT_EQ(of_place[1], 30U * 29 / 2) << "no crowd";
    EXPECT_EQ(of_place[2], 300U * 299 / 2) << "no crowd either for these bodies";
    EXPECT_EQ(result.pairs.size() + result.discarded, 600U * 599 / 2 + of_place[1] + of_place[2]);
    EXPECT_LE(result.looked_at, 600U * 256 + 30 * 30 + 300 * (256 + 300));
  }
}

TEST(BroadPhase, WhereManyLieInOnePlaceAndMeetNobodyThereIsNoCrowd) {
  std::vector<MotionBound> bounds(900);
  for (std::uint32_t i = 0; i < 900; ++i) bounds[i] = {Vec3(0.5, 0.5, 0.5), 1, i, 2, 0, true};
  bounds.front().group = bounds.back().group = bounds.front().collides_with = bounds.back().collides_with = 1;
  const CrowdsBeforeSlot crowds(900);
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  BroadPhase broad;
  const auto result = broad.find(bounds, {}, {.crowds = &crowds, .of_crowded = 1}, *executor);
  ASSERT_EQ(result.pairs.size(), 1U);
  EXPECT_EQ(result.pairs[0], (CandidatePair{0, 899}));
  EXPECT_EQ(result.discarded, 0U);
}

TEST(BroadPhase, OneBodyFarAwayPutsNoOthersTogether) {
  std::mt19937_64 random(5);
  auto bounds = random_bounds(random, 2000, 15, 0);
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  const std::size_t near = BroadPhase{}.find(bounds, {}, {kMany}, *executor).looked_at;
  for (const double far : {1e2, 1e4, 65536.0 * 2, 1e8}) {
    bounds.back().center_m = Vec3(far, -far, 2 * far);
    BroadPhase broad;
    EXPECT_EQ(found(broad, bounds, {}, *executor), brute_force(bounds, {}));
    EXPECT_LT(broad.find(bounds, {}, {kMany}, *executor).looked_at, near + near / 10) << far;
  }
}

}  // namespace
}  // namespace poise::collision
