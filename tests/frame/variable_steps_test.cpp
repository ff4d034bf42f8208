// SPDX-License-Identifier: MIT
// Steps whose length changes from frame to frame: what lies still does not notice.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "scenes.h"

namespace poise {
namespace {

constexpr double kStep_s = 1.0 / 60;

// Steps of the frame rate's third, half, whole, double and again.
double changing_s(int frame) {
  constexpr std::array<double, 6> kFactors{1, 0.5, 1, 2, 1.0 / 3, 2};
  return kStep_s * kFactors[static_cast<std::size_t>(frame) % kFactors.size()];
}

double fastest_mps(const Stage& stage) {
  double fastest = 0;
  for (const BodyId body : stage.bodies) fastest = std::max(fastest, stage.at(body).velocity_mps.norm());
  return fastest;
}

TEST(VariableSteps, AColumnOfBallsStaysAsItStood) {
  Stage stage(one_thread_with_gravity(), 0);
  stage.tray(4);
  const ShapeId ball = stage.ball(0.5);
  for (int i = 0; i < 10; ++i) stage.add(ball, Vec3(0, 0, 0.5 + 1.0 * i));
  for (int i = 0; i < 240; ++i) stage.world.step(step_of(kStep_s));
  const double height_m = stage.at(stage.bodies.back()).position_m.z();
  double fastest = 0;
  for (int i = 0; i < 120; ++i) {
    stage.world.step(step_of(changing_s(i)));
    fastest = std::max(fastest, fastest_mps(stage));
  }
  EXPECT_LT(fastest, 2e-3);
  EXPECT_NEAR(stage.at(stage.bodies.back()).position_m.z(), height_m, 1e-3);
}

TEST(VariableSteps, AHeapOfJacksMovesNoFasterThanWithEvenSteps) {
  Stage stage(one_thread_with_gravity(), 0);
  stage.material = stage.world.add_material({0, 0.5, 1000}).value();
  stage.jacks(40, 5);
  for (int i = 0; i < 300; ++i) stage.world.step(step_of(kStep_s));
  const auto fastest_of = [&](auto&& step) {
    double fastest = 0;
    for (int i = 0; i < 60; ++i) {
      step(i);
      fastest = std::max(fastest, fastest_mps(stage));
    }
    return fastest;
  };
  const double even = fastest_of([&](int) { stage.world.step(step_of(kStep_s)); });
  const double allowed = std::max(2.0 * even, 5e-3);
  EXPECT_LT(fastest_of([&](int i) { stage.world.step(step_of(changing_s(i))); }), allowed);
  WorldSettings settings = stage.world.settings();
  EXPECT_LT(fastest_of([&](int i) {
              settings.substeps = 1 + i % 4;
              ASSERT_TRUE(stage.world.set_settings(settings).ok());
              stage.world.step(step_of(kStep_s));
            }),
            allowed);
}

}  // namespace
}  // namespace poise
