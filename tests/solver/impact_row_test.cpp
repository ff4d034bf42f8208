// SPDX-License-Identifier: MIT
#include "solver/impact_row.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <set>

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
  // A hub with more neighbours than there are colours.
  std::vector<Coloring::Edge> edges;
  for (std::uint32_t i = 1; i <= Coloring::kColors + 10; ++i) edges.push_back({0, i, true, true});
  Coloring coloring;
  coloring.color(edges, Coloring::kColors + 11);
  EXPECT_EQ(coloring.colors(), Coloring::kColors);
  EXPECT_EQ(coloring.serial_begin(), Coloring::kColors);
  for (std::size_t k = Coloring::kColors; k < edges.size(); ++k) EXPECT_EQ(coloring.order()[k], k);
}

TEST(ContactRow, EffectiveMassOfTwoPointMassesIsTheReducedMass) {
  ContactRow row;
  row.direction = Vec3::UnitX();
  ASSERT_TRUE(prepare_row(row, 0.5, Mat3::Zero(), 0.25, Mat3::Zero()));
  EXPECT_DOUBLE_EQ(row.effective_mass, 1 / 0.75);
}

TEST(ContactRow, OpposedNormalsThatCancelAreDegenerateAndAnswerNothing) {
  ContactRow row;
  EXPECT_FALSE(prepare_row(row, 1, Mat3::Identity(), 1, Mat3::Identity()));
  EXPECT_EQ(row.effective_mass, 0);
}

}  // namespace
}  // namespace poise::solver
