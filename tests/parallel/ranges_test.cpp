// SPDX-License-Identifier: MIT
#include "parallel/ranges.h"

#include <gtest/gtest.h>

#include <algorithm>
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

// So that a loop over them can stop in time, however many items there are.
TEST(Ranges, AreNeverMuchLongerThanLong) {
  for (const std::size_t n : {std::size_t{600000}, std::size_t{5000001}}) {
    const Ranges ranges(n, 1000);
    EXPECT_EQ(ranges.end(ranges.count - 1), n);
    for (std::size_t k = 0; k < ranges.count; ++k)
      ASSERT_LE(ranges.end(k) - ranges.begin(k), Ranges::kLong + Ranges::kLong / 4);
  }
}

TEST(Reserve, KeepsWhatThereIs) {
  const auto executor = make_executor(ExecutorKind::Threads, 3);
  UnsetVector<std::uint64_t> list;
  resize(*executor, list, 100000, std::uint64_t{7});
  for (std::size_t i = 0; i < list.size(); i += 3) list[i] = i;
  reserve(*executor, list, 1000000);
  EXPECT_GE(list.capacity(), 1000000U);
  ASSERT_EQ(list.size(), 100000U);
  for (std::size_t i = 0; i < list.size(); ++i) ASSERT_EQ(list[i], i % 3 == 0 ? i : 7U);
  const std::uint64_t* const at = list.data();
  reserve(*executor, list, 10);
  EXPECT_EQ(list.data(), at);
}

TEST(ReserveAnew, ForgetsWhatThereIsOnlyWhereItNeedsMemory) {
  UnsetVector<int> list(100, 3);
  reserve_anew(list, 50);
  EXPECT_EQ(list.size(), 100U);
  make_room_anew(list, 101);
  EXPECT_GE(list.capacity(), 200U);
  EXPECT_TRUE(list.empty());
}

TEST(Sort, IsThatOfTheStandardLibraryWhateverTheLength) {
  const auto executor = make_executor(ExecutorKind::Threads, 3);
  std::vector<std::uint32_t> scratch;
  for (const std::size_t n : {0U, 1U, 2U, 2047U, 2048U, 2049U, 6000U, 8192U, 100003U}) {
    for (const std::uint64_t factor : {std::uint64_t{1}, std::uint64_t{0x9e3779b1}}) {
      std::vector<std::uint32_t> list(n);
      // All different: the factor is odd.
      for (std::size_t i = 0; i < n; ++i) list[i] = static_cast<std::uint32_t>(i * factor);
      std::vector<std::uint32_t> expected = list;
      std::sort(expected.begin(), expected.end(), std::greater<>());
      sort(*executor, list, scratch, std::greater<>());
      ASSERT_EQ(list, expected) << n;
    }
  }
}

TEST(SerialFor, GoesThroughAllInOrder) {
  const auto executor = make_executor(ExecutorKind::Threads, 2);
  std::vector<std::size_t> begins;
  std::size_t past = 0;
  serial_for(*executor, 25, 10, [&](std::size_t begin, std::size_t end) {
    EXPECT_EQ(begin, past);
    begins.push_back(begin);
    past = end;
  });
  EXPECT_EQ(past, 25U);
  EXPECT_EQ(begins, (std::vector<std::size_t>{0, 10, 20}));
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
