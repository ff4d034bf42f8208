// SPDX-License-Identifier: MIT
#include "collision/manifold/fitted_sums.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "collision/instruction_sets.h"
#include "collision/manifold/contact_sums.h"
#include "collision/shapes.h"

namespace poise::collision {
namespace {

// Random fits that are independent of the tree, so that an error cannot be hidden by equal numbers.
ShapePtr with_random_fits(const ShapePtr& shape, std::mt19937_64& random) {
  Shape changed = *shape;
  for (NodeFit& fit : changed.tree.fit) {
    const Eigen::Vector3f center = random_vector(random, 0.5).cast<float>();
    fit = {center.x(),
           center.y(),
           center.z(),
           static_cast<float>(uniform(random, 0.05, 0.4)),
           static_cast<float>(uniform(random, 1e-5, 1e-2)),
           static_cast<float>(uniform(random, -0.1, 0.1))};
  }
  return std::make_shared<Shape>(changed);
}

struct Contacts {
  PairFrame frame;
  std::vector<FrontEntry> front;
  ShapePtr a, b;
};

Contacts random_contacts(std::size_t count, std::mt19937_64& random, bool plane = false) {
  Contacts made;
  made.a = with_random_fits(make_worm(20), random);
  made.b = plane ? make_plane_shape(Vec3(1, 2, 3), 0.1).value() : with_random_fits(make_worm(30), random);
  made.frame = make_pair_frame(*made.a, random_pose(random, 0.6), *made.b, random_pose(random, 0.6), 0.1, 0.01);
  made.frame.fitted = true;
  made.frame.expected_gap_m = uniform(random, -0.1, 0.1);
  made.frame.width_m = uniform(random, 0.3, 0.6);
  for (std::size_t i = 0; i < count; ++i) {
    made.front.push_back({static_cast<NodeIndex>(random() % made.a->tree.node_count()),
                          plane ? 0 : static_cast<NodeIndex>(random() % made.b->tree.node_count())});
  }
  return made;
}

Vec3 center(const NodeFit& fit) {
  return {static_cast<double>(fit.x_m), static_cast<double>(fit.y_m), static_cast<double>(fit.z_m)};
}

// The sums by their definition, in double precision and with the standard exponential.
FittedSums defined_sums(const PairFrame& frame, std::span<const FrontEntry> front) {
  FittedSums sums;
  for (const FrontEntry entry : front) {
    const NodeFit& a = frame.a->tree.fit[entry.a];
    NodeFit b;
    Vec3 way = -frame.plane_normal;
    double distance = frame.plane_normal.dot(center(a)) - frame.plane_height_m;
    if (!frame.with_plane()) {
      b = frame.b->tree.fit[entry.b];
      way = frame.rotation * center(b) + frame.offset_m - center(a);
      distance = way.norm();
      way /= distance;
    }
    const auto radius_a = static_cast<double>(a.radius_m);
    const auto radius_b = static_cast<double>(b.radius_m);
    const double gap = distance - radius_a - radius_b;
    const double w = std::exp(std::clamp(-(gap - frame.expected_gap_m) / frame.width_m, -16.0, 6.0));
    const double sharp = std::pow(std::max(w, std::exp(-10.0)), 8);
    sums.direction += w * way;
    sums.point_m += sharp * (center(a) + 0.5 * (distance + radius_a - radius_b) * way);
    sums.weight += sharp;
    sums.fitted_m = std::min(sums.fitted_m, gap);
    sums.cores_m = std::min(sums.cores_m, distance - static_cast<double>(a.core_m) - static_cast<double>(b.core_m));
  }
  return sums;
}

void expect_near(const FittedSums& sums, const FittedSums& wanted) {
  // A weight is accurate to a thousandth, its eighth power to eight thousandths.
  EXPECT_LT((sums.direction - wanted.direction).norm(), 2e-3 * wanted.direction.norm() + 1e-6);
  EXPECT_NEAR(sums.weight, wanted.weight, 1e-2 * wanted.weight);
  EXPECT_LT((sums.point_m / sums.weight - wanted.point_m / wanted.weight).norm(), 5e-3);
  EXPECT_NEAR(sums.fitted_m, wanted.fitted_m, 1e-6);
  EXPECT_NEAR(sums.cores_m, wanted.cores_m, 1e-6);
}

TEST(FittedSums, AreWhatTheirDefinitionSaysForTreesAndPlanes) {
  std::mt19937_64 random(1);
  for (const bool plane : {false, true}) {
    for (const std::size_t count : {1U, 2U, 7U, 8U, 9U, 40U}) {
      const Contacts contacts = random_contacts(count, random, plane);
      FittedSums sums;
      add_fitted(contacts.frame, contacts.front, sums);
      expect_near(sums, defined_sums(contacts.frame, contacts.front));
    }
  }
}

TEST(FittedSums, OfPartsAddUp) {
  std::mt19937_64 random(2);
  const Contacts contacts = random_contacts(29, random);
  const std::span<const FrontEntry> front(contacts.front);
  FittedSums parts;
  add_fitted(contacts.frame, front.first(5), parts);
  add_fitted(contacts.frame, front.subspan(5, 0), parts);
  add_fitted(contacts.frame, front.subspan(5), parts);
  expect_near(parts, defined_sums(contacts.frame, front));
}

TEST(FittedSums, HaveTheSameBitsOnEveryInstructionSet) {
  std::mt19937_64 random(3);
  for (const bool plane : {false, true}) {
    const Contacts contacts = random_contacts(37, random, plane);
    std::vector<FittedSums> all;
    const int sets = on_every_instruction_set([&] {
      FittedSums sums;
      add_fitted(contacts.frame, contacts.front, sums);
      all.push_back(sums);
    });
    EXPECT_GT(sets, 1);
    for (const FittedSums& sums : all) {
      EXPECT_EQ(sums.direction, all[0].direction);
      EXPECT_EQ(sums.point_m, all[0].point_m);
      const auto rest = [](const FittedSums& of) { return std::array<double, 3>{of.weight, of.fitted_m, of.cores_m}; };
      EXPECT_EQ(rest(sums), rest(all[0]));
    }
  }
}

PairContact answer(const PairFrame& frame, std::span<const FrontEntry> front) {
  ContactSums sums;
  add_to_sums(frame, front, sums);
  PairContact contact;
  make_contact(frame, sums, Mat3::Identity(), contact);
  return contact;
}

PairFrame balls(double radius_a_m, double radius_b_m, const Vec3& between_m, std::array<ShapePtr, 2>& shapes) {
  shapes = {make_sphere_shape(radius_a_m).value(), make_sphere_shape(radius_b_m).value()};
  PairFrame frame = make_pair_frame(*shapes[0], {}, *shapes[1], {between_m, Mat3::Identity()}, 0.1, 0.001);
  frame.fitted = true;
  return frame;
}

TEST(FittedContact, OfTwoBallsIsTheirOwn) {
  std::array<ShapePtr, 2> shapes;
  const Vec3 way = Vec3(2, -3, 6) / 7;
  const PairFrame frame = balls(0.5, 0.25, 0.74 * way, shapes);
  const FrontEntry entry{0, 0};
  const PairContact contact = answer(frame, {&entry, 1});
  ASSERT_TRUE(contact.present);
  EXPECT_LT((contact.direction - way).norm(), 1e-6);
  EXPECT_LT((contact.arm_m - 0.495 * way).norm(), 1e-6);
  EXPECT_NEAR(contact.estimated_separation_m, -0.01, 1e-6);
  EXPECT_NEAR(contact.certain_separation_m, -0.01, 1e-6);
}

TEST(FittedContact, OfCoincidingBallsHasADirection) {
  std::array<ShapePtr, 2> shapes;
  const PairFrame frame = balls(0.5, 0.25, Vec3::Zero(), shapes);
  const FrontEntry entry{0, 0};
  const PairContact contact = answer(frame, {&entry, 1});
  ASSERT_TRUE(contact.present);
  EXPECT_EQ(contact.direction, Vec3::UnitZ());
  EXPECT_TRUE(contact.moment_a_m.allFinite() && contact.moment_b_m.allFinite());
  EXPECT_NEAR(contact.certain_separation_m, -0.75, 1e-6);
}

TEST(FittedContact, ANodeWithoutSurfaceKeepsStillBesideOneThatHasSome) {
  std::mt19937_64 random(4);
  Contacts contacts = random_contacts(1, random);
  const PairContact alone = answer(contacts.frame, contacts.front);
  Shape changed = *contacts.a;
  const NodeIndex other = contacts.front[0].a == 0 ? 1 : 0;
  changed.tree.fit[other].radius_m = -100;
  contacts.frame.a = &changed;
  contacts.front.push_back({other, contacts.front[0].b});
  const PairContact both = answer(contacts.frame, contacts.front);
  EXPECT_LT((both.direction - alone.direction).norm(), 0.05);
  EXPECT_LT((both.arm_m - alone.arm_m).norm(), 1e-3);
  EXPECT_EQ(both.estimated_separation_m, alone.estimated_separation_m);
}

}  // namespace
}  // namespace poise::collision
