// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace poise::geometry {

using Vec3f = Eigen::Vector3f;

/// The kernels that say so read, and write, so many numbers more than they are asked for: their SIMD lanes are at most
/// as many.
inline constexpr std::size_t kReadBeyond = 16;

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
  void resize(std::size_t size) {
    x.resize(size);
    y.resize(size);
    z.resize(size);
  }
};

/// Writes the squared distance of each point from `center` to `out` (at least as long) and returns the largest; 0 for
/// no point.
float squared_distances(const PointList& points, const Vec3f& center, float* out);

/// The largest squared distance of the points [first, last) from `center`; 0 for no point. `points` has kReadBeyond
/// more than `last`.
float largest_squared_distance(const PointList& points, std::size_t first, std::size_t last, const Vec3f& center);

/// Squared distances from a centre.
struct DistanceRange {
  Vec3f center;
  float least = 0, most = 0;  ///< both included
};

/// Writes the indices of the points [first, last) in the range to `out`, ascending, and returns their number; with
/// `count` (or null) only of those whose number there is 0. `points` and `count` have kReadBeyond more than `last`, and
/// `out` has room for as many more.
std::size_t points_between(const PointList& points, std::uint32_t first, std::uint32_t last, const DistanceRange& range,
                           const std::uint32_t* count, std::uint32_t* out);

/// Writes the indices of the `count` balls that reach beyond `radius`, by the squared distances of their middles and
/// their own radii, to `out`, ascending, and returns their number. All have kReadBeyond more than `count`.
std::size_t balls_beyond(const float* squared_distance, const float* reach, std::size_t count, float radius,
                         std::uint32_t* out);

/// Sum of the weights of the points within `radius` of `center`. Weights are from 0 to 4096, points at most 500,000.
std::int32_t weight_within(const PointList& points, const std::vector<std::int32_t>& weights, const Vec3f& center,
                           float radius);

/// Sum of the weights of the points whose balls (of radius `reach[i]`) lie completely within `radius` of `center`;
/// limits as above.
std::int32_t weight_of_balls_within(const PointList& points, const std::vector<float>& reach,
                                    const std::vector<std::int32_t>& weights, const Vec3f& center, float radius);

}  // namespace poise::geometry
