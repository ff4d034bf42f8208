// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "geometry/sphere_tree/cover/level_cover.h"
#include "math/functions.h"

namespace poise::geometry {
namespace {

/// Additional weight of a sample at the scale, relative to one at the surface. Chosen by trials of 1 to 10 on the
/// meshes of the docs.
constexpr double kFarWeight = 3;
constexpr double kScaleOfLargest = 0.7;
constexpr double kUnit = 16;  ///< unit of the integer weights
constexpr double kMostWeight = 4096;

}  // namespace

void LevelCover::count(const CoverBall& ball, int change) {
  const DistanceRange range = {ball.center, 0.0F, ball.radius * ball.radius};
  std::uint32_t* const ids = near_ids_.data();
  samples_.runs_near(ball.center, ball.radius, [&](std::uint32_t first, std::uint32_t last) {
    const std::size_t found = points_between(samples_.points, first, last, range, nullptr, ids);
    for (std::size_t k = 0; k < found; ++k) {
      const std::uint32_t i = ids[k];
      if (change > 0) {
        if (count_[i]++ == 0) total_ += weight_[i];
      } else if (--count_[i] == 0) {
        total_ -= weight_[i];
      }
    }
  });
}

void LevelCover::weigh(double power) {
  const double scale = std::max(1e-6, kScaleOfLargest * score().largest);
  total_ = 0;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const double far = math::pow(static_cast<double>(samples_.distance[i]) / scale, power);
    weight_[i] = static_cast<std::int32_t>(std::min(kMostWeight, kUnit * (1 + kFarWeight * far)));
    if (count_[i] != 0) total_ += weight_[i];
  }
}

LevelScore LevelCover::score() const {
  float largest = 0;
  std::size_t covered = 0;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    if (count_[i] == 0) continue;
    largest = std::max(largest, samples_.distance[i]);
    ++covered;
  }
  return {static_cast<double>(largest), static_cast<double>(covered) * static_cast<double>(samples_.volume)};
}

double LevelCover::contribution(const CoverBall& ball) const {
  const Vec3f& c = ball.center;
  const float square = ball.radius * ball.radius;
  std::int64_t sum = 0;
  samples_.runs_near(c, ball.radius, [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t i = first; i < last; ++i) {
      if (count_[i] == 1 && (samples_.points.at(i) - c).squaredNorm() <= square) sum += weight_[i];
    }
  });
  return static_cast<double>(sum);
}

void LevelCover::gather_samples(const Vec3f& center, float from, float to) {
  const DistanceRange range = {center, from > 0 ? from * from : 0, to * to};
  std::size_t found = 0;
  samples_.runs_near(center, to, [&](std::uint32_t first, std::uint32_t last) {
    found += points_between(samples_.points, first, last, range, count_.data(), near_ids_.data() + found);
  });
  near_.resize(found);
  near_weight_.resize(found);
  for (std::size_t k = 0; k < found; ++k) {
    const std::uint32_t i = near_ids_[k];
    near_.x[k] = samples_.points.x[i];
    near_.y[k] = samples_.points.y[i];
    near_.z[k] = samples_.points.z[i];
    near_weight_[k] = weight_[i];
  }
}

}  // namespace poise::geometry
