// SPDX-License-Identifier: MIT
#include "collision/front/pair_refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "collision/shapes.h"

namespace poise::collision {
namespace {

constexpr std::uint32_t kRoom = 1U << 16U;

std::vector<FrontPool> make_pools(int workers, std::uint32_t room = kRoom) {
  std::vector<FrontPool> pools;
  for (int w = 0; w < workers; ++w) pools.emplace_back(room);
  return pools;
}

SinglePair start(const PairFrame& frame) {
  SinglePair pair;
  pair.deepest = deepest_level(*frame.a, *frame.b, kMaxTreeDepth);
  return pair;
}

// Refines one level, `units` expansions at a time, on the given worker.
bool refine_once(const PairFrame& frame, std::span<FrontPool> pools, int worker, std::uint32_t units,
                 SinglePair& pair) {
  LevelProgress progress = begin_level(pair, pools[static_cast<std::size_t>(worker)]);
  for (;;) {
    const Quantum quantum = run_quantum(frame, pools, worker, units, progress);
    if (quantum == Quantum::Full) return false;
    if (quantum == Quantum::Complete) break;
  }
  publish_level(frame, Mat3::Identity(), progress, pair, pair);
  if (pair.points_due) make_points(frame, pools, pair, pair);
  return true;
}

double least_leaf_gap(const PairFrame& frame) {
  double least = 1e300;
  for (const NodeIndex a : frame.a->tree.nodes_at(frame.a->tree.depth())) {
    for (const NodeIndex b : frame.b->tree.nodes_at(frame.b->tree.depth())) {
      least = std::min(least, sphere_contact(frame, {a, b}).gap_m);
    }
  }
  return least;
}

TEST(PairRefinement, NeverLosesATouchAndKnowsItsDepthAtTheLeaves) {
  std::mt19937_64 random(11);
  const ShapePtr shapes[] = {make_jack(), make_worm(60), make_sphere_shape(0.4).value()};
  int touching = 0;
  int apart = 0;
  for (int round = 0; round < 600; ++round) {
    const Shape& a = *shapes[random() % 3];
    const Shape& b = *shapes[random() % 3];
    const PairFrame frame = make_pair_frame(a, random_pose(random, 0.8), b, random_pose(random, 0.8), 0.02, 0.001);
    const double exact = least_leaf_gap(frame);
    auto pools = make_pools(1);
    SinglePair pair = start(frame);
    while (pair.refinable()) {
      ASSERT_TRUE(refine_once(frame, pools, 0, 512, pair));
      if (exact < frame.margin_m) {
        ASSERT_FALSE(pair.apart) << "a touch was lost at level " << int{pair.level};
      }
    }
    if (pair.deepest == 0) continue;
    if (exact < frame.margin_m) {
      EXPECT_DOUBLE_EQ(pair.contact.spheres_m, exact);
      ++touching;
    } else {
      EXPECT_TRUE(pair.apart);
      ++apart;
    }
  }
  EXPECT_GT(touching, 50);
  EXPECT_GT(apart, 50);
}

// With fitted spheres a level is searched no farther than what the one before has found lets expect. Where spheres are
// the object, the gap of two cores is exact at the leaves.
TEST(PairRefinement, ANarrowedSearchLosesNothingThatIsNearTheNearestSurfaces) {
  constexpr double kMargin = 0.4;
  constexpr double kSkin = 0.001;
  constexpr double kReach = 10 * kSkin;
  std::mt19937_64 random(13);
  const ShapePtr worm = make_worm(200);
  std::size_t left_out = 0;
  int touching = 0;
  for (int round = 0; round < 60; ++round) {
    PairFrame frame = make_pair_frame(*worm, random_pose(random, 0.6), *worm, random_pose(random, 0.6), kMargin, kSkin);
    const PairFrame whole = frame;
    frame.fitted = true;
    const double exact = least_leaf_gap(frame);
    if (exact >= kMargin) continue;
    ++touching;
    auto pools = make_pools(1);
    SinglePair pair = start(frame);
    double searched = kMargin;
    while (pair.refinable()) {
      set_expected_fit(0, 0, pair.level > 0 ? pair.contact.estimated_separation_m : 0.0, frame);
      ASSERT_TRUE(refine_once(frame, pools, 0, 512, pair));
      ASSERT_FALSE(pair.apart);
      EXPECT_LE(pair.reach_m, searched);
      EXPECT_GE(pair.reach_m, std::min(kMargin, std::max(0.0, exact) + kReach) - 1e-6);
      searched = pair.reach_m;
      PairFrame next = make_pair_frame(*frame.a, {}, *frame.b, {frame.offset_m, frame.rotation}, searched, kSkin);
      next.fitted = true;
      next.fast = frame.fast;
      frame = next;
    }
    EXPECT_NEAR(pair.contact.certain_separation_m, exact, 1e-5);
    EXPECT_NEAR(pair.reach_m, std::min(kMargin, std::max(0.0, exact) + kReach), 1e-5);
    std::set<std::pair<NodeIndex, NodeIndex>> front;
    for_each_segment(pools, pair.front, [&](auto entries) {
      for (const FrontEntry entry : entries) front.insert({entry.a, entry.b});
    });
    for (const NodeIndex a : worm->tree.nodes_at(worm->tree.depth())) {
      for (const NodeIndex b : worm->tree.nodes_at(worm->tree.depth())) {
        const double gap = sphere_contact(whole, {a, b}).gap_m;
        if (gap < pair.reach_m - 1e-6) {
          EXPECT_TRUE(front.contains({a, b})) << gap << " of " << pair.reach_m;
        }
        if (gap < kMargin && !front.contains({a, b})) ++left_out;
      }
    }
  }
  EXPECT_GT(touching, 20);
  EXPECT_GT(left_out, 10000U);
}

TEST(PairRefinement, PiecesOfAnySizeOnAnyWorkersGiveTheSameBits) {
  std::mt19937_64 random(12);
  const ShapePtr worm = make_worm(200);
  for (int round = 0; round < 50; ++round) {
    const PairFrame frame =
        make_pair_frame(*worm, random_pose(random, 0.3), *worm, random_pose(random, 0.3), 0.05, 0.001);
    auto whole_pools = make_pools(1);
    auto split_pools = make_pools(3);
    SinglePair whole = start(frame);
    SinglePair split = start(frame);
    while (whole.refinable()) {
      ASSERT_TRUE(refine_once(frame, whole_pools, 0, 1U << 30U, whole));
      ASSERT_TRUE(refine_once(frame, split_pools, static_cast<int>(random() % 3), 3, split));
      ASSERT_EQ(whole.apart, split.apart);
      ASSERT_EQ(whole.front_entries, split.front_entries);
      EXPECT_EQ(whole.contact.direction, split.contact.direction);
      EXPECT_EQ(whole.contact.moment_a_m, split.contact.moment_a_m);
      EXPECT_EQ(whole.contact.estimated_separation_m, split.contact.estimated_separation_m);
      std::vector<NodeIndex> fronts[2];
      for_each_segment(whole_pools, whole.front, [&](auto entries) {
        for (auto e : entries) fronts[0].push_back(e.a * 1000 + e.b);
      });
      for_each_segment(split_pools, split.front, [&](auto entries) {
        for (auto e : entries) fronts[1].push_back(e.a * 1000 + e.b);
      });
      if (!whole.apart) {
        EXPECT_EQ(fronts[0], fronts[1]);
      }
    }
  }
}

TEST(PairRefinement, AFullPoolRefusesTheLevelWhole) {
  const ShapePtr jack = make_jack();
  const PairFrame frame = make_pair_frame(*jack, Pose{}, *jack, Pose{Vec3(0.1, 0, 0), Mat3::Identity()}, 0.01, 0.001);
  auto pools = make_pools(1, 64);
  SinglePair pair = start(frame);
  ASSERT_TRUE(refine_once(frame, pools, 0, 512, pair));
  const SinglePair before = pair;
  const FrontPool::Mark mark = pools[0].mark();
  EXPECT_FALSE(refine_once(frame, pools, 0, 512, pair));
  EXPECT_EQ(pair.level, before.level);
  EXPECT_EQ(pair.front_entries, before.front_entries);
  pools[0].release(mark);
  EXPECT_EQ(pools[0].mark().entries, mark.entries);
}

TEST(PairRefinement, DeepestLevelIsThatOfTheDeeperTreeWithinTheLimit) {
  const ShapePtr ball = make_sphere_shape(1).value();
  const ShapePtr jack = make_jack();
  const ShapePtr floor = make_plane_shape(Vec3::UnitZ(), 0).value();
  EXPECT_EQ(deepest_level(*ball, *ball, 6), 0);
  EXPECT_EQ(deepest_level(*ball, *jack, 6), jack->tree.depth());
  EXPECT_EQ(deepest_level(*jack, *floor, 6), jack->tree.depth());
  EXPECT_EQ(deepest_level(*jack, *jack, 1), 1);
}

}  // namespace
}  // namespace poise::collision
