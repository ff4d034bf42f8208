// SPDX-License-Identifier: MIT
#include "frame/refine/found_contacts.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
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
void find(FoundContacts& found, PairProgress& pair, int worker, double reach_m, double gap_m) {
  collision::LevelContact& entry = found.open(pair, worker);
  entry.reach_m = reach_m;
  entry.contact.estimated_separation_m = gap_m;
  found.keep(pair, kReachM, worker);
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

}  // namespace
}  // namespace poise::simulation
