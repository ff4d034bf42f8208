// SPDX-License-Identifier: MIT
#include "capture/packed_pose.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

namespace poise::capture {
namespace {

double angle_between(const Quat& a, const Quat& b) {
  const double distance = std::min((a.coeffs() - b.coeffs()).norm(), (a.coeffs() + b.coeffs()).norm());
  return 4 * std::asin(std::min(1.0, distance / 2));
}

RC_GTEST_PROP(PackedPose, IsWithinTheStatedPrecision, ()) {
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  const double step_m = std::pow(10.0, *rc::gen::inRange(-6, 1));
  const auto steps = static_cast<std::uint32_t>(1U << static_cast<unsigned>(*rc::gen::inRange(4, 21)));
  std::normal_distribution<double> normal;
  Pose pose;
  pose.position_m = 1e4 * Vec3(normal(random), normal(random), normal(random));
  pose.orientation = Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
  const PackedPose packed = pack(pose, step_m, steps);
  RC_ASSERT(sound(packed, steps));
  const Pose read = unpack(packed, step_m, steps);
  for (int axis = 0; axis < 3; ++axis)
    RC_ASSERT(std::abs(read.position_m[axis] - pose.position_m[axis]) <= 0.5 * step_m * (1 + 1e-9));
  RC_ASSERT(angle_between(read.orientation, pose.orientation) <= orientation_error_rad(steps));
  RC_ASSERT(std::abs(read.orientation.norm() - 1) < 1e-12);
}

TEST(PackedPose, OfAnOrientationWhoseComponentsAreEqualIsWithinThePrecisionToo) {
  for (const double sign : {-1.0, 1.0}) {
    const Quat even(sign * 0.5, 0.5, -0.5, 0.5);
    const PackedPose packed = pack({Vec3::Zero(), even}, 1, kLeastOrientationSteps);
    EXPECT_LE(angle_between(unpack(packed, 1, kLeastOrientationSteps).orientation, even),
              orientation_error_rad(kLeastOrientationSteps));
  }
}

TEST(PackedPose, FartherThanACaptureReachesStaysAtItsEnd) {
  const PackedPose packed = pack({Vec3(1e300, -1e300, 0), Quat::Identity()}, 1e-3, 16);
  EXPECT_EQ(packed.position[0], kMostSteps);
  EXPECT_EQ(packed.position[1], -kMostSteps);
  EXPECT_TRUE(sound(packed, 16));
}

TEST(PackedPose, OutOfRangeIsNotSound) {
  PackedPose pose;
  EXPECT_TRUE(sound(pose, 16));
  pose.orientation[1] = 17;
  EXPECT_FALSE(sound(pose, 16));
  pose.orientation[1] = 0;
  pose.largest = 4;
  EXPECT_FALSE(sound(pose, 16));
  pose.largest = 0;
  pose.position[2] = kMostSteps + 1;
  EXPECT_FALSE(sound(pose, 16));
}

}  // namespace
}  // namespace poise::capture
