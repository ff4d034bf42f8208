// SPDX-License-Identifier: MIT
#include "frame/view_cues.h"

#include <gtest/gtest.h>

#include <cmath>

namespace poise::simulation {
namespace {

View looking_along_x() { return {true, Vec3::Zero(), Vec3::UnitX(), Vec3::UnitZ(), 1.0, 1.5, Vec3::UnitX()}; }

PairView at(const Vec3& point, const Vec3& normal = Vec3::UnitY()) {
  PairView pair;
  pair.point_m = point;
  pair.normal = normal;
  pair.extent_m = 0.1;
  return pair;
}

TEST(Cues, WithoutAViewEveryPairIsAlike) {
  const scheduler::PairCues near = cues_of(View{}, at(Vec3(1, 0, 0)));
  const scheduler::PairCues far = cues_of(View{}, at(Vec3(100, 50, 0)));
  EXPECT_EQ(near.angle_radpm, far.angle_radpm);
  EXPECT_EQ(near.visibility, far.visibility);
  EXPECT_EQ(near.eccentricity_rad, far.eccentricity_rad);
}

TEST(Cues, TheVisibleAngleFallsWithDistanceAndAlongTheRay) {
  const View view = looking_along_x();
  EXPECT_NEAR(cues_of(view, at(Vec3(10, 0, 0))).angle_radpm, 0.1, 1e-12);
  EXPECT_NEAR(cues_of(view, at(Vec3(20, 0, 0))).angle_radpm, 0.05, 1e-12);
  EXPECT_NEAR(cues_of(view, at(Vec3(10, 0, 0), Vec3::UnitX())).angle_radpm, 0.01, 1e-12) << "error along the ray";
}

TEST(Cues, EccentricityIsTheAngleFromTheGaze) {
  View view = looking_along_x();
  view.gaze = Vec3(1, 1, 0).normalized();
  EXPECT_NEAR(cues_of(view, at(Vec3(5, 0, 0))).eccentricity_rad, std::acos(-1.0) / 4, 1e-12);
}

TEST(Cues, TheFrustumHasFourSidesAndEndsAtTheEye) {
  const View view = looking_along_x();
  const double up = std::tan(0.5);
  EXPECT_TRUE(in_frustum(view, Vec3(10, 0, 10 * up - 0.01), 0));
  EXPECT_FALSE(in_frustum(view, Vec3(10, 0, 10 * up + 0.01), 0));
  EXPECT_TRUE(in_frustum(view, Vec3(10, 0, 10 * up + 0.1), 0.2)) << "a part of it is in";
  EXPECT_TRUE(in_frustum(view, Vec3(10, -15 * up + 0.01, 0), 0));
  EXPECT_FALSE(in_frustum(view, Vec3(10, -15 * up - 0.02, 0), 0));
  EXPECT_FALSE(in_frustum(view, Vec3(-1, 0, 0), 0.5)) << "behind";
  EXPECT_EQ(cues_of(view, at(Vec3(-5, 0, 0))).visibility, scheduler::Policy{}.outside_frustum);
}

TEST(Cues, AtTheEyeItselfEverythingStaysFinite) {
  const scheduler::PairCues cues = cues_of(looking_along_x(), at(Vec3::Zero()));
  EXPECT_TRUE(std::isfinite(cues.angle_radpm));
  EXPECT_TRUE(std::isfinite(cues.eccentricity_rad));
}

TEST(Cues, SeparatingPairsDoNotClose) {
  PairView pair = at(Vec3(5, 0, 0));
  pair.closing_mps = -3;
  EXPECT_EQ(cues_of(looking_along_x(), pair).closing_mps, 0);
}

}  // namespace
}  // namespace poise::simulation
