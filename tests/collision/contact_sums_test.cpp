// SPDX-License-Identifier: MIT
#include "collision/manifold/contact_sums.h"

#include <gtest/gtest.h>

#include "collision/shapes.h"

namespace poise::collision {
namespace {

TEST(SphereContact, LiesOnTheCentreLineInProportionOfTheRadii) {
  const ShapePtr small = make_sphere_shape(1).value();
  const ShapePtr large = make_sphere_shape(3).value();
  const PairFrame frame = make_pair_frame(*small, Pose{}, *large, Pose{Vec3(3, 0, 0), Mat3::Identity()}, 0, 0);
  const SphereContact contact = sphere_contact(frame, {0, 0});
  EXPECT_EQ(contact.normal, Vec3(1, 0, 0));
  EXPECT_DOUBLE_EQ(contact.point_m.x(), 0.75);  // DO eq. 5
  EXPECT_DOUBLE_EQ(contact.gap_m, -1);
}

TEST(SphereContact, CoincidingCentresHaveADefinedNormal) {
  const ShapePtr ball = make_sphere_shape(1).value();
  const PairFrame same = make_pair_frame(*ball, Pose{}, *ball, Pose{}, 0, 0);
  const SphereContact contact = sphere_contact(same, {0, 0});
  EXPECT_DOUBLE_EQ(contact.normal.norm(), 1);
  EXPECT_DOUBLE_EQ(contact.gap_m, -2);
}

TEST(SphereContact, WithAPlaneTheNormalPointsIntoIt) {
  const ShapePtr ball = make_sphere_shape(0.5).value();
  const ShapePtr floor = make_plane_shape(Vec3(0, 0, 2), 1).value();
  const Pose turned{Vec3(4, 5, 1.25), Quat(0.3, 0.1, -0.7, 0.2).normalized().toRotationMatrix()};
  const PairFrame frame = make_pair_frame(*ball, turned, *floor, Pose{}, 1, 0.01);
  const SphereContact contact = sphere_contact(frame, {0, 0});
  EXPECT_TRUE((turned.rotation * contact.normal).isApprox(Vec3(0, 0, -1)));
  EXPECT_TRUE((turned.rotation * contact.point_m).isApprox(Vec3(0, 0, -0.5)));
  EXPECT_NEAR(contact.gap_m, -0.25, 1e-12);
}

TEST(ContactSums, AreTheWrenchOfAllOverlapsWeightedByDepth) {
  // Compared with the definition, entry by entry, in the world frame.
  std::mt19937_64 random(3);
  const ShapePtr jack = make_jack();
  int checked = 0;
  for (int round = 0; round < 200; ++round) {
    const Pose pose_a = random_pose(random, 0.4);
    const Pose pose_b = random_pose(random, 0.4);
    const PairFrame frame = make_pair_frame(*jack, pose_a, *jack, pose_b, 0.05, 0.01);
    std::vector<FrontEntry> front;
    double weights = 0;
    double least = 1e300;
    Vec3 l = Vec3::Zero(), ta = Vec3::Zero(), tb = Vec3::Zero();
    for (const NodeIndex i : jack->tree.nodes_at(jack->tree.depth())) {
      for (const NodeIndex j : jack->tree.nodes_at(jack->tree.depth())) {
        front.push_back({i, j});
        const Sphere a = jack->tree.sphere(i);
        const Sphere b = jack->tree.sphere(j);
        const Vec3 oa = pose_a.rotation * a.center_m + pose_a.position_m;
        const Vec3 ob = pose_b.rotation * b.center_m + pose_b.position_m;
        const double gap = (ob - oa).norm() - a.radius_m - b.radius_m;
        least = std::min(least, gap);
        const double w = std::max(0.0, 0.01 - gap);
        const Vec3 n = (ob - oa).normalized();
        const Vec3 c = oa + (ob - oa) * a.radius_m / (a.radius_m + b.radius_m);
        weights += w;
        l += w * n;
        ta += w * (c - pose_a.position_m).cross(n);
        tb += w * (c - pose_b.position_m).cross(n);
      }
    }
    if (weights == 0) continue;
    ++checked;
    ContactSums sums;
    add_to_sums(frame, front, sums);
    PairContact contact;
    make_contact(frame, sums, pose_a.rotation, contact);
    EXPECT_LT((contact.direction - l / weights).norm(), 1e-12);
    EXPECT_LT((contact.moment_a_m - ta / weights).norm(), 1e-12);
    EXPECT_LT((contact.moment_b_m - tb / weights).norm(), 1e-12);
    EXPECT_NEAR(contact.estimated_separation_m, least, 1e-12) << "leaves are the true surface";
  }
  EXPECT_GT(checked, 50);
}

TEST(ContactSums, ACoarseLevelAllowsForWhatItsSpheresOverstate) {
  const ShapePtr jack = make_jack();
  const Pose near{Vec3(1.5, 0, 0), Mat3::Identity()};
  const PairFrame frame = make_pair_frame(*jack, Pose{}, *jack, near, 0.5, 0.01);
  ContactSums sums;
  const FrontEntry roots[] = {{0, 0}};
  add_to_sums(frame, roots, sums);
  PairContact contact;
  make_contact(frame, sums, Mat3::Identity(), contact);
  const double mean = static_cast<double>(jack->tree.protrusion_mean_m[0]);
  const double most = static_cast<double>(jack->tree.protrusion_max_m[0]);
  EXPECT_GT(most, mean);
  EXPECT_DOUBLE_EQ(contact.estimated_separation_m, contact.spheres_m + 2 * mean);
  EXPECT_DOUBLE_EQ(contact.certain_separation_m, contact.spheres_m + 2 * most);
}

}  // namespace
}  // namespace poise::collision
