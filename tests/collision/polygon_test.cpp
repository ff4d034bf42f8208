// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>

#include "collision/near_touch.h"
#include "collision/pair_refinement.h"

namespace poise::collision {
namespace {

namespace fs = std::filesystem;

constexpr Level kDepth = 2;  // deeper trees take longer to build than a test may; bench_tree_query has the third level

const fs::path kMeshes = "/usr/share/doc/simbody/examples/src/TaskSpaceControl-UR10/geometry";

JudgedShape judged_shape(const char* file) {
  TriangleMesh mesh = read_mesh(kMeshes / file, {}).value();
  center_mesh(mesh);
  return make_judged_shape(mesh, build_sphere_tree(mesh, {.depth = kDepth, .preset = TreePreset::Fast}).value());
}

// Levels that have a front, from 1: kDepth when the pair is never found apart.
int levels_with_a_front(const PairFrame& frame, std::span<FrontPool> pools) {
  pools[0].clear();
  PairLevel pair;
  pair.deepest = deepest_level(*frame.a, *frame.b, kMaxTreeDepth);
  int levels = 0;
  while (pair.refinable()) {
    LevelProgress progress = begin_level(pair, pools[0]);
    while (run_quantum(frame, pools, 0, 64, progress) == Quantum::More) {
    }
    publish_level(frame, Mat3::Identity(), progress, pair);
    if (!pair.apart) ++levels;
  }
  return levels;
}

TEST(TreesOfMeshes, NoLevelIsEmptyWhereTrianglesMeet) {
  if (!fs::exists(kMeshes)) GTEST_SKIP() << "libsimbody-dev is not installed";
  const JudgedShape shapes[] = {judged_shape("Base.obj"), judged_shape("Wrist3.obj")};
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 16U);
  std::mt19937_64 random(21);
  int touching = 0;
  int told_apart = 0;
  for (int round = 0; round < 2000; ++round) {
    const JudgedShape& a = shapes[random() % 2];
    const JudgedShape& b = shapes[random() % 2];
    PosedPair posed;
    if (round % 10 == 0) {
      posed = pose_near_first_touch(a, b, 5e-3, random);
    } else {
      posed = {random_pose(random, 10), random_pose(random, 0)};
      const double distance = uniform(random, 0.1, 1) * (a.shape.bounding_radius_m + b.shape.bounding_radius_m);
      posed.b.position_m = posed.a.position_m + distance * random_vector(random, 1).normalized();
    }
    const PairFrame frame = make_pair_frame(a.shape, posed.a, b.shape, posed.b, 0, 0);
    const int levels = levels_with_a_front(frame, pools);
    if (a.judge.touches(posed.a, b.judge, posed.b)) {
      ++touching;
      ASSERT_EQ(levels, int{kDepth}) << "round " << round;
    } else if (levels < int{kDepth}) {
      ++told_apart;
    }
  }
  EXPECT_GT(touching, 300);
  EXPECT_GT(told_apart, 300);
}

}  // namespace
}  // namespace poise::collision
