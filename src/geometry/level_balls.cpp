// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "geometry/level_cover.h"

namespace poise::geometry {
namespace {

/// Share of radius^2 * bound that counts beside the covered samples: it steers where samples are too few to say anything.
constexpr float kBoundShare = 0.05F;
/// A search ends at this share of its first step.
constexpr float kLastStep = 0.12F;
/// A ball may grow by no more than this in one search, relative to its radius.
constexpr float kMostGrowth = 1.5F;
constexpr float kLeastStep = 1e-5F;

}  // namespace

float LevelCover::signed_distance(const Vec3f& at) const {
  return static_cast<float>(bvh_.signed_distance_m(frame_.from(at)) / frame_.diagonal_m);
}

/// A pattern search for the centre, with the radius that the atoms then need. The ball must not be counted among the samples.
void LevelCover::fit(CoverBall& ball, const std::vector<std::uint32_t>& atoms, float step) {
  if (atoms.empty()) {
    ball.radius = 0;
    return;
  }
  set_.gather(atoms_, atoms);
  const float start_radius = set_.radius_about(atoms_, ball.center, std::numeric_limits<float>::infinity());
  const float first_step = step * start_radius;
  const float farthest = 2 * first_step;
  // A radius changes by at most the way of the centre, so samples deeper inside are held at every place that is tried.
  const float core = start_radius - 2 * farthest;
  gather_samples(ball.center, core, start_radius + 2 * farthest);
  const float sample_share = static_cast<float>(samples_.volume) / 16.0F;

  const Vec3f start = ball.center;
  Vec3f center = start;
  float radius = start_radius;
  float distance = ball.signed_distance;
  const auto bound_cost = [](float r, float sd) { return kBoundShare * r * r * std::max(0.0F, r + sd); };
  const auto sample_cost = [&](const Vec3f& c, float r) { return sample_share * static_cast<float>(weight_within(near_, near_weight_, c, r)); };
  float cost = sample_cost(center, radius) + bound_cost(radius, distance);
  const auto try_center = [&](const Vec3f& place) {
    if ((place - start).norm() > farthest) return false;
    const float limit = kMostGrowth * start_radius;
    const float r = set_.radius_about(atoms_, place, limit);
    if (r > limit) return false;
    // The signed distance changes by at most the way, which often settles it without asking.
    const float way = (place - center).norm();
    const float least = bound_cost(r, distance - way);
    if (least >= cost) return false;
    const float covered = sample_cost(place, r);
    if (covered + least >= cost) return false;
    const float sd = signed_distance(place);
    if (r + sd > std::max(samples_.thickness, radius + distance)) return false;
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
  for (const std::uint32_t atom : parents_[ball.parent].allowed) {
    if (atoms_.within(atom, ball.center, ball.radius)) ball.covered.push_back(atom);
  }
  // Rounding must not lose what the radius was made for.
  if (!std::ranges::includes(ball.covered, needed)) {
    std::vector<std::uint32_t> all;
    std::ranges::set_union(ball.covered, needed, std::back_inserter(all));
    ball.covered = std::move(all);
  }
}

/// Two groups about two far atoms, moved to the groups' middles a few times.
bool LevelCover::halve(const std::vector<std::uint32_t>& atoms, Halves& halves) const {
  if (atoms.size() < 2) return false;
  const auto at = [&](std::uint32_t atom) { return atoms_.middles.at(atom); };
  const auto farthest = [&](const Vec3f& from) {
    return at(*std::ranges::max_element(atoms, {}, [&](std::uint32_t atom) { return (at(atom) - from).squaredNorm(); }));
  };
  Vec3f middle = Vec3f::Zero();
  for (const std::uint32_t atom : atoms) middle += at(atom);
  halves.first_middle = farthest(middle / static_cast<float>(atoms.size()));
  halves.second_middle = farthest(halves.first_middle);
  for (int round = 0; round < 4; ++round) {
    halves.first.clear();
    halves.second.clear();
    Vec3f first_sum = Vec3f::Zero();
    Vec3f second_sum = Vec3f::Zero();
    for (const std::uint32_t atom : atoms) {
      const Vec3f place = at(atom);
      const bool first = (place - halves.first_middle).squaredNorm() <= (place - halves.second_middle).squaredNorm();
      (first ? halves.first : halves.second).push_back(atom);
      (first ? first_sum : second_sum) += place;
    }
    if (halves.first.empty() || halves.second.empty()) return false;
    halves.first_middle = first_sum / static_cast<float>(halves.first.size());
    halves.second_middle = second_sum / static_cast<float>(halves.second.size());
  }
  return true;
}

}  // namespace poise::geometry
