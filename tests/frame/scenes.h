// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <random>
#include <vector>

#include "poise/world.h"

namespace poise {

/// A World with a few shapes and short functions to fill it; every refusal fails the test.
struct Stage {
  World world;
  MaterialId material;
  std::vector<BodyId> bodies;  // dynamic ones, in order

  explicit Stage(const WorldSettings& settings, double restitution = 0.5)
      : world(World::create(with_short_fronts(settings)).value()),
        material(world.add_material({restitution, 0, 1000}).value()) {}

  /// Tests create hundreds of Worlds: touching the default capacity for fronts would cost more than stepping.
  static WorldSettings with_short_fronts(WorldSettings settings) {
    settings.max_front_entries = std::min(settings.max_front_entries, 1U << 18U);
    return settings;
  }
  ShapeId ball(double radius_m) { return world.add_shape(make_sphere_shape(radius_m).value()); }
  ShapeId jack() {
    std::vector<Sphere> spheres = {{Vec3::Zero(), 0.28}};
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-1.0, 1.0}) {
        spheres.push_back({side * 0.35 * Vec3::Unit(axis), 0.22});
        spheres.push_back({side * 0.68 * Vec3::Unit(axis), 0.18});
      }
    }
    return world.add_shape(make_spheres_shape(spheres).value());
  }
  BodyId add(ShapeId shape, const Vec3& position, const Vec3& velocity = Vec3::Zero(), const Vec3& spin = Vec3::Zero(),
             const Quat& orientation = Quat::Identity()) {
    BodyDefinition body;
    body.shape = shape;
    body.material = material;
    body.position_m = position;
    body.velocity_mps = velocity;
    body.angular_velocity_radps = spin;
    body.orientation = orientation;
    const Result<BodyId> id = world.add_body(body);
    EXPECT_TRUE(id.ok()) << (id.ok() ? "" : id.error().message);
    bodies.push_back(id.value());
    return id.value();
  }
  BodyId plane(const Vec3& normal, double offset_m) {
    BodyDefinition body;
    body.shape = world.add_shape(make_plane_shape(normal, offset_m).value());
    body.material = material;
    body.motion = MotionType::Static;
    return world.add_body(body).value();
  }
  void tray(double side_m) {
    plane(Vec3::UnitZ(), 0);
    for (const int axis : {0, 1}) {
      for (const double side : {-1.0, 1.0}) plane(side * Vec3::Unit(axis), -0.5 * side_m);
    }
  }
  /// Jacks on a loose grid above a tray.
  void jacks(int count, double side_m) {
    std::mt19937_64 random(7);
    const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
    const ShapeId shape = jack();
    tray(side_m);
    const int row = std::max(1, static_cast<int>(side_m / 1.9));
    for (int i = 0; i < count; ++i) {
      // In separate statements: compilers evaluate the arguments of a call in different orders.
      std::array<double, 7> drawn{};
      for (double& number : drawn) number = unit();
      const Vec3 cell(i % row - 0.5 * (row - 1), (i / row) % row - 0.5 * (row - 1), i / (row * row));
      add(shape, Vec3(0, 0, 1.1) + 1.9 * cell + 0.08 * Vec3(drawn[6], drawn[5], drawn[4]), Vec3::Zero(), Vec3::Zero(),
          Quat(drawn[3], drawn[2], drawn[1], drawn[0]));
    }
  }
  BodyState at(BodyId body) const { return world.state(body).value(); }
};

inline WorldSettings one_thread_with_gravity() {
  WorldSettings settings;
  settings.threads = 1;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  return settings;
}

inline StepInput step_of(double dt_s) {
  StepInput input;
  input.dt_s = dt_s;
  return input;
}

/// A step whose deadline has long passed.
inline StepInput hopeless() {
  StepInput input = step_of(1.0 / 60);
  input.budget = Budget::until(SteadyClock::now() - std::chrono::hours(1));
  return input;
}

}  // namespace poise
