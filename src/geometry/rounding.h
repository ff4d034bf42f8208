// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <limits>

#include "poise/types.h"

namespace poise::geometry {

/// Lengths and coordinates that shapes accept, in metres: wide enough for any scene, narrow enough that squares
/// stay far inside single precision. Chosen, not measured.
inline constexpr double kSmallestLength_m = 1e-9;
inline constexpr double kLargestLength_m = 1e9;

/// The smallest float that is not below `value`; value finite and within the range of float.
inline float round_up(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest;
}

inline Eigen::Vector3f to_float(const Vec3& v) { return v.cast<float>(); }

/// Radius of a ball with a float centre that holds everything within `reach_m` of it, rounding included. The relative
/// part is a thousand times the error of a distance in double.
inline float covering_radius(double reach_m, double scale_m) { return round_up(reach_m * (1 + 1e-12) + scale_m * 1e-12); }

}  // namespace poise::geometry
