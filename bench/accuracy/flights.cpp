// SPDX-License-Identifier: MIT
#include "accuracy/flights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "accuracy/small_world.h"

namespace poise::accuracy {

Status free_flight(Context& context) {
  const Vec3 gravity(0.7, -1.3, -kGravityMps2);
  for (const double dt_s : {1e-4, 1.0 / 60, 0.1}) {
    SmallWorld world(context, gravity, {0, 0, 1000});
    const Vec3 x0(3, -2, 100);
    const Vec3 v0(4, 5, 30);
    const BodyId jack = world.add(world.jack(), x0, v0, Quat(0.3, 0.4, 0.5, 0.6).normalized(), {1, 2, 3});
    double place = 0;
    double speed = 0;
    double scale_m = x0.norm();
    for (int i = 1; i <= 1000; ++i) {
      world.step(dt_s);
      const double t = i * dt_s;
      const Vec3 x = x0 + t * v0 + 0.5 * t * t * gravity;
      const Vec3 v = v0 + t * gravity;
      scale_m = std::max({scale_m, x.norm(), t * v0.norm()});
      place = std::max(place, (world.at(jack).position_m - x).norm() / scale_m);
      speed = std::max(speed, (world.at(jack).velocity_mps - v).norm() / std::max(v0.norm(), v.norm()));
    }
    context.add(fmt::format("error of the place, dt = {:.4g} s", dt_s), "1", place, 1e-12);
    context.add(fmt::format("error of the velocity, dt = {:.4g} s", dt_s), "1", speed, 1e-12);
  }
  return context.at(1);
}

Status spinning_top(Context& context) {
  // Euler's equations without torque, solved by Jacobi's elliptic functions: w_2 = 0 after one quarter of its period,
  // then twice a period.
  constexpr double kFirstS = 10.916913, kBetweenS = 19.552867;
  constexpr double kStepS = 1.0 / 240;
  SmallWorld world(context, Vec3::Zero(), {0, 0, 1000});
  BodyDefinition body;
  body.shape = world.ball(1);
  body.mass_kg = 1;
  body.inertia_kgm2 = {1, 2, 3};
  body.angular_velocity_radps = {0.01, 1, 0.01};
  const BodyId top = world.add(body);
  const Vec3 start_l(0.01, 2, 0.03);
  const double start_j = 0.5 * (0.01 * 0.01 + 2 + 3 * 0.01 * 0.01);
  std::vector<double> flips_s;
  double before = 1;
  double worst_l = 0;
  double worst_j = 0;
  for (int i = 1; i * kStepS < kFirstS + 2 * kBetweenS + 1; ++i) {
    world.step(kStepS);
    const BodyState state = world.at(top);
    const Vec3 w = state.orientation.conjugate() * state.angular_velocity_radps;
    const Vec3 l(w.x(), 2 * w.y(), 3 * w.z());
    worst_l = std::max(worst_l, (state.orientation * l - start_l).norm() / start_l.norm());
    worst_j = std::max(worst_j, std::abs(0.5 * w.dot(l) / start_j - 1));
    if (w.y() * before < 0) flips_s.push_back((i - 1 + before / (before - w.y())) * kStepS);
    before = w.y();
  }
  const auto flip_error = [&](std::size_t k) {
    return k < flips_s.size() ? std::abs(flips_s[k] - kFirstS - static_cast<double>(k) * kBetweenS) : std::nan("");
  };
  context.add("error of the first flip, at 10.916913 s", "s", flip_error(0), 1e-3);
  context.add("error of the second flip, 19.552867 s later", "s", flip_error(1), 1e-3);
  context.add("error of the third flip", "s", flip_error(2), 1e-3);
  context.add("change of angular momentum as a vector", "1", worst_l, 1e-9);
  context.add("change of energy", "1", worst_j, 1e-9);
  return context.at(1);
}

}  // namespace poise::accuracy
