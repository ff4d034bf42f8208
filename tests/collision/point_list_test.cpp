// SPDX-License-Identifier: MIT
#include "collision/triangles/point_list.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "collision/shapes.h"

namespace poise::collision {
namespace {

FoundPoint found(const Vec3& point, double gap, std::uint64_t order, const Vec3& normal = Vec3::UnitZ()) {
  return {normal, point, gap, order, FoundPoint::kNoCorner, 0, false};
}

double widest(const ManifoldPoints& set) {
  double most = 0;
  for (const ManifoldPoint& p : set.all()) {
    for (const ManifoldPoint& q : set.all()) most = std::max(most, (p.point_m - q.point_m).norm());
  }
  return most;
}

TEST(PointList, ChoosesTheDeepestAndTheOnesThatSpanTheRest) {
  PointList list(1);
  std::uint64_t order = 0;
  for (int x = -3; x <= 3; ++x) {
    for (int y = -3; y <= 3; ++y) list.add(found(Vec3(x, y, 0), x == 3 && y == 3 ? -0.1 : 0.0, order++));
  }
  const ManifoldPoints set = list.choose(0.01);
  ASSERT_EQ(set.count, 4U);
  EXPECT_EQ(set.point[0].gap_m, -0.1);
  for (const ManifoldPoint& p : set.all()) {
    EXPECT_EQ(std::abs(p.point_m.x()), 3);
    EXPECT_EQ(std::abs(p.point_m.y()), 3);
  }
}

// Three points carry a body. Where a farther one that does not touch took the place of one of them, the body sank there
// until that was found again, and never came to rest.
TEST(PointList, PointsThatTouchAreChosenBeforeOthers) {
  PointList list(1);
  list.add(found(Vec3(-0.24, 1.70, 0), -1.0e-3, 0));
  list.add(found(Vec3(-0.06, -0.83, 0), -0.9e-3, 1));
  list.add(found(Vec3(0.31, 1.88, 0), -0.7e-3, 2));
  list.add(found(Vec3(-0.04, -1.03, 0), 3e-3, 3));
  list.add(found(Vec3(0.12, -1.04, 0), 3e-3, 4));
  list.add(found(Vec3(-0.30, 1.70, 0), 3e-3, 5));
  list.add(found(Vec3(0.36, 1.85, 0), 3e-3, 6));
  const ManifoldPoints set = list.choose(0.01);
  ASSERT_EQ(set.count, 4U);
  const auto touches = [](const ManifoldPoint& point) { return point.gap_m < 0; };
  EXPECT_EQ(std::count_if(set.all().begin(), set.all().end(), touches), 3) << "and one beside them";
}

TEST(PointList, WhatIsNearAnotherPlaceInTheSameDirectionIsTheSamePlace) {
  PointList list(1);
  list.add(found(Vec3(0, 0, 0), 1e-3, 1));
  list.add(found(Vec3(5e-4, 0, 0), -1e-3, 2));
  list.add(found(Vec3(0, 5e-4, 0), 2e-3, 0));
  EXPECT_EQ(list.count(), 1U);
  EXPECT_EQ(list.choose(0.1).point[0].gap_m, -1e-3);
  list.add(found(Vec3(0, 0, 0), 0, 3, Vec3::UnitX()));
  EXPECT_EQ(list.count(), 2U);
  EXPECT_EQ(list.least_gap_m(), -1e-3);
}

TEST(PointList, EveryDirectionHasItsShare) {
  PointList list(1);
  for (int i = 0; i < 6; ++i) list.add(found(Vec3(i, i % 2, 0), -0.01, static_cast<std::uint64_t>(i)));
  list.add(found(Vec3(2, 0, 0), 0.001, 9, Vec3::UnitX()));
  ManifoldPoints set = list.choose(0.01);
  ASSERT_EQ(set.count, 5U) << "four hold in a direction";
  EXPECT_EQ(set.point[4].normal, Vec3::UnitX());
  const auto of = [&](const Vec3& normal) {
    return std::ranges::count_if(set.all(), [&](const ManifoldPoint& p) { return p.normal == normal; });
  };
  for (int i = 1; i < 4; ++i) list.add(found(Vec3(2, 3 * (i % 2), 3 * (i / 2)), 0.001, 10, Vec3::UnitX()));
  set = list.choose(0.01);
  ASSERT_EQ(set.count, 8U);
  EXPECT_EQ(of(Vec3::UnitX()), 4);
  for (int i = 0; i < 4; ++i) list.add(found(Vec3(3 * (i % 2), 3, 3 * (i / 2)), 0.002, 20, Vec3::UnitY()));
  set = list.choose(0.01);
  ASSERT_EQ(set.count, 8U);
  EXPECT_EQ(of(Vec3::UnitZ()), 3);
  EXPECT_EQ(of(Vec3::UnitX()), 3);
  EXPECT_EQ(of(Vec3::UnitY()), 2);
}

TEST(PointList, ACornerBeneathTwoFacesLeavesByTheNearerOneButInAGroove) {
  for (const bool groove : {false, true}) {
    PointList list(1);
    FoundPoint up = found(Vec3::Zero(), -0.001, 1);
    FoundPoint aside = found(Vec3::Zero(), -0.004, 0, Vec3::UnitX());
    up.corner = aside.corner = 7;
    up.in_groove = aside.in_groove = groove;
    list.add(aside);
    list.add(up);
    const ManifoldPoints set = list.choose(0.01);
    EXPECT_EQ(set.count, groove ? 2U : 1U);
    EXPECT_EQ(set.point[groove ? 1 : 0].normal, Vec3::UnitZ());
  }
}

TEST(PointList, TheOrderOfFindingDoesNotMatter) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 50; ++round) {
    std::vector<FoundPoint> points;
    for (std::uint64_t i = 0; i < 40; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / 40;
      points.push_back(found(Vec3(std::cos(angle), std::sin(angle), 0), 0, i));
    }
    PointList straight(1);
    for (const FoundPoint& place : points) straight.add(place);
    std::ranges::shuffle(points, random);
    PointList shuffled(1);
    for (const FoundPoint& place : points) shuffled.add(place);
    const ManifoldPoints one = straight.choose(1);
    const ManifoldPoints other = shuffled.choose(1);
    ASSERT_EQ(one.count, 4U);
    ASSERT_EQ(other.count, 4U);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(one.point[i].point_m, other.point[i].point_m);
  }
}

TEST(PointList, AFullListKeepsItsDeepestAndItsOutermost) {
  std::mt19937_64 random(4);
  PointList list(1);
  double least = 1;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const double angle = uniform(random, 0, 2 * std::numbers::pi);
    const double radius = uniform(random, 0, 5);
    const double gap = uniform(random, -1, 0);
    least = std::min(least, gap);
    list.add(found(radius * Vec3(std::cos(angle), std::sin(angle), 0), gap, i));
    ASSERT_LE(list.count(), PointList::kRoom);
  }
  const ManifoldPoints set = list.choose(1);
  ASSERT_EQ(set.count, 4U);
  EXPECT_NEAR(set.point[0].gap_m, least, 2e-6);
  EXPECT_GT(widest(set), 9);
}

TEST(PointList, PlacesInARowAreTwo) {
  PointList list(1);
  for (std::uint64_t i = 0; i < 10; ++i) list.add(found(Vec3(0.1 * static_cast<double>(i), 0, 0), 0, i));
  const ManifoldPoints set = list.choose(1);
  EXPECT_EQ(set.count, 2U);
  EXPECT_NEAR(widest(set), 0.9, 1e-12);
}

}  // namespace
}  // namespace poise::collision
