// SPDX-License-Identifier: MIT
#include "frame/refine/found_contacts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <span>
#include <vector>

namespace poise::simulation {
namespace {

constexpr double kReachM = 0.5;

PairProgress refined(bool apart) {
  PairProgress pair;
  pair.level.level = 1;
  pair.level.apart = apart;
  return pair;
}

// What a level of a worker does with a pair.
void find(FoundContacts& found, PairProgress& pair, int worker, double reach_m, double gap_m, std::size_t points = 0) {
  collision::LevelContact& made = found.at_work(pair, worker);
  made.reach_m = reach_m;
  made.contact.estimated_separation_m = gap_m;
  made.manifold_points.count = points;
  for (std::size_t k = 0; k < points; ++k) made.manifold_points.point[k].gap_m = gap_m + static_cast<double>(k);
  found.keep(pair, made, kReachM, worker);
}

// Its points as find() leaves them.
void expect_points(const FoundContacts& found, const PairProgress& pair, double gap_m, std::size_t points) {
  const std::span<const collision::ManifoldPoint> kept = found.points_of(found.of(pair));
  ASSERT_EQ(kept.size(), points);
  for (std::size_t k = 0; k < points; ++k) EXPECT_EQ(kept[k].gap_m, gap_m + static_cast<double>(k));
}

TEST(FoundContacts, EachPairWithAContactHasAnEntryOfItsOwnWhicheverWorkerFoundIt) {
  constexpr std::size_t kPairs = 100;
  FoundContacts found;
  for (int frame = 0; frame < 2; ++frame) {
    found.begin(kPairs, 3);
    std::vector<PairProgress> pairs(kPairs, refined(false));
    for (std::size_t i = 0; i < kPairs; ++i)
      find(found, pairs[i], static_cast<int>(i * i % 3), kReachM, static_cast<double>(i));
    std::set<std::uint32_t> entries;
    for (std::size_t i = 0; i < kPairs; ++i) {
      entries.insert(pairs[i].found);
      EXPECT_EQ(found.of(pairs[i]).contact.estimated_separation_m, static_cast<double>(i));
    }
    EXPECT_EQ(entries.size(), kPairs);
    EXPECT_FALSE(entries.contains(0));
  }
}

TEST(FoundContacts, ADeeperLevelOfAnotherWorkerWritesIntoTheEntryOfThePair) {
  FoundContacts found;
  found.begin(4, 2);
  PairProgress pair = refined(false);
  find(found, pair, 0, kReachM, 1);
  const std::uint32_t entry = pair.found;
  pair.level.level = 2;
  find(found, pair, 1, kReachM, 2);
  EXPECT_EQ(pair.found, entry);
  EXPECT_EQ(found.of(pair).contact.estimated_separation_m, 2);
}

TEST(FoundContacts, PointsOfEachPairStayItsOwnHoweverManyALaterLevelFinds) {
  constexpr std::size_t kPairs = 200;
  FoundContacts found;
  for (int frame = 0; frame < 2; ++frame) {
    found.begin(kPairs, 3);
    std::vector<PairProgress> pairs(kPairs, refined(false));
    // First none to three, then one to four: some fit where they are, others need another place.
    for (const std::size_t more : {0U, 1U, 0U}) {
      for (std::size_t i = 0; i < kPairs; ++i)
        find(found, pairs[i], static_cast<int>((i + more) % 3), kReachM, static_cast<double>(i * 10 + more),
             (i / 7) % 4 + more);
      for (std::size_t i = 0; i < kPairs; ++i)
        expect_points(found, pairs[i], static_cast<double>(i * 10 + more), (i / 7) % 4 + more);
    }
  }
}

TEST(FoundContacts, PointsThatWereDueAreKeptWhenTheyAreMade) {
  FoundContacts found;
  found.begin(4, 2);
  PairProgress pair = refined(false);
  collision::LevelContact& made = found.at_work(pair, 0);
  made.points_due = true;
  made.manifold_points.count = 0;
  found.keep(pair, made, kReachM, 0);
  EXPECT_TRUE(found.of(pair).points_due);
  EXPECT_TRUE(found.points_of(found.of(pair)).empty());
  collision::ManifoldPoints points;
  points.count = 2;
  points.point[1].gap_m = 7;
  found.keep_points(pair, points, 1);
  EXPECT_FALSE(found.of(pair).points_due);
  ASSERT_EQ(found.points_of(found.of(pair)).size(), 2U);
  EXPECT_EQ(found.points_of(found.of(pair))[1].gap_m, 7);
}

TEST(FoundContacts, OfAPairThatIsSeparatedAsFarAsItsReachNothingIsKept) {
  FoundContacts found;
  found.begin(4, 1);
  PairProgress apart = refined(true);
  find(found, apart, 0, kReachM, 1);
  EXPECT_EQ(apart.found, 0U);
  EXPECT_EQ(found.of(apart).reach_m, std::numeric_limits<double>::max());
  PairProgress narrowed = refined(true);
  find(found, narrowed, 0, 0.5 * kReachM, 1);
  EXPECT_EQ(found.of(narrowed).reach_m, 0.5 * kReachM);
}

TEST(FoundContacts, ALevelThatDoesNotCompleteKeepsNothing) {
  FoundContacts found;
  found.begin(4, 1);
  PairProgress pair;
  find(found, pair, 0, kReachM, 1);
  EXPECT_EQ(pair.found, 0U);
}

TEST(FoundContacts, MemoryOfPointsServesOthersUntilTheNextFrame) {
  constexpr std::size_t kPairs = 50;
  FoundContacts found;
  for (int frame = 0; frame < 3; ++frame) {
    found.begin(kPairs, 1);
    std::vector<PairProgress> pairs(kPairs, refined(false));
    for (std::size_t i = 0; i < kPairs; ++i) find(found, pairs[i], 0, kReachM, static_cast<double>(i), 1 + i % 8);
    for (std::size_t i = 0; i < kPairs; ++i) expect_points(found, pairs[i], static_cast<double>(i), 1 + i % 8);
    // More of them in each frame than there were points.
    solver::LaneMemory& memory = found.reuse_points();
    const std::span<double> others = memory.use_anew<double>(kPairs * 1000 * static_cast<std::size_t>(1 + frame));
    std::fill(others.begin(), others.end(), -1.0);
    for (std::size_t i = 0; i < kPairs; ++i)
      EXPECT_EQ(found.of(pairs[i]).contact.estimated_separation_m, static_cast<double>(i)) << "contacts stay";
  }
}

}  // namespace
}  // namespace poise::simulation
