// SPDX-License-Identifier: MIT
#include "geometry/primitives/rounding.h"

#include <cmath>
#include <limits>

namespace poise::geometry {

[[gnu::noinline]] Eigen::Vector3f to_float(const Vec3& v) { return v.cast<float>(); }

[[gnu::noinline]] double stored_as_float(double value) { return static_cast<double>(static_cast<float>(value)); }

[[gnu::noinline]] float round_up(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity())
                                              : nearest;
}

}  // namespace poise::geometry
