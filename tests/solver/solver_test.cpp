// SPDX-License-Identifier: MIT
#include "solver/solver.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>

namespace poise::solver {
namespace {

/// A few bodies and rows, solved on one thread.
struct Bench {
  std::vector<SolverBody> bodies;
  std::vector<Mat3> inverse_inertia;
  std::vector<ContactRow> rows;
  std::vector<PointContact> points;
  Coloring coloring;
  SolveScratch scratch;
  SolveSettings settings;
  std::unique_ptr<parallel::Executor> executor = parallel::make_executor(ExecutorKind::Serial, 1);

  std::uint32_t add_body(double mass_kg, const Vec3& velocity, const Vec3& spin = Vec3::Zero()) {
    SolverBody body;
    body.velocity_mps = velocity;
    body.spin_radps = spin;
    body.inverse_mass = mass_kg > 0 ? 1 / mass_kg : 0;
    bodies.push_back(body);
    inverse_inertia.push_back(mass_kg > 0 ? Mat3(Mat3::Identity() / (0.4 * mass_kg)) : Mat3(Mat3::Zero()));
    return static_cast<std::uint32_t>(bodies.size() - 1);
  }
  ContactRow& add_row(std::uint32_t a, std::uint32_t b, const Vec3& l, const Vec3& ta, const Vec3& tb, double e) {
    ContactRow row;
    row.a = a;
    row.b = b;
    row.wrench = {l, ta, tb};
    row.restitution = e;
    EXPECT_TRUE(prepare_wrench(bodies[a].inverse_mass, inverse_inertia[a], bodies[b].inverse_mass, inverse_inertia[b],
                               row.wrench, row.turns));
    rows.push_back(row);
    return rows.back();
  }
  System system() {
    std::vector<Edge> edges;
    for (const ContactRow& row : rows) {
      edges.push_back({row.a, row.b, bodies[row.a].inverse_mass > 0, bodies[row.b].inverse_mass > 0});
    }
    coloring.color(edges, bodies.size());
    std::vector<ContactRow> ordered;
    for (const std::uint32_t i : coloring.order()) ordered.push_back(rows[i]);
    rows = ordered;
    return {bodies, rows, points, {}, inverse_inertia, coloring, scratch};
  }
  Convergence impacts() { return solve_impacts(system(), settings, *executor); }
  double energy() const {
    double sum = 0;
    for (const SolverBody& body : bodies) {
      if (body.inverse_mass == 0) continue;
      sum += 0.5 / body.inverse_mass * (body.velocity_mps.squaredNorm() + 0.4 * body.spin_radps.squaredNorm());
    }
    return sum;
  }
  Vec3 momentum() const {
    Vec3 sum = Vec3::Zero();
    for (const SolverBody& body : bodies) {
      if (body.inverse_mass > 0) sum += body.velocity_mps / body.inverse_mass;
    }
    return sum;
  }
};

TEST(Impact, TwoBallsHeadOnFollowTheClosedFormForAnyRestitution) {
  for (const double e : {0.0, 0.25, 0.7, 1.0}) {
    Bench bench;
    const auto a = bench.add_body(2, Vec3(3, 0, 0));
    const auto b = bench.add_body(5, Vec3(-1, 0, 0));
    bench.add_row(a, b, Vec3::UnitX(), Vec3::Zero(), Vec3::Zero(), e);
    bench.impacts();
    const double common = (2 * 3 + 5 * -1) / 7.0;
    EXPECT_NEAR(bench.bodies[a].velocity_mps.x(), common - e * 5 * 4 / 7.0, 1e-14);
    EXPECT_NEAR(bench.bodies[b].velocity_mps.x(), common + e * 2 * 4 / 7.0, 1e-14);
  }
}

TEST(Impact, FiveBallsInARowPassTheMotionOn) {
  Bench bench;
  for (int i = 0; i < 5; ++i) bench.add_body(1, Vec3(i == 0 ? 1 : 0, 0, 0));
  for (std::uint32_t i = 0; i < 4; ++i) bench.add_row(i, i + 1, Vec3::UnitX(), Vec3::Zero(), Vec3::Zero(), 1);
  bench.impacts();
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(bench.bodies[i].velocity_mps.x(), i == 4 ? 1 : 0, 1e-9);
}

// Balls that fly at one in their middle, each along its own line: more rows of a body than there are colours, so that
// most are looked at side by side and answered one after another.
Bench swarm(double hub_kg, double restitution, int threads) {
  constexpr int kBalls = 300;
  Bench bench;
  bench.executor = parallel::make_executor(ExecutorKind::Threads, threads);
  const auto hub = bench.add_body(hub_kg, Vec3::Zero());
  for (int i = 0; i < kBalls; ++i) {
    const double height = 1 - (2.0 * i + 1) / kBalls;
    const double angle = 2.4 * i;
    const double across = std::sqrt(1 - height * height);
    const Vec3 out(across * std::cos(angle), across * std::sin(angle), height);
    const auto ball = bench.add_body(1, -(1 + 0.01 * i) * out);
    bench.add_row(hub, ball, out, Vec3::Zero(), Vec3::Zero(), restitution);
  }
  bench.impacts();
  return bench;
}

TEST(Impact, OfMoreRowsThanThereAreColoursReboundsEachByItself) {
  for (const double e : {0.0, 0.5, 1.0}) {
    const Bench bench = swarm(1e9, e, 1);
    ASSERT_LT(bench.coloring.shared_begin(), bench.rows.size() / 2) << "most rows have no colour of their own";
    for (const ContactRow& row : bench.rows) {
      const std::uint32_t i = row.b - 1;
      EXPECT_NEAR(row.wrench.direction.dot(bench.bodies[row.b].velocity_mps), e * (1 + 0.01 * i), 1e-5)
          << e << ' ' << i;
    }
  }
}

TEST(Impact, OfMoreRowsThanThereAreColoursKeepsMomentumAndAddsNoEnergy) {
  for (const double hub_kg : {0.1, 1.0, 500.0}) {
    for (const double e : {0.0, 0.5, 1.0}) {
      Vec3 momentum = Vec3::Zero();
      double energy_j = 0;
      for (int i = 0; i < 300; ++i) energy_j += 0.5 * (1 + 0.01 * i) * (1 + 0.01 * i);
      const Bench one = swarm(hub_kg, e, 1);
      for (const ContactRow& row : one.rows) momentum -= (1 + 0.01 * (row.b - 1)) * row.wrench.direction;
      EXPECT_LT((one.momentum() - momentum).norm(), 1e-10) << hub_kg << ' ' << e;
      EXPECT_LE(one.energy(), energy_j * (1 + 1e-12)) << hub_kg << ' ' << e;
      const Bench three = swarm(hub_kg, e, 3);
      for (std::size_t i = 0; i < one.bodies.size(); ++i)
        ASSERT_EQ(one.bodies[i].velocity_mps, three.bodies[i].velocity_mps) << hub_kg << ' ' << e << ' ' << i;
    }
  }
}

RC_GTEST_PROP(Impact, AnyWrenchKeepsMomentumAndNeverAddsEnergy, ()) {
  const auto number = [] { return 1e-3 * *rc::gen::inRange(-1000, 1000); };
  const auto vector = [&] { return Vec3(number(), number(), number()); };
  Bench bench;
  const double e = *rc::gen::element(0.0, 0.5, 1.0);
  for (int i = 0; i < 6; ++i) bench.add_body(0.1 + std::abs(number()), vector(), vector());
  for (std::uint32_t i = 0; i < 6; ++i) {
    for (std::uint32_t j = i + 1; j < 6; ++j) {
      // One point for both bodies: the construction of the moments conserves angular momentum about it.
      const Vec3 l = (vector() + Vec3(0.1, 0.2, 0.3)).normalized();
      bench.add_row(i, j, l, vector(), vector(), e);
    }
  }
  const double energy = bench.energy();
  const Vec3 momentum = bench.momentum();
  bench.impacts();
  RC_ASSERT(bench.energy() <= energy * (1 + 1e-12));
  RC_ASSERT((bench.momentum() - momentum).norm() < 1e-12 * 10);
}

TEST(Impact, AnElasticWrenchKeepsEnergyToRounding) {
  Bench bench;
  const auto a = bench.add_body(2, Vec3(3, 1, 0), Vec3(0.1, 0.2, 0.3));
  const auto b = bench.add_body(5, Vec3(-1, 0, 0));
  bench.add_row(a, b, Vec3(0.6, 0.3, 0.1), Vec3(0.1, -0.2, 0.05), Vec3(-0.1, 0.3, 0.2), 1);
  const double energy = bench.energy();
  bench.impacts();
  EXPECT_NEAR(bench.energy(), energy, 1e-13 * energy);
}

TEST(Impact, APairThatSeparatesIsLeftAlone) {
  Bench bench;
  const auto a = bench.add_body(1, Vec3(-1, 0, 0));
  const auto b = bench.add_body(1, Vec3(1, 0, 0));
  bench.add_row(a, b, Vec3::UnitX(), Vec3::Zero(), Vec3::Zero(), 1).gap_m = -0.1;
  bench.impacts();
  EXPECT_EQ(bench.bodies[a].velocity_mps, Vec3(-1, 0, 0));
}

TEST(Impact, WithoutReboundAPairIsSlowedToJustTouch) {
  Bench bench;
  bench.settings.dt_s = 0.1;
  const auto a = bench.add_body(1, Vec3(4, 0, 0));
  const auto b = bench.add_body(0, Vec3::Zero());
  bench.add_row(a, b, Vec3::UnitX(), Vec3::Zero(), Vec3::Zero(), 0).gap_m = 0.3;
  bench.impacts();
  EXPECT_NEAR(bench.bodies[a].velocity_mps.x(), 3.0, 1e-12);  // 0.3 m in 0.1 s
}

TEST(Impact, PointContactsAreAnsweredOneByOneEachWithItsOwnApproach) {
  // Two points of one flat contact: the first one removes all of the approach speed, the second finds none left (DO,
  // eq. 1-3).
  Bench bench;
  const auto a = bench.add_body(1, Vec3(1, 0, 0));
  const auto b = bench.add_body(0, Vec3::Zero());
  ContactRow& row = bench.add_row(a, b, Vec3::UnitX(), Vec3::Zero(), Vec3::Zero(), 0.5);
  bench.points = {{Vec3::UnitX(), Vec3(1, 0, 0), Vec3::Zero(), -0.1},
                  {Vec3::UnitX(), Vec3(1, 0, 0), Vec3::Zero(), -0.1}};
  row.points_end = 2;
  bench.impacts();
  EXPECT_NEAR(bench.bodies[a].velocity_mps.x(), -0.5, 1e-14);
  EXPECT_NEAR(bench.rows[0].point_impulse_ns.x(), 1.5, 1e-14);
}

TEST(Impact, FrictionTakesFromTheSlipAtMostItsShareOfTheImpulse) {
  // A ball that spins and falls onto the ground: the closed form of a rigid impact with Coulomb friction.
  for (const double friction : {0.0, 0.1, 10.0}) {
    Bench bench;
    const double radius = 1;
    const auto ground = bench.add_body(0, Vec3::Zero());
    const auto ball = bench.add_body(2, Vec3(0, 0, -3), Vec3(0, 4, 0));
    ContactRow& row = bench.add_row(ball, ground, -Vec3::UnitZ(), Vec3::Zero(), Vec3::Zero(), 0.5);
    row.friction = friction;
    row.arm_m = Vec3(0, 0, -radius);
    row.a_to_b_m = Vec3(0, 0, -radius);
    bench.impacts();
    // The lowest point slips at w x r = -4 m/s; stopping it takes an impulse of 2/7 of that, since I = 2/5 m r^2.
    const double gained = std::min(friction * 1.5 * 3, 4 * 2.0 / 7);
    EXPECT_NEAR(bench.bodies[ball].velocity_mps.z(), 1.5, 1e-13);
    EXPECT_NEAR(bench.bodies[ball].velocity_mps.x(), gained, 1e-13) << friction;
    EXPECT_NEAR(bench.bodies[ball].spin_radps.y(), 4 - gained / 0.4, 1e-12) << friction;
  }
}

TEST(Convergence, OfImpactsGoesOnPastTheSweepsOfAFrame) {
  // An inelastic row of thirty: each iteration passes motion on, and eight do not make the relative velocities vanish.
  const auto row = [](const Stopping& stopping, Convergence& ended) {
    Bench bench;
    bench.settings.stopping = stopping;
    for (int i = 0; i < 30; ++i) bench.add_body(1, Vec3(i == 0 ? 30 : 0, 0, 0));
    for (std::uint32_t i = 0; i < 29; ++i) bench.add_row(i, i + 1, Vec3::UnitX(), Vec3::Zero(), Vec3::Zero(), 0);
    ended = bench.impacts();
    double closing = 0;
    for (std::size_t i = 0; i + 1 < 30; ++i) {
      closing = std::max(closing, bench.bodies[i].velocity_mps.x() - bench.bodies[i + 1].velocity_mps.x());
    }
    return closing;
  };
  Convergence quick, converged;
  EXPECT_GT(row({}, quick), 1e-3);
  EXPECT_EQ(quick.iterations, kImpactIterationsOfFew);
  EXPECT_LT(row({1e-10, 100000}, converged), 1e-6);
  EXPECT_TRUE(converged.reached);
  EXPECT_GT(converged.iterations, kImpactIterationsOfFew);
}

}  // namespace
}  // namespace poise::solver
