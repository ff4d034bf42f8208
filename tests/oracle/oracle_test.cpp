// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "oracle/exact_response.h"
#include "oracle/meshes.h"

namespace poise::oracle {
namespace {

constexpr double kDensity = 1000;

OracleMesh cube() { return OracleMesh::make(box_mesh(1, 1, 1), kDensity).value(); }

Quat turn(double angle_rad, const Vec3& axis) { return Quat(Eigen::AngleAxisd(angle_rad, axis)); }

// a is at rest at the origin, b approaches it from above at 2 m/s from 5 m.
struct Drop {
  Flight a, b;
  Drop(const Quat& turn_a, const Quat& turn_b) {
    a.start = {Vec3::Zero(), turn_a};
    b.start = {Vec3(0.1, 0.2, 5), turn_b};
    b.velocity_mps = Vec3(0, 0, -2);
  }
};

TEST(TriangleFeatures, ACornerOverAFaceIsNearestToItsFoot) {
  const TrianglePoints face = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const TrianglePoints corner = {Vec3(0.2, 0.3, 0.5), Vec3(0.2, 0.3, 2), Vec3(1, 1, 2)};
  const NearestFeatures under = nearest_features(face, corner);
  EXPECT_EQ(under.feature, Feature::FaceVertex);
  EXPECT_DOUBLE_EQ(under.distance_m, 0.5);
  EXPECT_EQ(under.normal, Vec3(0, 0, 1));
  EXPECT_EQ(under.on_a_m, Vec3(0.2, 0.3, 0));
  const NearestFeatures over = nearest_features(corner, face);
  EXPECT_EQ(over.feature, Feature::VertexFace);
  EXPECT_EQ(over.normal, Vec3(0, 0, -1));
}

TEST(TriangleFeatures, CrossedEdgesHaveTheirCrossProductAsNormal) {
  const TrianglePoints below = {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, -1)};
  const TrianglePoints above = {Vec3(0.25, -1, 0.5), Vec3(0.25, 1, 0.5), Vec3(0.25, 0, 2)};
  const NearestFeatures nearest = nearest_features(below, above);
  EXPECT_EQ(nearest.feature, Feature::EdgeEdge);
  EXPECT_DOUBLE_EQ(nearest.distance_m, 0.5);
  EXPECT_TRUE(nearest.normal.isApprox(Vec3::UnitZ(), 1e-15));
  EXPECT_TRUE(nearest.on_b_m.isApprox(Vec3(0.25, 0, 0.5), 1e-15));
}

TEST(TriangleFeatures, TrianglesThatCrossHaveNoDistance) {
  const TrianglePoints face = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const TrianglePoints through = {Vec3(0.2, 0.2, -1), Vec3(0.2, 0.2, 1), Vec3(0.3, 0.2, 1)};
  EXPECT_EQ(nearest_features(face, through).distance_m, 0);
  EXPECT_EQ(nearest_features(through, face).distance_m, 0);
}

TEST(Oracle, NearestPointsLieOnTheBodiesAndAreAsFarApartAsLibfclSays) {
  const OracleMesh a = OracleMesh::make(box_mesh(1, 0.6, 0.1), kDensity).value();
  const OracleMesh b = OracleMesh::make(ball_mesh(1), kDensity).value();
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  int apart = 0;
  for (int round = 0; round < 300; ++round) {
    const auto rotation = [&] { return Quat(any(random), any(random), any(random), any(random)).normalized(); };
    const Placed at_a{Vec3(10 * any(random), 3, 5), rotation()};
    const Placed at_b{at_a.position_m + 2.5 * Vec3(any(random), any(random), any(random)), rotation()};
    const double distance = a.distance_m(at_a, b, at_b);
    const NearestFeatures nearest = a.nearest(at_a, b, at_b);
    ASSERT_NEAR(nearest.distance_m, distance, 1e-12);
    if (distance == 0) continue;
    ++apart;
    ASSERT_NEAR((nearest.on_b_m - nearest.on_a_m).norm(), distance, 1e-12);
    ASSERT_NEAR(nearest.normal.dot(nearest.on_b_m - nearest.on_a_m), distance, 1e-9);
    const Vec3 on_box = at_a.orientation.conjugate() * (nearest.on_a_m - at_a.position_m);
    ASSERT_NEAR(on_box.cwiseAbs().cwiseQuotient(Vec3(0.5, 0.3, 0.05)).maxCoeff(), 1, 1e-12);
  }
  EXPECT_GT(apart, 100);
}

TEST(Oracle, ABodyHasTheMassOfItsMesh) {
  const OracleMesh slab = OracleMesh::make(box_mesh(2, 1, 0.5), kDensity).value();
  EXPECT_NEAR(slab.mass_kg(), 1000, 1e-9);
  EXPECT_NEAR(slab.inertia_kgm2()(0, 0), 1000 * (1 + 0.25) / 12, 1e-9);
  EXPECT_NEAR(slab.angular_response_m(), std::sqrt(2 * (4 + 1 + 0.25) / 12 / 3), 1e-12);
  EXPECT_DOUBLE_EQ(slab.size_m(), 2);
  TriangleMesh open = box_mesh(1, 1, 1);
  open.triangles.pop_back();
  EXPECT_FALSE(OracleMesh::make(open, kDensity).ok());
  EXPECT_FALSE(OracleMesh::make(box_mesh(1, 1, 1), 0).ok());
}

TEST(FirstTouch, ACornerMeetsAFaceOnTimeAndIsAnsweredAsInTheClosedForm) {
  const Vec3 axis = Vec3(1, 1, 1).cross(-Vec3::UnitZ()).normalized();
  const Drop drop(Quat::Identity(), turn(std::acos(-1 / std::numbers::sqrt3), axis));
  const OracleMesh box = cube();
  const FirstTouch touch = first_touch(box, drop.a, box, drop.b, 10);
  ASSERT_EQ(touch.outcome, FlightOutcome::Touch);
  EXPECT_EQ(touch.nearest.feature, Feature::FaceVertex);
  EXPECT_TRUE(touch.nearest.normal.isApprox(Vec3::UnitZ(), 1e-12));
  EXPECT_NEAR(touch.time_s, (4.5 - 0.5 * std::numbers::sqrt3) / 2, 1e-5);
  const Answer answer = exact_answer(box, drop.a, box, drop.b, touch, 0.5);
  // One impulse straight up at (0.1, 0.2) on a; I = m / 6.
  const double change = 1.5 * 2 / (2 + 6 * 0.05);
  EXPECT_TRUE(answer.dv_b_mps.isApprox(Vec3(0, 0, change), 1e-9));
  EXPECT_TRUE(answer.dv_a_mps.isApprox(Vec3(0, 0, -change), 1e-9));
  EXPECT_TRUE(answer.dw_a_radps.isApprox(-6 * change * Vec3(0.2, -0.1, 0), 1e-9));
  EXPECT_LT(answer.dw_b_radps.norm(), 1e-9);
}

TEST(FirstTouch, EdgesThatCrossMeetOnTimeAndAreAnsweredAsInTheClosedForm) {
  const Drop drop(turn(std::numbers::pi / 4, Vec3::UnitX()), turn(std::numbers::pi / 4, Vec3::UnitY()));
  const OracleMesh box = cube();
  const FirstTouch touch = first_touch(box, drop.a, box, drop.b, 10);
  ASSERT_EQ(touch.outcome, FlightOutcome::Touch);
  EXPECT_EQ(touch.nearest.feature, Feature::EdgeEdge);
  EXPECT_TRUE(touch.nearest.normal.isApprox(Vec3::UnitZ(), 1e-12));
  EXPECT_NEAR(touch.time_s, (5 - std::numbers::sqrt2) / 2, 1e-5);
  const Answer answer = exact_answer(box, drop.a, box, drop.b, touch, 0.5);
  const double change = 1.5 * 2 / (2 + 6 * (0.01 + 0.04));
  EXPECT_TRUE(answer.dv_b_mps.isApprox(Vec3(0, 0, change), 1e-9));
  EXPECT_TRUE(answer.dw_a_radps.isApprox(-6 * change * Vec3(0, -0.1, 0), 1e-9));
  EXPECT_TRUE(answer.dw_b_radps.isApprox(6 * change * Vec3(-0.2, 0, 0), 1e-9));
}

TEST(FirstTouch, BallsOfManyTrianglesMeetAndAnswerNearlyAsBalls) {
  const OracleMesh ball = OracleMesh::make(ball_mesh(5), kDensity).value();
  Flight a;
  Flight b;
  b.start.position_m = Vec3(-4, 0.6, 0.5);
  b.velocity_mps = Vec3(2, 0, 0);
  const FirstTouch touch = first_touch(ball, a, ball, b, 10);
  ASSERT_EQ(touch.outcome, FlightOutcome::Touch);
  const double along = std::sqrt(4 - 0.36 - 0.25);
  EXPECT_NEAR(touch.time_s, (4 - along) / 2, 1e-3);
  const Vec3 line = Vec3(-along, 0.6, 0.5) / 2;
  const Answer answer = exact_answer(ball, a, ball, b, touch, 0.5);
  EXPECT_LT((answer.dv_b_mps - 1.5 / 2 * along * line).norm(), 0.03 * along);
  EXPECT_LT(answer.dw_b_radps.norm(), 2.5 * 0.75 * along * 0.037);  // I = 0.4 m; a triangle leans by 0.037 at most
}

TEST(FirstTouch, AFlightThatPassesBySaysMiss) {
  const OracleMesh box = cube();
  Drop drop(Quat::Identity(), Quat::Identity());
  drop.b.start.position_m.x() = 1 + 1e-3;
  EXPECT_EQ(first_touch(box, drop.a, box, drop.b, 10).outcome, FlightOutcome::Miss);
  drop.b.start.position_m.z() = 0.5;
  drop.b.start.position_m.x() = 0.5;
  EXPECT_EQ(first_touch(box, drop.a, box, drop.b, 10).outcome, FlightOutcome::StartsTouching);
}

TEST(Flight, TurnsAboutItsSpinAtItsRate) {
  Flight flight;
  flight.start.orientation = turn(0.3, Vec3::UnitX());
  flight.velocity_mps = Vec3(1, 2, 3);
  flight.spin_radps = Vec3(0, 0, 2);
  const Placed at = flight.at(0.25);
  EXPECT_TRUE(at.position_m.isApprox(Vec3(0.25, 0.5, 0.75), 1e-15));
  EXPECT_LT(at.orientation.angularDistance(turn(0.5, Vec3::UnitZ()) * flight.start.orientation), 1e-12);
}

}  // namespace
}  // namespace poise::oracle
