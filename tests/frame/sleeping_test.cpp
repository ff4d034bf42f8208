// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "frame/scenes.h"

namespace poise {
namespace {

constexpr double kStepS = 1.0 / 60;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

WorldSettings sleepy(bool sleeping = true, int threads = 1) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = threads == 1 ? ExecutorKind::Serial : ExecutorKind::Threads;
  settings.threads = threads;
  settings.sleeping = sleeping;
  return settings;
}

/// A stage whose bodies have friction.
Stage rough(const WorldSettings& settings) {
  Stage stage(settings, 0.0);
  stage.material = stage.world.add_material({0, 0.5, 1000}).value();
  return stage;
}

StepInput plain_step() {
  StepInput input = step_of(kStepS);
  input.measure_energy = true;
  return input;
}

/// Steps until this many bodies sleep; returns the report of that frame.
FrameReport until_asleep(Stage& stage, std::size_t count, int frames = 900) {
  FrameReport report;
  for (int i = 0; i < frames && report.asleep < count; ++i) report = stage.world.step(plain_step());
  EXPECT_EQ(report.asleep, count);
  return report;
}

BodyId still_body(Stage& stage, ShapeId shape, const Vec3& position) {
  BodyDefinition body;
  body.shape = shape;
  body.material = stage.material;
  body.motion = MotionType::Static;
  body.position_m = position;
  return stage.world.add_body(body).value();
}

/// Three balls of 1 m side by side; a fourth one lies in the hollow between them, `height` above their centres.
ShapeId cradle(Stage& stage) {
  const double side = std::sqrt(0.75);
  const std::vector<Sphere> spheres = {{Vec3(1, 0, 0), 1.0}, {Vec3(-0.5, side, 0), 1.0}, {Vec3(-0.5, -side, 0), 1.0}};
  return stage.world.add_shape(make_spheres_shape(spheres).value());
}
// sqrt(1.5^2 - 1): the height of a ball of 0.5 m on balls of 1 m at 1 m from the axis.
constexpr double kInCradleM = 1.1180339887498949;

bool asleep(const Stage& stage, BodyId body) { return stage.world.asleep(body).value(); }

std::vector<BodyState> states(const Stage& stage) {
  std::vector<BodyState> all;
  for (const BodyId body : stage.bodies) all.push_back(stage.at(body));
  return all;
}

// Largest distance between the positions of the bodies of the first list, which may be the shorter one, and of the
// second.
double furthest(const std::vector<BodyState>& a, const std::vector<BodyState>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i].position_m - b[i].position_m).norm());
  return most;
}

TEST(Sleep, ASettledPileSleepsWholeAndThenCostsNothingButItsEntry) {
  Stage stage = rough(sleepy());
  stage.jacks(40, 8);
  const FrameReport last = until_asleep(stage, 40);
  EXPECT_GT(last.fell_asleep, 1U);
  EXPECT_GT(last.contact_pairs, 0U);
  const std::vector<BodyState> before = states(stage);
  for (int i = 0; i < 10; ++i) {
    const FrameReport report = stage.world.step(plain_step());
    EXPECT_EQ(report.bodies, 40U);
    EXPECT_EQ(report.asleep, 40U);
    EXPECT_EQ(report.fell_asleep + report.woken, 0U);
    EXPECT_EQ(report.candidate_pairs + report.coarse_pairs + report.contact_pairs, 0U);
    EXPECT_EQ(report.jobs_done + report.work_refine, 0U);
    EXPECT_EQ(report.kinetic_j, 0.0);
    EXPECT_EQ(report.potential_j, last.potential_j);
  }
  EXPECT_EQ(furthest(before, states(stage)), 0.0);
  double potential_j = 0;
  for (const BodyId body : stage.bodies) {
    EXPECT_TRUE(stage.at(body).velocity_mps.isZero(0));
    EXPECT_GT(stage.world.mass_kg(body).value(), 0);
    potential_j += 9.81 * stage.world.mass_kg(body).value() * stage.at(body).position_m.z();
  }
  EXPECT_NEAR(last.potential_j, potential_j, 1e-9 * potential_j);
}

TEST(Sleep, ABallThatFallsOnAPileWakesAllOfItBeforeItTouches) {
  Stage stage = rough(sleepy());
  stage.jacks(12, 5);
  until_asleep(stage, 12);
  const std::vector<BodyState> asleep_at = states(stage);
  const double start_m = 6;
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, start_m));
  const auto energy = [&] { return stage.world.conserved().kinetic_j + stage.world.conserved().potential_j; };
  const double start_j = energy();
  int frames = 0;
  FrameReport report;
  while (report.woken == 0 && ++frames < 120) {
    EXPECT_EQ(furthest(asleep_at, states(stage)), 0.0);
    report = stage.world.step(plain_step());
  }
  EXPECT_EQ(report.woken, 12U);
  EXPECT_EQ(report.asleep, 0U);
  // Until here it was in free fall.
  for (const Contact& contact : stage.world.contacts()) EXPECT_FALSE(contact.a == ball || contact.b == ball);
  EXPECT_NEAR(stage.at(ball).velocity_mps.z(), -9.81 * kStepS * frames, 1e-9);
  bool pushed = false;
  for (int i = 0; i < 60; ++i) {
    stage.world.step(plain_step());
    // Position correction may lift a body by some ten-thousandths of m g R, of which one is 2.5e-6 of the sum here.
    EXPECT_LE(energy(), start_j * (1 + 1.5e-5));
    for (const Contact& contact : stage.world.contacts()) pushed = pushed || contact.a == ball || contact.b == ball;
  }
  EXPECT_TRUE(pushed);
  EXPECT_GT(furthest(asleep_at, states(stage)), 1e-3);
}

TEST(Sleep, AHitOnASleeperIsThatOnABodyAtRestToTheBit) {
  std::vector<BodyState> ends[2];
  for (const bool sleeping : {false, true}) {
    WorldSettings settings = sleepy(sleeping);
    settings.gravity_mps2.setZero();
    Stage stage(settings, 1.0);
    const ShapeId ball = stage.ball(0.5);
    const BodyId rests = stage.add(ball, Vec3(0, 0, 0));
    stage.add(ball, Vec3(-3, 0.1, 0), Vec3(1, 0, 0));
    const Vec3 momentum = stage.world.conserved().momentum_ns;
    for (int i = 0; i < 60; ++i) stage.world.step(plain_step());
    EXPECT_EQ(asleep(stage, rests), sleeping);
    for (int i = 0; i < 120; ++i) stage.world.step(plain_step());
    EXPECT_GT(stage.at(rests).velocity_mps.x(), 0.9);
    EXPECT_LT((stage.world.conserved().momentum_ns - momentum).norm(), 1e-9 * momentum.norm());
    ends[sleeping ? 1 : 0] = states(stage);
  }
  EXPECT_EQ(furthest(ends[0], ends[1]), 0.0);
}

TEST(Sleep, APileWakesWithItsImpulsesAndStaysWhereItIs) {
  Stage stage = rough(sleepy());
  Stage control = rough(sleepy(false));
  for (Stage* each : {&stage, &control}) each->jacks(12, 5);
  FrameReport report;
  while (report.asleep < 12 && report.frame < 900) {
    report = stage.world.step(plain_step());
    control.world.step(plain_step());
  }
  ASSERT_EQ(report.asleep, 12U);
  for (int i = 0; i < 20; ++i) {
    stage.world.step(plain_step());
    control.world.step(plain_step());
  }
  const std::vector<BodyState> before = states(stage);
  ASSERT_TRUE(stage.world.set_state(stage.bodies[0], before[0]).ok());
  const double mass_kg = stage.world.mass_kg(stage.bodies[0]).value();
  double most_j = 0;
  for (int i = 0; i < 25; ++i) {
    report = stage.world.step(plain_step());
    const FrameReport other = control.world.step(plain_step());
    EXPECT_EQ(report.woken, i == 0 ? 11U + 1U : 0U);
    EXPECT_NEAR(report.potential_j, other.potential_j, 1e-3 * 12 * mass_kg * 9.81);
    EXPECT_EQ(report.contact_pairs > 0, true);
    most_j = std::max(most_j, report.kinetic_j);
    // The cached pairs are still valid: almost no refinement.
    EXPECT_GT(report.cached_contacts + report.cached_separations, report.coarse_pairs / 2);
    EXPECT_TRUE(stage.world.contact_events().empty());
  }
  EXPECT_LT(most_j, 1e-6 * 12 * mass_kg * 9.81);
  // It creeps as it did before it slept, 0.4 mm at most in these frames.
  EXPECT_LT(furthest(before, states(stage)), 6e-4);
  EXPECT_LT(furthest(states(control), states(stage)), 1e-3);
}

TEST(Sleep, WhatLayOnARemovedOrMovedBodyWakesAndFalls) {
  for (const bool on_plane : {false, true}) {
    for (const bool remove : {false, true}) {
      Stage stage(sleepy(), 0);
      const BodyId support = on_plane ? stage.plane(Vec3::UnitZ(), 0) : still_body(stage, cradle(stage), Vec3::Zero());
      const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, on_plane ? 0.5 : kInCradleM));
      until_asleep(stage, 1);
      const double height_m = stage.at(ball).position_m.z();
      if (remove) {
        ASSERT_TRUE(stage.world.remove_body(support).ok());
      } else {
        BodyState away = stage.at(support);
        away.position_m.z() -= 100;
        ASSERT_TRUE(stage.world.set_state(support, away).ok());
      }
      EXPECT_EQ(stage.world.step(plain_step()).woken, 1U);
      for (int i = 0; i < 9; ++i) stage.world.step(plain_step());
      EXPECT_NEAR(stage.at(ball).position_m.z(), height_m - 0.5 * 9.81 * (10 * kStepS) * (10 * kStepS), 1e-9);
    }
  }
}

TEST(Sleep, WhatLayOnARemovedSleeperWakesAlsoWhereItsSlotIsTakenAtOnce) {
  Stage stage(sleepy(), 0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId bowl = cradle(stage);
  const BodyId below = stage.add(bowl, Vec3(0, 0, 1));
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, 1 + kInCradleM));
  until_asleep(stage, 2);
  ASSERT_TRUE(stage.world.remove_body(below).ok());
  const BodyId other = stage.add(bowl, Vec3(50, 0, 1));
  EXPECT_EQ(other.slot, below.slot);
  const FrameReport report = stage.world.step(plain_step());
  EXPECT_EQ(report.asleep, 0U);
  EXPECT_LT(stage.at(ball).velocity_mps.z(), -0.1);
}

TEST(Sleep, AStaticBodyThatIsPutIntoASleeperWakesIt) {
  Stage stage(sleepy(), 0);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, 0.5));
  const BodyId far_away = stage.add(stage.ball(0.5), Vec3(30, 0, 0.5));
  until_asleep(stage, 2);
  still_body(stage, stage.ball(0.5), Vec3(0.9, 0, 0.5));
  EXPECT_EQ(stage.world.step(plain_step()).woken, 1U);
  EXPECT_FALSE(asleep(stage, ball));
  EXPECT_TRUE(asleep(stage, far_away));
}

TEST(Sleep, EveryCallThatChangesABodyWakesItAndRefusedOnesDoNot) {
  using Change = std::function<Status(World&, BodyId, const BodyState&)>;
  const std::vector<Change> changes = {
      [](World& world, BodyId body, const BodyState& state) { return world.set_state(body, state); },
      [](World& world, BodyId body, const BodyState& state) {
        return world.apply_force(body, Vec3::UnitX(), state.position_m);
      },
      [](World& world, BodyId body, const BodyState&) { return world.apply_torque(body, Vec3::UnitX()); },
      [](World& world, BodyId body, const BodyState& state) {
        return world.apply_impulse(body, Vec3::UnitX(), state.position_m);
      },
      [](World& world, BodyId body, const BodyState&) { return world.set_groups(body, 1, 1); }};
  const std::vector<Change> refused = {
      [](World& world, BodyId body, BodyState state) {
        return state.velocity_mps.x() = 1e300, world.set_state(body, state);
      },
      [](World& world, BodyId body, const BodyState& state) {
        return world.apply_force(body, Vec3(kNan, 0, 0), state.position_m);
      },
      [](World& world, BodyId body, const BodyState&) { return world.apply_torque(body, Vec3(kNan, 0, 0)); },
      [](World& world, BodyId body, const BodyState& state) {
        return world.apply_impulse(body, Vec3(1e29, 0, 0), state.position_m);
      }};
  Stage stage(sleepy(), 0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId shape = stage.ball(0.5);
  for (int i = 0; i < 3; ++i) stage.add(shape, Vec3(i, 0, 0.5));
  for (std::size_t i = 0; i < changes.size(); ++i) {
    until_asleep(stage, 3);
    const BodyState rest = stage.at(stage.bodies[0]);
    const std::uint64_t hash = stage.world.state_hash();
    for (const Change& change : refused) EXPECT_FALSE(change(stage.world, stage.bodies[0], rest).ok());
    EXPECT_EQ(stage.world.state_hash(), hash);
    ASSERT_TRUE(changes[i](stage.world, stage.bodies[0], rest).ok());
    EXPECT_FALSE(asleep(stage, stage.bodies[0])) << i;
    EXPECT_NE(stage.world.state_hash(), hash) << i;
    EXPECT_EQ(stage.world.step(plain_step()).woken, 3U) << i;
  }
}

TEST(Sleep, AnImpulseOnASleeperMovesItAsItDoesABodyAtRest) {
  Stage stage(sleepy(), 0);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, 0.5));
  until_asleep(stage, 1);
  const double mass_kg = stage.world.mass_kg(ball).value();
  ASSERT_TRUE(
      stage.world.apply_impulse(ball, Vec3(3 * mass_kg, 0, 0), stage.at(ball).position_m + Vec3(0, 0.1, 0)).ok());
  EXPECT_DOUBLE_EQ(stage.at(ball).velocity_mps.x(), 3);
  EXPECT_NEAR(stage.at(ball).angular_velocity_radps.z(), -0.3 / (0.4 * 0.25), 1e-6);
}

TEST(Sleep, SeparatePilesSleepAndWakeApart) {
  Stage stage(sleepy(), 0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId shape = stage.ball(0.5);
  for (const double x : {0.0, 20.0}) {
    for (int i = 0; i < 4; ++i) stage.add(shape, Vec3(x + i, 0, 0.5));
  }
  // The last body of the second pile spins in place.
  BodyState spun = stage.at(stage.bodies[7]);
  spun.angular_velocity_radps = Vec3(0, 0, 1);
  ASSERT_TRUE(stage.world.set_state(stage.bodies[7], spun).ok());
  until_asleep(stage, 4, 40);
  for (int i = 0; i < 60; ++i) EXPECT_EQ(stage.world.step(plain_step()).asleep, 4U) << "kept awake by a neighbour";
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(asleep(stage, stage.bodies[i]), i < 4);
  spun = stage.at(stage.bodies[7]);
  spun.angular_velocity_radps.setZero();
  ASSERT_TRUE(stage.world.set_state(stage.bodies[7], spun).ok());
  until_asleep(stage, 8, 40);
  ASSERT_TRUE(stage.world.apply_torque(stage.bodies[5], Vec3(0, 0, 1e-3)).ok());
  const FrameReport report = stage.world.step(plain_step());
  EXPECT_EQ(report.woken, 4U);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(asleep(stage, stage.bodies[i]), i < 4);
}

/// Hash of a run in which bodies fall, sleep, are hit and sleep again.
std::uint64_t hash_of_run(int threads, bool reference) {
  Stage stage = rough(sleepy(true, threads));
  stage.jacks(12, 5);
  std::size_t fell = 0;
  std::size_t woke = 0;
  for (int i = 0; i < 420; ++i) {
    if (i == 300) stage.add(stage.ball(0.4), Vec3(0.1, 0, 4));
    StepInput input = plain_step();
    input.reference = reference && (i % 60 == 0 || (i > 300 && i % 20 == 0));
    const FrameReport report = stage.world.step(input);
    fell += report.fell_asleep;
    woke += report.woken;
    EXPECT_EQ(report.asleep, fell - woke);
  }
  EXPECT_GE(fell, 12U);
  EXPECT_GE(woke, 12U);
  return stage.world.state_hash();
}

TEST(Sleep, TheSameBitsOnAnyThreadsAndWithReferences) {
  const std::uint64_t expected = hash_of_run(1, false);
  EXPECT_EQ(hash_of_run(2, false), expected);
  EXPECT_EQ(hash_of_run(4, true), expected);
}

TEST(Sleep, UnaskedNothingSleepsAndAskedNothingChangesUntilSomethingDoes) {
  Stage off = rough(sleepy(false));
  Stage on = rough(sleepy());
  for (Stage* each : {&off, &on}) each->jacks(12, 5);
  FrameReport report;
  while (report.asleep == 0 && report.frame < 900) {
    EXPECT_EQ(off.world.step(plain_step()).asleep, 0U);
    const std::vector<BodyState> before = states(on);
    report = on.world.step(plain_step());
    if (report.asleep > 0) break;
    const std::vector<BodyState> a = states(off);
    const std::vector<BodyState> b = states(on);
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].position_m, b[i].position_m);
      ASSERT_EQ(a[i].velocity_mps, b[i].velocity_mps);
      ASSERT_EQ(a[i].orientation.coeffs(), b[i].orientation.coeffs());
    }
  }
  for (int i = 0; i < 60; ++i) EXPECT_EQ(off.world.step(plain_step()).asleep, 0U);
}

// Under weak gravity it is slower than 0.01 sqrt(g R) for seconds.
TEST(Sleeping, NothingFallsAsleepInTheAirHoweverWeakGravityIs) {
  for (const auto& [gravity, radius_m] : {std::pair{1e-4, 0.3}, std::pair{1e-3, 3.0}, std::pair{0.016, 100.0}}) {
    for (const double up : {0.0, 0.3 * gravity}) {
      WorldSettings settings;
      settings.executor = ExecutorKind::Serial;
      settings.sleeping = true;
      settings.gravity_mps2 = Vec3(0, 0, -gravity);
      Stage stage(settings);
      const BodyId ball = stage.add(stage.ball(radius_m), Vec3::Zero(), Vec3(0, 0, up));
      for (int frame = 0; frame < 240; ++frame) {
        stage.world.step(step_of(1.0 / 60));
        ASSERT_FALSE(stage.world.asleep(ball).value()) << gravity << ", frame " << frame;
      }
      EXPECT_NEAR(stage.at(ball).position_m.z(), 4 * up - 8 * gravity, 1e-9) << gravity;
    }
  }
}

}  // namespace
}  // namespace poise
