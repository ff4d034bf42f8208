// SPDX-License-Identifier: MIT
#pragma once

#include <random>
#include <vector>

#include "collision/front/pair_frame.h"
#include "poise/shape.h"

namespace poise::collision {

/// Three crossed rods of 13 balls.
inline ShapePtr make_jack() {
  std::vector<Sphere> spheres = {{Vec3::Zero(), 0.28}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      spheres.push_back({side * 0.35 * Vec3::Unit(axis), 0.22});
      spheres.push_back({side * 0.68 * Vec3::Unit(axis), 0.18});
    }
  }
  return make_spheres_shape(spheres).value();
}

/// A chain of many balls, so that its tree is deep.
inline ShapePtr make_worm(int balls) {
  std::vector<Sphere> spheres;
  for (int i = 0; i < balls; ++i) {
    const double t = 0.05 * i;
    spheres.push_back({Vec3(std::cos(t), std::sin(t), 0.02 * i), 0.06 + 0.02 * std::sin(3.0 * i)});
  }
  return make_spheres_shape(spheres).value();
}

inline double uniform(std::mt19937_64& random, double least, double most) {
  return least + (most - least) * static_cast<double>(random() >> 11U) * 0x1.0p-53;
}

inline Vec3 random_vector(std::mt19937_64& random, double most) {
  return {uniform(random, -most, most), uniform(random, -most, most), uniform(random, -most, most)};
}

inline Pose random_pose(std::mt19937_64& random, double spread_m) {
  const Vec3 axis = random_vector(random, 1);
  return {random_vector(random, spread_m),
          Quat(uniform(random, -1, 1), axis.x(), axis.y(), axis.z()).normalized().toRotationMatrix()};
}

}  // namespace poise::collision
