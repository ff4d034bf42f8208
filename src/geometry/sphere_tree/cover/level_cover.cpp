// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/cover/level_cover.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/functions.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {
namespace {

// Chosen by trials on the meshes of docs/sphere-trees.md.
constexpr float kPriceStep = 0.15F;  ///< share of a ball's stand-off above the mean, each round
constexpr float kMostPrice = 0.5F;   ///< share of the mean stand-off
constexpr float kMostBound = 2;      ///< multiple of the mean stand-off, for centres that are tried
constexpr float kFirstStep = 0.25F;  ///< share of a ball's radius, in the first round of bids
constexpr float kLastShare = 0.12F;  ///< share of the first step, in the last round
constexpr float kSmallestStep = 0.02F;
constexpr float kIterationStep = 0.1F;
constexpr double kFirstPower = 4;
constexpr double kPowerStep = 4;
constexpr double kWorthwhile = 0.997;  ///< an iteration that leaves more than this share of the cost is the last at its
                                       ///< power
constexpr int kMostPowers = 3;

}  // namespace

LevelCover::LevelCover(const CoverCells& cells, const ShellSamples& samples, const TriangleBvh& bvh,
                       const CoverFrame& frame, const std::vector<DeepPoint>& points,
                       const std::vector<CoverParent>& parents)
    : cells_(cells),
      samples_(samples),
      bvh_(bvh),
      frame_(frame),
      points_(points),
      parents_(parents),
      family_(parents.size()),
      held_(cells.size(), 0),
      holders_(cells.size(), 0),
      least_bid_(cells.size()),
      winner_(cells.size()),
      count_(samples.size() + kReadBeyond, 0),
      weight_(samples.size(), 0),
      near_ids_(samples.size() + kReadBeyond) {
  for (const CoverParent& parent : parents) {
    if (!parent.closed) continue;
    for (const std::uint32_t cell : parent.allowed) held_[cell] = 1;
    CoverBall ball;
    ball.center = parent.center;
    ball.radius = parent.radius;
    count(ball, 1);
  }
}

void LevelCover::begin(std::vector<CoverBall> balls) {
  balls_ = std::move(balls);
  for (const CoverBall& ball : balls_) {
    if (ball.radius > 0) count(ball, 1);
  }
  drop_empty();
  weigh(kFirstPower);
  best_value_ = std::numeric_limits<double>::infinity();
  first_ = {};
}

/// Rebuilds the families without empty balls.
void LevelCover::drop_empty() {
  std::erase_if(balls_, [](const CoverBall& ball) { return !(ball.radius > 0); });
  for (auto& family : family_) family.clear();
  for (std::uint32_t k = 0; k < balls_.size(); ++k) family_[balls_[k].parent].push_back(k);
}

void LevelCover::remember() {
  const LevelScore now = score();
  if (!(first_.volume > 0)) first_ = {std::max(now.largest, 1e-9), std::max(now.volume, 1e-15)};
  const double value = now.volume / first_.volume + now.largest / first_.largest;
  if (value < best_value_) {
    best_value_ = value;
    best_ = balls_;
  }
}

void LevelCover::set_prices(const LevelSettings& settings) {
  if (balls_.empty()) return;
  double sum = 0;
  double cells = 0;
  for (const CoverBall& ball : balls_) {
    sum += static_cast<double>(ball.radius + ball.signed_distance);
    cells += static_cast<double>(ball.own.size());
  }
  const auto mean = static_cast<float>(std::max(0.0, sum / static_cast<double>(balls_.size())));
  most_bound_ = std::min(samples_.thickness, kMostBound * mean);
  for (CoverBall& ball : balls_) {
    if (settings.equal_sizes > 0) {
      const double size = cells > 0 ? static_cast<double>(ball.own.size() * balls_.size()) / cells : 1.0;
      ball.price = static_cast<float>(settings.equal_sizes * std::clamp(size - 1, -1.0, 1.0)) * mean;
    } else {
      const float step = kPriceStep * std::clamp(ball.radius + ball.signed_distance - mean, -mean, mean);
      ball.price = std::clamp(ball.price + step, -kMostPrice * mean, kMostPrice * mean);
    }
  }
}

/// Assigns each cell to the ball with the smallest stand-off plus price, among the balls of parents that contain the
/// cell.
void LevelCover::assign() {
  std::ranges::fill(least_bid_, std::numeric_limits<float>::infinity());
  for (CoverBall& ball : balls_) ball.own.clear();
  for (std::uint32_t k = 0; k < balls_.size(); ++k) {
    const CoverBall& ball = balls_[k];
    const float base = ball.signed_distance + ball.price;
    for (const std::uint32_t cell : parents_[ball.parent].allowed) {
      if (held_[cell] != 0) continue;
      const float least = least_bid_[cell] - base;
      const float middle = std::sqrt((cells_.middles.at(cell) - ball.center).squaredNorm());
      if (middle - cells_.reach[cell] >= least) continue;
      const float bid = cells_.reach_from(cell, ball.center) + base;
      if (bid >= least_bid_[cell]) continue;
      least_bid_[cell] = bid;
      winner_[cell] = k;
    }
  }
  for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
    if (held_[cell] == 0) balls_[winner_[cell]].own.push_back(cell);
  }
}

void LevelCover::split_for_free_points() {
  Halves halves;
  for (std::size_t p = 0; p < parents_.size(); ++p) {
    while (!parents_[p].closed && family_[p].size() < kTreeBranching) {
      double most = 0;
      std::uint32_t worst = 0;
      for (const std::uint32_t k : family_[p]) {
        const double share = balls_[k].own.size() < 2 ? 0.0 : contribution(balls_[k]);
        if (share > most) {
          most = share;
          worst = k;
        }
      }
      if (!(most > 0) || !halve(balls_[worst], balls_[worst].own, halves)) break;
      CoverBall second;
      second.parent = static_cast<std::uint32_t>(p);
      const auto place = [&](CoverBall& ball, std::vector<std::uint32_t>& own, const Vec3f& center) {
        ball.own = std::move(own);
        ball.center = center;
        ball.signed_distance = signed_distance(center);
        set_.gather(cells_, ball.own);
        ball.radius = set_.radius_about(cells_, center, std::numeric_limits<float>::infinity());
        count(ball, 1);
      };
      count(balls_[worst], -1);
      place(balls_[worst], halves.first, halves.first_center);
      place(second, halves.second, halves.second_center);
      family_[p].push_back(static_cast<std::uint32_t>(balls_.size()));
      balls_.push_back(std::move(second));
    }
  }
}

void LevelCover::bid(int round, const LevelSettings& settings) {
  set_prices(settings);
  assign();
  for (CoverBall& ball : balls_) {
    count(ball, -1);
    set_.gather(cells_, ball.own);
    ball.radius = set_.radius_about(cells_, ball.center, std::numeric_limits<float>::infinity());
    if (ball.radius > 0) count(ball, 1);
  }
  drop_empty();
  split_for_free_points();
  const float share = static_cast<float>(round) / static_cast<float>(settings.bids);
  const double shrunk = math::pow(static_cast<double>(kLastShare), static_cast<double>(share));
  const float step = std::max(kSmallestStep, kFirstStep * static_cast<float>(shrunk));
  for (CoverBall& ball : balls_) {
    count(ball, -1);
    fit(ball, ball.own, step);
    count(ball, 1);
  }
  remember();
}

std::vector<std::uint32_t> LevelCover::take_out(CoverBall& ball) {
  std::vector<std::uint32_t> needed;
  if (!(ball.radius > 0)) return needed;
  count(ball, -1);
  for (const std::uint32_t cell : ball.covered) {
    if (--holders_[cell] == 0) needed.push_back(cell);
  }
  return needed;
}

void LevelCover::put_in(CoverBall& ball, const std::vector<std::uint32_t>& needed) {
  find_covered(ball, needed);
  if (!(ball.radius > 0)) return;
  count(ball, 1);
  for (const std::uint32_t cell : ball.covered) ++holders_[cell];
}

void LevelCover::begin_iterations() {
  if (!best_.empty()) {
    for (const CoverBall& ball : balls_) count(ball, -1);
    balls_ = best_;
    for (const CoverBall& ball : balls_) count(ball, 1);
    drop_empty();
  }
  std::copy(held_.begin(), held_.end(), holders_.begin());
  for (CoverBall& ball : balls_) {
    count(ball, -1);
    put_in(ball, ball.own);
  }
}

/// Shrinks each ball to the cells that no other ball contains; returns false when the cost no longer falls.
bool LevelCover::shrink(int sweep) {
  const std::int64_t before = total_;
  for (CoverBall& ball : balls_) {
    const std::vector<std::uint32_t> needed = take_out(ball);
    fit(ball, needed, kIterationStep);
    put_in(ball, needed);
  }
  drop_empty();
  fill_free_points();
  swap_poor_for_needed();
  remember();
  if (static_cast<double>(total_) > kWorthwhile * static_cast<double>(before)) {
    if (sweep >= kMostPowers * 2) return false;
    weigh(kFirstPower + kPowerStep * (sweep + 1));
  }
  return true;
}

bool LevelCover::split_in_two(CoverBall& ball, const std::vector<std::uint32_t>& needed, CoverBall& second) {
  Halves halves;
  if (!halve(ball, needed, halves)) return false;
  second = {};
  second.parent = ball.parent;
  second.center = halves.second_center;
  second.signed_distance = signed_distance(second.center);
  ball.center = halves.first_center;
  ball.signed_distance = signed_distance(ball.center);
  fit(ball, halves.first, kFirstStep);
  put_in(ball, halves.first);
  fit(second, halves.second, kFirstStep);
  put_in(second, halves.second);
  for (CoverBall* each : {&ball, &second}) {
    const std::vector<std::uint32_t> left = take_out(*each);
    fit(*each, left, kFirstStep);
    put_in(*each, left);
  }
  return true;
}

void LevelCover::fill_free_points() {
  for (std::size_t p = 0; p < parents_.size(); ++p) {
    while (!family_[p].empty() && family_[p].size() < kTreeBranching) {
      const auto worst =
          *std::ranges::max_element(family_[p], {}, [&](std::uint32_t k) { return contribution(balls_[k]); });
      const std::int64_t before = total_;
      const CoverBall kept = balls_[worst];
      CoverBall second;
      const std::vector<std::uint32_t> needed = take_out(balls_[worst]);
      const bool split = split_in_two(balls_[worst], needed, second);
      if (split && total_ < before && second.radius > 0) {
        family_[p].push_back(static_cast<std::uint32_t>(balls_.size()));
        balls_.push_back(std::move(second));
        continue;
      }
      if (split) {
        take_out(balls_[worst]);
        take_out(second);
      }
      balls_[worst] = kept;
      put_in(balls_[worst], needed);
      break;
    }
  }
}

/// Gives the cells of a ball with little effect to its siblings, and uses it for half of the ball that stands out most.
bool LevelCover::swap(std::uint32_t poor, std::uint32_t worst, const std::vector<std::uint32_t>& family) {
  const std::int64_t before = total_;
  std::vector<CoverBall> kept;
  for (const std::uint32_t k : family) kept.push_back(balls_[k]);
  const std::vector<std::uint32_t> orphans = take_out(balls_[poor]);
  balls_[poor].radius = 0;
  balls_[poor].covered.clear();
  std::vector<std::vector<std::uint32_t>> more(family.size());
  for (const std::uint32_t cell : orphans) {
    std::size_t nearest = 0;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < family.size(); ++i) {
      if (family[i] == poor) continue;
      const float growth = cells_.reach_from(cell, balls_[family[i]].center) - balls_[family[i]].radius;
      if (growth < least) {
        least = growth;
        nearest = i;
      }
    }
    more[nearest].push_back(cell);
  }
  for (std::size_t i = 0; i < family.size(); ++i) {
    if (more[i].empty()) continue;
    CoverBall& heir = balls_[family[i]];
    const std::vector<std::uint32_t> needed = take_out(heir);
    std::vector<std::uint32_t> all;
    std::ranges::set_union(needed, more[i], std::back_inserter(all));
    fit(heir, all, kFirstStep);
    put_in(heir, all);
  }
  CoverBall second;
  const std::vector<std::uint32_t> needed = take_out(balls_[worst]);
  if (split_in_two(balls_[worst], needed, second)) {
    balls_[poor] = std::move(second);
    if (total_ < before) return true;
  } else {
    put_in(balls_[worst], needed);
  }
  for (const std::uint32_t k : family) take_out(balls_[k]);
  for (std::size_t i = 0; i < family.size(); ++i) {
    balls_[family[i]] = kept[i];
    put_in(balls_[family[i]], kept[i].covered);
  }
  return false;
}

void LevelCover::swap_poor_for_needed() {
  struct Share {
    double value;
    std::uint32_t ball;
  };
  for (const auto& family : family_) {
    if (family.size() < kTreeBranching) continue;
    std::vector<Share> shares;
    for (const std::uint32_t k : family) shares.push_back({contribution(balls_[k]), k});
    std::ranges::stable_sort(shares, {}, &Share::value);
    if (shares.back().value < 2 * shares.front().value) continue;
    for (std::size_t i = 0; i < 2; ++i) {
      if (swap(shares[i].ball, shares.back().ball, family)) break;
    }
  }
}

std::vector<CoverBall> LevelCover::take_best(LevelScore* result) {
  for (const CoverBall& ball : balls_) {
    if (ball.radius > 0) count(ball, -1);
  }
  if (!best_.empty()) balls_ = std::move(best_);
  for (const CoverBall& ball : balls_) count(ball, 1);
  drop_empty();
  if (result != nullptr) *result = score();
  // Of the balls that contain a cell, the one with the smallest stand-off for it owns the cell.
  std::ranges::fill(least_bid_, std::numeric_limits<float>::infinity());
  for (std::uint32_t k = 0; k < balls_.size(); ++k) {
    CoverBall& ball = balls_[k];
    const std::vector<std::uint32_t> needed = ball.covered.empty() ? ball.own : ball.covered;
    find_covered(ball, needed);
    for (const std::uint32_t cell : ball.covered) {
      const float bid = cells_.reach_from(cell, ball.center) + ball.signed_distance;
      if (held_[cell] != 0 || bid >= least_bid_[cell]) continue;
      least_bid_[cell] = bid;
      winner_[cell] = k;
    }
    ball.own.clear();
  }
  for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
    if (held_[cell] == 0) balls_[winner_[cell]].own.push_back(cell);
  }
  return std::move(balls_);
}

}  // namespace poise::geometry
