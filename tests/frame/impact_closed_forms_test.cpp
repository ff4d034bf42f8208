// SPDX-License-Identifier: MIT
// Impacts of single bodies against what does not yield, by closed form: wherever within a step they meet.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "frame/scenes.h"
#include "geometry/meshes.h"

namespace poise {
namespace {

constexpr double kBallM = 0.05;  // radius
constexpr double kLandingStepS = 1.0 / 60;

enum class Ground { Plane, Box, Ball };
std::string name_of(const testing::TestParamInfo<Ground>& ground) {
  constexpr const char* kNames[] = {"Plane", "Box", "Ball"};
  return kNames[static_cast<std::size_t>(ground.param)];
}

// A ball above ground that fills the half-space below z = 0, or nearly.
struct Landing : Stage {
  BodyId ball_id;

  static ShapePtr box_ground() {
    static const ShapePtr shape =
        make_mesh_shape(test::box_mesh(Vec3(6, 6, 1)), {.depth = 2, .preset = TreePreset::Fast}).value();
    return shape;
  }
  Landing(Ground ground, double restitution, double friction, double height_m, const Vec3& velocity_mps)
      : Stage(one_thread_with_gravity(), restitution) {
    material = world.add_material({restitution, friction, 1000}).value();
    BodyDefinition below;
    below.material = material;
    below.motion = MotionType::Static;
    if (ground == Ground::Plane) {
      below.shape = world.add_shape(make_plane_shape(Vec3::UnitZ(), 0).value());
    } else if (ground == Ground::Box) {
      below.shape = world.add_shape(box_ground());
      below.position_m = Vec3(0, 0, -0.5);
    } else {
      below.shape = ball(1e4);
      below.position_m = Vec3(0, 0, -1e4);
    }
    EXPECT_TRUE(world.add_body(below).ok());
    ball_id = add(ball(kBallM), Vec3(-2, 0, height_m), velocity_mps);
  }
  void step(bool backtracking = false) {
    StepInput input = step_of(kLandingStepS);
    input.polygons = true;
    input.backtracking = backtracking;
    world.step(input);
  }
};

class LandingBall : public testing::TestWithParam<Ground> {};
INSTANTIATE_TEST_SUITE_P(On, LandingBall, testing::Values(Ground::Plane, Ground::Box, Ground::Ball), name_of);

// Friction that stops the slip leaves 5/7 of the speed along the ground, and the ball rolls. In half a step it moves by
// less than its radius, so that its centre stays outside.
TEST_P(LandingBall, IsRubbedAtItsSurface) {
  for (const double restitution : {0.0, 0.5}) {
    for (int k = 0; k < 12; ++k) {
      Landing landing(GetParam(), restitution, 2, 0.6 + 0.013 * k, Vec3(2.5, 0, -4));
      for (int frame = 0; frame < 16; ++frame) landing.step();
      const BodyState ball = landing.at(landing.ball_id);
      EXPECT_NEAR(ball.velocity_mps.x(), 12.5 / 7, 5e-3) << restitution << ' ' << k;
      EXPECT_NEAR(ball.angular_velocity_radps.y(), 12.5 / 7 / kBallM, 0.1) << restitution << ' ' << k;
    }
  }
}

TEST_P(LandingBall, JustTouchesWhereItDoesNotRebound) {
  for (int k = 0; k < 40; ++k) {
    Landing landing(GetParam(), 0, 0, 1 + 0.011 * k, Vec3(0, 0, -8 - 0.1 * k));
    double lowest_m = 1;
    for (int frame = 0; frame < 20; ++frame) {
      landing.step();
      lowest_m = std::min(lowest_m, landing.at(landing.ball_id).position_m.z() - kBallM);
    }
    EXPECT_GT(lowest_m, -1e-3) << k;
    EXPECT_LT(lowest_m, 1e-3) << k;
  }
}

TEST_P(LandingBall, HasAContactWithItsTrueGap) {
  Landing landing(GetParam(), 0, 0, kBallM + 0.08, Vec3(0, 0, -10));
  landing.step();
  ASSERT_EQ(landing.world.contacts().size(), 1U);
  EXPECT_NEAR(landing.world.contacts()[0].gap_m, 0.08, 3e-4);  // two metres from the top of the huge ball
}

TEST(LandingBox, HasAContactWithItsTrueGap) {
  for (const Ground ground : {Ground::Plane, Ground::Box}) {
    Landing landing(ground, 0, 0, 5, Vec3::Zero());
    const ShapeId box = landing.world.add_shape(
        make_mesh_shape(test::box_mesh(Vec3(1, 1, 1)), {.depth = 2, .preset = TreePreset::Fast}).value());
    landing.add(box, Vec3(1, 0, 0.53), Vec3(0, 0, -10));
    landing.step();
    ASSERT_EQ(landing.world.contacts().size(), 1U);
    EXPECT_NEAR(landing.world.contacts()[0].gap_m, 0.03, 1e-6);
  }
}

// Two steps of the same motion: through backtracking the ball is answered where it meets.
TEST_P(LandingBall, IsRubbedWhereItMeetsWithinTheStep) {
  for (const double friction : {0.0, 0.1, 2.0}) {
    Landing landing(GetParam(), 0.5, friction, 1, Vec3(10, 0, -10));
    const double kg = landing.world.mass_kg(landing.ball_id).value();
    BodyState before = landing.at(landing.ball_id);
    for (int frame = 0; frame < 12 && landing.world.contacts().empty(); ++frame) {
      before = landing.at(landing.ball_id);
      landing.step(true);
    }
    ASSERT_EQ(landing.world.contacts().size(), 1U);
    const BodyState after = landing.at(landing.ball_id);
    // The speed at which it meets, of which gravity knows a part.
    const double falls_mps = after.velocity_mps.z() / 0.5;
    constexpr double near_mps = 5e-3;  // it is stopped a thousandth of its radius above the ground
    const double lost_mps = std::min(friction * 1.5 * falls_mps, 10.0 * 2 / 7);
    EXPECT_NEAR(after.velocity_mps.x(), 10 - lost_mps, near_mps) << friction;
    EXPECT_NEAR(after.angular_velocity_radps.y(), lost_mps / (0.4 * kBallM), 0.1) << friction;
    const Contact& contact = landing.world.contacts()[0];
    const double sign = contact.b == landing.ball_id ? 1 : -1;
    EXPECT_NEAR(sign * contact.impulse_ns.x(), -kg * lost_mps, near_mps * kg) << friction;
    EXPECT_NEAR(sign * contact.impulse_ns.z(), kg * 1.5 * falls_mps, near_mps * kg) << friction;
  }
}

// What turns a body within the step widens how far contacts are looked for, as what pushes it does.
TEST(TurnedRod, MeetsTheGroundInTheStepThatTurnsIt) {
  WorldSettings settings;
  settings.executor = ExecutorKind::Serial;
  for (const bool eccentric : {false, true}) {
    Stage stage(settings, 0);
    stage.plane(Vec3::UnitZ(), 0);
    std::vector<Sphere> balls;
    for (int i = -10; i <= 10; ++i) balls.push_back({Vec3(0.1 * i, 0, 0), kBallM});
    const ShapeId rod = stage.world.add_shape(make_spheres_shape(balls).value());
    const BodyId body = stage.add(rod, Vec3(0, 0, kBallM + 0.02));
    const double about_y_kgm2 = stage.world.mass_kg(body).value() * 0.35;
    const double torque_nm = about_y_kgm2 * 0.3 / (kLandingStepS * kLandingStepS);  // a third of a radian in the step
    if (eccentric) {
      EXPECT_TRUE(stage.world.apply_force(body, Vec3(0, 0, -torque_nm), Vec3(1, 0, kBallM + 0.02)).ok());
      EXPECT_TRUE(stage.world.apply_force(body, Vec3(0, 0, torque_nm), Vec3(0, 0, kBallM + 0.02)).ok());
    } else {
      EXPECT_TRUE(stage.world.apply_torque(body, Vec3(0, torque_nm, 0)).ok());
    }
    for (int frame = 0; frame < 5; ++frame) {
      stage.world.step(step_of(kLandingStepS));
      const BodyState now = stage.at(body);
      for (const double end : {-1.0, 1.0})
        EXPECT_GT((now.position_m + now.orientation * Vec3(end, 0, 0)).z() - kBallM, -0.01) << frame;
    }
  }
}

}  // namespace
}  // namespace poise
