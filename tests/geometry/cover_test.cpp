// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

#include "collision/instruction_sets.h"
#include "geometry/sphere_tree/cover/cover_starts.h"
#include "geometry/sphere_tree/cover/deep_candidates.h"
#include "geometry/sphere_tree/cover/greedy_cover.h"
#include "geometry/sphere_tree/cover/level_cover.h"
#include "geometry/sphere_tree/cover/solid_cells.h"
#include "geometry/sphere_tree/shell_samples.h"
#include "meshes.h"

// The stages of building a tree, each compared with a simple computation.
namespace poise::geometry {
namespace {

/// A mesh with the data that the stages need.
struct Bench {
  TriangleMesh mesh;
  TriangleBvh bvh;
  CoverFrame frame;
  std::unique_ptr<parallel::Executor> executor = parallel::make_executor(ExecutorKind::Serial, 1);

  explicit Bench(TriangleMesh given)
      : mesh(std::move(given)), bvh(mesh), frame{bounds_of(mesh.vertices_m).center(), mesh.diagonal_m()} {}
  [[nodiscard]] ShellSamples shell(float thickness, std::size_t target) const {
    return sample_shell(mesh, bvh, frame, thickness, target, 3, *executor);
  }
};

Vec3f random_vec(std::mt19937_64& random) {
  return test::random_in_box(random, Vec3::Constant(-1), Vec3::Constant(1)).cast<float>();
}

std::vector<std::uint32_t> all_of(const CoverCells& cells) {
  std::vector<std::uint32_t> all(cells.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

/// Points, reaches and weights, some of them exactly on the border of the query.
struct KernelInput {
  PointList points;
  std::vector<float> reach;
  std::vector<std::int32_t> weights;
};

KernelInput kernel_input(std::size_t length, const Vec3f& center, float radius, std::mt19937_64& random) {
  KernelInput input;
  for (std::size_t i = 0; i < length; ++i) {
    input.points.add(i % 7 == 3 ? Vec3f(center + radius * Vec3f::UnitX()) : random_vec(random));
    input.reach.push_back(i % 5 == 2 ? radius : static_cast<float>(0.6 * test::uniform(random)));
    input.weights.push_back(static_cast<std::int32_t>(random() % 4097));
  }
  return input;
}

TEST(CoverKernels, GiveTheBitsOfPlainLoopsForAnyLengthOnEveryInstructionSet) {
  const Vec3f center(0.125F, -0.25F, 0.0625F);
  const float radius = 0.75F;
  std::mt19937_64 random(17);
  for (std::size_t length = 0; length <= 70; ++length) {
    const KernelInput in = kernel_input(length, center, radius, random);
    std::vector<float> squares;
    float largest = 0;
    std::int32_t within = 0;
    std::int32_t balls_within = 0;
    for (std::size_t i = 0; i < length; ++i) {
      const Vec3f way = in.points.at(i) - center;
      const float square = way.x() * way.x() + way.y() * way.y() + way.z() * way.z();
      const float left = radius - in.reach[i];
      squares.push_back(square);
      largest = std::max(largest, square);
      if (square <= radius * radius) within += in.weights[i];
      if (left > 0 && square <= left * left) balls_within += in.weights[i];
    }
    const int sets = collision::on_every_instruction_set([&] {
      std::vector<float> out(length + 1, -7.0F);
      EXPECT_EQ(squared_distances(in.points, center, out.data()), largest) << length;
      EXPECT_EQ(out.back(), -7.0F) << "nothing is written behind the last point";
      out.pop_back();
      EXPECT_TRUE(length == 0 || std::memcmp(out.data(), squares.data(), length * sizeof(float)) == 0) << length;
      EXPECT_EQ(weight_within(in.points, in.weights, center, radius), within) << length;
      EXPECT_EQ(weight_of_balls_within(in.points, in.reach, in.weights, center, radius), balls_within) << length;
    });
    EXPECT_GE(sets, 1);
  }
}

TEST(CoverKernels, OfARangeFindWhatPlainLoopsFindOnEveryInstructionSet) {
  const Vec3f center(0.125F, -0.25F, 0.0625F);
  const float radius = 0.75F;
  const DistanceRange range = {center, 0.25F, radius * radius};
  std::mt19937_64 random(18);
  for (std::uint32_t length = 0; length <= 70; ++length) {
    KernelInput in = kernel_input(length, center, radius, random);
    const std::uint32_t first = length / 3;
    float largest = 0;
    std::vector<std::uint32_t> between;
    std::vector<std::uint32_t> uncounted;
    std::vector<std::uint32_t> beyond;
    std::vector<float> squares;
    std::vector<std::uint32_t> counts;
    for (std::uint32_t i = 0; i < length; ++i) {
      const Vec3f way = in.points.at(i) - center;
      const float square = way.x() * way.x() + way.y() * way.y() + way.z() * way.z();
      squares.push_back(square);
      counts.push_back(static_cast<std::uint32_t>(random() % 2));
      if (std::sqrt(square) + in.reach[i] > radius) beyond.push_back(i);
      if (i < first) continue;
      largest = std::max(largest, way.squaredNorm());
      if (square < range.least || square > range.most) continue;
      between.push_back(i);
      if (counts[i] == 0) uncounted.push_back(i);
    }
    // What is behind the last would be found if it were looked at.
    for (std::size_t k = 0; k < kReadBeyond; ++k) {
      in.points.add(center + Vec3f(0.6F, 0, 0));
      in.reach.push_back(9);
      squares.push_back(9);
      counts.push_back(0);
    }
    const int sets = collision::on_every_instruction_set([&] {
      std::vector<std::uint32_t> out(length + kReadBeyond);
      const auto found = [&](std::size_t count) {
        return std::vector<std::uint32_t>(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(count));
      };
      EXPECT_EQ(largest_squared_distance(in.points, first, length, center), largest) << length;
      EXPECT_EQ(found(points_between(in.points, first, length, range, nullptr, out.data())), between) << length;
      EXPECT_EQ(found(points_between(in.points, first, length, range, counts.data(), out.data())), uncounted) << length;
      EXPECT_EQ(found(balls_beyond(squares.data(), in.reach.data(), length, radius, out.data())), beyond) << length;
    });
    EXPECT_GE(sets, 1);
  }
}

TEST(CoverCells, RadiusAboutIsThatOfTheFarthestPointAndWithinNeverTakesAnAtomThatSticksOut) {
  const Bench bench(make_procedural_shape("jack").value());
  const SolidCells solid = cut_into_cells(bench.mesh, bench.bvh, 500, *bench.executor);
  const CoverCells cells(solid, bench.frame);
  std::mt19937_64 random(4);
  for (int round = 0; round < 40; ++round) {
    std::vector<std::uint32_t> some;
    for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
      if (random() % 4 == 0) some.push_back(cell);
    }
    const Vec3f center = 0.5F * random_vec(random);
    double farthest = 0;
    for (const std::uint32_t cell : some) {
      for (const Vec3& p : solid.points_of(cell))
        farthest = std::max(farthest, (p - bench.frame.from(center)).norm() / bench.frame.diagonal_m);
    }
    CellSet set;
    set.gather(cells, some);
    const float radius = set.radius_about(cells, center, 9);
    EXPECT_GE(static_cast<double>(radius), farthest - 1e-7);
    EXPECT_LE(static_cast<double>(radius), farthest + 1e-6);
    // A cell whose middle is outside the ball is skipped even if all of its points are inside.
    for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
      const float reach = cells.reach_from(cell, center);
      const float middle = (cells.middles.at(cell) - center).norm();
      if (reach > 0.7F * radius + 1e-6F) {
        EXPECT_FALSE(cells.within(cell, center, 0.7F * radius));
      } else if (std::max(reach, middle) < 0.7F * radius - 1e-6F) {
        EXPECT_TRUE(cells.within(cell, center, 0.7F * radius));
      }
    }
    EXPECT_GT(set.radius_about(cells, center, 0.5F * radius), 0.5F * radius);
  }
}

TEST(ShellSamples, LieOutsideWithinTheThicknessAtTheDistancesThatTheyState) {
  for (const char* kind : {"l", "torus", "bowl"}) {
    const Bench bench(make_procedural_shape(kind).value());
    const float thickness = 0.08F;
    const ShellSamples shell = bench.shell(thickness, 4000);
    EXPECT_GE(shell.size(), 2000U) << kind;
    EXPECT_LE(shell.size(), 8000U) << kind;
    ASSERT_EQ(shell.points.size(), shell.size() + kReadBeyond);
    for (std::size_t i = 0; i < shell.size(); ++i) {
      const double distance =
          bench.bvh.signed_distance_m(bench.frame.from(shell.points.at(i))) / bench.frame.diagonal_m;
      ASSERT_GT(distance, 0) << kind;
      ASSERT_LE(shell.distance[i], thickness) << kind;
      ASSERT_NEAR(static_cast<double>(shell.distance[i]), distance, 1e-6) << kind;
    }
  }
}

TEST(ShellSamples, StandForTheVolumeAroundABallWhereverItLies) {
  const Bench bench(test::ball_mesh(1, 4));
  const ShellSamples shell = bench.shell(0.1F, 20000);
  const double radius = 1 / bench.frame.diagonal_m;
  const auto ball = [](double r) { return 4.0 / 3 * std::numbers::pi * r * r * r; };
  EXPECT_NEAR(
      static_cast<double>(shell.volume) * static_cast<double>(shell.size()) / (ball(radius + 0.1) - ball(radius)), 1,
      0.03);
  std::size_t near_half = 0;
  std::size_t above = 0;
  for (std::size_t i = 0; i < shell.size(); ++i) {
    near_half += shell.distance[i] < 0.05F ? 1U : 0U;
    above += shell.points.z[i] > 0 ? 1U : 0U;
  }
  const auto share = [&](std::size_t count) { return static_cast<double>(count) / static_cast<double>(shell.size()); };
  EXPECT_NEAR(share(near_half), (ball(radius + 0.05) - ball(radius)) / (ball(radius + 0.1) - ball(radius)), 0.02);
  EXPECT_NEAR(share(above), 0.5, 0.02);
}

TEST(ShellSamples, RunsNearABallHoldAllThatAreInIt) {
  const Bench bench(make_procedural_shape("jack").value());
  const ShellSamples shell = bench.shell(0.1F, 4000);
  std::mt19937_64 random(6);
  for (int round = 0; round < 50; ++round) {
    const Vec3f center = 0.6F * random_vec(random);
    const auto radius = static_cast<float>(0.5 * test::uniform(random));
    std::vector<int> taken(shell.size(), 0);
    shell.runs_near(center, radius, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t i = first; i < last; ++i) ++taken[i];
    });
    for (std::size_t i = 0; i < shell.size(); ++i) {
      EXPECT_LE(taken[i], 1);
      if ((shell.points.at(i) - center).norm() <= radius) {
        EXPECT_EQ(taken[i], 1);
      }
    }
  }
}

TEST(DeepPoints, OfATorusAreAsDeepAsTheySayAndSomeReachItsMiddle) {
  const Bench bench(test::torus_mesh(0.7, 0.2, 48, 24));
  const auto points = find_deep_points(bench.mesh, bench.bvh, bench.frame, 200, 1, *bench.executor);
  ASSERT_EQ(points.size(), 200U);
  // Near an edge between two facets a ball that touches both is small, and most points are near an edge.
  int in_the_middle = 0;
  for (const DeepPoint& place : points) {
    const Vec3 at = bench.frame.from(place.center);
    EXPECT_NEAR(-bench.bvh.signed_distance_m(at) / bench.frame.diagonal_m, static_cast<double>(place.depth), 1e-5);
    in_the_middle += std::hypot(std::hypot(at.x(), at.y()) - 0.7, at.z()) < 0.03 ? 1 : 0;
  }
  EXPECT_GT(in_the_middle, 5);
}

TEST(GreedyCover, HoldsEveryAtomWithEightBallsOrFewer) {
  for (const char* kind : {"jack", "slab", "bowl"}) {
    const Bench bench(make_procedural_shape(kind).value());
    const CoverCells cells(cut_into_cells(bench.mesh, bench.bvh, 800, *bench.executor), bench.frame);
    const auto points = find_deep_points(bench.mesh, bench.bvh, bench.frame, 300, 1, *bench.executor);
    const GreedyCover cover =
        cover_greedily(cells, all_of(cells), points, Vec3f::Zero(), 0.6F, bench.bvh, bench.frame, 1, {.cells = 100000});
    EXPECT_GE(cover.points.size(), 1U) << kind;
    EXPECT_LE(cover.points.size(), std::size_t{kTreeBranching}) << kind;
    for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
      const bool held = std::ranges::any_of(cover.points, [&](const DeepPoint& place) {
        return cells.reach_from(cell, place.center) <= place.depth + cover.stand_off + 1e-6F;
      });
      EXPECT_TRUE(held) << kind << " atom " << cell;
    }
    // Much less than the stand-off of one ball around everything.
    EXPECT_LT(cover.stand_off, 0.25F) << kind;
  }
}

/// Cells of an L below two parents, divided across: one ball at each end.
class LevelCoverOf : public testing::Test {
 protected:
  LevelCoverOf() {
    for (const float side : {-1.0F, 1.0F}) {
      CoverParent parent;
      parent.center = Vec3f(side * 0.2F, 0, 0);
      parent.radius = 0.5F;
      for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
        if (cells_.within(cell, parent.center, parent.radius)) parent.allowed.push_back(cell);
      }
      parents_.push_back(std::move(parent));
    }
    for (const std::uint32_t cell : all_of(cells_)) {
      const bool first = std::ranges::binary_search(parents_[0].allowed, cell);
      EXPECT_TRUE(first || std::ranges::binary_search(parents_[1].allowed, cell)) << "the parents hold all atoms";
      parents_[first ? 0 : 1].own.push_back(cell);
    }
  }

  std::vector<CoverBall> first_balls() const {
    std::vector<CoverBall> balls;
    for (std::uint32_t p = 0; p < parents_.size(); ++p) {
      if (parents_[p].closed) continue;
      const GreedyCover cover = cover_greedily(cells_, parents_[p].own, points_, parents_[p].center, parents_[p].radius,
                                               bench_.bvh, bench_.frame, 1, {.cells = 500, .random_starts = 0});
      const std::vector<CoverBall> some = balls_of(cover, p);
      balls.insert(balls.end(), some.begin(), some.end());
    }
    return balls;
  }

  /// The level after this many calls of keep_going.
  std::vector<CoverBall> level_after(int rounds, LevelScore* score = nullptr) const {
    LevelCover cover(cells_, shell_, bench_.bvh, bench_.frame, points_, parents_);
    cover.improve(first_balls(), {.bids = 4, .iterations = 2, .redone = 2}, [&] { return rounds-- > 0; });
    return cover.take_best(score);
  }

  /// Each cell that no closed parent contains is owned by one ball that contains it, and whose parent contains it.
  void expect_cover(const std::vector<CoverBall>& balls) const {
    std::vector<int> owners(cells_.size(), 0);
    std::vector<std::size_t> family(parents_.size(), 0);
    for (const CoverBall& ball : balls) {
      ++family[ball.parent];
      EXPECT_FALSE(parents_[ball.parent].closed);
      for (const std::uint32_t cell : ball.own) {
        ++owners[cell];
        EXPECT_LE(cells_.reach_from(cell, ball.center), ball.radius + 1e-6F);
        EXPECT_TRUE(std::ranges::binary_search(parents_[ball.parent].allowed, cell));
      }
    }
    for (const std::size_t size : family) EXPECT_LE(size, std::size_t{kTreeBranching});
    for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
      const bool elsewhere = std::ranges::any_of(parents_, [&](const CoverParent& parent) {
        return parent.closed && std::ranges::binary_search(parent.allowed, cell);
      });
      EXPECT_EQ(owners[cell], elsewhere ? 0 : 1) << cell;
    }
  }

  Bench bench_{make_procedural_shape("l").value()};
  CoverCells cells_{cut_into_cells(bench_.mesh, bench_.bvh, 900, *bench_.executor), bench_.frame};
  std::vector<DeepPoint> points_ = find_deep_points(bench_.mesh, bench_.bvh, bench_.frame, 200, 1, *bench_.executor);
  ShellSamples shell_ = bench_.shell(0.15F, 4000);
  std::vector<CoverParent> parents_;
};

TEST_F(LevelCoverOf, TwoParentsGivesEachAtomABallThatHoldsItAndMayHaveIt) { expect_cover(level_after(1000)); }

TEST_F(LevelCoverOf, AClosedParentLeavesItsAtomsToIt) {
  parents_[0].closed = true;
  expect_cover(level_after(1000));
}

TEST_F(LevelCoverOf, TwoParentsIsWholeWheneverItIsStopped) {
  for (const int rounds : {1, 2, 4, 5, 6}) expect_cover(level_after(rounds));
}

TEST_F(LevelCoverOf, TwoParentsLetsLessStandOutAfterMoreRounds) {
  LevelScore early;
  LevelScore late;
  level_after(1, &early);
  level_after(1000, &late);
  EXPECT_LT(late.largest + late.volume, early.largest + early.volume);
  EXPECT_LT(late.volume, early.volume);
}

TEST_F(LevelCoverOf, TwoParentsCountsTheSamplesThatItsBallsHold) {
  LevelScore score;
  const std::vector<CoverBall> balls = level_after(1000, &score);
  std::size_t held = 0;
  float largest = 0;
  for (std::size_t i = 0; i < shell_.size(); ++i) {
    const Vec3f at = shell_.points.at(i);
    const bool in = std::ranges::any_of(
        balls, [&](const CoverBall& b) { return (at - b.center).squaredNorm() <= b.radius * b.radius; });
    if (!in) continue;
    ++held;
    largest = std::max(largest, shell_.distance[i]);
  }
  EXPECT_NEAR(score.volume, static_cast<double>(held) * static_cast<double>(shell_.volume),
              2 * static_cast<double>(shell_.volume));
  EXPECT_EQ(score.largest, static_cast<double>(largest));
}

}  // namespace
}  // namespace poise::geometry
