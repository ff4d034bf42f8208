// SPDX-License-Identifier: MIT
#include "parallel/ranges.h"

#include <gtest/gtest.h>

#include <functional>
#include <numeric>
#include <span>
#include <vector>

#include "parallel/disjoint_sets.h"

namespace poise::parallel {
namespace {

TEST(Ranges, CoverAllItemsOnceAndAreNoMoreThanTheirBound) {
  for (const std::size_t n : {0U, 1U, 63U, 64U, 1000U, 100001U}) {
    const Ranges ranges(n, 10);
    EXPECT_LE(ranges.count, Ranges::kMost);
    EXPECT_EQ(ranges.begin(0), 0U);
    EXPECT_EQ(ranges.end(ranges.count - 1), n);
    for (std::size_t k = 0; k + 1 < ranges.count; ++k) EXPECT_GE(ranges.end(k) - ranges.begin(k), 10U);
  }
}

TEST(Select, WritesWhatIsKeptInOrder) {
  const auto executor = make_executor(ExecutorKind::Threads, 3);
  std::vector<std::size_t> counts;
  std::vector<std::size_t> kept;
  select(
      *executor, 10000, 16, counts, [](std::size_t i) { return i % 7 == 3; },
      [&](std::size_t count) { kept.assign(count, 0); },
      [&](std::size_t i, std::size_t position) { kept[position] = i; });
  ASSERT_EQ(kept.size(), 1429U);
  for (std::size_t k = 0; k < kept.size(); ++k) EXPECT_EQ(kept[k], 7 * k + 3);
}

TEST(Group, HasItemsOfEachInOrder) {
  const auto executor = make_executor(ExecutorKind::Threads, 3);
  std::vector<std::size_t> counts;
  std::vector<std::vector<std::size_t>> groups(5);
  // Of the second there are none.
  const auto group_of = [](std::size_t i) { return i % 11 < 4 ? std::size_t{0} : 2 + i % 3; };
  group(
      *executor, 10000, 16, groups.size(), counts, group_of,
      [&](std::span<const std::size_t> sizes) {
        ASSERT_EQ(sizes.size(), groups.size());
        for (std::size_t g = 0; g < groups.size(); ++g) groups[g].assign(sizes[g], 0);
      },
      [&](std::size_t i, std::size_t g, std::size_t position) { groups[g][position] = i; });
  std::vector<std::vector<std::size_t>> expected(groups.size());
  for (std::size_t i = 0; i < 10000; ++i) expected[group_of(i)].push_back(i);
  EXPECT_TRUE(expected[1].empty());
  EXPECT_EQ(groups, expected);
}

TEST(Merge, PutsTwoSortedListsInOrder) {
  const auto executor = make_executor(ExecutorKind::Threads, 3);
  std::vector<int> a;
  std::vector<int> b;
  for (int i = 0; i < 5000; ++i) (i % 3 == 0 || i > 4000 ? a : b).push_back(i);
  std::vector<int> merged(5000, -1);
  merge(*executor, 64, a, b, std::less<>(), [&](int item, std::size_t position) { merged[position] = item; });
  for (int i = 0; i < 5000; ++i) EXPECT_EQ(merged[static_cast<std::size_t>(i)], i);
  merged.assign(a.size(), -1);
  merge(*executor, 64, a, {}, std::less<>(), [&](int item, std::size_t position) { merged[position] = item; });
  EXPECT_EQ(merged, a);
}

TEST(Resize, SetsWhatItAddsAndKeepsTheRest) {
  const auto executor = make_executor(ExecutorKind::Threads, 2);
  UnsetVector<double> list;
  resize(*executor, list, 5);
  list[3] = 7;
  resize(*executor, list, 1000);
  EXPECT_EQ(list[3], 7);
  EXPECT_EQ(std::accumulate(list.begin(), list.end(), 0.0), 7);
  resize(*executor, list, 3);
  EXPECT_EQ(list.size(), 3U);
}

TEST(DisjointSets, HaveTheirLowestMemberAsRootOnAnyNumberOfThreads) {
  constexpr std::uint32_t kNumbers = 30000;
  const auto executor = make_executor(ExecutorKind::Threads, 4);
  std::vector<std::uint32_t> parent(kNumbers);
  std::iota(parent.begin(), parent.end(), 0U);
  DisjointSets sets(parent);
  // A chain of each residue, in an order that has long paths.
  parallel_for(*executor, kNumbers - 5, 64, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = end; i-- > begin;)
      sets.unite(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i + 5));
  });
  for (std::uint32_t i = 0; i < kNumbers; ++i) EXPECT_EQ(sets.root(i), i % 5);
}

}  // namespace
}  // namespace poise::parallel
