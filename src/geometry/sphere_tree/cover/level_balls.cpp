// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include <Eigen/Eigenvalues>

#include "geometry/sphere_tree/cover/level_cover.h"

namespace poise::geometry {
namespace {

/// Weight of radius^2 * bound, beside the covered samples: it directs the search where there are too few samples.
constexpr float kBoundShare = 0.05F;
/// A search ends when its step is below this share of the first one.
constexpr float kLastStep = 0.12F;
/// A ball may grow by no more than this in one search, relative to its radius.
constexpr float kMostGrowth = 1.5F;
constexpr float kLeastStep = 1e-5F;

}  // namespace

float LevelCover::signed_distance(const Vec3f& at) const {
  return static_cast<float>(bvh_.signed_distance_m(frame_.from(at)) / frame_.diagonal_m);
}

/// A pattern search for the centre, with the radius that the cells then need. The ball must not be counted in the
/// samples.
void LevelCover::fit(CoverBall& ball, const std::vector<std::uint32_t>& cells, float step) {
  if (cells.empty()) {
    ball.radius = 0;
    return;
  }
  set_.gather(cells_, cells);
  const float start_radius = set_.radius_about(cells_, ball.center, std::numeric_limits<float>::infinity());
  const float first_step = step * start_radius;
  const float farthest = 2 * first_step;
  // A radius changes by at most the distance that the centre moves, so samples deeper inside are covered at every
  // centre that is tried.
  const float core = start_radius - 2 * farthest;
  gather_samples(ball.center, core, start_radius + 2 * farthest);
  const float sample_share = static_cast<float>(samples_.volume) / 16.0F;

  const Vec3f start = ball.center;
  Vec3f center = start;
  float radius = start_radius;
  float distance = ball.signed_distance;
  const auto bound_cost = [](float r, float sd) { return kBoundShare * r * r * std::max(0.0F, r + sd); };
  const auto sample_cost = [&](const Vec3f& c, float r) {
    return sample_share * static_cast<float>(weight_within(near_, near_weight_, c, r));
  };
  float cost = sample_cost(center, radius) + bound_cost(radius, distance);
  const auto try_center = [&](const Vec3f& place) {
    if ((place - start).norm() > farthest) return false;
    const float limit = kMostGrowth * start_radius;
    const float r = set_.radius_about(cells_, place, limit);
    if (r > limit) return false;
    // The signed distance changes by at most the distance moved, which often decides without a query.
    const float way = (place - center).norm();
    const float least = bound_cost(r, distance - way);
    if (least >= cost) return false;
    const float covered = sample_cost(place, r);
    if (covered + least >= cost) return false;
    const float sd = signed_distance(place);
    if (r + sd > std::max(most_bound_, radius + distance)) return false;
    const float total = covered + bound_cost(r, sd);
    if (total >= cost) return false;
    cost = total;
    center = place;
    radius = r;
    distance = sd;
    return true;
  };
  for (float length = first_step; length > kLastStep * first_step + kLeastStep;) {
    bool better = false;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3f way = length * Vec3f::Unit(axis);
      better = try_center(center + way) || try_center(center - way) || better;
    }
    if (!better) length *= 0.5F;
  }
  ball.center = center;
  ball.radius = radius;
  ball.signed_distance = distance;
}

void LevelCover::find_covered(CoverBall& ball, const std::vector<std::uint32_t>& needed) const {
  ball.covered.clear();
  if (!(ball.radius > 0)) return;
  for (const std::uint32_t cell : parents_[ball.parent].allowed) {
    if (cells_.within(cell, ball.center, ball.radius)) ball.covered.push_back(cell);
  }
  // Rounding must not lose the cells that the radius was computed for.
  if (!std::ranges::includes(ball.covered, needed)) {
    std::vector<std::uint32_t> all;
    std::ranges::set_union(ball.covered, needed, std::back_inserter(all));
    ball.covered = std::move(all);
  }
}

/// Splits by a plane through the middle of the cells, across the principal axis whose halves would stand out least. The
/// search for the halves' centres starts from the ball's own centre, which is deep.
bool LevelCover::halve(const CoverBall& ball, const std::vector<std::uint32_t>& cells, Halves& best) {
  if (cells.size() < 2) return false;
  Vec3f middle = Vec3f::Zero();
  for (const std::uint32_t cell : cells) middle += cells_.middles.at(cell);
  middle /= static_cast<float>(cells.size());
  Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
  for (const std::uint32_t cell : cells) {
    const Vec3f way = cells_.middles.at(cell) - middle;
    spread += way * way.transpose();
  }
  const Eigen::Matrix3f axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f>(spread).eigenvectors();
  float least = std::numeric_limits<float>::infinity();
  for (int k = 2; k >= 0; --k) {
    const Vec3f axis = axes.col(k);
    Halves halves;
    float first_sum = 0;
    float second_sum = 0;
    for (const std::uint32_t cell : cells) {
      const float along = axis.dot(cells_.middles.at(cell) - middle);
      (along <= 0 ? halves.first : halves.second).push_back(cell);
      (along <= 0 ? first_sum : second_sum) += along;
    }
    if (halves.first.empty() || halves.second.empty()) continue;
    halves.first_center = ball.center + first_sum / static_cast<float>(halves.first.size()) * axis;
    halves.second_center = ball.center + second_sum / static_cast<float>(halves.second.size()) * axis;
    set_.gather(cells_, halves.first);
    float bound = set_.radius_about(cells_, halves.first_center, 2.0F) + signed_distance(halves.first_center);
    set_.gather(cells_, halves.second);
    bound =
        std::max(bound, set_.radius_about(cells_, halves.second_center, 2.0F) + signed_distance(halves.second_center));
    if (bound < least) {
      least = bound;
      best = std::move(halves);
    }
  }
  return std::isfinite(least);
}

}  // namespace poise::geometry
