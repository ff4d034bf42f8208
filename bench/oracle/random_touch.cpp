// SPDX-License-Identifier: MIT
#include "oracle/random_touch.h"

#include <cmath>
#include <random>

namespace poise::oracle {
namespace {

constexpr int kMostThrows = 10000;
constexpr double kGrazing = 0.01;

// Uses only exactly rounded operations and the standard's generator, so that a throw is the same on every machine.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t number, std::uint64_t draw) {
    std::seed_seq words{low(seed), high(seed), low(number), high(number), low(draw), high(draw)};
    bits_.seed(words);
  }
  double unit() { return static_cast<double>(bits_() >> 11U) * 0x1p-53; }
  double between(double least, double most) { return least + (most - least) * unit(); }
  // A point of the unit ball, by rejection.
  Vec3 in_ball() {
    for (;;) {
      const double x = between(-1, 1);
      const double y = between(-1, 1);
      const double z = between(-1, 1);
      const Vec3 point(x, y, z);
      if (point.squaredNorm() <= 1 && point.squaredNorm() > 1e-4) return point;
    }
  }
  Vec3 direction() { return in_ball().normalized(); }
  // A point of the unit ball of four dimensions, normalised to a rotation: uniformly distributed.
  Quat rotation() {
    for (;;) {
      const double w = between(-1, 1);
      const double x = between(-1, 1);
      const double y = between(-1, 1);
      const double z = between(-1, 1);
      const Quat q(w, x, y, z);
      if (q.squaredNorm() <= 1 && q.squaredNorm() > 1e-4) return q.normalized();
    }
  }

 private:
  static std::uint32_t low(std::uint64_t word) { return static_cast<std::uint32_t>(word); }
  static std::uint32_t high(std::uint64_t word) { return static_cast<std::uint32_t>(word >> 32U); }
  std::mt19937_64 bits_;
};

// A point of the unit disc perpendicular to `along`, by rejection.
Vec3 in_disc(Dice& dice, const Vec3& along) {
  const Vec3 right = along.unitOrthogonal();
  const Vec3 up = along.cross(right);
  for (;;) {
    const double x = dice.between(-1, 1);
    const double y = dice.between(-1, 1);
    if (x * x + y * y <= 1) return x * right + y * up;
  }
}

Vec3 spin(Dice& dice, double mean_radps) {
  const double rate = mean_radps * dice.between(0.5, 1.5);
  return rate * dice.direction();
}

void throw_bodies(Dice& dice, const OracleMesh& a, const OracleMesh& b, const ThrowOptions& options,
                  RandomTouch& thrown) {
  const Vec3 along = dice.direction();
  const Vec3 aim = a.radius_m() * in_disc(dice, along);
  const double apart = 1.05 * (a.radius_m() + b.radius_m());
  const double way = std::sqrt(apart * apart - aim.squaredNorm());
  thrown.a.start = {Vec3::Zero(), dice.rotation()};
  thrown.b.start = {aim - way * along, dice.rotation()};
  thrown.a.velocity_mps = -0.5 * options.speed_mps * along;
  thrown.b.velocity_mps = 0.5 * options.speed_mps * along;
  thrown.a.spin_radps = spin(dice, options.spin_radps);
  thrown.b.spin_radps = spin(dice, options.spin_radps);
  thrown.horizon_s = 2 * way / options.speed_mps;
}

}  // namespace

RandomTouch random_touch(const OracleMesh& a, const OracleMesh& b, const ThrowOptions& options, std::uint64_t number) {
  Dice dice(options.seed, number, 0);
  RandomTouch thrown;
  thrown.number = number;
  for (int round = 0; round < kMostThrows; ++round) {
    throw_bodies(dice, a, b, options, thrown);
    thrown.touch = first_touch(a, thrown.a, b, thrown.b, thrown.horizon_s);
    if (thrown.touch.outcome == FlightOutcome::Touch) {
      thrown.answer = exact_answer(a, thrown.a, b, thrown.b, thrown.touch, options.restitution);
      if (thrown.answer.approach_mps >= kGrazing * options.speed_mps) return thrown;
      ++thrown.grazing;
    } else {
      ++(thrown.touch.outcome == FlightOutcome::Undecided ? thrown.undecided : thrown.missed);
    }
  }
  thrown.touch.outcome = FlightOutcome::Miss;
  return thrown;
}

Answer shifted_answer(const OracleMesh& a, const OracleMesh& b, const ThrowOptions& options, const RandomTouch& touch,
                      double shift_m, std::uint64_t draw) {
  Dice dice(options.seed, touch.number, 1 + draw);
  Flight shifted = touch.b;
  shifted.start.position_m += shift_m * dice.direction();
  const FirstTouch met = first_touch(a, touch.a, b, shifted, touch.horizon_s);
  return exact_answer(a, touch.a, b, shifted, met, options.restitution);
}

}  // namespace poise::oracle
