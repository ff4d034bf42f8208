// SPDX-License-Identifier: MIT
#include "solver/contact_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "solver/contact_bench.h"

namespace poise::solver {
namespace {

TEST(Rest, SweepsEndWhereTheVisitsDoAndAsTheyDidWithAllOfThem) {
  constexpr std::uint32_t kPoints = 10 * 4;
  constexpr std::uint32_t kMixedIteration = kPoints * kMixedIterationCost;
  struct Allowed {
    std::uint32_t visits, most_a_substep;
  };
  std::uint64_t before = 0;
  double drop_before_mps = 1e300;
  for (const auto& [visits, most] :
       {Allowed{1, kPoints}, Allowed{3 * kPoints, 3 * kPoints}, Allowed{12 * kPoints, 12 * kPoints},
        Allowed{25 * kMixedIteration, 25 * kMixedIteration}}) {
    Bench bench;
    stack(bench, 10);
    bench.settings.point_iterations = visits;
    const Convergence ended = bench.solve();
    EXPECT_TRUE(ended.cut_short) << visits;
    EXPECT_LE(ended.point_iterations, std::uint64_t{most} * static_cast<std::uint64_t>(bench.settings.substeps))
        << visits;
    EXPECT_GT(ended.point_iterations, before) << visits;
    before = ended.point_iterations;
    double drop_mps = 0;
    for (const SolverBody& body : bench.bodies) drop_mps = std::max(drop_mps, body.velocity_mps.norm());
    EXPECT_LT(drop_mps, drop_before_mps) << visits << ": more visits hold it no better";
    drop_before_mps = drop_mps;
  }
  Bench whole;
  stack(whole, 10);
  EXPECT_FALSE(whole.solve().cut_short) << "nothing was kept from it";
  Bench alone;
  stack(alone, 1);
  alone.settings.point_iterations = 19 * 4;
  EXPECT_FALSE(alone.solve().cut_short) << "one box settles before";
}

TEST(Rest, APairThatIsLeftOutIsAsIfItHadNoContact) {
  Bench bench;
  bench.settings.gravity_mps2 = Vec3(0, 0, -9.81);
  const std::uint32_t floor = bench.add_body(0);
  for (const double x_m : {0.0, 10.0, 20.0}) {
    const std::uint32_t body = bench.add_body(1, Vec3(x_m, 0, 1));
    bench.add_pair(floor, body, Vec3::UnitZ(), {Vec3(x_m, 0, 0)});
  }
  const std::vector<std::uint8_t> left_out = {0, 1, 0};
  LaneMemory memory;
  ContactSystem system = bench.system();
  system.left_out = left_out;
  system.point_count = 2;
  system.memory = &memory;
  bench.solver.solve(system, bench.settings, *bench.executor);
  const double fall_mps = bench.settings.gravity_mps2.z() * bench.settings.dt_s;
  EXPECT_NEAR(bench.bodies[1].velocity_mps.z(), 0, 1e-6);
  EXPECT_NEAR(bench.bodies[2].velocity_mps.z(), fall_mps, 1e-12);
  EXPECT_NEAR(bench.bodies[3].velocity_mps.z(), 0, 1e-6);
  EXPECT_EQ(bench.applied_impulse_ns[1], Vec3(Vec3::Zero()));
  EXPECT_EQ(bench.forces[1].normal_n, 0);
  EXPECT_GT(bench.forces[0].normal_n, 9);
}

TEST(Rest, IterationsEndWithTheirTimeAndAreRepeatedWithoutAClock) {
  const auto speeds = [](const Bench& bench) {
    std::vector<double> all;
    for (const SolverBody& body : bench.bodies)
      all.insert(all.end(), body.velocity_mps.begin(), body.velocity_mps.end());
    return all;
  };
  Bench whole;
  stack(whole, 10);
  const Convergence converged = whole.solve();
  EXPECT_EQ(whole.solver.made().stopped_after, std::vector<std::uint32_t>(2, 0)) << "nothing stopped them";
  EXPECT_EQ(whole.solver.made().beyond, std::chrono::nanoseconds(0)) << "nobody asked for times";
  Bench late;
  stack(late, 10);
  late.settings.until = std::chrono::steady_clock::time_point{};
  const Convergence ended = late.solve();
  EXPECT_EQ(late.solver.made().stopped_after, std::vector<std::uint32_t>(2, 1)) << "one a substep has to be made";
  EXPECT_TRUE(ended.cut_short);
  EXPECT_EQ(ended.iterations, 2U);
  EXPECT_NE(speeds(late), speeds(whole));
  Bench again;
  stack(again, 10);
  const std::vector<std::uint32_t> stopped_after = late.solver.made().stopped_after;
  again.settings.repeated = stopped_after;
  EXPECT_EQ(again.solve().iterations, 2U);
  EXPECT_EQ(speeds(again), speeds(late));
  Bench early;
  stack(early, 10);
  early.settings.until = std::chrono::steady_clock::now() + std::chrono::hours(1);
  EXPECT_EQ(early.solve().iterations, converged.iterations);
  EXPECT_EQ(speeds(early), speeds(whole)) << "time that is not needed changes nothing";
  EXPECT_GT(early.solver.made().beyond, std::chrono::nanoseconds(0));
}

TEST(Rest, ABodyOnTheFloorStaysWhereItIs) {
  Bench bench;
  bench.settings.gravity_mps2 = Vec3(0, 0, -9.81);
  const auto floor = bench.add_body(0);
  const auto ball = bench.add_body(2, Vec3(0, 0, 1));
  bench.add_pair(floor, ball, Vec3::UnitZ(), {Vec3::Zero()});
  bench.solve();
  EXPECT_NEAR(bench.bodies[ball].velocity_mps.z(), 0, 1e-7);
  EXPECT_NEAR(bench.bodies[ball].moved_m.z(), 0, 1e-8);
  EXPECT_TRUE(bench.bodies[ball].solved);
  EXPECT_FALSE(bench.bodies[floor].solved);
  EXPECT_NEAR(bench.applied_impulse_ns[0].z(), 2 * 9.81 / 60, 1e-6);
  EXPECT_NEAR(bench.forces[0].normal_n, 2 * 9.81, 1e-4);
}

TEST(Rest, AGapClosesAndNoMore) {
  Bench bench;
  bench.settings.dt_s = 0.1;
  const auto wall = bench.add_body(0);
  const auto ball = bench.add_body(1, Vec3(1, 0, 0), Vec3(-4, 0, 0));
  bench.add_pair(wall, ball, Vec3::UnitX(), {Vec3::Zero()}, 0, 0.3);
  bench.solve();
  EXPECT_NEAR(bench.bodies[ball].moved_m.x(), -0.3, 1e-6);
}

TEST(Rest, OverlapIsPushedApartWithoutLeavingSpeedBehind) {
  Bench bench;
  const auto a = bench.add_body(1);
  const auto b = bench.add_body(1, Vec3(1, 0, 0));
  bench.add_pair(a, b, Vec3::UnitX(), {Vec3(0.5, 0, 0)}, 0, -0.1);
  bench.solve();
  EXPECT_GT(bench.bodies[b].moved_m.x() - bench.bodies[a].moved_m.x(), 1e-3);
  EXPECT_TRUE(bench.bodies[a].solved);
  EXPECT_TRUE(bench.bodies[b].velocity_mps.isZero(0));
}

TEST(Rest, WhatMayNotOverlapAtAllIsNotPushed) {
  // At a coarse level the surfaces are estimated to touch, but not certain to.
  Bench bench;
  const auto a = bench.add_body(1);
  const auto b = bench.add_body(1, Vec3(1, 0, 0));
  bench.add_pair(a, b, Vec3::UnitX(), {Vec3(0.5, 0, 0)}, 0, -0.1);
  bench.points[0].certainty_m = 0.3;
  bench.solve();
  EXPECT_TRUE(bench.bodies[a].moved_m.isZero(0));
  EXPECT_FALSE(bench.bodies[a].solved);
}

TEST(Rest, APairWithoutPlacesIsLeftAlone) {
  Bench bench;
  const auto a = bench.add_body(1, Vec3::Zero(), Vec3(5, 0, 0));
  const auto b = bench.add_body(0, Vec3(1, 0, 0));
  bench.add_pair(a, b, Vec3::UnitX(), {});
  bench.solve();
  EXPECT_EQ(bench.bodies[a].velocity_mps, Vec3(5, 0, 0));
}

TEST(Rest, FrictionStopsABodyByCoulombsLaw) {
  for (const double friction : {0.0, 0.3, 0.8}) {
    Bench bench;
    bench.settings.gravity_mps2 = Vec3(0, 0, -10);
    bench.settings.dt_s = 0.01;
    const auto floor = bench.add_body(0);
    const auto box = bench.add_body(2, Vec3(0, 0, 0.01), Vec3(1, 0.5, 0));
    const auto corners = {Vec3(1, 1, 0), Vec3(-1, 1, 0), Vec3(-1, -1, 0), Vec3(1, -1, 0)};
    bench.add_pair(floor, box, Vec3::UnitZ(), corners, friction);
    for (int step = 0; step < 10; ++step) bench.solve();
    const double speed = std::sqrt(1.25) - friction * 10 * 0.1;
    EXPECT_NEAR(bench.bodies[box].velocity_mps.norm(), speed, 0.01) << friction;
    for (int step = 0; step < 90; ++step) bench.solve();
    const double later = std::max(0.0, std::sqrt(1.25) - friction * 10 * 1.0);
    EXPECT_NEAR(bench.bodies[box].velocity_mps.norm(), later, 1e-3) << friction;
    EXPECT_NEAR(bench.bodies[box].velocity_mps.z(), 0, 1e-3);
  }
}

TEST(Rest, FrictionHoldsAgainstAPullWithinTheConeAlone) {
  for (const double pull : {0.45, 0.55}) {
    Bench bench;
    bench.settings.gravity_mps2 = Vec3(10 * pull, 0, -10);
    const auto floor = bench.add_body(0);
    const auto box = bench.add_body(3, Vec3(0, 0, 0.01));
    bench.add_pair(floor, box, Vec3::UnitZ(), {Vec3(1, 1, 0), Vec3(-1, 1, 0), Vec3(-1, -1, 0), Vec3(1, -1, 0)}, 0.5);
    for (int step = 0; step < 60; ++step) bench.solve();
    EXPECT_NEAR(bench.bodies[box].velocity_mps.x(), pull < 0.5 ? 0 : 10 * (pull - 0.5), 0.01) << pull;
  }
}

TEST(Rest, WhatIsLeftToTheImpactPhaseIsNotRubbedEither) {
  Bench bench;
  bench.settings.gravity_mps2 = Vec3(0, 0, -10);
  const auto floor = bench.add_body(0);
  const auto ball = bench.add_body(1, Vec3(0, 0, 1), Vec3(3, 0, -5));
  bench.add_pair(floor, ball, Vec3::UnitZ(), {Vec3::Zero()}, 0.5, 0.01);
  bench.pairs[0].restitution = 0.5;
  bench.solve();
  EXPECT_EQ(bench.bodies[ball].velocity_mps.x(), 3);
  EXPECT_NEAR(bench.bodies[ball].velocity_mps.z(), -5 - 10.0 / 60, 1e-12);
}

TEST(Rest, TheGroundHoldsALightBodyUnderAHeavyOneThoughIterationsAreFew) {
  Bench bench;
  bench.settings.gravity_mps2 = Vec3(0, 0, -9.81);
  bench.settings.point_iterations = 1;
  const auto ground = bench.add_body(0);
  const auto light = bench.add_body(1e-3, Vec3(0, 0, 0.5));
  const auto heavy = bench.add_body(1e3, Vec3(0, 0, 1.5));
  bench.add_pair(ground, light, Vec3::UnitZ(), {Vec3::Zero()});
  bench.add_pair(light, heavy, Vec3::UnitZ(), {Vec3(0, 0, 1)});
  bench.solve();
  EXPECT_LT(bench.bodies[heavy].velocity_mps.z(), -0.1) << "one iteration cannot carry it";
  EXPECT_GT(bench.bodies[light].velocity_mps.z(), -1e-6);
  EXPECT_GT(bench.bodies[light].moved_m.z(), -2e-4) << "2.7 mm if nothing held it";
}

// Seven bodies that move anyhow, and pairs between all of them.
Bench tangle(std::mt19937& random) {
  const auto number = [&] { return 1e-3 * (static_cast<double>(random() % 2000) - 1000); };
  const auto vector = [&] {
    const double x = number();
    const double y = number();
    return Vec3(x, y, number());
  };
  Bench bench;
  bench.settings.substeps = 1 + static_cast<int>(random() % 4);
  const double friction = random() % 2 == 0 ? 0.0 : 0.5;
  const double gap_m = 1e-3 * (static_cast<double>(random() % 3) - 1);
  for (int i = 0; i < 7; ++i) {
    const Vec3 place = vector();
    bench.add_body(0.1 + std::abs(number()), place, vector());
  }
  for (std::uint32_t i = 0; i < 7; ++i) {
    for (std::uint32_t j = i + 1; j < 7; ++j) {
      std::vector<Vec3> points;
      for (auto k = 1 + random() % 4; k > 0; --k) points.push_back(vector());
      bench.add_pair(i, j, (vector() + Vec3(0.1, 0.2, 0.3)).normalized(), points, friction, gap_m);
    }
  }
  return bench;
}

TEST(Rest, AnyPlacesKeepMomentumAndAngularMomentumAndAddNoEnergy) {
  constexpr int kTangles = 400;
  int changed = 0;
  std::mt19937 random(5);
  for (int i = 0; i < kTangles; ++i) {
    Bench bench = tangle(random);
    const Vec3 momentum = bench.momentum();
    const Vec3 angular = bench.angular_momentum();
    const double energy_j = bench.energy_j();
    bench.solve();
    EXPECT_LT((bench.momentum() - momentum).norm(), 1e-11) << i;
    EXPECT_LT(bench.energy_j(), energy_j * (1 + 1e-12)) << i;
    const double change = (bench.angular_momentum() - angular).norm();
    EXPECT_LT(change, 0.02) << i;
    changed += change > 1e-9 ? 1 : 0;
  }
  // Where it could not be returned without adding energy. Without returning it, all of them change.
  EXPECT_LE(changed, kTangles / 50);
}

// A layer of balls on the ground, each touching its neighbours: more pairs than lanes, with different numbers of
// contact points.
Bench layer(int threads) {
  Bench bench;
  bench.executor = parallel::make_executor(ExecutorKind::Threads, threads);
  bench.settings.gravity_mps2 = Vec3(0.3, 0.2, -9.81);
  const auto ground = bench.add_body(0);
  for (int i = 0; i < 40; ++i) {
    const double x = i % 7;
    const double y = static_cast<double>(i / 7);
    const auto ball = bench.add_body(1 + 0.1 * i, Vec3(x, y, 0.5), Vec3(0.1 * (i % 3), 0.05 * (i % 5), 0));
    std::vector<Vec3> feet;
    for (int k = 0; k <= i % 4; ++k) feet.emplace_back(x + 0.1 * (k % 2), y + 0.1 * (k / 2), 0);
    bench.add_pair(ground, ball, Vec3::UnitZ(), feet, i % 2 == 0 ? 0.4 : 0.0, -1e-3 * (i % 3));
    if (i % 7 > 0) bench.add_pair(ball - 1, ball, Vec3::UnitX(), {Vec3(x - 0.5, y, 0.5)}, 0.2, 1e-3);
    if (i >= 7) bench.add_pair(ball - 7, ball, Vec3::UnitY(), {Vec3(x, y - 0.5, 0.5)}, 0, -2e-3);
  }
  for (int step = 0; step < 3; ++step) bench.solve();
  return bench;
}

TEST(Rest, ThreadsDoNotShow) {
  const Bench one = layer(1);
  for (const int threads : {2, 4}) {
    const Bench many = layer(threads);
    for (std::size_t i = 0; i < one.bodies.size(); ++i) {
      ASSERT_EQ(one.bodies[i].velocity_mps, many.bodies[i].velocity_mps);
      ASSERT_EQ(one.bodies[i].moved_m, many.bodies[i].moved_m);
      ASSERT_EQ(one.bodies[i].turned_rad, many.bodies[i].turned_rad);
    }
  }
}

// A plate on balls of like mass on the ground: more pairs of the plate than there are colours, and so few points that
// iterations are extrapolated in double precision unless bodies collide, which one plain iteration finds out.
Bench plate(double falls_mps) {
  constexpr int kSide = 13;
  Bench bench;
  bench.settings.gravity_mps2 = Vec3(0, 0, -9.81);
  const auto ground = bench.add_body(0);
  const auto top = bench.add_body(3, Vec3(0, 0, 1.2), Vec3(0, 0, -falls_mps));
  bench.inverse_inertia[top] = Mat3::Identity() / 40;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double x = i % kSide - 0.5 * (kSide - 1);
    const double y = static_cast<double>(i / kSide) - 0.5 * (kSide - 1);
    const auto ball = bench.add_body(1, Vec3(x, y, 0.5), Vec3(0, 0, -falls_mps));
    bench.add_pair(ground, ball, Vec3::UnitZ(), {Vec3(x, y, 0)}, 0.5);
    bench.add_pair(ball, top, Vec3::UnitZ(), {Vec3(x, y, 1)}, 0.5);
  }
  return bench;
}

// What it did, a step.
std::vector<Convergence> three_steps(Bench& bench, ContactSolver& solver) {
  std::vector<Convergence> made;
  for (int step = 0; step < 3; ++step) made.push_back(solver.solve(bench.system(), bench.settings, *bench.executor));
  return made;
}

// A solver keeps its lanes from step to step, of two precisions in the same memory, and abandons an attempt in single
// precision where nothing collides.
TEST(Rest, WhatASolverDidBeforeDoesNotShow) {
  const std::vector<std::function<Bench()>> scenes = {[] { return plate(0); }, [] { return layer(1); },
                                                      [] { return plate(3); },
                                                      [] {
                                                        Bench boxes;
                                                        stack(boxes, 30);
                                                        return boxes;
                                                      },
                                                      [] { return plate(0); }};
  ContactSolver used;
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    Bench after_others = scenes[k]();
    Bench by_itself = scenes[k]();
    ContactSolver fresh;
    const std::vector<Convergence> with_used = three_steps(after_others, used);
    const std::vector<Convergence> with_fresh = three_steps(by_itself, fresh);
    for (std::size_t step = 0; step < with_used.size(); ++step) {
      EXPECT_EQ(with_used[step].point_iterations, with_fresh[step].point_iterations) << k;
      EXPECT_EQ(with_used[step].reached, with_fresh[step].reached) << k;
    }
    for (std::size_t i = 0; i < by_itself.bodies.size(); ++i) {
      ASSERT_EQ(after_others.bodies[i].velocity_mps, by_itself.bodies[i].velocity_mps) << k << ' ' << i;
      ASSERT_EQ(after_others.bodies[i].spin_radps, by_itself.bodies[i].spin_radps) << k << ' ' << i;
      ASSERT_EQ(after_others.bodies[i].moved_m, by_itself.bodies[i].moved_m) << k << ' ' << i;
    }
    for (std::size_t p = 0; p < by_itself.forces.size(); ++p) {
      ASSERT_EQ(after_others.forces[p].normal_n, by_itself.forces[p].normal_n) << k << ' ' << p;
      ASSERT_EQ(after_others.forces[p].friction_n, by_itself.forces[p].friction_n) << k << ' ' << p;
    }
  }
}

// Nothing of an attempt that is abandoned is left in the bodies: what stands still stands, as with the attempt's result
// it would not, and what collides is answered by the attempt alone.
TEST(Rest, AnAttemptInSinglePrecisionIsAbandonedWhereNothingCollides) {
  Bench still = plate(0);
  const Convergence rests = still.solve();
  ASSERT_EQ(still.coloring.shared().size(), 1U);
  const std::uint64_t points = still.points.size();
  EXPECT_EQ(rests.point_iterations, kMixedIterationCost * points * rests.iterations) << "in double precision";
  for (int step = 0; step < 20; ++step) still.solve();
  for (const SolverBody& body : still.bodies) EXPECT_LT(body.velocity_mps.norm(), 1e-4);
  Bench falling = plate(3);
  const Convergence collides = falling.solve();
  EXPECT_EQ(collides.point_iterations, points * collides.iterations) << "plain ones";
}

// A column of equal bodies at rest on the ground: the impulse below body k carries all bodies above.
Bench column(std::uint32_t count) {
  Bench bench;
  bench.settings.dt_s = 0.01;
  bench.settings.gravity_mps2 = Vec3(0, 0, -10);
  bench.settings.substeps = 1;
  auto below = bench.add_body(0);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto body = bench.add_body(2, Vec3(0, 0, i + 0.5));
    bench.add_pair(below, body, Vec3::UnitZ(), {Vec3(0, 0, i)});
    below = body;
  }
  return bench;
}

TEST(Convergence, CarriesAColumnWithTheWeightAboveEachContact) {
  Bench bench = column(15);
  bench.settings.stopping = {1e-10, 100000};
  const Convergence ended = bench.solve();
  EXPECT_TRUE(ended.reached);
  EXPECT_GT(ended.iterations, 50U);
  for (std::size_t i = 0; i < 15; ++i)
    EXPECT_NEAR(bench.applied_impulse_ns[i].z(), 2 * 10 * 0.01 * (15.0 - static_cast<double>(i)), 1e-6) << i;
  for (const SolverBody& body : bench.bodies) EXPECT_NEAR(body.velocity_mps.z(), 0, 1e-7);
}

TEST(Convergence, OfASmallSceneNeedsNoAsking) {
  Bench bench = column(10);
  for (int step = 0; step < 10; ++step) bench.solve();
  for (std::size_t i = 0; i < 10; ++i)
    EXPECT_NEAR(bench.applied_impulse_ns[i].z(), 2 * 10 * 0.01 * (10.0 - static_cast<double>(i)), 1e-3) << i;
}

TEST(Convergence, OfALargeSceneComesWithTheStepsThatWarmStartEachOther) {
  Bench bench;
  bench.settings.dt_s = 0.01;
  bench.settings.gravity_mps2 = Vec3(0, 0, -10);
  const auto ground = bench.add_body(0);
  for (int stack = 0; stack < 20000; ++stack) {
    const auto lower = bench.add_body(2, Vec3(stack, 0, 0.5));
    const auto upper = bench.add_body(2, Vec3(stack, 0, 1.5));
    bench.add_pair(ground, lower, Vec3::UnitZ(), {Vec3(stack, 0, 0)});
    bench.add_pair(lower, upper, Vec3::UnitZ(), {Vec3(stack, 0, 1)});
  }
  Convergence ended;
  for (int step = 0; step < 20; ++step) ended = bench.solve();
  EXPECT_EQ(ended.iterations, 2U) << "one a substep";
  EXPECT_NEAR(bench.applied_impulse_ns.front().z(), 2 * 2 * 10 * 0.01, 1e-4);
  EXPECT_NEAR(bench.applied_impulse_ns.back().z(), 2 * 10 * 0.01, 1e-4);
}

TEST(Convergence, IsDeniedWhereSweepsWereCutOff) {
  Bench bench = column(15);
  bench.settings.stopping = {1e-10, 20};
  const Convergence ended = bench.solve();
  EXPECT_FALSE(ended.reached);
  EXPECT_EQ(ended.iterations, 20U);
}

}  // namespace
}  // namespace poise::solver
