// SPDX-License-Identifier: MIT
#include <cmath>

#include "accuracy/friction.h"
#include "accuracy/slope.h"

namespace poise::accuracy {
namespace {

constexpr double kRadiusM = 0.25;
constexpr double kRollingStepS = 1.0 / 240;

// Speed of the ball's lowest point over the ground.
double slip_mps(const SlopeWorld& slope, const BodyState& ball) {
  return (ball.velocity_mps + ball.angular_velocity_radps.cross(-kRadiusM * slope.up())).norm();
}

}  // namespace

Status tipping_box(Context& context) {
  const Vec3 size_m(0.4, 0.4, 1);
  const double limit_rad = std::atan(size_m.x() / size_m.z());
  const auto tips = [&](double angle_rad) {
    SlopeWorld slope(context, angle_rad, 1, SlopeWorld::Ground::Plane);
    const BodyId box = slope.put(slope.world.box(size_m), 0.5 * size_m.z());
    for (int i = 0; i < 180; ++i) slope.world.step(1.0 / 60);
    return (slope.world.at(box).orientation * Vec3::UnitZ()).dot(slope.up()) < std::cos(10 * kDegree);
  };
  const double found_rad = begins_at(limit_rad - 6 * kDegree, limit_rad + 6 * kDegree, 10, tips);
  context.add("angle from which it tips", "degree", found_rad / kDegree, {});
  context.add("error of that angle", "degree", std::abs(found_rad - limit_rad) / kDegree, 0.1);
  return context.at(1);
}

Status rolling_ball(Context& context) {
  // The path lies within the top face of the 12 m box, so the ball stays on either ground.
  for (const SlopeWorld::Ground ground : {SlopeWorld::Ground::Plane, SlopeWorld::Ground::Box}) {
    const std::string on = ground == SlopeWorld::Ground::Plane ? ", on a plane" : ", on a box";
    const double angle_rad = 20 * kDegree;
    SlopeWorld slope(context, angle_rad, 0.5, ground);
    const BodyId ball = slope.put(slope.world.ball(kRadiusM), kRadiusM, Vec3::Zero(), -4);
    for (int i = 0; i < 360; ++i) slope.world.step(kRollingStepS);
    const BodyState end = slope.world.at(ball);
    const double expected_mps = 5.0 / 7 * kGravityMps2 * std::sin(angle_rad) * 360 * kRollingStepS;
    context.add("error of the acceleration" + on, "1",
                std::abs(end.velocity_mps.dot(slope.downhill()) / expected_mps - 1), 0.005);
    context.add("slip, as a share of the speed" + on, "1", slip_mps(slope, end) / expected_mps, 0.005);
  }
  return context.at(1);
}

Status skidding_ball(Context& context) {
  constexpr double kSpeedMps = 5;
  SlopeWorld floor(context, 0, 0.2, SlopeWorld::Ground::Plane);
  const BodyId ball = floor.put(floor.world.ball(kRadiusM), kRadiusM, kSpeedMps * floor.downhill());
  // It skids for 2 v / (7 mu g) = 0.73 s.
  for (int i = 0; i < 360; ++i) floor.world.step(kRollingStepS);
  const BodyState end = floor.world.at(ball);
  context.add("error of the speed once it rolls", "1",
              std::abs(end.velocity_mps.dot(floor.downhill()) / (5.0 / 7 * kSpeedMps) - 1), 0.005);
  context.add("slip once it rolls, as a share of the speed", "1", slip_mps(floor, end) / kSpeedMps, 0.005);

  const double steep_rad = 40 * kDegree;
  constexpr double kLittle = 0.1;  // rolling would take 2/7 tan(40 degrees) = 0.24
  SlopeWorld slope(context, steep_rad, kLittle, SlopeWorld::Ground::Plane);
  const BodyId slipping = slope.put(slope.world.ball(kRadiusM), kRadiusM);
  for (int i = 0; i < 240; ++i) slope.world.step(kRollingStepS);
  const BodyState after = slope.world.at(slipping);
  const double speed_mps = kGravityMps2 * (std::sin(steep_rad) - kLittle * std::cos(steep_rad)) * 240 * kRollingStepS;
  const double spin_radps = 2.5 * kLittle * kGravityMps2 * std::cos(steep_rad) / kRadiusM * 240 * kRollingStepS;
  context.add("error of the speed on a slope too steep to roll", "1",
              std::abs(after.velocity_mps.dot(slope.downhill()) / speed_mps - 1), 0.005);
  context.add("error of the spin on a slope too steep to roll", "1",
              std::abs(after.angular_velocity_radps.norm() / spin_radps - 1), 0.005);
  return context.at(1);
}

}  // namespace poise::accuracy
