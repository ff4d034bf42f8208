// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/tree_grow.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "geometry/primitives/enclosing_ball.h"
#include "geometry/primitives/rounding.h"

namespace poise::geometry {
namespace {

/// A ball whose stand-off is at most this share of the diagonal is not split further (docs/sphere-trees.md).
constexpr float kGoodEnough = 0.001F;
/// Multiple of the stand-off of the greedy cover at the start of a level, up to which balls are tried.
constexpr float kGrowShellFactor = 1.5F;
constexpr std::size_t kFewestGrowSamples = 30000;
constexpr std::size_t kMostSamples = 400000;
/// Cells for each leaf of a full tree, if that is more than the preset's number; then the upper limit.
constexpr std::size_t kCellsPerLeaf = 24;
constexpr std::size_t kMaxCells = 600000;
constexpr double kStartShare = 0.25;  ///< share of the first level in the whole time, for progress
constexpr double kEndShare = 0.9;

class Grower {
  // Invariant: parents_ are the nodes of level level_, node_of_[i] is the loose node of parents_[i], and every cell is
  // in `allowed` of a closed parent or in `own` of exactly one open parent.
 public:
  Grower(const TriangleMesh& mesh, const TriangleBvh& bvh, const TreeBuildOptions& options,
         parallel::Executor& executor, const std::function<void(double)>& progress,
         const std::function<bool()>& keep_going)
      : mesh_(mesh),
        bvh_(bvh),
        options_(options),
        effort_(effort_of(options.preset)),
        executor_(executor),
        progress_(progress),
        keep_going_(keep_going),
        frame_{bounds_of(mesh.vertices_m).center(), mesh.diagonal_m()} {}

  std::vector<LooseNode> grow() {
    solid_ = cut_into_cells(mesh_, bvh_, cell_count(), executor_);
    cells_ = CoverCells(solid_, frame_);
    progress_(0.05);
    make_root();
    if (options_.depth > 0 && !parents_[0].closed) {
      points_ = find_deep_points(mesh_, bvh_, frame_, effort_.points, options_.seed, executor_);
      for (Level level = 1; level <= options_.depth && keep_going_() && any_open(); ++level) make_level(level);
    }
    return std::move(nodes_);
  }

 private:
  [[nodiscard]] std::size_t cell_count() const {
    const std::size_t leaves = std::size_t{1} << (3U * options_.depth);
    return std::clamp(kCellsPerLeaf * leaves, effort_.cells, std::max(effort_.cells, kMaxCells));
  }
  [[nodiscard]] bool any_open() const {
    return std::ranges::any_of(parents_, [](const CoverParent& parent) { return !parent.closed; });
  }

  /// A node whose stored sphere contains the cells, exactly.
  LooseNode node_about(const Vec3& center_m, const std::vector<std::uint32_t>& own) const {
    LooseNode node;
    node.center_m = to_float(center_m);
    const Vec3 center = node.center_m.cast<double>();
    double square_m2 = 0;
    for (const std::uint32_t cell : own) {
      for (const Vec3& p : solid_.points_of(cell)) square_m2 = std::max(square_m2, (p - center).squaredNorm());
    }
    node.radius_m = covering_radius(std::sqrt(square_m2), frame_.diagonal_m);
    return node;
  }

  /// The cells that lie in a node's stored sphere, exactly.
  [[nodiscard]] std::vector<std::uint32_t> held_by(const LooseNode& node,
                                                   const std::vector<std::uint32_t>& cells) const {
    const Vec3 center_m = node.center_m.cast<double>();
    const auto radius_m = static_cast<double>(node.radius_m);
    const double square_m2 = radius_m * radius_m * (1 - 1e-12);
    const Vec3f center = frame_.to(center_m);
    const auto radius = static_cast<float>(radius_m / frame_.diagonal_m * (1 + 1e-5)) + 1e-5F;
    std::vector<std::uint32_t> held;
    for (const std::uint32_t cell : cells) {
      if ((cells_.middles.at(cell) - center).squaredNorm() > radius * radius) continue;
      if (std::ranges::all_of(solid_.points_of(cell),
                              [&](const Vec3& p) { return (p - center_m).squaredNorm() <= square_m2; })) {
        held.push_back(cell);
      }
    }
    return held;
  }

  /// Makes a parent for the next level, and its loose node; `allowed` are the cells that all nodes above it contain.
  CoverParent close_ball(const Vec3& center_m, std::vector<std::uint32_t> own,
                         const std::vector<std::uint32_t>& allowed) {
    nodes_.push_back(node_about(center_m, own));
    const LooseNode& node = nodes_.back();
    CoverParent parent;
    parent.center = frame_.to(node.center_m.cast<double>());
    parent.radius = static_cast<float>(static_cast<double>(node.radius_m) / frame_.diagonal_m);
    parent.own = std::move(own);
    const std::vector<std::uint32_t> held = held_by(node, allowed);
    std::ranges::set_union(held, parent.own, std::back_inserter(parent.allowed));
    parent.closed = parent.own.size() < 2 || parent.radius + signed_distance(parent.center) <= kGoodEnough;
    return parent;
  }

  [[nodiscard]] float signed_distance(const Vec3f& at) const {
    return static_cast<float>(bvh_.signed_distance_m(frame_.from(at)) / frame_.diagonal_m);
  }

  void make_root() {
    std::vector<std::uint32_t> all(cells_.size());
    std::iota(all.begin(), all.end(), 0U);
    // The root is the smallest ball: bounds and the broad phase use its size, not its fit.
    parents_.push_back(close_ball(enclosing_ball(solid_.points_m).center_m, all, all));
    node_of_.push_back(0);
  }

  std::vector<CoverBall> first_balls(Level level, float& stand_off) {
    if (level == 1) {
      const CoverCells coarse(cut_into_cells(mesh_, bvh_, effort_.start_cells, executor_), frame_);
      CoverParent root = parents_[0];
      root.own.resize(coarse.size());
      std::iota(root.own.begin(), root.own.end(), 0U);
      root.allowed = root.own;
      std::vector<CoverBall> balls = find_start({mesh_, bvh_, frame_, points_, options_.seed}, coarse, root,
                                                effort_.start, executor_, keep_going_);
      for (CoverBall& ball : balls) {
        stand_off = std::max(stand_off, ball.radius + ball.signed_distance);
        ball.own.clear();
        ball.covered.clear();
        ball.price = 0;
      }
      return balls;
    }
    std::vector<GreedyCover> covers(parents_.size());
    const GreedySettings greedy{
        .cells = level == 2 ? 2500U : 1200U, .points = level == 2 ? 200U : 100U, .halvings = 6, .random_starts = 1};
    parallel::parallel_for(executor_, parents_.size(), 1, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end && keep_going_(); ++i) {
        const CoverParent& parent = parents_[i];
        if (parent.closed) continue;
        covers[i] = cover_greedily(cells_, parent.own, points_, parent.center, parent.radius, bvh_, frame_,
                                   options_.seed + i, greedy);
      }
    });
    std::vector<CoverBall> balls;
    for (std::uint32_t i = 0; i < covers.size(); ++i) {
      const std::vector<CoverBall> some = balls_of(covers[i], i);
      balls.insert(balls.end(), some.begin(), some.end());
      stand_off = std::max(stand_off, covers[i].stand_off);
    }
    return balls;
  }

  void make_level(Level level) {
    float stand_off = 0;
    std::vector<CoverBall> balls = first_balls(level, stand_off);
    if (!keep_going_()) return;
    const double done = kStartShare + (kEndShare - kStartShare) * (level - 1) / options_.depth;
    const double part = (kEndShare - kStartShare) / options_.depth;
    progress_(done);
    const auto open = static_cast<std::size_t>(
        std::ranges::count_if(parents_, [](const CoverParent& parent) { return !parent.closed; }));
    const std::size_t target =
        std::clamp(effort_.samples_per_ball * kTreeBranching * open, kFewestGrowSamples, kMostSamples);
    const ShellSamples samples = sample_shell(mesh_, bvh_, frame_, kGrowShellFactor * stand_off + 0.002F, target,
                                              options_.seed + level, executor_);
    LevelCover cover(cells_, samples, bvh_, frame_, points_, parents_);
    int round = 0;
    LevelSettings settings = effort_.level;
    // Levels of few balls are cheap and stand out far.
    if (level <= 2) settings.bids *= 2;
    if (level == 1) settings.redone = 0;
    cover.improve(std::move(balls), settings, [&] {
      progress_(done + part * ++round / (settings.bids + settings.iterations + 2));
      return keep_going_();
    });
    if (keep_going_()) take_over(cover.take_best());
  }

  /// Makes nodes of the balls. A parent whose balls would not improve it becomes a leaf instead.
  void take_over(const std::vector<CoverBall>& balls) {
    std::vector<std::vector<const CoverBall*>> families(parents_.size());
    for (const CoverBall& ball : balls) {
      if (!ball.own.empty()) families[ball.parent].push_back(&ball);
    }
    std::vector<CoverParent> next;
    std::vector<std::uint32_t> next_nodes;
    for (std::size_t p = 0; p < parents_.size(); ++p) {
      if (parents_[p].closed || !improved(parents_[p], families[p])) {
        parents_[p].closed = true;
        next.push_back(std::move(parents_[p]));
        next_nodes.push_back(node_of_[p]);
        continue;
      }
      for (const CoverBall* ball : families[p]) {
        const auto node = static_cast<std::uint32_t>(nodes_.size());
        next.push_back(close_ball(frame_.from(ball->center), ball->own, parents_[p].allowed));
        next_nodes.push_back(node);
        nodes_[node_of_[p]].children.push_back(node);
      }
    }
    parents_ = std::move(next);
    node_of_ = std::move(next_nodes);
  }

  [[nodiscard]] bool improved(const CoverParent& parent, const std::vector<const CoverBall*>& family) const {
    float radius = 0;
    float bound = -1;
    for (const CoverBall* ball : family) {
      radius = std::max(radius, ball->radius);
      bound = std::max(bound, ball->radius + ball->signed_distance);
    }
    return !family.empty() &&
           (radius < 0.99F * parent.radius || bound < 0.99F * (parent.radius + signed_distance(parent.center)));
  }

  const TriangleMesh& mesh_;
  const TriangleBvh& bvh_;
  const TreeBuildOptions& options_;
  TreeEffort effort_;
  parallel::Executor& executor_;
  const std::function<void(double)>& progress_;
  const std::function<bool()>& keep_going_;
  CoverFrame frame_;
  SolidCells solid_;
  CoverCells cells_;
  std::vector<DeepPoint> points_;
  std::vector<LooseNode> nodes_;
  std::vector<CoverParent> parents_;
  std::vector<std::uint32_t> node_of_;
};

}  // namespace

TreeEffort effort_of(TreePreset preset) {
  TreeEffort effort;
  if (preset == TreePreset::Fast) {
    effort.cells = 20000;
    effort.start_cells = 3000;
    effort.points = 1000;
    effort.samples_per_ball = 100;
    effort.start = {.tries = 2, .samples = 6000, .level = {.bids = 5, .iterations = 2}};
    effort.level = {.bids = 5, .iterations = 2, .redone = 0};
  } else if (preset == TreePreset::Best) {
    effort.cells = 250000;
    effort.start_cells = 12000;
    effort.points = 8000;
    effort.samples_per_ball = 800;
    effort.start = {.tries = 64, .samples = 30000, .level = {.bids = 12, .iterations = 5}};
    effort.level = {.bids = 40, .iterations = 10, .redone = 150};
  }
  return effort;
}

std::vector<LooseNode> grow_tree(const TriangleMesh& mesh, const TriangleBvh& bvh, const TreeBuildOptions& options,
                                 parallel::Executor& executor, const std::function<void(double)>& progress,
                                 const std::function<bool()>& keep_going) {
  return Grower(mesh, bvh, options, executor, progress, keep_going).grow();
}

}  // namespace poise::geometry
