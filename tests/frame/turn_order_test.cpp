// SPDX-License-Identifier: MIT
#include "frame/refine/turn_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <numeric>
#include <vector>

#include "parallel/executor.h"

namespace poise::simulation {
namespace {

std::vector<std::uint32_t> all_of(TurnOrder& order, std::uint32_t most) {
  std::vector<std::uint32_t> pairs;
  for (;;) {
    const TurnOrder::Block block = order.take(most, 1);
    if (block.begin == block.end) return pairs;
    EXPECT_LE(block.end - block.begin, most);
    for (std::uint32_t place = block.begin; place < block.end; ++place) pairs.push_back(order.pair_at(place));
  }
}

TEST(TurnOrder, BeginsWithTheBestBandAndKeepsTheOrderWithinIt) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  TurnOrder order;
  order.begin(6);
  order.put(0, 70, 3);
  order.put(1, 71, 255);
  order.put(2, 72, 3);
  order.put(4, 74, 1);  // nothing waits at 3
  order.put(5, 75, 255);
  order.make(*executor);
  EXPECT_EQ(order.next_turn(), 255U);
  TurnOrder::Block block = order.take(2, 2);
  EXPECT_EQ(block.end - block.begin, 1U) << "others have something left";
  EXPECT_EQ(order.turn_at(block.begin), 255U);
  EXPECT_EQ(order.pair_at(block.begin), 71U);
  block = order.take(2, 1);
  EXPECT_EQ(order.pair_at(block.begin), 75U);
  EXPECT_EQ(order.next_turn(), 3U);
  EXPECT_EQ(all_of(order, 2), (std::vector<std::uint32_t>{70, 72, 74}));
  EXPECT_EQ(order.next_turn(), 0U);
  // Made again, it has forgotten all of it.
  order.begin(3);
  order.make(*executor);
  EXPECT_EQ(order.next_turn(), 0U);
  EXPECT_TRUE(all_of(order, 1).empty());
}

TEST(TurnOrder, IsTakenInBlocksThatGetSmallTowardsItsEnd) {
  const auto executor = parallel::make_executor(ExecutorKind::Serial, 1);
  TurnOrder order;
  order.begin(100);
  for (std::uint32_t pair = 0; pair < 100; ++pair) order.put(pair, pair, 1);
  order.make(*executor);
  std::vector<std::uint32_t> lengths;
  for (TurnOrder::Block block = order.take(9, 2); block.begin < block.end; block = order.take(9, 2))
    lengths.push_back(block.end - block.begin);
  EXPECT_EQ(lengths.front(), 9U);
  EXPECT_EQ(lengths.back(), 1U);
  EXPECT_TRUE(std::is_sorted(lengths.rbegin(), lengths.rend()));
  EXPECT_EQ(std::accumulate(lengths.begin(), lengths.end(), 0U), 100U);
}

TEST(TurnOrder, IsTheSameOnAnyNumberOfThreadsWhichTakeEachPlaceOnce) {
  constexpr std::uint32_t kPairs = 20'000;
  std::vector<std::uint32_t> expected;
  const auto turn_of = [](std::uint32_t pair) { return static_cast<std::uint8_t>(pair * 2654435761U >> 24U); };
  for (std::uint32_t pair = 0; pair < kPairs; ++pair)
    if (turn_of(pair) != 0) expected.push_back(pair);
  std::stable_sort(expected.begin(), expected.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return turn_of(a) > turn_of(b); });
  for (const int threads : {1, 2, 5}) {
    const auto executor = parallel::make_executor(ExecutorKind::Threads, threads);
    TurnOrder order;
    order.begin(kPairs);
    parallel::parallel_for(*executor, kPairs, 100, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t pair = begin; pair < end; ++pair) {
        const auto item = static_cast<std::uint32_t>(pair);
        if (turn_of(item) != 0) order.put(pair, item, turn_of(item));
      }
    });
    order.make(*executor);
    std::vector<std::uint32_t> taken(expected.size(), kPairs);
    std::atomic<std::size_t> places{0};
    parallel::parallel_for(*executor, static_cast<std::size_t>(threads), 1, [&](std::size_t, std::size_t, int) {
      for (;;) {
        const TurnOrder::Block block = order.take(7, static_cast<std::size_t>(threads));
        if (block.begin == block.end) return;
        places += block.end - block.begin;
        for (std::uint32_t place = block.begin; place < block.end; ++place) taken[place] = order.pair_at(place);
      }
    });
    EXPECT_EQ(places.load(), expected.size());
    EXPECT_EQ(taken, expected) << threads;
  }
}

}  // namespace
}  // namespace poise::simulation
