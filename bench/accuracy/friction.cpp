// SPDX-License-Identifier: MIT
#include "accuracy/friction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "accuracy/slope.h"

namespace poise::accuracy {
namespace {

constexpr double kFriction = 0.5;

struct Block {
  bool is_box = true;
  ShapeId make(SmallWorld& world) const { return is_box ? world.box({0.4, 0.4, 0.2}) : world.slab_of_balls(0.3, 0.1); }
};
constexpr double kHeightM = 0.1;  // of the origin of both blocks

void slide(Context& context, Block block, double dt_s, std::optional<double> at_most) {
  constexpr double kSpeedMps = 3;
  const double expected_m = kSpeedMps * kSpeedMps / (2 * kFriction * kGravityMps2);
  SlopeWorld slope(context, 0, kFriction, SlopeWorld::Ground::Plane);
  const BodyId body = slope.put(block.make(slope.world), kHeightM, kSpeedMps * slope.downhill());
  const Vec3 start = slope.world.at(body).position_m;
  // It stops after 0.61 s.
  for (double t = 0; t < 1.5; t += dt_s) slope.world.step(dt_s);
  const BodyState end = slope.world.at(body);
  const double distance_m = (end.position_m - start).dot(slope.downhill());
  const std::string with = fmt::format(", dt = {:.4g} s", dt_s);
  context.add("distance" + with, "m", distance_m, {});
  context.add("error of the distance" + with, "1", std::abs(distance_m / expected_m - 1), at_most);
  context.add("speed after it should have stopped" + with, "m/s", end.velocity_mps.norm(), 1e-3);
}

void slide_to_stop(Context& context, Block block) {
  slide(context, block, 1e-3, 0.005);
  slide(context, block, 1.0 / 60, {});
}

struct Slid {
  double moved_m = 0, speed_mps = 0;
};

Slid let_go(const Context& context, Block block, SlopeWorld::Ground ground, double angle_rad, double seconds) {
  SlopeWorld slope(context, angle_rad, kFriction, ground);
  const BodyId body = slope.put(block.make(slope.world), kHeightM);
  const Vec3 start = slope.world.at(body).position_m;
  for (int i = 0; i < 60 * seconds; ++i) slope.world.step(1.0 / 60);
  const BodyState end = slope.world.at(body);
  return {(end.position_m - start).norm(), end.velocity_mps.norm()};
}

void on_slope(Context& context, Block block, SlopeWorld::Ground ground) {
  const double limit_rad = std::atan(kFriction);
  // A tenth of a degree above the limit the block reaches 38 mm/s after two seconds; below the limit it stays at rest.
  const double found_rad = begins_at(limit_rad - 6 * kDegree, limit_rad + 6 * kDegree, 10, [&](double angle_rad) {
    return let_go(context, block, ground, angle_rad, 2).speed_mps > 5e-3;
  });
  context.add("angle from which it slides", "degree", found_rad / kDegree, {});
  context.add("error of that angle", "degree", std::abs(found_rad - limit_rad) / kDegree, 0.1);
  context.add("moved in 10 s, 0.1 degree below", "m",
              let_go(context, block, ground, limit_rad - 0.1 * kDegree, 10).moved_m, 1e-3);
  const double above_rad = limit_rad + 5 * kDegree;
  const double expected_m = 0.5 * kGravityMps2 * (std::sin(above_rad) - kFriction * std::cos(above_rad));
  const Slid slid = let_go(context, block, ground, above_rad, 1);
  context.add("error of the way in 1 s, 5 degrees above", "1", std::abs(slid.moved_m / expected_m - 1), 0.02);
}

}  // namespace

Status sliding_box(Context& context) {
  slide_to_stop(context, {true});
  return context.at(1);
}

Status sliding_balls(Context& context) {
  slide_to_stop(context, {false});
  return context.at(1);
}

Status slope_box(Context& context) {
  on_slope(context, {true}, SlopeWorld::Ground::Plane);
  return context.at(1);
}

Status slope_box_on_box(Context& context) {
  on_slope(context, {true}, SlopeWorld::Ground::Box);
  return context.at(1);
}

Status slope_balls(Context& context) {
  on_slope(context, {false}, SlopeWorld::Ground::Plane);
  return context.at(1);
}

}  // namespace poise::accuracy
