// SPDX-License-Identifier: MIT
#include "solver/coloring.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numeric>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "parallel/counting_executor.h"

namespace poise::solver {
namespace {

// The bodies of each edge, or their copies.
RowEnds ends_of(const Coloring& coloring, std::span<const Edge> edges, std::uint32_t edge) {
  return coloring.ends().empty() ? RowEnds{edges[edge].a, edges[edge].b} : coloring.ends()[edge];
}

// Every edge has a colour, and none of a colour pushes what another one pushes.
::testing::AssertionResult is_sound(const Coloring& coloring, std::span<const Edge> edges) {
  const std::set<std::uint32_t> seen(coloring.order().begin(), coloring.order().end());
  if (seen.size() != edges.size()) return ::testing::AssertionFailure() << "not all edges are there";
  if (coloring.begin(coloring.colors()) != edges.size()) return ::testing::AssertionFailure() << "some have no colour";
  for (std::uint32_t c = 0; c < coloring.colors(); ++c) {
    std::set<std::uint32_t> pushed;
    for (std::size_t k = coloring.begin(c); k < coloring.begin(c + 1); ++k) {
      const std::uint32_t i = coloring.order()[k];
      const RowEnds ends = ends_of(coloring, edges, i);
      const bool twice = (edges[i].dynamic_a && !pushed.insert(ends.a).second) ||
                         (edges[i].dynamic_b && !pushed.insert(ends.b).second);
      if (twice) return ::testing::AssertionFailure() << "edge " << i << " shares a body in colour " << c;
      if (coloring.places()[i] != k) return ::testing::AssertionFailure() << "edge " << i << " is not in its place";
    }
  }
  return ::testing::AssertionSuccess();
}

// Copies are of the bodies that are shared, at least two of each, numbered behind the bodies and all pushed.
::testing::AssertionResult copies_are_sound(const Coloring& coloring, std::span<const Edge> edges, std::size_t bodies) {
  std::vector<std::uint32_t> original(bodies + coloring.copies());
  std::iota(original.begin(), original.end(), 0U);
  std::set<std::uint32_t> unused, shared;
  for (const SharedBody& body : coloring.shared()) {
    if (body.copies < 2) return ::testing::AssertionFailure() << "one copy of body " << body.body;
    shared.insert(body.body);
    for (std::uint32_t copy = body.first; copy < body.first + body.copies; ++copy) {
      if (!unused.insert(copy).second) return ::testing::AssertionFailure() << "two bodies have copy " << copy;
      original[copy] = body.body;
    }
  }
  if (unused.size() != coloring.copies()) return ::testing::AssertionFailure() << "copies are counted wrongly";
  for (std::uint32_t i = 0; i < edges.size(); ++i) {
    const RowEnds ends = ends_of(coloring, edges, i);
    if (original[ends.a] != edges[i].a || original[ends.b] != edges[i].b)
      return ::testing::AssertionFailure() << "edge " << i << " pushes other bodies";
    for (const std::uint32_t end : {ends.a, ends.b}) {
      if (shared.contains(end)) return ::testing::AssertionFailure() << "edge " << i << " pushes what is shared";
      unused.erase(end);
    }
  }
  if (!unused.empty()) return ::testing::AssertionFailure() << "nothing pushes copy " << *unused.begin();
  return ::testing::AssertionSuccess();
}

RC_GTEST_PROP(Coloring, NoTwoRowsOfAColourShareABodyThatYields, ()) {
  const auto bodies = *rc::gen::inRange<std::uint32_t>(2, 60);
  const auto count = *rc::gen::inRange<std::size_t>(0, 400);
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < count; ++i) {
    Edge edge;
    edge.a = *rc::gen::inRange<std::uint32_t>(0, bodies);
    edge.b = (edge.a + *rc::gen::inRange<std::uint32_t>(1, bodies)) % bodies;
    edge.dynamic_b = edge.b % 5 != 0;
    edge.dynamic_a = edge.a % 5 != 0;
    edges.push_back(edge);
  }
  Coloring coloring;
  coloring.color(edges, bodies);
  const ::testing::AssertionResult sound = is_sound(coloring, edges);
  RC_ASSERT(sound);
  const ::testing::AssertionResult copies = copies_are_sound(coloring, edges, bodies);
  RC_ASSERT(copies);
}

constexpr std::uint32_t kFree = kColors - kGroundColors;

// A hub and what touches it.
std::vector<Edge> star(std::uint32_t neighbours) {
  std::vector<Edge> edges;
  for (std::uint32_t i = 1; i <= neighbours; ++i) edges.push_back({0, i, true, true});
  return edges;
}

TEST(Coloring, RowsBeyondTheFirstColoursHaveASecondSet) {
  const std::vector<Edge> edges = star(2 * kFree);
  Coloring coloring;
  coloring.color(edges, edges.size() + 1);
  EXPECT_TRUE(is_sound(coloring, edges));
  EXPECT_EQ(coloring.own_colors(), kFree);
  EXPECT_EQ(coloring.shared_begin(), kFree);
  EXPECT_EQ(coloring.colors(), 2 * kFree);
  EXPECT_TRUE(coloring.shared().empty());
  EXPECT_TRUE(coloring.ends().empty());
}

TEST(Coloring, AHubWithThousandsOfRowsIsSharedInCopies) {
  const std::vector<Edge> edges = star(5000);
  Coloring coloring;
  const auto threads = parallel::make_executor(ExecutorKind::Threads, 2);
  coloring.color(edges, edges.size() + 1, *threads);
  EXPECT_TRUE(is_sound(coloring, edges));
  EXPECT_TRUE(copies_are_sound(coloring, edges, edges.size() + 1));
  ASSERT_EQ(coloring.shared().size(), 1U);
  EXPECT_EQ(coloring.shared()[0].body, 0U);
  EXPECT_EQ(coloring.copies(), (5000 - kFree + kFree - 1) / kFree) << "as many as the second set needs";
  EXPECT_EQ(coloring.colors(), 2 * kFree);
  const std::vector<Edge> few = star(kFree);
  coloring.color(few, edges.size() + 1);
  EXPECT_TRUE(coloring.shared().empty());
  EXPECT_TRUE(coloring.ends().empty()) << "nothing is left of the last time";
}

TEST(Coloring, TwoHubsThatTouchAreBothShared) {
  std::vector<Edge> edges = star(300);
  for (std::uint32_t i = 0; i < 300; ++i) edges.push_back({i == 0 ? 0 : 1000 + i, 301, true, true});
  Coloring coloring;
  coloring.color(edges, 2000);
  EXPECT_TRUE(is_sound(coloring, edges));
  EXPECT_TRUE(copies_are_sound(coloring, edges, 2000));
  EXPECT_EQ(coloring.shared().size(), 2U);
}

TEST(Coloring, RowsOnTheGroundComeAfterAllOthers) {
  // A column whose ground is named first, and a body with more such rows than there are colours for them.
  std::vector<Edge> edges = {{0, 1, false, true}, {1, 2, true, true}, {2, 3, true, true}, {3, 0, true, false}};
  for (std::uint32_t i = 0; i < kGroundColors + 3; ++i) edges.push_back({0, 4, false, true});
  Coloring coloring;
  coloring.color(edges, 5);
  ASSERT_EQ(coloring.order().size(), edges.size());
  EXPECT_EQ(coloring.order()[0], 1U);
  EXPECT_EQ(coloring.order()[1], 2U);
  EXPECT_EQ(coloring.shared_begin(), edges.size() - 3);
  EXPECT_EQ(coloring.own_colors(), 2 + kGroundColors) << "those without rows are left out";
  EXPECT_EQ(coloring.colors(), 2 + kGroundColors + 3);
}

TEST(Coloring, FewRowsOfAColourStandByRankAlone) {
  constexpr std::uint32_t kRows = 64;
  std::vector<Edge> edges;
  for (std::uint32_t i = 0; i < kRows; ++i)
    edges.push_back({100 * i, 100 * i + 1, true, true, static_cast<std::uint8_t>(i % kRanks)});
  Coloring coloring;
  coloring.color(edges, 100 * kRows);
  ASSERT_EQ(coloring.colors(), 1U);
  for (std::uint32_t k = 0; k < kRows; ++k) {
    EXPECT_EQ(edges[coloring.order()[k]].rank, kRanks - 1 - k / (kRows / kRanks));
    EXPECT_EQ(coloring.places()[coloring.order()[k]], k);
  }
}

// Pairs of bodies that are `near` slots apart at most, or of any.
std::vector<Edge> many_edges(std::uint32_t bodies, std::size_t count, std::uint32_t near) {
  std::mt19937 random(7);
  std::vector<Edge> edges;
  while (edges.size() < count) {
    Edge edge;
    edge.a = static_cast<std::uint32_t>(random() % bodies);
    edge.b = static_cast<std::uint32_t>((edge.a + 1 + random() % near) % bodies);
    edge.dynamic_a = edge.a % 50 != 0;
    edge.dynamic_b = edge.b % 50 != 0;
    edge.rank = static_cast<std::uint8_t>(random() % kRanks);
    if (edge.dynamic_a || edge.dynamic_b) edges.push_back(edge);
  }
  return edges;
}

// How rows of one colour follow each other: by eighths of 8,192 slots, by rank, and in canonical order.
std::tuple<std::uint32_t, int, std::uint32_t> place_in_color(const Edge& edge, std::uint32_t index) {
  const std::uint32_t low = std::min(edge.dynamic_a ? edge.a : edge.b, edge.dynamic_b ? edge.b : edge.a);
  return {low / 1024, -edge.rank, index};
}

class ManyEdges : public testing::TestWithParam<std::uint32_t> {};

TEST_P(ManyEdges, HaveTheSameColoursOnAnyNumberOfThreads) {
  constexpr std::uint32_t kBodies = 5000;
  const std::vector<Edge> edges = many_edges(kBodies, 4 * Coloring::kTiledEdges, GetParam());
  Coloring alone;
  alone.color(edges, kBodies);
  EXPECT_EQ(alone.shared_begin(), edges.size());
  for (std::uint32_t c = 0; c < alone.colors(); ++c) {
    std::vector<bool> taken(kBodies);
    for (std::size_t k = alone.begin(c); k < alone.begin(c + 1); ++k) {
      const Edge& edge = edges[alone.order()[k]];
      if (edge.dynamic_a) {
        EXPECT_FALSE(taken[edge.a]);
        taken[edge.a] = true;
      }
      if (edge.dynamic_b) {
        EXPECT_FALSE(taken[edge.b]);
        taken[edge.b] = true;
      }
      EXPECT_EQ(alone.places()[alone.order()[k]], k);
      if (k == alone.begin(c)) continue;
      const std::uint32_t before = alone.order()[k - 1];
      EXPECT_LT(place_in_color(edges[before], before), place_in_color(edge, alone.order()[k]));
    }
  }
  parallel::CountingExecutor counting(16);
  const auto threads = parallel::make_executor(ExecutorKind::Threads, 3);
  for (parallel::Executor* executor : {static_cast<parallel::Executor*>(&counting), threads.get()}) {
    Coloring together;
    together.color(edges, kBodies, *executor);
    EXPECT_EQ(together.colors(), alone.colors());
    EXPECT_TRUE(std::equal(together.order().begin(), together.order().end(), alone.order().begin()));
  }
}

INSTANTIATE_TEST_SUITE_P(OfNearSlotsAndOfAny, ManyEdges, testing::Values(200U, 4000U));

}  // namespace
}  // namespace poise::solver
