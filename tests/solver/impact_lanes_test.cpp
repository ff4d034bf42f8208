// SPDX-License-Identifier: MIT
#include "solver/impacts/impact_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "collision/instruction_sets.h"

namespace poise::solver {
namespace {

// Pairs of bodies that share at most the ground, body 0, and a row of each: of all kinds of closing, gaps, restitution
// and friction.
struct Pairs {
  std::vector<SolverBody> bodies;
  std::vector<Mat3> inverse_inertia;
  std::vector<ContactRow> rows;

  explicit Pairs(std::size_t count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> number(-1, 1);
    const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
    const auto add_body = [&] {
      SolverBody body;
      body.velocity_mps = 3 * vector();
      body.spin_radps = vector();
      body.inverse_mass = 1.5 + number(random);
      bodies.push_back(body);
      const Mat3 root = Mat3::Identity() + 0.3 * Mat3(vector() * vector().transpose());
      inverse_inertia.push_back(root * root.transpose());
      return static_cast<std::uint32_t>(bodies.size() - 1);
    };
    bodies.emplace_back();
    inverse_inertia.push_back(Mat3::Zero());
    for (std::size_t i = 0; i < count; ++i) {
      ContactRow row;
      row.a = add_body();
      row.b = i % 3 == 0 ? 0 : add_body();
      row.arm_m = vector();
      row.a_to_b_m = vector();
      const Vec3 direction = i % 5 == 0 ? Vec3(0.7 * vector().normalized()) : vector().normalized();
      row.wrench = {direction, row.arm_m.cross(direction), (row.arm_m - row.a_to_b_m).cross(direction)};
      row.gap_m = i % 2 == 0 ? -0.01 : 0.03 * (1 + number(random));
      row.restitution = i % 4 == 0 ? 0 : 0.5 * (1 + number(random));
      row.friction = i % 7 == 0 ? 0 : 0.5 * (1 + number(random));
      EXPECT_TRUE(prepare_wrench(bodies[row.a].inverse_mass, inverse_inertia[row.a], bodies[row.b].inverse_mass,
                                 inverse_inertia[row.b], row.wrench, row.turns));
      rows.push_back(row);
    }
  }
  ImpactLanes lanes() { return {rows.data(), nullptr, bodies.data(), inverse_inertia.data(), 1.0 / 60, 0.1}; }
  // Looks at rows from `begin` to `end`, and gives what they need.
  ImpactBatch answer(std::size_t begin, std::size_t end) {
    ImpactBatch batch;
    for (std::size_t i = begin; i < end; ++i) batch.add(static_cast<std::uint32_t>(i), rows[i].a, rows[i].b);
    look_at_rows(lanes(), batch);
    give_impulses(lanes(), batch);
    return batch;
  }
};

// What one row needs, as docs/method.md says it.
double needed_ns(const ContactRow& row, double closing_mps, const ImpactLanes& terms) {
  if (closing_mps <= terms.still_mps) return 0;
  const bool rebounds = row.restitution * closing_mps > terms.still_mps;
  if (row.gap_m <= 0.5 * closing_mps * terms.dt_s)
    return (1 + (rebounds ? row.restitution : 0)) * closing_mps * row.wrench.effective_mass;
  if (rebounds || closing_mps * terms.dt_s <= row.gap_m) return 0;
  return (closing_mps - row.gap_m / terms.dt_s) * row.wrench.effective_mass;
}

TEST(ImpactLanes, GiveWhatTheFormulasSay) {
  Pairs pairs(64);
  const Pairs before = pairs;
  const ImpactBatch batch = pairs.answer(0, 64);
  int given = 0;
  for (std::size_t i = 0; i < 64; ++i) {
    const ContactRow& row = before.rows[i];
    SolverBody a = before.bodies[row.a];
    SolverBody b = before.bodies[row.b];
    const double closing = approach_mps(row.wrench, a, b);
    const double lambda = needed_ns(row, closing, pairs.lanes());
    EXPECT_DOUBLE_EQ(batch.lambda_ns[i], lambda) << i;
    EXPECT_EQ(batch.needs >> i & 1U, lambda > 0 ? 1U : 0U) << i;
    EXPECT_EQ(batch.rebounds >> i & 1U, row.restitution * closing > pairs.lanes().still_mps ? 1U : 0U) << i;
    if (lambda > 0) ++given;
    apply_impulse(row.wrench, row.turns, lambda, a, b);
    // Friction stops the slip across the normal at the contact point, or gives its share of the impulse.
    const Vec3 arm_b = row.arm_m - row.a_to_b_m;
    const Vec3 normal = row.wrench.direction.normalized();
    Vec3 slip = b.velocity_mps + b.spin_radps.cross(arm_b) - a.velocity_mps - a.spin_radps.cross(row.arm_m);
    slip -= slip.dot(normal) * normal;
    const Vec3 along = -slip.normalized();
    Wrench across{along, row.arm_m.cross(along), arm_b.cross(along)};
    Turns turns;
    ASSERT_TRUE(prepare_wrench(a.inverse_mass, before.inverse_inertia[row.a], b.inverse_mass,
                               before.inverse_inertia[row.b], across, turns));
    const double across_ns =
        std::min(slip.norm() * across.effective_mass, row.friction * lambda * row.wrench.direction.norm());
    apply_impulse(across, turns, across_ns, a, b);
    EXPECT_LT((pairs.bodies[row.a].velocity_mps - a.velocity_mps).norm(), 1e-13) << i;
    EXPECT_LT((pairs.bodies[row.a].spin_radps - a.spin_radps).norm(), 1e-13) << i;
    EXPECT_LT((pairs.bodies[row.b].velocity_mps - b.velocity_mps).norm(), 1e-13) << i;
    EXPECT_LT((pairs.bodies[row.b].spin_radps - b.spin_radps).norm(), 1e-13) << i;
    EXPECT_LT((pairs.rows[i].point_impulse_ns - across_ns * along).norm(), 1e-13) << i;
  }
  EXPECT_GT(given, 16);
  EXPECT_LT(given, 48);
}

TEST(ImpactLanes, HaveTheSameBitsForEachRowAloneOnEveryInstructionSet) {
  Pairs alone(61);
  for (std::size_t i = 0; i < 61; ++i) alone.answer(i, i + 1);
  const int sets = collision::on_every_instruction_set([&](const char* name) {
    Pairs together(61);
    together.answer(0, 61);
    for (std::size_t i = 0; i < together.bodies.size(); ++i) {
      EXPECT_EQ(together.bodies[i].velocity_mps, alone.bodies[i].velocity_mps) << name << ' ' << i;
      EXPECT_EQ(together.bodies[i].spin_radps, alone.bodies[i].spin_radps) << name << ' ' << i;
    }
    for (std::size_t i = 0; i < 61; ++i)
      EXPECT_EQ(together.rows[i].point_impulse_ns, alone.rows[i].point_impulse_ns) << name << ' ' << i;
  });
  EXPECT_GE(sets, 1);
}

TEST(ImpactLanes, LeaveBodiesThatDoNotYieldAlone) {
  Pairs pairs(30);
  pairs.bodies[0].velocity_mps = Vec3(1, 2, 3);
  pairs.bodies[0].held = true;
  const Pairs before = pairs;
  const ImpactBatch batch = pairs.answer(0, 30);
  EXPECT_EQ(pairs.bodies[0].velocity_mps, Vec3(1, 2, 3));
  EXPECT_TRUE(pairs.bodies[0].held);
  int pushed = 0;
  for (std::size_t i = 0; i < 30; i += 3) {
    const std::uint32_t a = pairs.rows[i].a;
    EXPECT_EQ(batch.needs >> i & 1U, pairs.bodies[a].velocity_mps != before.bodies[a].velocity_mps ? 1U : 0U) << i;
    if (pairs.bodies[a].velocity_mps != before.bodies[a].velocity_mps) ++pushed;
  }
  EXPECT_GT(pushed, 0);
}

}  // namespace
}  // namespace poise::solver
