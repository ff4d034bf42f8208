// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/primitives/random.h"
#include "geometry/sphere_tree/cover/cover_starts.h"
#include "geometry/sphere_tree/cover/level_cover.h"

namespace poise::geometry {
namespace {

constexpr GreedySettings kGreedy{.cells = 800, .points = 120, .halvings = 5, .random_starts = 2};
constexpr int kBids = 8;
constexpr float kFirstRedoStep = 0.25F;
constexpr float kSecondStep = 0.1F;
constexpr double kPower = 12;  ///< high, so that the largest stand-off dominates

}  // namespace

double LevelCover::largest_of(const CoverBall& ball) const {
  float largest = 0;
  const float square = ball.radius * ball.radius;
  samples_.runs_near(ball.center, ball.radius, [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t i = first; i < last; ++i) {
      if (samples_.distance[i] > largest && (samples_.points.at(i) - ball.center).squaredNorm() <= square)
        largest = samples_.distance[i];
    }
  });
  return static_cast<double>(largest);
}

/// Rebuilds the balls of one parent from another greedy cover, with all others unchanged, and uses them if they stand
/// out less.
bool LevelCover::redo(std::uint32_t parent, std::uint64_t seed) {
  const std::int64_t before = total_;
  const std::vector<std::uint32_t> family = family_[parent];
  std::vector<CoverBall> kept;
  std::vector<std::uint32_t> needed;
  for (const std::uint32_t k : family) {
    kept.push_back(balls_[k]);
    const std::vector<std::uint32_t> some = take_out(balls_[k]);
    needed.insert(needed.end(), some.begin(), some.end());
    balls_[k].radius = 0;
  }
  std::ranges::sort(needed);
  const CoverParent& above = parents_[parent];
  std::vector<CoverBall> made = balls_of(
      cover_greedily(cells_, needed, points_, above.center, above.radius, bvh_, frame_, seed, kGreedy), parent);
  for (int round = 0; round < kBids && !made.empty(); ++round) {
    for (CoverBall& ball : made) ball.own.clear();
    for (const std::uint32_t cell : needed) {
      std::size_t winner = 0;
      float least = std::numeric_limits<float>::infinity();
      for (std::size_t i = 0; i < made.size(); ++i) {
        const float bid = cells_.reach_from(cell, made[i].center) + made[i].signed_distance;
        if (bid >= least) continue;
        least = bid;
        winner = i;
      }
      made[winner].own.push_back(cell);
    }
    std::erase_if(made, [](const CoverBall& ball) { return ball.own.empty(); });
    // Siblings cover each other's samples, so each is fitted with the others in place.
    for (CoverBall& ball : made) {
      set_.gather(cells_, ball.own);
      ball.radius = set_.radius_about(cells_, ball.center, std::numeric_limits<float>::infinity());
      count(ball, 1);
    }
    for (CoverBall& ball : made) {
      count(ball, -1);
      fit(ball, ball.own, kFirstRedoStep);
      count(ball, 1);
    }
    for (const CoverBall& ball : made) count(ball, -1);
  }
  for (CoverBall& ball : made) put_in(ball, ball.own);
  for (int sweep = 0; sweep < 2; ++sweep) {
    for (CoverBall& ball : made) {
      const std::vector<std::uint32_t> left = take_out(ball);
      fit(ball, left, kSecondStep);
      put_in(ball, left);
    }
  }
  std::erase_if(made, [](const CoverBall& ball) { return !(ball.radius > 0); });
  if (total_ < before && !made.empty()) {
    std::vector<std::uint32_t>& points = family_[parent];
    for (std::size_t i = 0; i < made.size(); ++i) {
      if (i < family.size()) {
        balls_[family[i]] = std::move(made[i]);
      } else {
        points.push_back(static_cast<std::uint32_t>(balls_.size()));
        balls_.push_back(std::move(made[i]));
      }
    }
    return true;
  }
  for (CoverBall& ball : made) take_out(ball);
  for (std::size_t i = 0; i < family.size(); ++i) {
    balls_[family[i]] = kept[i];
    put_in(balls_[family[i]], kept[i].covered);
  }
  return false;
}

void LevelCover::redo_worst(int attempts) {
  if (attempts <= 0 || balls_.empty()) return;
  weigh(kPower);
  std::vector<int> tried(parents_.size(), 0);
  std::uint64_t seed = 0;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    // Chooses the family of the ball that stands out most, unless it was tried too often without success.
    constexpr int kMostTries = 3;
    double most = 0;
    std::uint32_t parent = 0;
    for (const CoverBall& ball : balls_) {
      if (!(ball.radius > 0) || tried[ball.parent] >= kMostTries) continue;
      const double largest = largest_of(ball);
      if (largest > most) {
        most = largest;
        parent = ball.parent;
      }
    }
    if (!(most > 0)) break;
    if (redo(parent, ++seed)) {
      tried[parent] = 0;
    } else {
      ++tried[parent];
    }
  }
  drop_empty();
  for (CoverBall& ball : balls_) {
    const std::vector<std::uint32_t> needed = take_out(ball);
    fit(ball, needed, kSecondStep);
    put_in(ball, needed);
  }
  drop_empty();
  fill_free_points();
  remember();
}

}  // namespace poise::geometry
