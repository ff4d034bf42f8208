// SPDX-License-Identifier: MIT
#pragma once

#include "poise/types.h"

namespace poise::geometry {

/// Limits of the lengths and coordinates of shapes, in metres: wide enough for any scene, narrow enough that squares
/// are far inside single precision. Chosen, not measured.
inline constexpr double kSmallestLength_m = 1e-9;
inline constexpr double kLargestLength_m = 1e9;

// These are never inlined: GCC 12.2 at -O2 (its straight-line vectoriser) removes the rounding of a vector that is
// converted to float and back to double in one function, so a radius would be computed about a centre that is not the
// stored one. Measured: leaves 1.5e-6 m too small, 40 m from the origin. -O1, -fno-tree-slp-vectorize and Clang 14 are
// correct.

/// Each coordinate rounded to the nearest float.
Eigen::Vector3f to_float(const Vec3& v);
/// The value of a number after storage as the nearest float.
double stored_as_float(double value);
/// The smallest float that is not below `value`; value finite and within the range of float.
float round_up(double value);

/// Radius of a ball with a float centre that contains everything within `reach_m` of it, rounding included. The
/// relative part is a thousand times the error of a distance in double.
inline float covering_radius(double reach_m, double scale_m) {
  return round_up(reach_m * (1 + 1e-12) + scale_m * 1e-12);
}

}  // namespace poise::geometry
