// SPDX-License-Identifier: MIT
#include "accuracy/equal_shares.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "accuracy/small_world.h"

namespace poise::accuracy {
namespace {

// Fills a box of half side half_m with balls on a grid; every second one has the mass `heavy`.
void fill(SmallWorld& world, int rows, double half_m, double radius_m, double heavy_kg, double light_kg,
          double light_mps, double heavy_mps) {
  Random random(41);
  const ShapeId ball = world.ball(radius_m);
  const double apart_m = 2 * half_m / rows;
  for (int i = 0; i < rows * rows * rows; ++i) {
    const Vec3 place =
        apart_m * (Vec3(i % rows, i / rows % rows, i / (rows * rows)) + Vec3::Constant(0.5)) - Vec3::Constant(half_m);
    const bool heavy = i % 2 == 0;
    world.add(ball, place, (heavy ? heavy_mps : light_mps) * random.direction(), Quat::Identity(), Vec3::Zero(),
              heavy ? heavy_kg : light_kg);
  }
}

// Mean kinetic energy of the heavy balls and of the light ones.
std::array<double, 2> mean_energies(const SmallWorld& world, double heavy_kg, double light_kg) {
  std::array<double, 2> sums{};
  for (std::size_t i = 0; i < world.bodies().size(); ++i) {
    const bool heavy = i % 2 == 0;
    sums[heavy ? 0 : 1] += 0.5 * (heavy ? heavy_kg : light_kg) * world.at(world.bodies()[i]).velocity_mps.squaredNorm();
  }
  const double half = 0.5 * static_cast<double>(world.bodies().size());
  return {sums[0] / half, sums[1] / half};
}

// Did a ball of the first ring and one of the second exchange an impulse in the last step?
bool rings_met(const SmallWorld& world, std::ptrdiff_t balls_of_first) {
  const auto first_end = world.bodies().begin() + balls_of_first;
  const auto of_first = [&](BodyId body) { return std::find(world.bodies().begin(), first_end, body) != first_end; };
  return std::ranges::any_of(world.world().contacts(), [&](const Contact& contact) {
    return contact.impulse_ns.squaredNorm() > 0 && of_first(contact.a) != of_first(contact.b);
  });
}

}  // namespace

Status two_gases(Context& context) {
  // Statistical mechanics: every degree of freedom has the same mean energy, whatever the mass (equipartition).
  constexpr double kHeavyKg = 4, kLightKg = 1, kStepS = 1.0 / 120;
  constexpr int kWarmFrames = 6000, kBlocks = 24, kBlockFrames = 600;
  SmallWorld world(context, Vec3::Zero(), {1, 0, 1000});
  world.closed_box(2);
  fill(world, 6, 2, 0.15, kHeavyKg, kLightKg, 4, 0);
  const double start_j = world.energy_j();
  for (int i = 0; i < kWarmFrames; ++i) world.step(kStepS);
  // Blocks much longer than the mean time between two impacts of a ball (0.3 s) are independent; their spread gives the
  // error of the mean.
  std::vector<double> blocks;
  for (int b = 0; b < kBlocks; ++b) {
    std::array<double, 2> sums{};
    for (int i = 0; i < kBlockFrames; ++i) {
      world.step(kStepS);
      const auto energies = mean_energies(world, kHeavyKg, kLightKg);
      sums[0] += energies[0];
      sums[1] += energies[1];
    }
    blocks.push_back(2 * (sums[0] - sums[1]) / (sums[0] + sums[1]));
    const Status go_on = context.at((b + 1.0) / kBlocks);
    if (!go_on) return go_on;
  }
  double mean = 0;
  for (const double block : blocks) mean += block / kBlocks;
  double spread = 0;
  for (const double block : blocks) spread += (block - mean) * (block - mean) / (kBlocks - 1);
  const double error = std::sqrt(spread / kBlocks);
  context.add("difference of the mean energies", "1", std::abs(mean), 0.05);
  context.add("difference of the mean energies, in standard errors", "1", std::abs(mean) / error, 3);
  context.add("change of the energy of all", "1", std::abs(world.energy_j() / start_j - 1), 1e-9);
  return Done{};
}

Status spinning_rings(Context& context) {
  using std::numbers::pi;
  constexpr int kBalls = 24;
  {
    // 16 balls in one body lie on a floor without friction and turn.
    std::vector<Sphere> spheres;
    for (int i = 0; i < 16; ++i) spheres.push_back({Vec3(std::cos(i * pi / 8), std::sin(i * pi / 8), 0), 0.2});
    SmallWorld world(context, {0, 0, -kGravityMps2}, {0, 0, 1000});
    world.plane(Vec3::UnitZ(), 0);
    world.add(world.shape(make_spheres_shape(spheres).value()), {0, 0, 0.2}, Vec3::Zero(), Quat::Identity(),
              {0, 0, 10});
    // About the vertical: neither weight nor floor can change this component.
    const double start = motions_of(world.world(), world.bodies()).angular_momentum_js.z();
    double worst = 0;
    for (int i = 0; i < 600; ++i) {
      world.step(1.0 / 60);
      worst = std::max(worst, std::abs(motions_of(world.world(), world.bodies()).angular_momentum_js.z() / start - 1));
    }
    context.add("change of angular momentum, one body of 16 balls on a smooth floor, 10 s", "1", worst, 1e-9);
  }
  for (const double friction : {0.0, 0.5}) {
    // Two rings of 24 single balls rotate in opposite directions and fall onto each other.
    SmallWorld world(context, Vec3::Zero(), {0.3, friction, 1000});
    const ShapeId ball = world.ball(0.1);
    for (int ring = 0; ring < 2; ++ring) {
      for (int i = 0; i < kBalls; ++i) {
        const double angle = pi / 12 * (i + 0.5 * ring);
        const Vec3 out(std::cos(angle), std::sin(angle), 0);
        const Vec3 along(-out.y(), out.x(), 0);
        world.add(ball, (1 + 0.35 * ring) * out + Vec3(0, 0, 0.02 * ring),
                  (ring == 0 ? 2.0 : -1.0) * along - 0.8 * ring * out);
      }
    }
    const Motions start = motions_of(world.world(), world.bodies());
    double worst = 0;
    bool met = false;
    for (int i = 0; i < 240; ++i) {
      world.step(1.0 / 120);
      met = met || rings_met(world, kBalls);
      const Vec3 now = motions_of(world.world(), world.bodies()).angular_momentum_js;
      worst = std::max(worst, (now - start.angular_momentum_js).norm() / start.scale.angular_momentum_js);
    }
    const std::string with = friction > 0 ? ", friction 0.5" : "";
    context.add("change of angular momentum, two rings of 24 balls" + with, "1", worst, 1e-12);
    context.add("rings that missed each other" + with, "", met ? 0 : 2, 0);
  }
  return context.at(1);
}

Status million_impacts(Context& context) {
  constexpr double kImpacts = 1e6;
  SmallWorld world(context, Vec3::Zero(), {1, 0, 1000});
  world.closed_box(2);
  fill(world, 8, 2, 0.18, 2, 1, 8, 6);
  const double start_j = world.energy_j();
  double impacts = 0;
  double worst = 0;
  for (int i = 0; i < 40000 && impacts < kImpacts; ++i) {
    world.step(1.0 / 120);
    for (const Contact& contact : world.world().contacts()) impacts += contact.impulse_ns.squaredNorm() > 0 ? 1 : 0;
    if (i % 50 != 0) continue;
    worst = std::max(worst, std::abs(world.energy_j() / start_j - 1));
    const Status go_on = context.at(impacts / kImpacts);
    if (!go_on) return go_on;
  }
  std::size_t lost = 0;
  for (const BodyId body : world.bodies()) lost += world.at(body).position_m.cwiseAbs().maxCoeff() < 2 ? 0U : 1U;
  context.add("impacts short of a million", "", std::max(0.0, kImpacts - impacts), 0);
  context.add("change of energy", "1", worst, 1e-9);
  context.add("balls outside the box", "", static_cast<double>(lost), 0);
  return Done{};
}

}  // namespace poise::accuracy
