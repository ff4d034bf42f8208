// SPDX-License-Identifier: MIT
#include "accuracy/hard_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "accuracy/small_world.h"

namespace poise::accuracy {
namespace {

/// Requirements on a hard case.
struct Sanity {
  int frames = 600;
  double dt_s = 1.0 / 60;
  double half_m = 1e3;  ///< a body farther than this from `middle` in any direction is lost
  Vec3 middle = Vec3::Zero();
  double energy_at_most = 1e-9;                  ///< gain over the start, as a share of the scale
  double later_energy_at_most = energy_at_most;  ///< the same in the next hundred frames, over their least
  double calm_mps = HUGE_VAL;                    ///< largest speed in the next hundred frames
  std::string name;                              ///< of the variant, may be empty
  std::function<void(SmallWorld&, int)> before_frame;
};

// The scale of changes of energy: the kinetic energy at the start, plus for each body the larger of its kinetic energy
// at 1 m/s and its weight times its radius.
double scale_j(const SmallWorld& world, double gravity_mps2) {
  double sum = 0;
  for (const BodyId body : world.bodies()) {
    const BodyMotion motion = motion_of(world.world(), body);
    const double radius_m = world.world().shape(body).value()->bounding_radius_m;
    sum += motion.kinetic_j() + motion.mass_kg * std::max(0.5, gravity_mps2 * radius_m);
  }
  return sum;
}

struct Sane {
  double not_finite = 0, lost = 0;
};

Sane look(const SmallWorld& world, const Sanity& sanity) {
  Sane sane;
  for (const BodyId body : world.bodies()) {
    const BodyState s = world.at(body);
    const bool finite = s.position_m.allFinite() && s.velocity_mps.allFinite() &&
                        s.angular_velocity_radps.allFinite() && std::abs(s.orientation.norm() - 1) < 1e-6;
    if (!finite) ++sane.not_finite;
    if (finite && (s.position_m - sanity.middle).cwiseAbs().maxCoeff() > sanity.half_m) ++sane.lost;
  }
  return sane;
}

double largest_speed(const SmallWorld& world) {
  double largest = 0;
  for (const BodyId body : world.bodies()) largest = std::max(largest, world.at(body).velocity_mps.norm());
  return largest;
}

void oracle(Context& context, SmallWorld& world, double gravity_mps2, const Sanity& sanity) {
  const double scale = scale_j(world, gravity_mps2);
  const double start_j = world.energy_j();
  double most_j = start_j;
  for (int i = 0; i < sanity.frames; ++i) {
    if (sanity.before_frame) sanity.before_frame(world, i);
    world.step(sanity.dt_s);
    const double now_j = world.energy_j();
    most_j = std::isfinite(now_j) ? std::max(most_j, now_j) : HUGE_VAL;
  }
  double least_j = world.energy_j();
  double gained_j = 0;
  double fastest_mps = 0;
  for (int i = 0; i < 100; ++i) {
    if (sanity.before_frame) sanity.before_frame(world, sanity.frames + i);
    world.step(sanity.dt_s);
    least_j = std::min(least_j, world.energy_j());
    gained_j = std::max(gained_j, world.energy_j() - least_j);
    fastest_mps = std::max(fastest_mps, largest_speed(world));
  }
  const Sane sane = look(world, sanity);
  const std::string with = sanity.name.empty() ? "" : ", " + sanity.name;
  context.add("bodies not finite" + with, "", sane.not_finite + world.refusals(), 0);
  context.add("bodies lost" + with, "", sane.lost, 0);
  context.add("energy above the start, as a share of its scale" + with, "1", (most_j - start_j) / scale,
              sanity.energy_at_most);
  context.add("energy gained in the next hundred frames" + with, "1", gained_j / scale, sanity.later_energy_at_most);
  if (std::isfinite(sanity.calm_mps))
    context.add("largest speed in the next hundred frames" + with, "m/s", fastest_mps, sanity.calm_mps);
}

const Vec3 kDown(0, 0, -kGravityMps2);
// Depenetration may lift a body by this share of its weight times its radius, as in the piles.
constexpr double kLift = 1e-3;
// The same of boxes that slide on spheres without friction (docs/accuracy.md, "Bounds that were measured").
constexpr double kLiftOnSpheres = 1e-2;
// The same of balls that were spawned in each other, and their largest speed.
constexpr double kLiftOfSpawned = 0.11, kSpawnedMps = 1.8;

}  // namespace

Status coinciding_centres(Context& context) {
  for (const double e : {0.0, 1.0}) {
    SmallWorld world(context, Vec3::Zero(), {e, 0, 1000});
    for (int i = 0; i < 20; ++i) world.add(world.ball(0.3 + 0.02 * i), Vec3::Zero());
    oracle(context, world, 0,
           {.half_m = 20, .calm_mps = 1e-6, .name = fmt::format("20 balls, e = {:g}", e), .before_frame = {}});
    SmallWorld moving(context, Vec3::Zero(), {e, 0, 1000});
    moving.add(moving.jack(), Vec3::Zero(), {1, 0, 0});
    moving.add(moving.ball(0.5), Vec3::Zero(), {-1, 0, 0});
    oracle(context, moving, 0,
           {.half_m = 50, .name = fmt::format("a jack and a ball that move, e = {:g}", e), .before_frame = {}});
  }
  return context.at(1);
}

Status equal_positions(Context& context) {
  for (const bool boxes : {false, true}) {
    SmallWorld world(context, Vec3::Zero(), {0.5, 0.5, 1000});
    const ShapeId shape = boxes ? world.box({0.6, 0.5, 0.4}) : world.jack();
    world.input.polygons = boxes;
    for (int i = 0; i < 12; ++i) world.add(shape, Vec3::Zero());
    oracle(context, world, 0,
           {.half_m = 20, .calm_mps = 1e-6, .name = boxes ? "12 boxes" : "12 jacks", .before_frame = {}});
  }
  return context.at(1);
}

// How fast a body of 1 g leaves from under 1 t, both cubes of 1 m and without friction: any tilt that rounding leaves
// moves it, and once it carries the tonne off its middle, the tonne tips and squeezes it out. With x from the middle,
// m x'' = N theta, I theta'' = N x and N = M g / (1 + M x^2 / I), until the contact ends at the corner.
double squeezed_out_mps(double small_kg, double large_kg) {
  constexpr double kStepS = 1e-5;
  constexpr double kCornerM = 0.70711, kBeganMps = 1;
  const double inertia_kgm2 = large_kg / 6;
  double out_m = 0;
  double speed_mps = kBeganMps;
  double tilt_rad = 0;
  double tilting_radps = 0;
  while (out_m < kCornerM) {
    const double force_n = large_kg * kGravityMps2 / (1 + large_kg * out_m * out_m / inertia_kgm2);
    speed_mps += kStepS * force_n * tilt_rad / small_kg;
    tilting_radps += kStepS * force_n * out_m / inertia_kgm2;
    out_m += kStepS * speed_mps;
    tilt_rad += kStepS * tilting_radps;
  }
  return speed_mps;
}

Status mass_ratios(Context& context) {
  for (const double friction : {0.0, 0.5}) {
    SmallWorld world(context, kDown, {0, friction, 1000});
    world.plane(Vec3::UnitZ(), 0);
    world.input.polygons = true;
    const ShapeId box = world.box({1, 1, 1});
    world.add(box, {0, 0, 0.5}, Vec3::Zero(), Quat::Identity(), Vec3::Zero(), 1e-3);
    world.add(box, {0, 0, 1.5}, Vec3::Zero(), Quat::Identity(), Vec3::Zero(), 1e3);
    const bool slides = friction == 0;
    oracle(context, world, kGravityMps2,
           {.half_m = slides ? 1e3 : 5,
            .energy_at_most = kLift,
            .calm_mps = slides ? squeezed_out_mps(1e-3, 1e3) : 0.2,
            .name = fmt::format("1 g under 1 t, friction {:g}", friction),
            .before_frame = {}});
  }
  SmallWorld world(context, Vec3::Zero(), {1, 0, 1000});
  const ShapeId ball = world.ball(0.5);
  world.closed_box(4);
  world.add(ball, {0, 0, 0}, {3, 0.1, 0}, Quat::Identity(), Vec3::Zero(), 1e3);
  for (int i = 0; i < 8; ++i) {
    world.add(ball, {i % 2 == 0 ? 2.0 : -2.0, i / 2 % 2 == 0 ? 2.0 : -2.0, i / 4 == 0 ? 2.0 : -2.0}, Vec3::Zero(),
              Quat::Identity(), Vec3::Zero(), 1e-3);
  }
  oracle(context, world, 0, {.half_m = 4, .name = "elastic, in a box", .before_frame = {}});
  return context.at(1);
}

Status random_masses(Context& context) {
  constexpr int kTowers = 20;
  constexpr double kSizes[3] = {1, 1, 0.2};
  Random random(97);
  for (const double friction : {0.0, 0.5, 1.0}) {
    double gained[2] = {0, 0};  // by spheres, by polygons
    int towers[2] = {0, 0};
    int not_finite = 0;
    for (int tower = 0; tower < kTowers; ++tower) {
      SmallWorld world(context, kDown, {0, friction, 1000});
      world.plane(Vec3::UnitZ(), 0);
      world.input.polygons = tower % 2 == 0;
      const ShapeId shapes[3] = {world.box({1, 1, 1}), world.ball(0.5), world.box({2, 2, 0.2})};
      double top_m = 0;
      const auto bodies = static_cast<int>(random.between(2, 10));
      for (int i = 0; i < bodies; ++i) {
        const auto kind = static_cast<std::size_t>(random.between(0, 3));
        const Vec3 place(random.between(-0.05, 0.05), random.between(-0.05, 0.05), top_m + 0.5 * kSizes[kind]);
        world.add(shapes[kind], place, Vec3::Zero(), Quat::Identity(), Vec3::Zero(),
                  std::pow(10.0, random.between(-3, 3)));
        top_m += kSizes[kind];
      }
      const double start_j = world.energy_j();
      double most_j = start_j;
      for (int i = 0; i < 240; ++i) {
        world.step(1.0 / 60);
        const double now_j = world.energy_j();
        most_j = std::isfinite(now_j) ? std::max(most_j, now_j) : HUGE_VAL;
      }
      not_finite += static_cast<int>(look(world, {}).not_finite);
      const bool polygons = world.input.polygons;
      const double most = polygons || friction > 0 ? kLift : kLiftOnSpheres;
      gained[polygons] = std::max(gained[polygons], most_j / start_j - 1);
      towers[polygons] += most_j > (1 + most) * start_j ? 1 : 0;
    }
    context.add(fmt::format("bodies not finite, friction {:g}", friction), "", not_finite, 0);
    for (const bool polygons : {false, true}) {
      const std::string with = fmt::format(", {}, friction {:g}", polygons ? "polygons" : "spheres", friction);
      context.add("towers of 10 that gained energy" + with, "", towers[polygons], 0);
      context.add("largest gain of energy, as a share" + with, "1", gained[polygons],
                  polygons || friction > 0 ? kLift : kLiftOnSpheres);
    }
  }
  return context.at(1);
}

Status needles_and_plates(Context& context) {
  for (const bool polygons : {false, true}) {
    SmallWorld world(context, kDown, {0.2, 0.5, 1000});
    world.tray(5);
    world.input.polygons = polygons;
    const ShapeId needle = world.box({1.5, 0.01, 0.01});
    const ShapeId plate = world.box({1, 1, 0.005});
    Random random(61);
    for (int i = 0; i < 40; ++i) {
      world.add(i % 2 == 0 ? needle : plate, Vec3(i % 2 == 0 ? 1 : -1, i / 2 % 2 == 0 ? 1 : -1, 1 + 0.45 * (i / 4) * 2),
                Vec3::Zero(), random.turn());
    }
    oracle(context, world, kGravityMps2,
           {.frames = 900,
            .half_m = 20,
            .energy_at_most = kLift,
            .calm_mps = 2,
            .name = polygons ? "by polygons" : "by spheres",
            .before_frame = {}});
  }
  return context.at(1);
}

Status one_km_per_s(Context& context) {
  SmallWorld world(context, Vec3::Zero(), {1, 0, 1000});
  world.closed_box(60);
  const ShapeId jack = world.jack();
  Random random(62);
  for (int i = 0; i < 64; ++i)
    world.add(jack, 4 * Vec3(i % 4 - 1.5, i / 4 % 4 - 1.5, i / 16 - 1.5), 1000 * random.direction(), random.turn());
  oracle(context, world, 0, {.half_m = 60 + 20, .name = "64 jacks in a box", .before_frame = {}});
  return context.at(1);
}

Status far_from_origin(Context& context) {
  const Vec3 far(1e7, -1e7, 0);
  SmallWorld world(context, kDown, {0, 0.5, 1000});
  world.plane(Vec3::UnitZ(), 0);
  world.input.polygons = true;
  const ShapeId box = world.box({0.5, 0.5, 0.5});
  for (int i = 0; i < 5; ++i) world.add(box, far + Vec3(0, 0, 0.25 + 0.5 * i));
  oracle(context, world, kGravityMps2,
         {.half_m = 3,
          .middle = far,
          .energy_at_most = kLift,
          .calm_mps = 0.2,
          .name = "five boxes on a floor",
          .before_frame = {}});
  double fell = 0;
  for (std::size_t i = 0; i < world.bodies().size(); ++i)
    fell += world.at(world.bodies()[i]).position_m.z() > 0.2 + 0.5 * static_cast<double>(i) ? 0 : 1;
  context.add("boxes that fell", "", fell, 0);

  const Vec3 corner = Vec3::Constant(1e7);
  SmallWorld gas(context, Vec3::Zero(), {1, 0, 1000});
  Random random(63);
  const ShapeId jack = gas.jack();
  for (int i = 0; i < 27; ++i)
    gas.add(jack, corner + 2 * Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1), random.in_box(2), random.turn());
  oracle(context, gas, 0, {.half_m = 200, .middle = corner, .name = "27 elastic jacks", .before_frame = {}});
  return context.at(1);
}

Status fast_spins(Context& context) {
  for (const double e : {0.0, 1.0}) {
    SmallWorld world(context, Vec3::Zero(), {e, e == 0 ? 0.5 : 0, 1000});
    const ShapeId jack = world.jack();
    Random random(64);
    for (int i = 0; i < 8; ++i) {
      const Vec3 place = 1.2 * Vec3(i % 2 - 0.5, i / 2 % 2 - 0.5, i / 4 - 0.5);
      world.add(jack, 2 * place, -place, random.turn(), 1e4 * random.direction());
    }
    oracle(context, world, 0,
           {.half_m = 1e6, .name = fmt::format("eight jacks that meet, e = {:g}", e), .before_frame = {}});
  }
  return context.at(1);
}

Status overlapping_spawn(Context& context) {
  for (const bool falling : {false, true}) {
    SmallWorld world(context, falling ? kDown : Vec3::Zero(), {0.5, 0, 1000});
    if (falling) world.tray(8);
    const ShapeId ball = world.ball(0.3);
    Random random(65);
    for (int i = 0; i < 2000; ++i) world.add(ball, Vec3(0, 0, falling ? 3 : 0) + random.in_box(2));
    // Balls that are pushed apart under gravity are lifted by that; they must not fly. After 400 frames they still are
    // (docs/accuracy.md, "Bounds that were measured").
    oracle(context, world, falling ? kGravityMps2 : 0,
           {.frames = 300,
            .half_m = 30,
            .energy_at_most = falling ? kLift : 1e-9,
            .later_energy_at_most = falling ? kLiftOfSpawned : 1e-9,
            .calm_mps = falling ? kSpawnedMps : 1e-3,
            .name = falling ? "2,000 balls over a tray" : "2,000 balls without gravity",
            .before_frame = {}});
    const Status go_on = context.at(falling ? 1 : 0.5);
    if (!go_on) return go_on;
  }
  return Done{};
}

Status time_steps(Context& context) {
  for (const double dt_s : {1e-4, 1e-3, 1.0 / 60, 0.05, 0.1}) {
    SmallWorld world(context, kDown, {0.2, 0.5, 1000});
    world.tray(4);
    const ShapeId jack = world.jack();
    Random random(66);
    for (int i = 0; i < 16; ++i)
      world.add(jack, Vec3(i % 2 - 0.5, i / 2 % 2 - 0.5, 0.55 + i / 4) * 1.9, Vec3::Zero(), random.turn());
    const bool tiny = dt_s < 2e-3;
    oracle(context, world, kGravityMps2,
           {.frames = tiny ? 4000 : 600,
            .dt_s = dt_s,
            .half_m = 12,
            .energy_at_most = kLift,
            .calm_mps = dt_s < 5e-4 ? HUGE_VAL : 0.5,
            .name = fmt::format("dt = {:.4g} s", dt_s),
            .before_frame = {}});
  }
  return context.at(1);
}

Status flipping_levels(Context& context) {
  SmallWorld world(context, kDown, {0.2, 0, 1000});
  world.tray(5);
  const ShapeId jack = world.jack();
  Random random(67);
  for (int i = 0; i < 60; ++i)
    world.add(jack, 1.9 * Vec3(i % 2 - 0.5, i / 2 % 2 - 0.5, 0.55 + i / 4), Vec3::Zero(), random.turn());
  oracle(context, world, kGravityMps2,
         {.frames = 1200,
          .half_m = 60,
          .energy_at_most = kLift,
          .calm_mps = 0.5,
          .name = "from the first frame",
          .before_frame = [](SmallWorld& w, int i) { w.input.max_level = static_cast<Level>(i % 3); }});
  return context.at(1);
}

namespace {

// False if a step has no backtracking.
template <class Input>
bool look_back(Input& input) {
  if constexpr (requires { input.backtracking = true; }) {
    input.backtracking = true;
    return true;
  }
  return false;
}

}  // namespace

Status bullet(Context& context) {
  constexpr double kSpeedMps = 500;
  for (const bool free_plate : {false, true}) {
    SmallWorld world(context, Vec3::Zero(), {0.5, 0, 1000});
    if (!look_back(world.input)) return Done{};
    world.input.polygons = true;
    const ShapeId plate = world.box({0.02, 2, 2});
    const ShapeId ball = world.ball(0.025);
    if (free_plate) {
      world.add(plate, Vec3::Zero());
    } else {
      BodyDefinition body;
      body.shape = plate;
      body.motion = MotionType::Static;
      world.add(body);
    }
    // From distances that put the impact into every part of a step (8.33 m at 60 Hz).
    std::vector<BodyId> bullets;
    const int count = free_plate ? 1 : 16;
    for (int i = 0; i < count; ++i) {
      bullets.push_back(
          world.add(ball, {-1 - 0.52 * i, 0.3 * (i % 4) - 0.45, 0.3 * (i / 4 % 4) - 0.45}, {kSpeedMps, 0, 0}));
    }
    const double start_j = world.energy_j();
    double most_j = start_j;
    for (int i = 0; i < 12; ++i) {
      world.step(1.0 / 60);
      most_j = std::max(most_j, world.energy_j());
    }
    double through = 0;
    for (const BodyId id : bullets) {
      const double beside = free_plate ? world.at(world.bodies()[0]).position_m.x() : 0;
      through += world.at(id).position_m.x() < beside ? 0 : 1;
    }
    const std::string with = free_plate ? ", free plate" : ", fixed plate";
    context.add("bullets that went through" + with, "", through, 0);
    context.add("energy gained" + with, "1", most_j / start_j - 1, 1e-12);
  }
  return context.at(1);
}

}  // namespace poise::accuracy
