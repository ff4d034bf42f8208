// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <optional>

#include "poise/world.h"

/// Checks of what comes from outside, at the door of the World: each gives the refusal, or nothing.
namespace poise::simulation {

// Beyond these, products of a few of them leave the range of double, or what is left of its precision means nothing.
inline constexpr double kMaxPositionM = 1e12;
inline constexpr double kMaxSpeedMps = 1e9;
inline constexpr double kMaxSpinRadps = 1e9;
inline constexpr double kMaxAccelerationMps2 = 1e9;
inline constexpr double kMaxForceN = 1e30;
inline constexpr double kMinDensityKgpm3 = 1e-9;
inline constexpr double kMaxDensityKgpm3 = 1e12;
inline constexpr double kMinMassKg = 1e-18;
inline constexpr double kMaxMassKg = 1e18;
inline constexpr double kMaxImportance = 1e6;
/// Of the mass times the square of the bounding radius. Chosen: a needle a million times as long as it is thick has as
/// much about its axis, and with a hundredth of it resting contact in single precision still is sound.
inline constexpr double kLeastOfInertia = 1e-12;

/// `field = value, must be in [least, most]`; a number that is not finite is out of every range.
std::optional<Error> check_range(const char* field, double value, double least, double most);
/// Each component finite and within `most` of zero.
std::optional<Error> check_vector(const char* field, const Vec3& value, double most);
/// The refusal of a handle that names nothing.
Error stale_body(BodyId body);
std::optional<Error> check_settings(const WorldSettings& settings);
std::optional<Error> check_body(const BodyDefinition& definition, const Shape& shape);
std::optional<Error> check_state(const BodyState& state, bool is_static);

/// Would check_state accept it? With a unit quaternion. Any thread.
inline bool in_range(const BodyState& state) {
  const auto within = [](const Vec3& value, double most) {
    return std::abs(value.x()) <= most && std::abs(value.y()) <= most && std::abs(value.z()) <= most;
  };
  return within(state.position_m, kMaxPositionM) && within(state.velocity_mps, kMaxSpeedMps) &&
         within(state.angular_velocity_radps, kMaxSpinRadps) && std::abs(state.orientation.squaredNorm() - 1.0) <= 1e-9;
}

struct BodyMass {
  double mass_kg = 0;
  Vec3 principal_kgm2 = Vec3::Zero();
};
/// From the definition, and from shape and density where that is silent. Zero for static bodies.
Result<BodyMass> mass_of(const BodyDefinition& definition, const Shape& shape, double density_kgpm3);

}  // namespace poise::simulation
