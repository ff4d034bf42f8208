// SPDX-License-Identifier: MIT
#include "geometry/primitives/enclosing_ball.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

namespace poise::geometry {
namespace {

struct Support {
  std::array<Vec3, 5> points;
  int count = 0;
};

/// The ball through all points of a subset with its centre in their affine hull. False for dependent points.
bool ball_through(const std::array<Vec3, 4>& points, int count, Vec3& center, double& squared_radius) {
  if (count == 1) {
    center = points[0];
    squared_radius = 0;
    return true;
  }
  const int unknowns = count - 1;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> gram(unknowns, unknowns);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> right(unknowns);
  for (int i = 0; i < unknowns; ++i) {
    const Vec3 edge_i = points[static_cast<std::size_t>(i) + 1] - points[0];
    right(i) = 0.5 * edge_i.squaredNorm();
    for (int j = 0; j < unknowns; ++j) gram(i, j) = edge_i.dot(points[static_cast<std::size_t>(j) + 1] - points[0]);
  }
  const auto factors = gram.fullPivLu();
  if (!factors.isInvertible()) return false;
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> weights = factors.solve(right);
  Vec3 offset = Vec3::Zero();
  for (int i = 0; i < unknowns; ++i) offset += weights(i) * (points[static_cast<std::size_t>(i) + 1] - points[0]);
  if (!offset.allFinite()) return false;
  center = points[0] + offset;
  squared_radius = offset.squaredNorm();
  return true;
}

/// The smallest ball of at most five points, by trying every subset of up to four; the support becomes that subset.
bool solve_small(Support& support, Vec3& center, double& squared_radius) {
  bool found = false;
  Support best;
  const unsigned subsets = 1U << support.count;
  for (unsigned subset = 1; subset < subsets; ++subset) {
    std::array<Vec3, 4> chosen;
    int count = 0;
    bool fits = true;
    for (int i = 0; i < support.count && fits; ++i) {
      if ((subset >> i & 1U) == 0) continue;
      fits = count < 4;
      if (fits) chosen[static_cast<std::size_t>(count++)] = support.points[static_cast<std::size_t>(i)];
    }
    Vec3 c;
    double r2 = 0;
    if (!fits || !ball_through(chosen, count, c, r2) || (found && r2 >= squared_radius)) continue;
    bool holds = true;
    for (int i = 0; i < support.count && holds; ++i) {
      holds = (support.points[static_cast<std::size_t>(i)] - c).squaredNorm() <= r2 * (1 + 1e-12);
    }
    if (!holds) continue;
    found = true;
    center = c;
    squared_radius = r2;
    best.count = count;
    for (int i = 0; i < count; ++i) best.points[static_cast<std::size_t>(i)] = chosen[static_cast<std::size_t>(i)];
  }
  if (found) support = best;
  return found;
}

std::size_t farthest_point(std::span<const Vec3> points, const Vec3& from, double& squared_distance) {
  std::size_t farthest = 0;
  squared_distance = -1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double d2 = (points[i] - from).squaredNorm();
    if (d2 > squared_distance) {
      squared_distance = d2;
      farthest = i;
    }
  }
  return farthest;
}

double reach_of(std::span<const Sphere> balls, const Vec3& from, std::size_t* farthest = nullptr) {
  double reach = 0;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const double r = (balls[i].center_m - from).norm() + balls[i].radius_m;
    if (r > reach) {
      reach = r;
      if (farthest != nullptr) *farthest = i;
    }
  }
  return reach;
}

}  // namespace

Sphere enclosing_ball(std::span<const Vec3> points) {
  if (points.empty()) return {};
  Support support;
  support.points[0] = points[0];
  support.count = 1;
  Vec3 center = points[0];
  double squared_radius = 0;
  // The radius grows with every pivot; about ten pivots are usual. The bound stops cycles between equal radii.
  for (int pivot = 0; pivot < 200; ++pivot) {
    double d2 = 0;
    const std::size_t outside = farthest_point(points, center, d2);
    if (d2 <= squared_radius * (1 + 1e-12)) break;
    const Vec3 old_center = center;
    const double old_squared_radius = squared_radius;
    support.points[static_cast<std::size_t>(support.count++)] = points[outside];
    if (!solve_small(support, center, squared_radius) || squared_radius <= old_squared_radius) {
      center = old_center;
      break;
    }
  }
  double d2 = 0;
  farthest_point(points, center, d2);
  return {center, std::sqrt(d2)};
}

Sphere enclosing_ball_of_balls(std::span<const Sphere> balls) {
  if (balls.empty()) return {};
  if (balls.size() == 1) return balls[0];
  Vec3 low = balls[0].center_m;
  Vec3 high = low;
  for (const Sphere& ball : balls) {
    low = low.cwiseMin(ball.center_m - Vec3::Constant(ball.radius_m));
    high = high.cwiseMax(ball.center_m + Vec3::Constant(ball.radius_m));
  }
  Vec3 best = 0.5 * (low + high);
  std::size_t farthest = 0;
  double best_reach = reach_of(balls, best, &farthest);
  Vec3 center = best;
  for (int step = 1; step <= 200; ++step) {
    center += (balls[farthest].center_m - center) / (step + 1);
    const double reach = reach_of(balls, center, &farthest);
    if (reach < best_reach) {
      best_reach = reach;
      best = center;
    }
  }
  for (double step = 0.05 * best_reach; step > 1e-5 * best_reach;) {
    bool better = false;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        Vec3 candidate = best;
        candidate[axis] += sign * step;
        const double reach = reach_of(balls, candidate);
        if (reach < best_reach) {
          best_reach = reach;
          best = candidate;
          better = true;
        }
      }
    }
    if (!better) step *= 0.5;
  }
  return {best, best_reach};
}

}  // namespace poise::geometry
