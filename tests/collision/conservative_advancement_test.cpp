// SPDX-License-Identifier: MIT
#include "collision/time_of_impact/conservative_advancement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "collision/broad_phase/broad_phase.h"
#include "collision/time_of_impact/least_extent.h"
#include "geometry/meshes.h"

namespace poise::collision {
namespace {

MovingBody at(const ShapePtr& shape, const Vec3& position, const Vec3& velocity = Vec3::Zero(),
              const Vec3& spin = Vec3::Zero(), const Quat& turn = Quat::Identity()) {
  MovingBody moving_body;
  moving_body.shape = shape.get();
  moving_body.position_m = position;
  moving_body.velocity_mps = velocity;
  moving_body.rotation = {turn * shape->principal_axes, spin};
  if (shape->kind == ShapeKind::Tree && spin != Vec3::Zero()) moving_body.moments_kgm2 = shape->principal_m5;
  return moving_body;
}

ShapePtr box(const Vec3& size) {
  return make_mesh_shape(test::box_mesh(size), {.depth = 2, .preset = TreePreset::Fast}).value();
}

constexpr double kTolerance = 1e-5;

TEST(FirstImpact, OfTwoBallsIsTheRootOfTheQuadratic) {
  const ShapePtr ball = make_sphere_shape(0.1).value();
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    const Vec3 from = test::random_in_box(random, Vec3::Constant(-2), Vec3::Constant(2));
    const Vec3 velocity = test::random_in_box(random, Vec3::Constant(-50), Vec3::Constant(50));
    if (from.norm() < 0.3) continue;
    const TimeOfImpact met = first_time_of_impact(at(ball, from, velocity), at(ball, Vec3::Zero()), {0.1, kTolerance});
    const double a = velocity.squaredNorm();
    const double b = from.dot(velocity);
    const double root2 = b * b - a * (from.squaredNorm() - 0.04);
    const double time = b < 0 && root2 > 0 ? (-b - std::sqrt(root2)) / a : 1.0;
    if (root2 > 0 && std::sqrt(root2) / a < 1e-4) continue;  // a grazing contact: the result depends on the tolerance
    ASSERT_EQ(met.kind == TimeOfImpact::Kind::Hit, time < 0.1) << i;
    if (time >= 0.1) continue;
    EXPECT_NEAR((from + met.time_s * velocity).norm() - 0.2, 0.75 * kTolerance, 0.25 * kTolerance + 1e-12);
    EXPECT_LT((met.contact.normal + (from + met.time_s * velocity).normalized()).norm(), 1e-9);
  }
}

TEST(FirstImpact, OfABallAndAPlaneOrAPlateIsItsWayOverItsSpeed) {
  const ShapePtr ball = make_sphere_shape(0.025).value();
  const ShapePtr plane = make_plane_shape(Vec3::UnitZ(), 0.01).value();
  const ShapePtr plate = box(Vec3(1, 1, 0.02));
  for (const ShapePtr& target : {plane, plate}) {
    for (const double across : {0.0, 3.0, 80.0}) {
      const Vec3 velocity(across, 0, -500);
      const double expected = (2 - 0.01 - 0.025) / 500;
      const TimeOfImpact met = first_time_of_impact(at(ball, Vec3(0.1 - across * expected, 0.03, 2), velocity),
                                                    at(target, Vec3::Zero()), {1.0, kTolerance});
      ASSERT_EQ(met.kind, TimeOfImpact::Kind::Hit);
      EXPECT_NEAR(met.time_s, expected, kTolerance / 500);
      EXPECT_LT((met.contact.normal + Vec3::UnitZ()).norm(), 1e-9);
      EXPECT_LT((met.contact.point_m - Vec3(0.1, 0.03, 0.01)).norm(), 2 * kTolerance);
    }
  }
}

TEST(FirstImpact, NothingIsMetThatIsSlidAlongOrFlownPast) {
  const ShapePtr ball = make_sphere_shape(0.025).value();
  const ShapePtr plate = box(Vec3(1, 1, 0.02));
  const MovingBody target = at(plate, Vec3::Zero());
  EXPECT_EQ(
      first_time_of_impact(at(ball, Vec3(-0.6, 0.1, 0.035 + 2e-5), Vec3(500, 0, 0)), target, {1.0, kTolerance}).kind,
      TimeOfImpact::Kind::None);
  EXPECT_EQ(first_time_of_impact(at(ball, Vec3(-0.2, 0.1, 0.035 + 5e-6), Vec3(500, 1, 0)), target, {1.0, 4e-6}).kind,
            TimeOfImpact::Kind::None);
  EXPECT_EQ(first_time_of_impact(at(ball, Vec3(0.5251, 0.1, 2), Vec3(0, 0, -500)), target, {1.0, kTolerance}).kind,
            TimeOfImpact::Kind::None);
  EXPECT_EQ(first_time_of_impact(at(ball, Vec3(0.5249, 0.1, 2), Vec3(0, 0, -500)), target, {1.0, kTolerance}).kind,
            TimeOfImpact::Kind::Hit);
  EXPECT_EQ(first_time_of_impact(at(ball, Vec3(0, 0, 2), Vec3(0, 0, 500)), target, {1.0, kTolerance}).kind,
            TimeOfImpact::Kind::None);
  EXPECT_EQ(first_time_of_impact(at(ball, Vec3(0, 0, 2), Vec3(0, 0, -500)), target, {0.0039, kTolerance}).kind,
            TimeOfImpact::Kind::None)
      << "not there yet";
}

TEST(FirstImpact, WhatTurnsIsNeverMetTooLate) {
  // Before the time of impact no pose may come nearer than the tolerance; at it, the surfaces are that near.
  const ShapePtr rod = box(Vec3(0.4, 0.05, 0.08));
  const ShapePtr plate = box(Vec3(1, 1, 0.02));
  std::mt19937_64 random(11);
  int hits = 0;
  for (int i = 0; i < 12; ++i) {
    const Vec3 spin = test::random_in_box(random, Vec3::Constant(-120), Vec3::Constant(120));
    const Vec3 from = test::random_in_box(random, Vec3(-0.3, -0.3, 0.5), Vec3(0.3, 0.3, 0.9));
    const MovingBody moving_body = at(rod, from, Vec3(2, -1, -30), spin);
    const MovingBody target = at(plate, Vec3::Zero());
    const TimeOfImpact met = first_time_of_impact(moving_body, target, {0.05, kTolerance});
    ASSERT_NE(met.kind, TimeOfImpact::Kind::Cut) << i;
    if (met.kind == TimeOfImpact::Kind::None) continue;
    ++hits;
    EXPECT_LE(surface_gap(met.a, met.b, 1).gap_m, 1.01 * kTolerance);
    for (int k = 0; k < 40; ++k) {
      const double time = met.time_s * k / 40;
      EXPECT_GT(surface_gap(moved_on(moving_body, time), target, 1).gap_m, 0.4 * kTolerance)
          << i << " at " << time << " of " << met.time_s;
    }
  }
  EXPECT_GT(hits, 8);
}

TEST(FirstImpact, StopsShortWhereItsWorkRunsOut) {
  const ShapePtr ball = make_sphere_shape(0.025).value();
  const ShapePtr plate = box(Vec3(1, 1, 0.02));
  ImpactTerms terms{1.0, kTolerance};
  terms.max_node_pairs = 3;
  const TimeOfImpact met =
      first_time_of_impact(at(ball, Vec3(0.1, 0.03, 2), Vec3(0, 0, -500)), at(plate, Vec3::Zero()), terms);
  EXPECT_EQ(met.kind, TimeOfImpact::Kind::Cut);
  EXPECT_LE(met.time_s, (2 - 0.035) / 500);
}

TEST(SurfaceGap, IsThatOfTheTrianglesAndTellsTheSide) {
  const ShapePtr cube = box(Vec3(0.2, 0.2, 0.2));
  const ConvexGap apart = surface_gap(at(cube, Vec3(0, 0, 0.35)), at(cube, Vec3(0.05, 0, 0)), 1);
  EXPECT_NEAR(apart.gap_m, 0.15, 1e-12);
  EXPECT_LT((apart.normal + Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(surface_gap(at(cube, Vec3(0, 0, 0.35)), at(cube, Vec3::Zero()), 0.1).gap_m, 0.1)
      << "nothing within the limit";
  EXPECT_EQ(surface_gap(at(cube, Vec3(0.07, 0.11, 0.15)),
                        at(cube, Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Quat(0.9, 0.1, 0.3, 0.2).normalized()), 1)
                .gap_m,
            0);
  const ShapePtr floor = make_plane_shape(Vec3::UnitZ(), 0).value();
  const ConvexGap flat = surface_gap(at(cube, Vec3(0.3, 0, 0.25)), at(floor, Vec3::Zero()), 1);
  EXPECT_NEAR(flat.gap_m, 0.15, 1e-12);
}

TEST(LeastExtent, IsTheSmallestSide) {
  EXPECT_NEAR(least_extent_m(*make_sphere_shape(0.025).value()), 0.05, 1e-8);
  EXPECT_NEAR(least_extent_m(*box(Vec3(1, 0.5, 0.1))), 0.1, 1e-9);
  EXPECT_TRUE(std::isinf(least_extent_m(*make_plane_shape(Vec3::UnitX(), 0).value())));
}

// Trajectories through a cloud of balls of several sizes, compared with testing all pairs.
TEST(SweptBounds, FindWhatAComparisonOfAllFinds) {
  std::mt19937_64 random(5);
  for (const double size : {0.02, 0.3}) {
    std::vector<MotionBound> bounds;
    for (std::uint32_t i = 0; i < 3000; ++i) {
      bounds.push_back({test::random_in_box(random, Vec3::Constant(-5), Vec3::Constant(5)), size * (i % 7 == 0 ? 8 : 1),
                        i, 1, 0xffffffffU, i % 5 != 0});
    }
    std::vector<SweptBound> swept;
    for (std::uint32_t i = 0; i < 40; ++i) {
      const double far = i % 3 == 0 ? 40 : 3;
      swept.push_back({{test::random_in_box(random, Vec3::Constant(-6), Vec3::Constant(6)), 0.03 + 0.01 * i, 3000 + i},
                       test::random_in_box(random, Vec3::Constant(-far), Vec3::Constant(far))});
    }
    const std::vector<PlaneBound> planes{{Vec3::UnitZ(), -2, 4000}};
    const auto distance = [](const SweptBound& way, const Vec3& point) {
      const double t =
          std::clamp((point - way.start.center_m).dot(way.motion_m) / way.motion_m.squaredNorm(), 0.0, 1.0);
      return (way.start.center_m + t * way.motion_m - point).norm();
    };
    std::vector<CandidatePair> expected;
    for (std::size_t s = 0; s < swept.size(); ++s) {
      for (const MotionBound& bound : bounds) {
        if (distance(swept[s], bound.center_m) < bound.radius_m + swept[s].start.radius_m)
          expected.push_back({bound.slot, swept[s].start.slot});
      }
      const double low = std::min(swept[s].start.center_m.z(), (swept[s].start.center_m + swept[s].motion_m).z());
      if (low + 2 < swept[s].start.radius_m) expected.push_back({swept[s].start.slot, 4000});
    }
    BroadPhase phase;
    const auto executor = parallel::make_executor(ExecutorKind::Threads, 2);
    const BroadPhase::Result found = phase.find(bounds, planes, {1}, *executor, swept);
    std::vector<CandidatePair> with_one;
    std::size_t between = 0;
    for (const CandidatePair& pair : found.pairs) {
      if (pair.low < 3000 && pair.high < 3000) continue;
      if (pair.low >= 3000 && pair.high < 4000) {
        if (pair.low < 3000 || pair.high < 3000) continue;
        ++between;
        continue;
      }
      if (pair.high == 4000 && pair.low < 3000) continue;
      with_one.push_back(pair);
    }
    const auto order = [](const CandidatePair& x, const CandidatePair& y) {
      return std::pair(x.low, x.high) < std::pair(y.low, y.high);
    };
    std::sort(expected.begin(), expected.end(), order);
    EXPECT_GT(expected.size(), 30U);
    EXPECT_EQ(with_one, expected) << size;
    EXPECT_GT(between, 0U);
  }
}

}  // namespace
}  // namespace poise::collision
