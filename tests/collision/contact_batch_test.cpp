// SPDX-License-Identifier: MIT
#include "collision/manifold/contact_batch.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collision/instruction_sets.h"
#include "collision/manifold/contact_sums.h"
#include "collision/shapes.h"

namespace poise::collision {
namespace {

std::vector<FrontEntry> random_front(const PairFrame& frame, std::size_t count, std::mt19937_64& random) {
  std::vector<FrontEntry> front;
  for (std::size_t i = 0; i < count; ++i) {
    front.push_back({static_cast<NodeIndex>(random() % frame.a->tree.node_count()),
                     static_cast<NodeIndex>(random() % frame.b->tree.node_count())});
  }
  return front;
}

Vec3 at(const ContactBatch::Vectors& v, std::size_t k) { return {v.x[k], v.y[k], v.z[k]}; }

void expect_same_bits(const PairFrame& frame, std::span<const FrontEntry> front) {
  ContactBatch batch;
  set_contacts(frame, front, batch);
  ASSERT_EQ(batch.count, front.size());
  for (std::size_t k = 0; k < front.size(); ++k) {
    const SphereContact contact = sphere_contact(frame, front[k]);
    ASSERT_EQ(at(batch.normal, k), contact.normal);
    ASSERT_EQ(at(batch.point_m, k), contact.point_m);
    ASSERT_EQ(batch.gap_m[k], contact.gap_m);
    const auto of = [&](const std::vector<float>& a, const std::vector<float>& b) {
      return static_cast<double>(a[front[k].a]) + static_cast<double>(b[front[k].b]);
    };
    ASSERT_EQ(batch.expected_m[k], of(frame.a->tree.protrusion_mean_m, frame.b->tree.protrusion_mean_m));
    ASSERT_EQ(batch.certain_m[k], of(frame.a->tree.protrusion_max_m, frame.b->tree.protrusion_max_m));
  }
}

// The sums by their definition, one entry at a time and in order.
ContactSums plain_sums(const PairFrame& frame, std::span<const FrontEntry> front) {
  ContactSums sums;
  for (const FrontEntry entry : front) {
    const SphereContact contact = sphere_contact(frame, entry);
    if (contact.gap_m >= frame.margin_m) continue;
    const auto note = [&](double gap, double& least) { least = std::min(least, gap); };
    const SphereTree& a = frame.a->tree;
    const SphereTree& b = frame.b->tree;
    note(contact.gap_m, sums.spheres_m);
    note(contact.gap_m +
             (static_cast<double>(a.protrusion_mean_m[entry.a]) + static_cast<double>(b.protrusion_mean_m[entry.b])),
         sums.estimated_separation_m);
    note(contact.gap_m +
             (static_cast<double>(a.protrusion_max_m[entry.a]) + static_cast<double>(b.protrusion_max_m[entry.b])),
         sums.certain_separation_m);
    const auto add = [&](double weight, WrenchSum& sum) {
      const Vec3 normal = weight * contact.normal;
      sum.weight_m += weight;
      sum.direction += normal;
      sum.moment_m2 += contact.point_m.cross(normal);
      sum.place_m2 += weight * contact.point_m;
    };
    if (contact.gap_m < frame.skin_m) add(frame.skin_m - contact.gap_m, sums.touching);
    if (sums.touching.weight_m == 0) add(frame.margin_m - contact.gap_m, sums.near);
  }
  return sums;
}

void expect_same_sum(const WrenchSum& found, const WrenchSum& expected) {
  ASSERT_EQ(found.weight_m, expected.weight_m);
  ASSERT_EQ(found.direction, expected.direction);
  ASSERT_EQ(found.moment_m2, expected.moment_m2);
  ASSERT_EQ(found.place_m2, expected.place_m2);
}

TEST(ContactBatch, EveryInstructionSetGivesTheBitsOfOneEntryAtATime) {
  const ShapePtr worm = make_worm(200);
  const int sets = on_every_instruction_set([&] {
    std::mt19937_64 random(31);
    for (int round = 0; round < 300; ++round) {
      const PairFrame frame = make_pair_frame(*worm, random_pose(random, 2), *worm, random_pose(random, 2), 0.05, 0.01);
      ASSERT_NO_FATAL_FAILURE(
          expect_same_bits(frame, random_front(frame, 1 + random() % ContactBatch::kEntries, random)));
    }
  });
  EXPECT_GE(sets, 1);
}

TEST(ContactBatch, CoincidingCentresAmongOthersTakeTheirDefinedNormal) {
  const ShapePtr worm = make_worm(50);
  const Pose pose;
  const PairFrame frame = make_pair_frame(*worm, pose, *worm, pose, 0.05, 0.01);
  std::vector<FrontEntry> front;
  for (NodeIndex node = 0; node < 20; ++node) front.push_back({node, node % 3 == 0 ? node : node + 1});
  on_every_instruction_set([&] { expect_same_bits(frame, front); });
}

TEST(ContactBatch, SumsOfAnyLengthHaveTheBitsOfTheirDefinition) {
  // Skins below, at and above the margin; fronts whose first contacts are near and whose later ones touch.
  const ShapePtr worm = make_worm(200);
  int both = 0;
  on_every_instruction_set([&] {
    std::mt19937_64 random(32);
    for (int round = 0; round < 300; ++round) {
      const double margin = uniform(random, 0, 1);
      const PairFrame frame = make_pair_frame(*worm, random_pose(random, 1), *worm, random_pose(random, 1), margin,
                                              uniform(random, -0.5, 1.5) * margin);
      const auto front = random_front(frame, 1 + random() % 100, random);
      const ContactSums expected = plain_sums(frame, front);
      ContactSums whole;
      add_to_sums(frame, front, whole);
      ContactSums pieces;
      const std::size_t cut = random() % front.size();
      add_to_sums(frame, std::span(front).first(cut), pieces);
      add_to_sums(frame, std::span(front).subspan(cut), pieces);
      for (const ContactSums* found : {&whole, &pieces}) {
        ASSERT_NO_FATAL_FAILURE(expect_same_sum(found->touching, expected.touching));
        ASSERT_NO_FATAL_FAILURE(expect_same_sum(found->near, expected.near));
        ASSERT_EQ(found->spheres_m, expected.spheres_m);
        ASSERT_EQ(found->estimated_separation_m, expected.estimated_separation_m);
        ASSERT_EQ(found->certain_separation_m, expected.certain_separation_m);
      }
      if (expected.touching.weight_m > 0 && expected.near.weight_m > 0) ++both;
    }
  });
  EXPECT_GT(both, 50);
}

}  // namespace
}  // namespace poise::collision
