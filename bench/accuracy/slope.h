// SPDX-License-Identifier: MIT
#pragma once

#include <numbers>

#include "accuracy/small_world.h"

namespace poise::accuracy {

inline constexpr double kDegree = std::numbers::pi / 180;

/// A World with one slope through the origin, which descends along a direction that is not an axis. Restitution is 0.
class SlopeWorld {
 public:
  enum class Ground { Plane, Box };
  SlopeWorld(const Context& context, double angle_rad, double friction, Ground ground)
      : world(context, {0, 0, -kGravityMps2}, {0, friction, 1000}),
        turn(Eigen::AngleAxisd(0.4, Vec3::UnitZ()) * Eigen::AngleAxisd(angle_rad, Vec3::UnitY())) {
    world.input.polygons = true;
    if (ground == Ground::Plane) {
      world.plane(up(), 0);
      return;
    }
    BodyDefinition body;
    body.shape = world.box({12, 12, 1});
    body.motion = MotionType::Static;
    body.position_m = -0.5 * up();
    body.orientation = turn;
    world.add(body);
  }

  [[nodiscard]] Vec3 up() const { return turn * Vec3::UnitZ(); }  ///< away from the ground
  [[nodiscard]] Vec3 downhill() const { return turn * Vec3::UnitX(); }
  /// Adds a body with its origin at this height above the ground, and its axes along the slope's.
  BodyId put(ShapeId shape, double height_m, const Vec3& velocity_mps = Vec3::Zero(), double downhill_m = 0) {
    return world.add(shape, height_m * up() + downhill_m * downhill(), velocity_mps, turn);
  }

  SmallWorld world;
  Quat turn;
};

/// Bisects for the value at which `happens` (false at `low`, true at `high`) becomes true, to (high - low) / 2^rounds.
template <class Happens>
double begins_at(double low, double high, int rounds, const Happens& happens) {
  if (happens(low) || !happens(high)) return happens(low) ? low : high;
  for (int i = 0; i < rounds; ++i) {
    const double middle = 0.5 * (low + high);
    (happens(middle) ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace poise::accuracy
