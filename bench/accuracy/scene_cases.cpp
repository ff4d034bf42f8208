// SPDX-License-Identifier: MIT
#include "accuracy/scene_cases.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "accuracy/scene_watch.h"
#include "accuracy/small_world.h"

namespace poise::accuracy {
namespace {

constexpr double kBallRadiusM = 0.1;

double cpu_now_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Kinetic energy and height over the floor, computed here and not by the engine.
double energy_of(SceneWatch& watch) {
  double sum = motions_of(watch.world(), watch.bodies()).kinetic_j;
  for (const BodyId body : watch.bodies()) {
    sum -= watch.world().mass_kg(body).value() * watch.scene().gravity_mps2.dot(watch.at(body).position_m);
  }
  return sum;
}

// Sum of the squared penetration depths of all pairs of balls, and of balls and the floor z = 0.
double squared_penetration_m2(const SceneWatch& watch) {
  std::vector<Vec3> points;
  for (const BodyId body : watch.bodies()) points.push_back(watch.at(body).position_m);
  double sum = 0;
  const auto add = [&](double depth_m) {
    if (depth_m > 0) sum += depth_m * depth_m;
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    add(kBallRadiusM - points[i].z());
    for (std::size_t k = i + 1; k < points.size(); ++k) add(2 * kBallRadiusM - (points[i] - points[k]).norm());
  }
  return sum;
}

}  // namespace

Status bouncing_balls(Context& context) {
  Result<SceneWatch> started = SceneWatch::start(context, "accuracy/bouncing.json");
  if (!started) return started.error();
  SceneWatch& watch = started.value();
  const double start_j = energy_of(watch);
  const std::uint64_t frames = watch.frames_of(20);
  double sum = 0;
  double spent_s = 0;
  for (std::uint64_t i = 0; i < frames; ++i) {
    const double before_s = cpu_now_s();
    watch.step();
    spent_s += cpu_now_s() - before_s;
    const double error = energy_of(watch) / start_j - 1;
    sum += error * error / static_cast<double>(frames);
  }
  context.add("relative energy error, root of the mean square", "1", std::sqrt(sum), 5.7e-4,
              "RaiSim 5.7e-4, ODE 5.7e-3, Bullet 0.113, DART 0.113");
  context.add("CPU time", "s", spent_s, {});
  return context.at(1);
}

Status falling_cube(Context& context) {
  Result<SceneWatch> started = SceneWatch::start(context, "accuracy/666.json");
  if (!started) return started.error();
  SceneWatch& watch = started.value();
  const std::uint64_t frames = watch.frames_of(10);
  double mean_m2 = 0;
  double spent_s = 0;
  for (std::uint64_t i = 0; i < frames; ++i) {
    const double before_s = cpu_now_s();
    watch.step();
    spent_s += cpu_now_s() - before_s;
    mean_m2 += squared_penetration_m2(watch) / static_cast<double>(frames);
  }
  context.add("summed squared penetration, mean over time", "m^2", mean_m2, 0.0153,
              "RaiSim 0.0153, ODE 0.0161, Bullet 37.4, DART 215");
  context.add("CPU time", "s", spent_s, {});
  return context.at(1);
}

}  // namespace poise::accuracy
