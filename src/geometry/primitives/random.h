// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>

#include "poise/types.h"

namespace poise::geometry {

/// SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014): a counter with a
/// mixing function. Everything here uses only exactly rounded operations, so a scene is the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// An independent generator for each pair of numbers.
  static Random of(std::uint64_t seed, std::uint64_t index) {
    Random first(seed);
    return Random(first.next() ^ (index * 0xd1342543de82ef95ULL));
  }

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
  }
  /// In [0, 1), 53 bits.
  double unit() { return static_cast<double>(next() >> 11U) * 0x1p-53; }
  /// In [-1, 1).
  double symmetric() { return 2 * unit() - 1; }
  /// In [0, n), n > 0; the bias is below n / 2^64.
  std::uint64_t below(std::uint64_t n) { return next() % n; }

  /// Uniformly distributed on the unit sphere (Marsaglia, "Choosing a Point from the Surface of a Sphere", 1972).
  Vec3 direction() {
    for (;;) {
      const double a = symmetric();
      const double b = symmetric();
      const double s = a * a + b * b;
      if (s >= 1) continue;
      const double scale = 2 * std::sqrt(1 - s);
      return {a * scale, b * scale, 1 - 2 * s};
    }
  }
  /// Uniformly distributed rotation (the same paper, for the sphere in four dimensions).
  Quat rotation() {
    for (;;) {
      const double a = symmetric();
      const double b = symmetric();
      const double s = a * a + b * b;
      if (s >= 1) continue;
      const double c = symmetric();
      const double d = symmetric();
      const double t = c * c + d * d;
      if (t >= 1 || t == 0) continue;
      const double scale = std::sqrt((1 - s) / t);
      return Quat(a, b, c * scale, d * scale).normalized();
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace poise::geometry
