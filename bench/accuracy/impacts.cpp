// SPDX-License-Identifier: MIT
#include "accuracy/impacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "accuracy/small_world.h"

namespace poise::accuracy {
namespace {

struct PosedImpact {
  BodyId a, b;
  Vec3 va = Vec3::Zero(), vb = Vec3::Zero();  // the result of the closed form
  double speed_mps = 0;                       // of the faster body before the impact
};

struct Throw {
  double ra_m, rb_m, ma_kg, mb_kg;
  Vec3 normal, va, vb;  // normal from a to b; they approach along it
};

Throw random_throw(Random& random, bool head_on) {
  Throw t{random.between(0.1, 1),
          random.between(0.1, 1),
          std::pow(10, random.between(-1, 2)),
          std::pow(10, random.between(-1, 2)),
          random.direction(),
          Vec3::Zero(),
          Vec3::Zero()};
  if (head_on) {
    t.va = random.between(1, 5) * t.normal;
    t.vb = -random.between(0, 5) * t.normal;
    return t;
  }
  do {
    t.va = random.between(0.5, 5) * random.direction();
    t.vb = random.between(0, 5) * random.direction();
  } while ((t.va - t.vb).dot(t.normal) < 0.2);
  return t;
}

BodyId add_ball(SmallWorld& world, double radius_m, double mass_kg, const Vec3& place, const Vec3& velocity,
                std::uint32_t group) {
  BodyDefinition ball;
  ball.shape = world.ball(radius_m);
  ball.mass_kg = mass_kg;
  ball.position_m = place;
  ball.velocity_mps = velocity;
  ball.group = group;
  ball.collides_with = group;
  return world.add(ball);
}

// All pairs meet near the origin, where coordinates are exact; each pair is in a group of its own.
PosedImpact place(SmallWorld& world, const Throw& t, double e, double gap_m, std::uint32_t group) {
  PosedImpact m;
  m.a = add_ball(world, t.ra_m, t.ma_kg, Vec3::Zero(), t.va, group);
  m.b = add_ball(world, t.rb_m, t.mb_kg, (t.ra_m + t.rb_m + gap_m) * t.normal, t.vb, group);
  const double impulse_ns = (1 + e) * (t.va - t.vb).dot(t.normal) / (1 / t.ma_kg + 1 / t.mb_kg);
  m.va = t.va - impulse_ns / t.ma_kg * t.normal;
  m.vb = t.vb + impulse_ns / t.mb_kg * t.normal;
  m.speed_mps = std::max(t.va.norm(), t.vb.norm());
  return m;
}

double worst_error(const SmallWorld& world, const std::vector<PosedImpact>& impacts) {
  double worst = 0;
  for (const PosedImpact& m : impacts) {
    const BodyState a = world.at(m.a);
    const BodyState b = world.at(m.b);
    const double error = std::max((a.velocity_mps - m.va).norm(), (b.velocity_mps - m.vb).norm()) / m.speed_mps;
    const double spin = std::max(a.angular_velocity_radps.norm(), b.angular_velocity_radps.norm());
    worst = std::max({worst, error, spin / m.speed_mps});
  }
  return worst;
}

double worst_of(Context& context, double e, bool head_on) {
  SmallWorld world(context, Vec3::Zero(), {e, 0, 1000});
  Random random(head_on ? 11 : 12);
  std::vector<PosedImpact> impacts;
  for (int i = 0; i < 24; ++i)
    impacts.push_back(
        place(world, random_throw(random, head_on), e, head_on ? 0.3 : 0, 1U << static_cast<unsigned>(i)));
  for (int i = 0; i < (head_on ? 60 : 1); ++i) world.step(1.0 / 60);
  return worst_error(world, impacts);
}

}  // namespace

Status two_spheres(Context& context) {
  for (const double e : {0.0, 0.3, 0.5, 0.8, 1.0}) {
    context.add(fmt::format("velocity error, head-on, e = {:g}", e), "1", worst_of(context, e, true), 1e-12);
    context.add(fmt::format("velocity error, oblique, e = {:g}", e), "1", worst_of(context, e, false), 1e-12);
  }
  return context.at(1);
}

Status dropped_ball(Context& context) {
  // The n-th flight takes 2 e^n sqrt(2 h / g), the first half of that: in all sqrt(2 h / g) (1 + e) / (1 - e).
  constexpr double kHeightM = 1, kRadiusM = 0.1, kRestitution = 0.5, kStepS = 1e-3;
  const double expected_s = std::sqrt(2 * kHeightM / kGravityMps2) * (1 + kRestitution) / (1 - kRestitution);
  SmallWorld world(context, {0, 0, -kGravityMps2}, {kRestitution, 0, 1000});
  world.plane(Vec3::UnitZ(), 0);
  const BodyId ball = world.add(world.ball(kRadiusM), {0, 0, kRadiusM + kHeightM});
  double rest_s = 0;
  double deepest_m = 0;
  for (int i = 1; i <= 3000; ++i) {
    world.step(kStepS);
    // At rest means a speed that gravity could stop within a step.
    if (world.at(ball).velocity_mps.norm() > kGravityMps2 * kStepS) rest_s = i * kStepS;
    deepest_m = std::max(deepest_m, kRadiusM - world.at(ball).position_m.z());
  }
  context.add("time to rest", "s", rest_s, {});
  context.add("error of the time to rest", "1", std::abs(rest_s / expected_s - 1), 0.01);
  context.add("height above the floor at the end", "m", std::abs(world.at(ball).position_m.z() - kRadiusM), 1e-3);
  context.add("deepest penetration", "m", deepest_m, {});
  return context.at(1);
}

}  // namespace poise::accuracy
