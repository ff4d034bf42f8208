// SPDX-License-Identifier: MIT
#include <poise/world.h>

#include <cstdio>

// A ball falls on a floor. Every call that can be refused returns a poise::Result; value() would throw on a refusal.
int main() {
  poise::WorldSettings settings;
  settings.gravity_mps2 = {0, 0, -9.81};
  poise::World world = poise::World::create(settings).value();
  const poise::MaterialId rubber = world.add_material({.restitution = 0.5, .friction = 0.6}).value();

  poise::BodyDefinition floor;
  floor.shape = world.add_shape(poise::make_plane_shape({0, 0, 1}, 0).value());
  floor.material = rubber;
  floor.motion = poise::MotionType::Static;
  poise::BodyDefinition ball;
  ball.shape = world.add_shape(poise::make_sphere_shape(0.5).value());
  ball.material = rubber;
  ball.position_m = {0, 0, 3};
  const bool placed = world.add_body(floor).ok();
  const poise::BodyId id = world.add_body(ball).value();

  for (int frame = 0; frame < 180; ++frame) {
    world.step({.budget = poise::Budget::within(std::chrono::milliseconds(4))});
    if (frame % 30 == 29) std::printf("%.1f s: %.3f m\n", (frame + 1) / 60.0, world.state(id).value().position_m.z());
  }
  const double height_m = world.state(id).value().position_m.z();
  return placed && height_m > 0.45 && height_m < 0.6 ? 0 : 1;
}
