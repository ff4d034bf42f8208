// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "peers/engine.h"
#include "peers/pile_figures.h"
#include "peers/turns.h"

namespace poise::bench {
namespace {

/// One body of one ball on the floor z = 0.
PileScene ball_scene(double radius_m) {
  PileScene scene;
  scene.spheres = {{Vec3::Zero(), radius_m}};
  scene.mass_kg = 2;
  scene.inertia_kgm2 = Vec3::Constant(0.4 * scene.mass_kg * radius_m * radius_m);
  scene.walls = {{Vec3::UnitZ(), 0}};
  scene.gravity_mps2 = Vec3(0, 0, -9.81);
  scene.dt_s = 1.0 / 60;
  return scene;
}

BodyState at(const Vec3& position_m, const Vec3& velocity_mps = Vec3::Zero()) {
  BodyState state;
  state.position_m = position_m;
  state.velocity_mps = velocity_mps;
  return state;
}

std::vector<Engine> peers(const PileScene& scene) {
  return {make_bullet(scene), make_ode(scene, false), make_ode(scene, true)};
}

BodyState state_of(const Engine& engine) {
  BodyState state;
  engine.read_states({&state, 1});
  return state;
}

TEST(Peers, GoOnFromTheStateTheyAreSetTo) {
  for (const Engine& engine : peers([] {
         PileScene scene = ball_scene(0.5);
         scene.start = {at({0, 0, 3})};
         return scene;
       }())) {
    engine.step();
    BodyState wanted = at({1, -2, 7}, {0.5, 0.25, -1});
    wanted.angular_velocity_radps = {1, 2, 3};
    wanted.orientation = Quat(0.5, 0.5, -0.5, 0.5);
    engine.set_states({&wanted, 1});
    const BodyState set = state_of(engine);
    EXPECT_LT((set.position_m - wanted.position_m).norm(), 1e-6) << engine.name;
    EXPECT_LT(set.orientation.angularDistance(wanted.orientation), 1e-5) << engine.name;
    EXPECT_LT((set.angular_velocity_radps - wanted.angular_velocity_radps).norm(), 1e-6) << engine.name;
    engine.step();
    const Vec3 velocity = wanted.velocity_mps + Vec3(0, 0, -9.81 / 60);
    EXPECT_LT((state_of(engine).velocity_mps - velocity).norm(), 1e-5) << engine.name;
    EXPECT_LT((state_of(engine).position_m - wanted.position_m - velocity / 60).norm(), 1e-5) << engine.name;
  }
}

TEST(PileFigures, OverlapsOfSpheresAndWallsAreCountedOnceAndMeasured) {
  PileScene scene = ball_scene(0.5);
  scene.walls.push_back({Vec3::UnitX(), -5});
  const std::vector<BodyState> states = {at({0, 0, 0.4}, {3, 4, 0}), at({0, 0.9, 0.5}), at({3, 3, 3}),
                                         at({-5.1, -3, 2})};
  const PileFigures figures = pile_figures(scene, states);
  EXPECT_TRUE(figures.finite);
  EXPECT_EQ(figures.overlaps, 3U);  // the first ball with the floor and with the second, the last with the wall
  const double pair_m = 1 - std::hypot(0.9, 0.1);
  EXPECT_NEAR(figures.greatest_overlap_m, 0.6, 1e-12);
  EXPECT_NEAR(figures.mean_overlap_m, (0.1 + pair_m + 0.6) / 3, 1e-12);
  EXPECT_EQ(figures.outside, 1U);
  EXPECT_DOUBLE_EQ(figures.mean_speed_mps, 1.25);
  EXPECT_DOUBLE_EQ(figures.greatest_speed_mps, 5);
  EXPECT_DOUBLE_EQ(figures.mean_height_m, 5.9 / 4);
  EXPECT_FALSE(figures.holds(1));
}

TEST(PileFigures, NeighbouringCellsHideNoOverlap) {
  PileScene scene = ball_scene(0.3);
  scene.spheres.push_back({Vec3(0.5, 0, 0), 0.2});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-2, 2);
  std::vector<BodyState> states;
  for (int i = 0; i < 150; ++i) states.push_back(at({place(random), place(random), 3 + place(random)}));
  std::size_t overlaps = 0;
  double greatest_m = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      for (const Sphere& a : scene.spheres) {
        for (const Sphere& b : scene.spheres) {
          const double apart_m = (states[i].position_m + a.center_m - states[j].position_m - b.center_m).norm();
          if (apart_m < a.radius_m + b.radius_m) ++overlaps;
          greatest_m = std::max(greatest_m, a.radius_m + b.radius_m - apart_m);
        }
      }
    }
  }
  const PileFigures figures = pile_figures(scene, states);
  ASSERT_GT(overlaps, 100U);
  EXPECT_EQ(figures.overlaps, overlaps);
  EXPECT_NEAR(figures.greatest_overlap_m, greatest_m, 1e-12);
}

TEST(PileFigures, APileWithANumberThatIsNoneDoesNotHold) {
  std::vector<BodyState> states = {at({0, 0, 1}), at({0, 0, 3})};
  EXPECT_TRUE(pile_figures(ball_scene(0.5), states).holds(0));
  states[1].velocity_mps.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(pile_figures(ball_scene(0.5), states).holds(0));
}

TEST(Peers, BeginWhereTheSceneSaysAndFallAsItsGravityAndTimeStepSay) {
  PileScene scene = ball_scene(0.5);
  BodyState start = at({1, 2, 100}, {0.5, 0, 1});
  start.orientation = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  scene.start = {start};
  for (const Engine& engine : peers(scene)) {
    EXPECT_NEAR((state_of(engine).position_m - start.position_m).norm(), 0, 1e-5) << engine.name;
    EXPECT_NEAR(std::abs(state_of(engine).orientation.dot(start.orientation)), 1, 1e-6) << engine.name;
    for (int i = 0; i < 60; ++i) engine.step();
    EXPECT_NEAR(state_of(engine).velocity_mps.z(), 1 - 9.81, 1e-3) << engine.name;
    EXPECT_NEAR(state_of(engine).position_m.x(), 1.5, 1e-3) << engine.name;
    EXPECT_NEAR(state_of(engine).position_m.z(), 101 - 0.5 * 9.81 * 61 / 60, 1e-2) << engine.name;
  }
}

TEST(Peers, ThrowBackByTheRestitutionOfTheScene) {
  PileScene scene = ball_scene(0.5);
  scene.gravity_mps2 = Vec3::Zero();
  scene.restitution = 0.2;
  // A centimetre deep after a step: with a remaining gap, Bullet's restitution is reduced by that much.
  scene.start = {at({0, 0, 0.54}, {0, 0, -3})};
  for (const Engine& engine : peers(scene)) {
    double fastest_mps = -3;
    for (int i = 0; i < 30; ++i) {
      engine.step();
      fastest_mps = std::max(fastest_mps, state_of(engine).velocity_mps.z());
    }
    // Penetration is also removed by velocity: a fifth a step.
    EXPECT_GT(fastest_mps, 0.59) << engine.name;
    EXPECT_LT(fastest_mps, 0.9) << engine.name;
  }
}

TEST(Peers, SlideAsFarAsTheFrictionOfTheSceneLetsThem) {
  // A flat tripod does not tip, so it slides by v^2 / (2 mu g).
  PileScene scene = ball_scene(0.1);
  scene.spheres = {{Vec3(1, 0, 0), 0.1}, {Vec3(-0.5, 0.87, 0), 0.1}, {Vec3(-0.5, -0.87, 0), 0.1}};
  scene.inertia_kgm2 = Vec3(1, 1, 2);
  scene.friction = 0.5;
  scene.start = {at({0, 0, 0.1}, {3, 0, 0})};
  const double far_m = 9 / (2 * 0.5 * 9.81);
  for (const Engine& engine : peers(scene)) {
    for (int i = 0; i < 90; ++i) engine.step();
    EXPECT_NEAR(state_of(engine).position_m.x(), far_m, 0.07 * far_m) << engine.name;
    EXPECT_NEAR(state_of(engine).velocity_mps.norm(), 0, 0.01) << engine.name;
  }
}

TEST(Turns, EveryEngineStepsEveryFrameInBlocksAndWhoBeginsChanges) {
  std::string order;
  std::vector<Engine> engines(2);
  engines[0].step = [&] { order += 'a'; };
  engines[1].step = [&] { order += 'b'; };
  std::vector<std::uint64_t> told;
  const auto times = take_turns(engines, 7, 3, [&](std::uint64_t done) { told.push_back(done); });
  EXPECT_EQ(order,
            "aaabbb"
            "bbbaaa"
            "ab");
  EXPECT_EQ(told, (std::vector<std::uint64_t>{3, 6, 7}));
  ASSERT_EQ(times.size(), 2U);
  EXPECT_EQ(times[0].size(), 7U);
  EXPECT_EQ(times[1].size(), 7U);
}

TEST(Turns, QuantilesAreByNearestRank) {
  std::vector<StepTime> times;
  for (int i = 100; i >= 1; --i) times.push_back({static_cast<double>(i), 1000.0 + i});
  const TimeFigures figures = time_figures(times);
  EXPECT_EQ(figures.frames, 100U);
  EXPECT_EQ(figures.wall.p25_ms, 25);
  EXPECT_EQ(figures.wall.p50_ms, 50);
  EXPECT_EQ(figures.wall.p75_ms, 75);
  EXPECT_EQ(figures.wall.p99_ms, 99);
  EXPECT_EQ(figures.cpu.p50_ms, 1050);
  EXPECT_EQ(time_figures({}).frames, 0U);
}

TEST(Piles, OfPoiseAreReadAsTheSceneSays) {
  const Scene scene = read_scene(POISE_SOURCE_DIR "/scenes/jacks.json").value();
  const PileScene pile = pile_scene(scene, 20).value();
  EXPECT_EQ(pile.start.size(), 20U);
  EXPECT_EQ(pile.spheres.size(), 13U);
  EXPECT_EQ(pile.walls.size(), 5U);
  EXPECT_EQ(pile.friction, 0.5);
  EXPECT_EQ(pile.restitution, 0.2);
  double mass_kg = 0;
  for (const Sphere& sphere : pile.spheres) mass_kg += 4.0 / 3 * M_PI * std::pow(sphere.radius_m, 3);
  EXPECT_NEAR(pile.mass_kg, mass_kg, 1e-12);
  Scene without = scene;
  without.tray.reset();
  EXPECT_FALSE(pile_scene(without, 20));
}

}  // namespace
}  // namespace poise::bench
