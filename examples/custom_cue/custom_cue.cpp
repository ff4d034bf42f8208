// SPDX-License-Identifier: MIT
#include <poise/world.h>

#include <cstdint>
#include <cstdio>
#include <vector>

// A game sets its own priorities with a custom cue: a plain function from a viewer's view of a pair to a factor of the
// pair's score. Here the cue favours the contacts of heroes. The same pile is stepped with and without it. The budget
// is counted work for a few levels a frame, not time, so every run prints the same figures.
namespace {

constexpr std::uint64_t kHero = 1;
constexpr int kBodies = 80;
constexpr int kFrames = 90;

double heroes_first(const poise::scheduler::PairView& pair, void*) noexcept {
  return pair.user_data.a == kHero || pair.user_data.b == kHero ? 1000 : 1;
}

poise::ShapePtr make_jack() {
  std::vector<poise::Sphere> spheres = {{poise::Vec3::Zero(), 0.28}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      spheres.push_back({side * 0.35 * poise::Vec3::Unit(axis), 0.22});
      spheres.push_back({side * 0.68 * poise::Vec3::Unit(axis), 0.18});
    }
  }
  return poise::make_spheres_shape(spheres).value();
}

/// Adds jacks above a tray of five planes; every fifth is a hero. Returns whether the World accepted all of them.
bool fill(poise::World& world) {
  const poise::MaterialId material = world.add_material({.restitution = 0.2, .friction = 0.5}).value();
  bool taken = true;
  poise::BodyDefinition wall;
  wall.motion = poise::MotionType::Static;
  wall.material = material;
  for (const poise::Vec3& normal : {poise::Vec3(0, 0, 1), poise::Vec3(1, 0, 0), poise::Vec3(-1, 0, 0),
                                    poise::Vec3(0, 1, 0), poise::Vec3(0, -1, 0)}) {
    wall.shape = world.add_shape(poise::make_plane_shape(normal, normal.z() > 0 ? 0.0 : -2.5).value());
    taken = world.add_body(wall).ok() && taken;
  }
  poise::BodyDefinition jack;
  jack.shape = world.add_shape(make_jack());
  jack.material = material;
  for (int i = 0; i < kBodies; ++i) {
    jack.position_m = {1.7 * (i % 3) - 1.7, 1.7 * (i / 3 % 3) - 1.7, 1.0 + 1.6 * (i / 9)};
    jack.orientation = poise::Quat(Eigen::AngleAxisd(0.7 * i, poise::Vec3(1, 2, 3).normalized()));
    jack.user_data = i % 5 == 0 ? kHero : 0;
    taken = world.add_body(jack).ok() && taken;
  }
  return taken;
}

struct Levels {
  double heroes = 0, others = 0;  // mean completed level of the contacts
};

Levels run(const poise::scheduler::HostCue& cue) {
  poise::WorldSettings settings;
  settings.gravity_mps2 = {0, 0, -9.81};
  settings.policy.cue = cue;
  poise::World world = poise::World::create(settings).value();
  if (!fill(world)) return {};
  double sum[2] = {0, 0};
  double count[2] = {1e-9, 1e-9};
  for (int frame = 0; frame < kFrames; ++frame) {
    world.step({.budget = poise::Budget::work(60)});
    for (const poise::Contact& contact : world.contacts()) {
      const bool hero = world.user_data(contact.a).value() == kHero || world.user_data(contact.b).value() == kHero;
      sum[hero ? 0 : 1] += contact.level;
      count[hero ? 0 : 1] += 1;
    }
  }
  return {sum[0] / count[0], sum[1] / count[1]};
}

}  // namespace

int main() {
  const Levels plain = run({});
  const Levels told = run({heroes_first, nullptr});
  std::printf("mean completed level   heroes   others\n");
  std::printf("without a cue           %6.2f   %6.2f\n", plain.heroes, plain.others);
  std::printf("heroes_first            %6.2f   %6.2f\n", told.heroes, told.others);
  return told.heroes - told.others > plain.heroes - plain.others ? 0 : 1;
}
