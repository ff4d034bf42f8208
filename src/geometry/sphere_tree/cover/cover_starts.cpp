// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/cover/cover_starts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/primitives/random.h"
#include "math/functions.h"

namespace poise::geometry {
namespace {

// Chosen: as cheap as possible without visibly worse starts.
constexpr GreedySettings kStartGreedy{.cells = 1500, .points = 120, .halvings = 5, .random_starts = 2};
constexpr GreedySettings kLookahead{.cells = 500, .points = 70, .halvings = 4, .random_starts = 0};
/// Weight of the largest stand-off below the level, relative to that of the level itself.
constexpr double kNextLargest = 3;
/// Multiple of the stand-off of a first cover, so that balls that shrink later are still weighted.
constexpr float kShellFactor = 1.5F;

/// Cost of a level: logarithms of its own stand-off and volume, and of the stand-off that the level below would have.
double value_of(const CoverScene& scene, const CoverCells& cells, const std::vector<CoverBall>& balls,
                const LevelScore& score) {
  double largest = 0;
  double sum = 0;
  for (const CoverBall& ball : balls) {
    if (ball.own.empty()) continue;
    const GreedyCover below = cover_greedily(cells, ball.own, scene.points, ball.center, ball.radius, scene.bvh,
                                             scene.frame, scene.seed, kLookahead);
    largest = std::max(largest, static_cast<double>(below.stand_off));
    sum += static_cast<double>(below.stand_off) * static_cast<double>(ball.own.size());
  }
  const auto log_of = [](double x) { return math::log(std::max(x, 1e-12)); };
  return log_of(score.largest) + log_of(score.volume) + kNextLargest * log_of(largest) +
         log_of(sum / static_cast<double>(cells.size()));
}

}  // namespace

std::vector<CoverBall> balls_of(const GreedyCover& cover, std::uint32_t parent) {
  std::vector<CoverBall> balls;
  for (const DeepPoint& place : cover.points) {
    CoverBall ball;
    ball.center = place.center;
    ball.signed_distance = -place.depth;
    ball.radius = place.depth + cover.stand_off;
    ball.parent = parent;
    balls.push_back(ball);
  }
  return balls;
}

std::vector<CoverBall> find_start(const CoverScene& scene, const CoverCells& cells, const CoverParent& root,
                                  const StartSettings& settings, parallel::Executor& executor,
                                  const std::function<bool()>& keep_going) {
  struct Try {
    GreedyCover cover;
    std::vector<CoverBall> balls;
    double value = std::numeric_limits<double>::infinity();
  };
  const auto count = static_cast<std::size_t>(settings.tries);
  std::vector<Try> tries(count);
  parallel::parallel_for(executor, count, 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint64_t seed = Random::of(scene.seed, i).next();
      tries[i].cover = cover_greedily(cells, root.own, scene.points, root.center, root.radius, scene.bvh, scene.frame,
                                      seed, kStartGreedy);
    }
  });
  float stand_off = std::numeric_limits<float>::infinity();
  for (const Try& each : tries) stand_off = std::min(stand_off, each.cover.stand_off);
  const ShellSamples samples = sample_shell(scene.mesh, scene.bvh, scene.frame, kShellFactor * stand_off + 0.002F,
                                            settings.samples, scene.seed, executor);
  const std::vector<CoverParent> parents{root};
  parallel::parallel_for(executor, count, 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end && keep_going(); ++i) {
      LevelSettings level = settings.level;
      // Every second try prefers balls of equal size: a level whose balls differ much wastes the children of the small
      // ones.
      level.equal_sizes = i % 2 == 1 ? 0.15 + 0.05 * static_cast<double>(i % 5) : 0.0;
      LevelCover cover(cells, samples, scene.bvh, scene.frame, scene.points, parents);
      cover.improve(balls_of(tries[i].cover, 0), level, keep_going);
      LevelScore score;
      tries[i].balls = cover.take_best(&score);
      tries[i].value = value_of(scene, cells, tries[i].balls, score);
    }
  });
  return std::ranges::min_element(tries, {}, &Try::value)->balls;
}

}  // namespace poise::geometry
