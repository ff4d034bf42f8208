// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace poise::geometry {

using Vec3f = Eigen::Vector3f;

/// Points in structure-of-arrays form, for the loops that take most of a tree's build time. They use eight or more SIMD
/// lanes where the processor has them, and give the same bits on every processor. Any thread.
struct PointList {
  std::vector<float> x, y, z;

  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] Vec3f at(std::size_t i) const { return {x[i], y[i], z[i]}; }
  void clear() {
    x.clear();
    y.clear();
    z.clear();
  }
  void add(const Vec3f& p) {
    x.push_back(p.x());
    y.push_back(p.y());
    z.push_back(p.z());
  }
};

/// Writes the squared distance of each point from `center` to `out` (at least as long) and returns the largest; 0 for
/// no point.
float squared_distances(const PointList& points, const Vec3f& center, float* out);

/// Sum of the weights of the points within `radius` of `center`. Weights are from 0 to 4096, points at most 500,000.
std::int32_t weight_within(const PointList& points, const std::vector<std::int32_t>& weights, const Vec3f& center,
                           float radius);

/// Sum of the weights of the points whose balls (of radius `reach[i]`) lie completely within `radius` of `center`;
/// limits as above.
std::int32_t weight_of_balls_within(const PointList& points, const std::vector<float>& reach,
                                    const std::vector<std::int32_t>& weights, const Vec3f& center, float radius);

}  // namespace poise::geometry
