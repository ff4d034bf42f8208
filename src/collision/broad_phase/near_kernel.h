// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "poise/types.h"

/// The test of a ball against many that lie side by side: in single precision, so that a register holds many. It tells
/// of each whether it is apart for sure, overlaps for sure, or has to be tested in double precision.
namespace poise::collision {

/// A ball in single precision. Two balls whose centres are as far from each other as the sum of their radii `most_m`
/// are apart; those that are nearer than the sum of their radii `least_m` overlap, in double precision as well:
/// |o_a - o_b|^2 - (r_a + r_b)^2 < 0.
struct NearBall {
  float x, y, z, most_m, least_m;
};

/// Any values: where single precision does not reach, and for what is no number, a ball that is apart from none and
/// overlaps none for sure. Nor does one that is not `plain`.
inline NearBall near_ball(const Vec3& center_m, double radius_m, bool plain) {
  // Rounding moves the centre by at most 2^-24 of its distance from the origin, and the test itself rounds by a few
  // 2^-24 of the reach. What is added keeps squares from underflow.
  constexpr double kOfDistance = 0x1p-23;
  constexpr double kOfRadius = 0x1p-20;
  constexpr double kLeastM = 1e-17;
  // Squares of what lies within overflow nowhere.
  constexpr double kFarM = 1e17;
  constexpr auto kNever = static_cast<float>(-10 * kFarM);
  const double distance = std::abs(center_m.x()) + std::abs(center_m.y()) + std::abs(center_m.z());
  if (!(distance + radius_m < kFarM)) return {0, 0, 0, -kNever, kNever};
  const double moved = kOfDistance * distance;
  const auto least = static_cast<float>((radius_m - moved) * (1 - kOfRadius) - kLeastM);
  return {static_cast<float>(center_m.x()), static_cast<float>(center_m.y()), static_cast<float>(center_m.z()),
          static_cast<float>((radius_m + moved) * (1 + kOfRadius) + kLeastM), plain ? least : kNever};
}

/// Arrays of balls, and what is known of each beside: only those of equal tag are compared.
struct NearBalls {
  static constexpr std::size_t kPast = 8;  ///< elements that may be read behind the last
  const float *x, *y, *z, *most_m, *least_m;
  const std::uint32_t* tag;
};

/// Consecutive balls to test: those of this tag.
struct NearRange {
  std::uint32_t begin = 0, end = 0;
  std::uint32_t tag = 0;
};

struct NearCount {
  std::size_t listed = 0;
  bool sure = false;  ///< all that are listed overlap the ball
};

/// Lists the balls of all ranges that are not apart from `ball` for sure, in order of ranges, into `list`, which has
/// room for all balls of the ranges and NearBalls::kPast more. Any thread; any instruction set gives the same list.
NearCount list_near(const NearBalls& balls, const NearBall& ball, std::span<const NearRange> ranges,
                    std::uint32_t* list);

}  // namespace poise::collision
