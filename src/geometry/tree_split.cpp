// SPDX-License-Identifier: MIT
#include "geometry/tree_split.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/enclosing_ball.h"
#include "geometry/random.h"

namespace poise::geometry {
namespace {

// Chosen by trying them on the meshes of docs/sphere-trees.md.
constexpr int kStarts = 3;
constexpr int kMiddleRounds = 8;
constexpr int kBallRounds = 4;
constexpr double kSizeWeight = 0.1;

using Members = std::vector<std::uint32_t>;

std::vector<Vec3> points_of(const SolidAtoms& atoms, std::span<const std::uint32_t> members) {
  std::vector<Vec3> points;
  for (const std::uint32_t atom : members) {
    const auto own = atoms.points_of(atom);
    points.insert(points.end(), own.begin(), own.end());
  }
  return points;
}

double reach_m(std::span<const Vec3> points, const Vec3& from) {
  double largest2 = 0;
  for (const Vec3& p : points) largest2 = std::max(largest2, (p - from).squaredNorm());
  return std::sqrt(largest2);
}

/// The first start spreads by always taking the farthest atom; the others draw with chances by squared distance (Arthur
/// and Vassilvitskii, "k-means++", 2007).
std::vector<Vec3> start_centers(const SolidAtoms& atoms, std::span<const std::uint32_t> members, int start, Random& random) {
  std::vector<double> nearest2(members.size(), std::numeric_limits<double>::infinity());
  std::vector<Vec3> centers;
  Vec3 last = Vec3::Zero();
  for (const std::uint32_t atom : members) last += atoms.middle_m[atom];
  last /= static_cast<double>(members.size());
  for (std::uint32_t k = 0; k < kTreeBranching; ++k) {
    double sum2 = 0;
    double largest2 = -1;
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const double d2 = (atoms.middle_m[members[i]] - last).squaredNorm();
      nearest2[i] = k <= 1 ? d2 : std::min(nearest2[i], d2);
      sum2 += nearest2[i];
      if (nearest2[i] > largest2) {
        largest2 = nearest2[i];
        farthest = i;
      }
    }
    if (k > 0 && !(largest2 > 0)) break;
    if (start > 0) {
      double left = random.unit() * sum2;
      for (std::size_t i = 0; i < members.size() && left >= 0; ++i) {
        farthest = i;
        left -= nearest2[i];
      }
    }
    last = atoms.middle_m[members[farthest]];
    centers.push_back(last);
  }
  return centers;
}

/// Gives each atom to the centre with the least cost(atom, k); ties to the first. Groups may come out empty.
template <class Cost>
std::vector<Members> assign(std::span<const std::uint32_t> members, std::size_t groups, Cost&& cost) {
  std::vector<Members> result(groups);
  for (const std::uint32_t atom : members) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < groups; ++k) {
      const double c = cost(atom, k);
      if (c < least) {
        least = c;
        best = k;
      }
    }
    result[best].push_back(atom);
  }
  return result;
}

std::vector<Members> lloyd(const SolidAtoms& atoms, std::span<const std::uint32_t> members, std::vector<Vec3> centers) {
  std::vector<Members> groups;
  for (int round = 0; round < kMiddleRounds; ++round) {
    groups = assign(members, centers.size(), [&](std::uint32_t atom, std::size_t k) { return (atoms.middle_m[atom] - centers[k]).squaredNorm(); });
    for (std::size_t k = 0; k < centers.size(); ++k) {
      if (groups[k].empty()) continue;
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t atom : groups[k]) sum += atoms.middle_m[atom];
      centers[k] = sum / static_cast<double>(groups[k].size());
    }
  }
  return groups;
}

std::vector<SplitGroup> with_balls(const SolidAtoms& atoms, std::vector<Members> groups, const TriangleBvh& bvh) {
  std::vector<SplitGroup> result;
  for (Members& members : groups) {
    if (members.empty()) continue;
    const DeepBall ball = deep_ball(atoms, members, bvh, kSizeWeight);
    result.push_back({std::move(members), ball});
  }
  return result;
}

/// By how much a set of balls stands out together: each bound weighted by the ball's surface.
double total_cost(const std::vector<SplitGroup>& groups) {
  double sum = 0;
  for (const SplitGroup& group : groups) {
    const double radius_m = group.ball.sphere.radius_m;
    sum += radius_m * radius_m * (std::max(0.0, group.ball.protrusion_bound_m) + kSizeWeight * radius_m);
  }
  return sum;
}

std::vector<Members> regroup(const SolidAtoms& atoms, std::span<const std::uint32_t> members, const std::vector<SplitGroup>& groups) {
  return assign(members, groups.size(), [&](std::uint32_t atom, std::size_t k) {
    const DeepBall& ball = groups[k].ball;
    // The bound that the ball's centre would have if it had to reach this atom.
    const double depth_m = ball.protrusion_bound_m - ball.sphere.radius_m;
    return reach_m(atoms.points_of(atom), ball.sphere.center_m) * (1 + kSizeWeight) + depth_m;
  });
}

}  // namespace

DeepBall deep_ball(const SolidAtoms& atoms, std::span<const std::uint32_t> members, const TriangleBvh& bvh, double size_weight) {
  const std::vector<Vec3> points = points_of(atoms, members);
  const Sphere smallest = enclosing_ball(points);
  DeepBall best{smallest, smallest.radius_m + bvh.signed_distance_m(smallest.center_m)};
  const auto cost = [size_weight](const DeepBall& ball) { return ball.protrusion_bound_m + size_weight * ball.sphere.radius_m; };
  const auto try_center = [&](const Vec3& center) {
    const double radius_m = reach_m(points, center);
    // The signed distance changes by at most the way from the best centre, which often settles it without asking.
    const double depth_m = best.protrusion_bound_m - best.sphere.radius_m;
    const double least_m = depth_m - (center - best.sphere.center_m).norm();
    if (radius_m * (1 + size_weight) + least_m >= cost(best)) return false;
    const DeepBall candidate{{center, radius_m}, radius_m + bvh.signed_distance_m(center)};
    if (cost(candidate) >= cost(best)) return false;
    best = candidate;
    return true;
  };
  for (double step_m = 0.3 * smallest.radius_m; step_m > 0.02 * smallest.radius_m;) {
    const Vec3 at = best.sphere.center_m;
    const Vec3 from_surface = at - bvh.closest(at).point_m;
    const double sign = best.protrusion_bound_m > best.sphere.radius_m ? -1.0 : 1.0;  // toward the surface when outside
    bool better = from_surface.norm() > 0 && try_center(at + sign * step_m * from_surface.normalized());
    for (int axis = 0; axis < 3 && !better; ++axis) {
      const Vec3 way = step_m * Vec3::Unit(axis);
      better = try_center(at + way) || try_center(at - way);
    }
    if (!better) step_m *= 0.5;
  }
  return best;
}

std::vector<SplitGroup> split_atoms(const SolidAtoms& atoms, std::span<const std::uint32_t> members, const TriangleBvh& bvh,
                                    std::uint64_t seed) {
  Random random(seed);
  std::vector<SplitGroup> best;
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start < kStarts; ++start) {
    const std::vector<Vec3> centers = start_centers(atoms, members, start, random);
    std::vector<SplitGroup> groups = with_balls(atoms, lloyd(atoms, members, centers), bvh);
    for (int round = 0;; ++round) {
      const double cost = total_cost(groups);
      if (cost < least) {
        least = cost;
        best = groups;
      }
      if (round == kBallRounds) break;
      groups = with_balls(atoms, regroup(atoms, members, groups), bvh);
    }
  }
  return best;
}

}  // namespace poise::geometry
