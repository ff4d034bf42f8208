// SPDX-License-Identifier: MIT
#include "poise/scheduler/rounds.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

namespace poise::scheduler {
namespace {

TEST(Rounds, ServeTheBestFirstAndTiesByPair) {
  RoundSelector rounds;
  rounds.begin_frame(100, 4);
  rounds.add({1.0, 7, 1});
  rounds.add({2.0, 9, 1});
  rounds.add({2.0, 3, 1});
  const auto round = rounds.next_round();
  ASSERT_EQ(round.size(), 3U);
  EXPECT_EQ(round[0].pair, 3U);
  EXPECT_EQ(round[1].pair, 9U);
  EXPECT_EQ(round[2].pair, 7U);
  EXPECT_TRUE(rounds.next_round().empty());
}

TEST(Rounds, ChargeWhatTheyAdmitAndLetSmallerOnesPass) {
  RoundSelector rounds;
  rounds.begin_frame(10, 3);
  rounds.add({3.0, 1, 6});
  rounds.add({2.0, 2, 6});
  rounds.add({1.0, 3, 4});
  const auto first = rounds.next_round();
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].pair, 1U);
  const auto second = rounds.next_round();
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].pair, 3U);
  EXPECT_EQ(rounds.charged_units(), 10U);
}

TEST(Rounds, LeaveHalfOfWhatIsLeftToWhatTheyMakePossible) {
  RoundSelector rounds;
  rounds.begin_frame(16, 32);
  for (std::uint32_t pair = 0; pair < 32; ++pair) rounds.add({1.0, pair, 1});
  EXPECT_EQ(rounds.next_round().size(), 8U);
  rounds.add({2.0, 32, 4});
  const auto round = rounds.next_round();
  ASSERT_EQ(round.size(), 1U) << "a deeper level of a pair of the first round";
  EXPECT_EQ(round[0].pair, 32U);
  std::size_t admitted = 0;
  for (auto next = rounds.next_round(); !next.empty(); next = rounds.next_round()) admitted += next.size();
  EXPECT_EQ(admitted, 4U) << "nothing of the budget is left over";
}

TEST(Rounds, AFrameForgetsTheOneBefore) {
  RoundSelector rounds;
  rounds.begin_frame(1, 1);
  rounds.add({1.0, 1, 5});
  rounds.begin_frame(10, 1);
  EXPECT_TRUE(rounds.next_round().empty());
  EXPECT_EQ(rounds.charged_units(), 0U);
}

TEST(Rounds, AreAsLargeAsAsked) {
  RoundSelector rounds;
  rounds.begin_frame(100, 5, 2);
  for (std::uint32_t pair = 0; pair < 5; ++pair) rounds.add({1.0, pair, 1});
  EXPECT_EQ(rounds.next_round().size(), 2U);
  EXPECT_EQ(rounds.next_round().size(), 2U);
  EXPECT_EQ(rounds.next_round().size(), 1U);
  EXPECT_TRUE(rounds.next_round().empty());
}

RC_GTEST_PROP(Rounds, NeverChargeMoreThanTheBudgetAndDoNotDependOnTheOrderOfAdding, ()) {
  const auto budget = *rc::gen::inRange<std::uint64_t>(0, 3000);
  const auto scores =
      *rc::gen::container<std::vector<int>>(*rc::gen::inRange<std::size_t>(0, 1500), rc::gen::inRange(0, 20));
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    candidates.push_back(
        {static_cast<double>(scores[i]), static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(1 + (i * 7) % 13)});
  }
  const auto served = [&](const std::vector<Candidate>& order) {
    RoundSelector rounds;
    rounds.begin_frame(budget, order.size());
    for (const Candidate& candidate : order) rounds.add(candidate);
    std::vector<std::uint32_t> pairs;
    std::uint64_t charged = 0;
    for (auto round = rounds.next_round(); !round.empty(); round = rounds.next_round()) {
      RC_ASSERT(round.size() <= RoundSelector::kDefaultRoundPairs);
      for (const Candidate& candidate : round) {
        pairs.push_back(candidate.pair);
        charged += candidate.units;
      }
    }
    RC_ASSERT(charged == rounds.charged_units());
    RC_ASSERT(charged <= budget);
    return pairs;
  };
  std::vector<Candidate> reversed(candidates.rbegin(), candidates.rend());
  RC_ASSERT(served(candidates) == served(reversed));
}

}  // namespace
}  // namespace poise::scheduler
