// SPDX-License-Identifier: MIT
#include "collision/front/overlap_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "collision/instruction_sets.h"
#include "collision/shapes.h"

namespace poise::collision {
namespace {

using Pairs = std::set<std::pair<NodeIndex, NodeIndex>>;

// All overlapping nodes of two trees at a level, in double precision and without traversing a tree.
Pairs brute_force(const PairFrame& frame, Level level, double inflation_m) {
  Pairs pairs;
  for (const NodeIndex a : frame.a->tree.nodes_at(level)) {
    for (const NodeIndex b : frame.b->tree.nodes_at(level)) {
      const Sphere sa = frame.a->tree.sphere(a);
      const Sphere sb = frame.b->tree.sphere(b);
      const double distance = (frame.rotation * sb.center_m + frame.offset_m - sa.center_m).norm();
      if (distance < sa.radius_m + sb.radius_m + inflation_m) pairs.insert({a, b});
    }
  }
  return pairs;
}

TEST(OverlapKernel, FindsEveryOverlapOfTheChildrenAndLittleElse) {
  std::mt19937_64 random(1);
  const ShapePtr jack = make_jack();
  int overlaps = 0;
  for (int round = 0; round < 500; ++round) {
    const PairFrame frame =
        make_pair_frame(*jack, random_pose(random, 0.5), *jack, random_pose(random, 0.5), 0.01, 0.001);
    const FrontEntry roots[] = {{0, 0}};
    FrontEntry out[64];
    const Expansion made = expand(frame, roots, out);
    ASSERT_EQ(made.consumed, 1U);
    Pairs found;
    for (const FrontEntry entry : std::span(out, made.hits)) found.insert({entry.a, entry.b});
    ASSERT_EQ(found.size(), made.hits) << "a pair was listed twice";
    const Pairs needed = brute_force(frame, 1, frame.margin_m);
    const Pairs allowed = brute_force(frame, 1, 2.0 * static_cast<double>(frame.nearness.inflation_m) - frame.margin_m);
    EXPECT_TRUE(std::includes(found.begin(), found.end(), needed.begin(), needed.end()));
    EXPECT_TRUE(std::includes(allowed.begin(), allowed.end(), found.begin(), found.end()));
    overlaps += static_cast<int>(made.hits);
  }
  EXPECT_GT(overlaps, 1000);
}

TEST(OverlapKernel, RoundingFarFromTheOriginLosesNoOverlap) {
  // Two balls that touch exactly, ten thousand kilometres away, where single precision in the world would be wrong by a
  // metre.
  const ShapePtr ball = make_sphere_shape(0.5).value();
  std::mt19937_64 random(5);
  for (int round = 0; round < 1000; ++round) {
    const Vec3 far = Vec3(1e7, -1e7, 1e7) + random_vector(random, 100);
    const Pose a{far, random_pose(random, 0).rotation};
    const Pose b{far + random_vector(random, 1).normalized() * 0.99999, random_pose(random, 0).rotation};
    const FrontEntry roots[] = {{0, 0}};
    FrontEntry out[64];
    EXPECT_EQ(expand(make_pair_frame(*ball, a, *ball, b, 0, 0), roots, out).hits, 1U);
  }
}

// Calls visit(front) for the front of each level of two worms, from that of the roots to that of the leaves.
template <class Visit>
void for_each_front(const PairFrame& frame, Visit&& visit) {
  std::vector<FrontEntry> front = {{0, 0}};
  visit(front);
  for (Level level = 1; level <= frame.a->tree.depth(); ++level) {
    std::vector<FrontEntry> next(64 * front.size());
    next.resize(expand(frame, front, next).hits);
    front = next;
    visit(front);
  }
}

PairFrame random_frame(std::mt19937_64& random, const Shape& worm, double margin_m) {
  return make_pair_frame(worm, random_pose(random, 0.5), worm, random_pose(random, 0.5), margin_m, 0.001);
}

TEST(OverlapKernel, EveryInstructionSetGivesTheSameFrontInTheOrderOfItsEntries) {
  const ShapePtr worm = make_worm(300);
  using Fronts = std::vector<std::pair<NodeIndex, NodeIndex>>;
  const auto all_fronts = [&] {
    std::mt19937_64 random(6);
    Fronts all;
    for (int round = 0; round < 100; ++round) {
      const PairFrame frame = random_frame(random, *worm, 0.01);
      for_each_front(frame, [&](std::span<const FrontEntry> front) {
        std::vector<FrontEntry> next(64 * front.size());
        next.resize(expand(frame, front, next).hits);
        // Entry by entry the same lists must result, one after the other.
        std::vector<FrontEntry> one_by_one;
        for (const FrontEntry& entry : front) {
          FrontEntry out[64];
          const Expansion made = expand(frame, std::span(&entry, 1), out);
          one_by_one.insert(one_by_one.end(), out, out + made.hits);
        }
        const auto same = [](const FrontEntry& x, const FrontEntry& y) { return x.a == y.a && x.b == y.b; };
        EXPECT_TRUE(std::equal(next.begin(), next.end(), one_by_one.begin(), one_by_one.end(), same));
        for (const FrontEntry& entry : front) all.emplace_back(entry.a, entry.b);
      });
    }
    return all;
  };
  const Fronts expected = all_fronts();
  EXPECT_GT(expected.size(), 1000U);
  on_every_instruction_set([&] { EXPECT_EQ(all_fronts(), expected); });
}

double squared_beyond(const PairFrame& frame, FrontEntry entry) {
  const Sphere a = frame.a->tree.sphere(entry.a);
  const Sphere b = frame.b->tree.sphere(entry.b);
  const double both = a.radius_m + b.radius_m;
  return (frame.rotation * b.center_m + frame.offset_m - a.center_m).squaredNorm() - both * both;
}

TEST(OverlapKernel, ListsTheNearestChildrenOfEachEntryThatHasAny) {
  std::mt19937_64 random(7);
  const ShapePtr worm = make_worm(300);
  int several = 0;
  int none = 0;
  for (int round = 0; round < 100; ++round) {
    const PairFrame frame = random_frame(random, *worm, 0.01);
    for_each_front(frame, [&](std::span<const FrontEntry> front) {
      std::vector<FrontEntry> next(64 * front.size());
      std::vector<FrontEntry> close(64 * front.size());
      std::vector<FrontEntry> nearest(front.size());
      const Expansion all = expand(frame, frame.nearness, front, {next, close, nearest});
      std::size_t listed = 0;
      for (const FrontEntry& entry : front) {
        FrontEntry out[64];
        const Expansion made = expand(frame, std::span(&entry, 1), out);
        if (made.hits == 0) {
          ++none;
          continue;
        }
        if (made.hits > 1) ++several;
        ASSERT_LT(listed, all.nearest);
        double least = 1e300;
        bool among = false;
        const FrontEntry& found = nearest[listed++];
        for (const FrontEntry& child : std::span(out, made.hits)) {
          least = std::min(least, squared_beyond(frame, child));
          among = among || (child.a == found.a && child.b == found.b);
        }
        EXPECT_TRUE(among);
        EXPECT_NEAR(squared_beyond(frame, found), least, 1e-6);
      }
      EXPECT_EQ(listed, all.nearest);
    });
  }
  EXPECT_GT(several, 300);
  EXPECT_GT(none, 10);
}

TEST(OverlapKernel, ANarrowedFrontHoldsTheEntriesThatOverlapThemselves) {
  std::mt19937_64 random(8);
  const ShapePtr worm = make_worm(300);
  int kept = 0;
  int gone = 0;
  for (int round = 0; round < 100; ++round) {
    const PairFrame frame = random_frame(random, *worm, 0.2);
    std::vector<FrontEntry> front;
    for_each_front(frame,
                   [&](std::span<const FrontEntry> of_level) { front.assign(of_level.begin(), of_level.end()); });
    const float inflation = frame.nearness.inflation_m - 0.15F;
    std::vector<FrontEntry> narrowed(front.size());
    narrowed.resize(narrow_front(frame.trees(), inflation, front, narrowed));
    std::size_t at = 0;
    for (const FrontEntry& entry : front) {
      const Sphere a = worm->tree.sphere(entry.a);
      const Sphere b = worm->tree.sphere(entry.b);
      const double beyond = (frame.rotation * b.center_m + frame.offset_m - a.center_m).norm() - a.radius_m -
                            b.radius_m - static_cast<double>(inflation);
      const bool is_kept = at < narrowed.size() && narrowed[at].a == entry.a && narrowed[at].b == entry.b;
      if (is_kept) ++at;
      ++(is_kept ? kept : gone);
      if (std::abs(beyond) > 1e-5) {
        EXPECT_EQ(is_kept, beyond < 0);
      }
    }
    EXPECT_EQ(at, narrowed.size()) << "in the order of the front";
  }
  EXPECT_GT(kept, 1000);
  EXPECT_GT(gone, 1000);
}

TEST(OverlapKernel, EveryInstructionSetListsAndNarrowsAlike) {
  const ShapePtr worm = make_worm(300);
  const auto all_lists = [&] {
    std::mt19937_64 random(9);
    std::vector<NodeIndex> all;
    for (int round = 0; round < 50; ++round) {
      PairFrame frame = make_pair_frame(*worm, random_pose(random, 0.5), *worm, random_pose(random, 0.5), 0.1, 0.001);
      frame.closeness_m = frame.nearness.inflation_m - 0.05F;
      std::vector<FrontEntry> front = {{0, 0}};
      for (Level level = 1; level <= worm->tree.depth(); ++level) {
        std::vector<FrontEntry> lists[3] = {std::vector<FrontEntry>(64 * front.size()),
                                            std::vector<FrontEntry>(64 * front.size()),
                                            std::vector<FrontEntry>(front.size())};
        const Expansion made = expand(frame, frame.nearness, front, {lists[0], lists[1], lists[2]});
        // What is only counted is as much, the other lists are the same, and nothing is written.
        std::vector<FrontEntry> unlisted = {{77, 78}};
        std::vector<FrontEntry> others[2] = {lists[1], lists[2]};
        const Expansion counted = expand(frame, frame.nearness, front, {unlisted, others[0], others[1], true});
        EXPECT_EQ(counted.hits, made.hits);
        EXPECT_EQ(counted.consumed, made.consumed);
        EXPECT_EQ(counted.close, made.close);
        EXPECT_EQ(counted.nearest, made.nearest);
        EXPECT_TRUE(unlisted[0].a == 77 && unlisted[0].b == 78);
        const auto same = [](const FrontEntry& x, const FrontEntry& y) { return x.a == y.a && x.b == y.b; };
        EXPECT_TRUE(std::equal(others[0].begin(), others[0].begin() + counted.close, lists[1].begin(), same));
        EXPECT_TRUE(std::equal(others[1].begin(), others[1].begin() + counted.nearest, lists[2].begin(), same));
        lists[0].resize(made.hits);
        lists[1].resize(made.close);
        lists[2].resize(made.nearest);
        std::vector<FrontEntry> narrowed(made.hits);
        narrowed.resize(narrow_front(frame.trees(), frame.closeness_m, lists[0], narrowed));
        for (const auto& list : {lists[0], lists[1], lists[2], narrowed}) {
          for (const FrontEntry& entry : list) all.insert(all.end(), {entry.a, entry.b});
        }
        front = lists[0];
      }
    }
    return all;
  };
  const std::vector<NodeIndex> expected = all_lists();
  EXPECT_GT(expected.size(), 10000U);
  on_every_instruction_set([&] { EXPECT_EQ(all_lists(), expected); });
}

TEST(OverlapKernel, APlaceBeyondTheRoomIsNeverWritten) {
  // All 64 pairs of children of two equal bodies at one point overlap, and lists are written in parts.
  const ShapePtr worm = make_worm(300);
  const Pose pose;
  const PairFrame frame = make_pair_frame(*worm, pose, *worm, pose, 10, 0);
  const std::vector<FrontEntry> front(2, FrontEntry{0, 0});
  std::vector<FrontEntry> out(129, FrontEntry{77, 78});
  const Expansion made = expand(frame, front, std::span(out).first(128));
  const std::uint32_t children = worm->tree.child_count[0];
  EXPECT_EQ(made.hits, 2 * children * children);
  EXPECT_EQ(made.consumed, 2U);
  EXPECT_EQ(out.back().a, 77U);
  EXPECT_EQ(out.back().b, 78U);
}

TEST(OverlapKernel, StopsWhereThereIsNoRoomForAWholeBlock) {
  const ShapePtr jack = make_jack();
  const Pose pose;
  const PairFrame frame = make_pair_frame(*jack, pose, *jack, pose, 0, 0);
  const std::vector<FrontEntry> roots(3, FrontEntry{0, 0});
  std::vector<FrontEntry> out(63);
  EXPECT_EQ(expand(frame, roots, out).consumed, 0U);
  out.resize(64);
  EXPECT_EQ(expand(frame, roots, out).consumed, 1U);
}

TEST(OverlapKernel, PlaneFrontsHoldExactlyTheNodesThatReachBelow) {
  std::mt19937_64 random(2);
  const ShapePtr worm = make_worm(100);
  const ShapePtr floor = make_plane_shape(Vec3(0.3, -0.2, 1), 0.1).value();
  for (int round = 0; round < 200; ++round) {
    const PairFrame frame = make_pair_frame(*worm, random_pose(random, 1.0), *floor, Pose{}, 0.02, 0.001);
    std::vector<FrontEntry> front = {{0, 0}};
    for (Level level = 1; level <= worm->tree.depth() && !front.empty(); ++level) {
      std::vector<FrontEntry> next(1024);
      next.resize(expand(frame, front, next).hits);
      std::set<NodeIndex> found;
      for (const FrontEntry entry : next) found.insert(entry.a);
      for (const NodeIndex node : worm->tree.nodes_at(level)) {
        const Sphere sphere = worm->tree.sphere(node);
        const double gap = frame.plane_normal.dot(sphere.center_m) - frame.plane_height_m - sphere.radius_m;
        // A node whose parent is above the plane may be skipped only if its content is above the plane too.
        if (gap < frame.margin_m && level == worm->tree.depth()) {
          EXPECT_TRUE(found.contains(node));
        }
        if (gap > 2 * static_cast<double>(frame.nearness.inflation_m)) {
          EXPECT_FALSE(found.contains(node));
        }
      }
      front = next;
    }
  }
}

// Nearly overlapping pairs that were skipped are reported, for trees and planes.
TEST(OverlapKernel, SaysWhetherItPassedOverWhatIsNearlyNear) {
  std::mt19937_64 random(3);
  const ShapePtr jack = make_jack();
  const ShapePtr floor = make_plane_shape(Vec3::UnitZ(), 0).value();
  constexpr float kWideM = 0.05F;
  int nearly = 0;
  int clear = 0;
  for (int round = 0; round < 400; ++round) {
    Pose high = random_pose(random, 0.3);
    high.position_m.z() += 1.0;
    PairFrame frame =
        round % 2 == 0 ? make_pair_frame(*jack, random_pose(random, 0.7), *jack, random_pose(random, 0.7), 0.01, 0.001)
                       : make_pair_frame(*jack, high, *floor, Pose{}, 0.01, 0.001);
    frame.nearness.wide_m = kWideM;
    const FrontEntry roots[] = {{0, 0}};
    FrontEntry out[64];
    const Expansion made = expand(frame, roots, out);
    PairFrame wider = frame;
    wider.nearness = {frame.nearness.inflation_m + kWideM, 0};
    EXPECT_EQ(made.nearly, expand(wider, roots, out).hits > made.hits);
    ++(made.nearly ? nearly : clear);
  }
  EXPECT_GT(nearly, 40);
  EXPECT_GT(clear, 40);
}

}  // namespace
}  // namespace poise::collision
