// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "accuracy/impacts.h"
#include "accuracy/small_world.h"

namespace poise::accuracy {
namespace {

// Largest deviation of the final velocities from (0, 0, 0, 0, 1).
double row_of_balls(const Context& context, double gap_m, double dt_s) {
  constexpr double kRadiusM = 0.5;
  SmallWorld world(context, Vec3::Zero(), {1, 0, 1000});
  const ShapeId ball = world.ball(kRadiusM);
  std::vector<BodyId> balls;
  for (int i = 0; i < 5; ++i) {
    const double x = i * (2 * kRadiusM + gap_m) - (i == 0 ? 0.25 : 0);
    balls.push_back(world.add(ball, {x, 0, 0}, {i == 0 ? 1.0 : 0.0, 0, 0}));
  }
  for (double t = 0; t < 1; t += dt_s) world.step(dt_s);
  double worst = 0;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    worst = std::max(worst, (world.at(balls[i]).velocity_mps - Vec3(i == 4 ? 1 : 0, 0, 0)).norm());
  }
  return worst;
}

}  // namespace

Status five_balls(Context& context) {
  context.add("velocity error, balls touch", "m/s", row_of_balls(context, 0, 1.0 / 60), 1e-9);
  context.add("velocity error, balls touch, dt = 1 ms", "m/s", row_of_balls(context, 0, 1e-3), 1e-9);
  context.add("velocity error, 1 mm between them", "m/s", row_of_balls(context, 1e-3, 1.0 / 60), 1e-9);
  return context.at(1);
}

}  // namespace poise::accuracy
