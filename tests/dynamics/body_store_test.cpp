// SPDX-License-Identifier: MIT
#include "dynamics/body_store.h"

#include <gtest/gtest.h>

#include "dynamics/conserved.h"

namespace poise::dynamics {
namespace {

std::uint32_t add_ball(BodyStore& bodies, double radius_m, double mass_kg) {
  const std::uint32_t slot = bodies.add().slot;
  bodies.shape[slot] = make_sphere_shape(radius_m).value();
  bodies.make_dynamic(slot);
  bodies.mass_kg[slot] = mass_kg;
  bodies.inverse_mass[slot] = 1 / mass_kg;
  bodies.principal_kgm2[slot] = Vec3::Constant(0.4 * mass_kg * radius_m * radius_m);
  return slot;
}

TEST(BodyStore, AStaleHandleIsNotFollowedWhenItsSlotIsUsedAgain) {
  BodyStore bodies;
  const BodyId first = bodies.add();
  const BodyId second = bodies.add();
  bodies.remove(first.slot);
  EXPECT_FALSE(bodies.contains(first));
  const BodyId third = bodies.add();
  EXPECT_EQ(third.slot, first.slot);
  EXPECT_FALSE(bodies.contains(first));
  EXPECT_TRUE(bodies.contains(third));
  EXPECT_TRUE(bodies.contains(second));
  EXPECT_EQ(bodies.alive_count(), 2U);
}

TEST(BodyStore, FreeSlotsAreUsedLowestFirst) {
  BodyStore bodies;
  for (int i = 0; i < 5; ++i) bodies.add();
  for (const std::uint32_t slot : {3U, 1U, 4U}) bodies.remove(slot);
  EXPECT_EQ(bodies.add().slot, 1U);
  EXPECT_EQ(bodies.add().slot, 3U);
  EXPECT_EQ(bodies.add().slot, 4U);
  EXPECT_EQ(bodies.add().slot, 5U);
}

TEST(BodyStore, ARemovedBodyLeavesNoMotionBehind) {
  BodyStore bodies;
  const std::uint32_t slot = add_ball(bodies, 0.5, 2);
  bodies.set_velocity(slot, Vec3(1, 2, 3));
  bodies.remove(slot);
  EXPECT_EQ(bodies.dynamic_count(), 0U);
  EXPECT_TRUE(bodies.velocity(slot).isZero(0));
  EXPECT_TRUE(conserved_sums(bodies, Vec3(0, 0, -9.81), 0, bodies.slot_count()).momentum_ns.isZero(0));
}

TEST(Conserved, SumsOneBodyInClosedForm) {
  BodyStore bodies;
  const std::uint32_t slot = add_ball(bodies, 0.5, 2);
  bodies.set_position(slot, Vec3(1, 0, 3));
  bodies.set_velocity(slot, Vec3(0, 4, 0));
  bodies.set_spin(slot, Vec3(0, 0, 5));
  const Conserved sums = conserved_sums(bodies, Vec3(0, 0, -10), 0, bodies.slot_count());
  EXPECT_TRUE(sums.momentum_ns.isApprox(Vec3(0, 8, 0)));
  // x cross p = (1, 0, 3) x (0, 8, 0) = (-24, 0, 8); I w = 0.4 * 2 * 0.25 * 5 = 1.
  EXPECT_TRUE(sums.angular_momentum_js.isApprox(Vec3(-24, 0, 9)));
  EXPECT_DOUBLE_EQ(sums.kinetic_j, 0.5 * 2 * 16 + 0.5 * 0.2 * 25);
  EXPECT_DOUBLE_EQ(sums.potential_j, 60);
}

}  // namespace
}  // namespace poise::dynamics
