// SPDX-License-Identifier: MIT
#include "solver/coloring.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "parallel/counting_executor.h"

namespace poise::solver {
namespace {

RC_GTEST_PROP(Coloring, NoTwoRowsOfAColourShareABodyThatYields, ()) {
  const auto bodies = *rc::gen::inRange<std::uint32_t>(2, 60);
  const auto count = *rc::gen::inRange<std::size_t>(0, 400);
  std::vector<Coloring::Edge> edges;
  for (std::size_t i = 0; i < count; ++i) {
    Coloring::Edge edge;
    edge.a = *rc::gen::inRange<std::uint32_t>(0, bodies);
    edge.b = (edge.a + *rc::gen::inRange<std::uint32_t>(1, bodies)) % bodies;
    edge.dynamic_b = edge.b % 5 != 0;
    edge.dynamic_a = edge.a % 5 != 0;
    edges.push_back(edge);
  }
  Coloring coloring;
  coloring.color(edges, bodies);
  std::set<std::uint32_t> seen(coloring.order().begin(), coloring.order().end());
  RC_ASSERT(seen.size() == count);
  for (std::uint32_t c = 0; c < coloring.colors(); ++c) {
    std::set<std::uint32_t> taken;
    for (std::size_t k = coloring.begin(c); k < coloring.begin(c + 1); ++k) {
      const Coloring::Edge& edge = edges[coloring.order()[k]];
      if (edge.dynamic_a) RC_ASSERT(taken.insert(edge.a).second);
      if (edge.dynamic_b) RC_ASSERT(taken.insert(edge.b).second);
    }
  }
  RC_ASSERT(coloring.serial_begin() <= count);
}

TEST(Coloring, RowsBeyondTheLastColourGoToTheEndInOrder) {
  // A hub with more neighbours than there are colours for pairs of dynamic bodies.
  constexpr std::uint32_t kFree = Coloring::kColors - Coloring::kGroundColors;
  std::vector<Coloring::Edge> edges;
  for (std::uint32_t i = 1; i <= Coloring::kColors + 10; ++i) edges.push_back({0, i, true, true});
  Coloring coloring;
  coloring.color(edges, Coloring::kColors + 11);
  EXPECT_EQ(coloring.colors(), kFree);
  EXPECT_EQ(coloring.serial_begin(), kFree);
  for (std::size_t k = kFree; k < edges.size(); ++k) EXPECT_EQ(coloring.order()[k], k);
}

TEST(Coloring, RowsOnTheGroundComeAfterAllOthers) {
  // A column whose ground is named first, and a body with more such rows than there are colours for them.
  std::vector<Coloring::Edge> edges = {
      {0, 1, false, true}, {1, 2, true, true}, {2, 3, true, true}, {3, 0, true, false}};
  for (std::uint32_t i = 0; i < Coloring::kGroundColors + 3; ++i) edges.push_back({0, 4, false, true});
  Coloring coloring;
  coloring.color(edges, 5);
  ASSERT_EQ(coloring.order().size(), edges.size());
  EXPECT_EQ(coloring.order()[0], 1U);
  EXPECT_EQ(coloring.order()[1], 2U);
  EXPECT_EQ(coloring.serial_begin(), edges.size() - 3);
  EXPECT_EQ(coloring.colors(), 2 + Coloring::kGroundColors) << "those without rows are left out";
}

TEST(Coloring, FewRowsOfAColourStandByRankAlone) {
  constexpr std::uint32_t kRows = 64;
  std::vector<Coloring::Edge> edges;
  for (std::uint32_t i = 0; i < kRows; ++i)
    edges.push_back({100 * i, 100 * i + 1, true, true, static_cast<std::uint8_t>(i % Coloring::kRanks)});
  Coloring coloring;
  coloring.color(edges, 100 * kRows);
  ASSERT_EQ(coloring.colors(), 1U);
  for (std::uint32_t k = 0; k < kRows; ++k) {
    EXPECT_EQ(edges[coloring.order()[k]].rank, Coloring::kRanks - 1 - k / (kRows / Coloring::kRanks));
    EXPECT_EQ(coloring.places()[coloring.order()[k]], k);
  }
}

// Pairs of bodies that are `near` slots apart at most, or of any.
std::vector<Coloring::Edge> many_edges(std::uint32_t bodies, std::size_t count, std::uint32_t near) {
  std::mt19937 random(7);
  std::vector<Coloring::Edge> edges;
  while (edges.size() < count) {
    Coloring::Edge edge;
    edge.a = static_cast<std::uint32_t>(random() % bodies);
    edge.b = static_cast<std::uint32_t>((edge.a + 1 + random() % near) % bodies);
    edge.dynamic_a = edge.a % 50 != 0;
    edge.dynamic_b = edge.b % 50 != 0;
    edge.rank = static_cast<std::uint8_t>(random() % Coloring::kRanks);
    if (edge.dynamic_a || edge.dynamic_b) edges.push_back(edge);
  }
  return edges;
}

// How rows of one colour follow each other: by eighths of 8,192 slots, by rank, and in canonical order.
std::tuple<std::uint32_t, int, std::uint32_t> place_in_color(const Coloring::Edge& edge, std::uint32_t index) {
  const std::uint32_t low = std::min(edge.dynamic_a ? edge.a : edge.b, edge.dynamic_b ? edge.b : edge.a);
  return {low / 1024, -edge.rank, index};
}

class ManyEdges : public testing::TestWithParam<std::uint32_t> {};

TEST_P(ManyEdges, HaveTheSameColoursOnAnyNumberOfThreads) {
  constexpr std::uint32_t kBodies = 5000;
  const std::vector<Coloring::Edge> edges = many_edges(kBodies, 4 * Coloring::kTiledEdges, GetParam());
  Coloring alone;
  alone.color(edges, kBodies);
  EXPECT_EQ(alone.serial_begin(), edges.size());
  for (std::uint32_t c = 0; c < alone.colors(); ++c) {
    std::vector<bool> taken(kBodies);
    for (std::size_t k = alone.begin(c); k < alone.begin(c + 1); ++k) {
      const Coloring::Edge& edge = edges[alone.order()[k]];
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
