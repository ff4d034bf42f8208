// SPDX-License-Identifier: MIT
#include "dynamics/rotation.h"

#include <algorithm>
#include <cmath>

#include "math/functions.h"

namespace poise::dynamics {
namespace {

// Angle per part of the midpoint rule. At 0.05 rad the asymmetric top of the tests flips within 0.1 % of its time.
constexpr double kAnglePerPartRad = 0.05;
// Bounds the cost of a body that spins extremely fast: above 3 rad a step the angle of a part grows, up to one radian,
// where Newton's method still converges. Beyond 500 rad a step momentum is still conserved, and energy stays within
// what the moments allow.
constexpr double kMaxFineParts = 64;
constexpr double kMaxParts = 512;

// Newton's method on momentum_1 = momentum_0 + h m x (m / I), with m the mean of both. Body frame.
Vec3 midpoint_momentum(const Vec3& before, const Vec3& inverse_moments, double h) {
  Vec3 after = before;
  for (int iteration = 0; iteration < 8; ++iteration) {
    const Vec3 mean = 0.5 * (before + after);
    const Vec3 spin = inverse_moments.cwiseProduct(mean);
    const Vec3 residual = after - before - h * mean.cross(spin);
    Mat3 jacobian = Mat3::Identity();
    for (int column = 0; column < 3; ++column) {
      const Vec3 unit = Vec3::Unit(column);
      jacobian.col(column) -= 0.5 * h * (unit.cross(spin) + mean.cross(inverse_moments.cwiseProduct(unit)));
    }
    const Vec3 change = jacobian.inverse() * residual;
    after -= change;
    if (change.squaredNorm() <= 1e-32 * before.squaredNorm()) break;
  }
  // The midpoint rule conserves the norm; this removes the residual of Newton's method.
  const double norm = after.norm();
  return norm > 0 ? Vec3(after * (before.norm() / norm)) : before;
}

}  // namespace

Quat rotation_by(const Vec3& angle_rad) {
  const double angle = angle_rad.norm();
  if (angle < 1e-8) return Quat(1, 0.5 * angle_rad.x(), 0.5 * angle_rad.y(), 0.5 * angle_rad.z()).normalized();
  const math::SinCos half = math::sin_cos(0.5 * angle);
  const Vec3 part = angle_rad * (half.sin / angle);
  return {half.cos, part.x(), part.y(), part.z()};
}

Rotation turned_by(const Rotation& start, const Vec3& moments_kgm2, const Quat& turn, TurnKeeps keeps) {
  const Quat after = (turn * start.orientation).normalized();
  if (moments_kgm2.x() == moments_kgm2.y() && moments_kgm2.y() == moments_kgm2.z()) return {after, start.spin_radps};
  const Vec3 spin = start.orientation.conjugate() * start.spin_radps;
  const Vec3 momentum = after.conjugate() * (start.orientation * moments_kgm2.cwiseProduct(spin));
  const Vec3 kept = momentum.cwiseQuotient(moments_kgm2);
  // A needle that is tilted against its momentum would spin up about its thin axis.
  const double before = spin.dot(moments_kgm2.cwiseProduct(spin));
  const double energy = kept.dot(momentum);
  if (energy <= before) return {after, after * kept};
  if (keeps == TurnKeeps::Momentum) return start;
  return {after, std::sqrt(before / energy) * (after * kept)};
}

Rotation turned_freely(const Rotation& start, const Vec3& moments_kgm2, double time_s) {
  const double speed = start.spin_radps.norm();
  // Without spin, or with one that is no number.
  if (!(speed > 0)) return start;
  if (moments_kgm2.x() == moments_kgm2.y() && moments_kgm2.y() == moments_kgm2.z()) {
    return {(rotation_by(start.spin_radps * time_s) * start.orientation).normalized(), start.spin_radps};
  }
  const Vec3 inverse = moments_kgm2.cwiseInverse();
  const double angle_rad = speed * time_s;
  const double fine_parts = std::clamp(std::ceil(angle_rad / kAnglePerPartRad), 1.0, kMaxFineParts);
  const double parts = std::clamp(std::ceil(angle_rad), fine_parts, kMaxParts);
  const double h = time_s / parts;
  Quat turn = start.orientation;
  Vec3 momentum = moments_kgm2.cwiseProduct(turn.conjugate() * start.spin_radps);
  const Vec3 momentum_world = turn * momentum;
  for (int part = 0; part < static_cast<int>(parts); ++part) {
    const Vec3 after = midpoint_momentum(momentum, inverse, h);
    const Vec3 half = 0.5 * h * inverse.cwiseProduct(Vec3(0.5 * (momentum + after)));
    turn = (turn * Quat(1, half.x(), half.y(), half.z())).normalized();
    momentum = after;
  }
  // Restores the momentum of the start in the world frame, whatever the rounding of the orientation.
  return {turn, turn * inverse.cwiseProduct(turn.conjugate() * momentum_world)};
}

}  // namespace poise::dynamics
