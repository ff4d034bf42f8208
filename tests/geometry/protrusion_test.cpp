// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>

#include "geometry/primitives/random.h"
#include "geometry/sphere_tree/tree_layout.h"
#include "geometry/sphere_tree/tree_protrusion.h"
#include "meshes.h"
#include "poise/assets/mesh_file.h"

namespace poise::geometry {
namespace {

constexpr std::size_t kSamples = 1000000;

TriangleMesh mesh_named(const std::string& name) {
  if (name == "ring") return test::torus_mesh(0.35, 0.15, 32, 16);
  if (name.starts_with("/")) return read_mesh(name, {}).value();
  return make_procedural_shape(name).value();
}

/// Sampled protrusion of one node's sphere, the largest over its levels.
struct Seen {
  double max_m = 0;
  double mean_m = 0;
  double mean_error_m = 0;  ///< standard error of that mean
  double exposed_m2 = 0;
};

/// The definition of protrusion, by random points on every sphere of every level.
std::vector<Seen> sample(const SphereTree& tree, const TriangleBvh& bvh, std::size_t samples) {
  std::vector<Seen> seen(tree.node_count());
  const auto executor = parallel::make_executor(ExecutorKind::Threads, 2);
  for (Level level = 0; level <= tree.depth(); ++level) {
    const std::vector<NodeIndex> nodes = tree.nodes_at(level);
    const std::size_t each = samples / nodes.size() / (std::size_t{tree.depth()} + 1) + 1;
    parallel::parallel_for(*executor, nodes.size(), 1, [&](std::size_t begin, std::size_t, int) {
      const Sphere own = tree.sphere(nodes[begin]);
      std::vector<Sphere> others;
      for (const NodeIndex other : nodes) {
        const Sphere s = tree.sphere(other);
        if (other != nodes[begin] && (s.center_m - own.center_m).norm() < s.radius_m + own.radius_m)
          others.push_back(s);
      }
      Random random = Random::of(level, begin);
      double sum = 0;
      double sum2 = 0;
      double count = 0;
      Seen& here = seen[nodes[begin]];
      for (std::size_t i = 0; i < each; ++i) {
        const Vec3 point = own.center_m + own.radius_m * random.direction();
        if (std::ranges::any_of(others, [&](const Sphere& s) { return (s.center_m - point).norm() < s.radius_m; }))
          continue;
        const double d = bvh.outside_distance_m(point);
        here.max_m = std::max(here.max_m, d);
        sum += d;
        sum2 += d * d;
        ++count;
      }
      if (count < 10 || sum / count <= here.mean_m) return;
      here.mean_m = sum / count;
      here.mean_error_m = std::sqrt(std::max(0.0, sum2 / count - here.mean_m * here.mean_m) / count);
      here.exposed_m2 = own.radius_m * own.radius_m * count / static_cast<double>(each);
    });
  }
  return seen;
}

class ProtrusionOf : public testing::TestWithParam<const char*> {};

TEST_P(ProtrusionOf, IsBoundedForEveryNodeAndNotLoosely) {
  const std::string name = GetParam();
  if (name.starts_with("/") && !std::filesystem::exists(name))
    GTEST_SKIP() << name << " is not installed (libsimbody-dev)";
  const TriangleMesh mesh = mesh_named(name);
  const TriangleBvh bvh(mesh);
  const SphereTree tree = build_sphere_tree(mesh, {.depth = 2, .preset = TreePreset::Fast}).value();
  const std::vector<Seen> seen = sample(tree, bvh, kSamples);
  const double near_m = 4e-4 * mesh.diagonal_m();
  double bound_sum = 0;
  double seen_sum = 0;
  for (Level level = 0; level <= tree.depth(); ++level) {
    double bound_max_m = 0;
    double seen_max_m = 0;
    for (NodeIndex node = tree.level_begin[level]; node < tree.level_begin[level + 1U]; ++node) {
      const auto max_m = static_cast<double>(tree.protrusion_max_m[node]);
      const auto mean_m = static_cast<double>(tree.protrusion_mean_m[node]);
      EXPECT_LE(seen[node].max_m, max_m) << node;
      EXPECT_LE(seen[node].mean_m - 5 * seen[node].mean_error_m, mean_m) << node;
      bound_max_m = std::max(bound_max_m, max_m);
      seen_max_m = std::max(seen_max_m, seen[node].max_m);
      bound_sum += mean_m * seen[node].exposed_m2;
      seen_sum += seen[node].mean_m * seen[node].exposed_m2;
    }
    EXPECT_LE(bound_max_m, 1.05 * seen_max_m + near_m) << int{level};
  }
  EXPECT_GE(bound_sum, seen_sum);
  EXPECT_LE(bound_sum, 1.15 * seen_sum);
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, ProtrusionOf,
    testing::Values("l", "ring", "bowl",
                    "/usr/share/doc/simbody/examples/src/TaskSpaceControl-UR10/geometry/Forearm.obj"));

SphereTree root_and(const std::vector<Sphere>& children) {
  std::vector<LooseNode> nodes(1 + children.size());
  nodes[0].radius_m = 10;
  for (std::size_t i = 0; i < children.size(); ++i) {
    nodes[i + 1].center_m = children[i].center_m.cast<float>();
    nodes[i + 1].radius_m = static_cast<float>(children[i].radius_m);
    nodes[0].children.push_back(static_cast<std::uint32_t>(i + 1));
  }
  return flatten_tree(nodes);
}

TEST(Protrusion, OfTheBallAroundACubeIsBoundedByItsClosedForm) {
  const TriangleMesh mesh = test::box_mesh({2, 2, 2});
  const SphereTree tree = build_sphere_tree(mesh, {.depth = 0}).value();
  EXPECT_GE(static_cast<double>(tree.protrusion_max_m[0]), std::sqrt(3.0) - 1);
  EXPECT_LE(static_cast<double>(tree.protrusion_max_m[0]), 1.02 * (std::sqrt(3.0) - 1) + 1e-6);
}

TEST(Protrusion, OfBallsOverAPlaneIsThatOfTheirCaps) {
  // Half of a unit ball above a large box's face: the height over the plane has the maximum 1, and the mean 1/4 over
  // the whole sphere.
  SphereTree tree = root_and({{{0, 0, 20}, 1}});
  const TriangleBvh bvh(test::box_mesh({40, 40, 40}));
  measure_protrusions(tree, bvh, *parallel::make_executor(ExecutorKind::Serial, 1));
  EXPECT_GE(tree.protrusion_max_m[1], 1);
  EXPECT_LE(tree.protrusion_max_m[1], 1.021);
  EXPECT_GE(tree.protrusion_mean_m[1], 0.25);
  EXPECT_LE(tree.protrusion_mean_m[1], 0.27);
}

TEST(Protrusion, CountsOnlyWhatNoOtherBallOfTheLevelHides) {
  // A ball far outside a small box whose outer half is hidden by a larger one, one that is completely hidden, and one
  // inside the box.
  SphereTree tree = root_and({{{4, 0, 0}, 1}, {{5.5, 0, 0}, 2}, {{5.5, 0, 0}, 1}, {{0, 0, 0}, 0.25}});
  const TriangleBvh bvh(test::box_mesh({2, 2, 2}));
  measure_protrusions(tree, bvh, *parallel::make_executor(ExecutorKind::Serial, 1));
  // Hidden from x = 4 + (1 + 1.5^2 - 4) / 3 on; the circle at that x is farthest from the box's face x = 1.
  const double border = (1 + 2.25 - 4) / 3;
  const double beside = std::max(0.0, std::sqrt(1 - border * border) / std::sqrt(2.0) - 1);
  const double farthest = std::hypot(3 + border, beside);
  EXPECT_GE(static_cast<double>(tree.protrusion_max_m[1]), farthest * (1 - 1e-6));
  EXPECT_LE(static_cast<double>(tree.protrusion_max_m[1]), 1.021 * farthest);
  EXPECT_GT(tree.protrusion_mean_m[1], 2);
  EXPECT_EQ(tree.protrusion_max_m[3], 0);
  EXPECT_EQ(tree.protrusion_mean_m[3], 0);
  EXPECT_EQ(tree.protrusion_max_m[4], 0);
  EXPECT_EQ(tree.protrusion_mean_m[4], 0);
}

TEST(Protrusion, OfAShellIsMeasuredOnBothSides) {
  SphereTree tree = root_and({{{0, 0, 0}, 0.25}});
  const TriangleMesh mesh = test::box_mesh({2, 2, 2});
  measure_protrusions(tree, TriangleBvh(mesh, Solidity::Shell), *parallel::make_executor(ExecutorKind::Serial, 1));
  const double farthest = 1 - 0.25 / std::sqrt(3.0);
  EXPECT_GE(static_cast<double>(tree.protrusion_max_m[1]), farthest);
  EXPECT_LE(static_cast<double>(tree.protrusion_max_m[1]), 1.02 * farthest + 1e-6);
}

TEST(Protrusion, OfALeafIsTheLargestOverTheLevelsItServes) {
  // On level 1 the leaf without siblings lies inside its neighbour; on level 2 that one is replaced by a small ball far
  // away.
  std::vector<LooseNode> nodes(4);
  nodes[0].radius_m = 10;
  nodes[0].children = {1, 2};
  nodes[1].radius_m = 1;
  nodes[2].radius_m = 3;
  nodes[2].children = {3};
  nodes[3].radius_m = 0.5F;
  nodes[3].center_m = {0, 0, 5};
  SphereTree tree = flatten_tree(nodes);
  const TriangleMesh mesh = test::box_mesh(Vec3::Constant(0.2));
  measure_protrusions(tree, TriangleBvh(mesh), *parallel::make_executor(ExecutorKind::Serial, 1));
  EXPECT_NEAR(tree.protrusion_max_m[1], 0.9, 0.02);
}

TEST(Protrusion, IsTheSameOnAnyNumberOfThreads) {
  const TriangleMesh mesh = make_procedural_shape("jack").value();
  const TriangleBvh bvh(mesh);
  SphereTree one = build_sphere_tree(mesh, {.depth = 1, .preset = TreePreset::Fast}).value();
  SphereTree three = one;
  measure_protrusions(one, bvh, *parallel::make_executor(ExecutorKind::Serial, 1));
  measure_protrusions(three, bvh, *parallel::make_executor(ExecutorKind::Threads, 3));
  EXPECT_TRUE(test::same_tree(one, three));
}

TEST(OverlappingNodes, AreThoseOfASearchOverAllPairs) {
  std::mt19937_64 random(8);
  std::vector<Sphere> balls;
  for (int i = 0; i < 300; ++i) {
    balls.push_back({test::random_in_box(random, Vec3::Constant(-1), Vec3::Constant(1)),
                     0.05 + (i % 50 == 0 ? 1.0 : 0.2 * test::uniform(random))});
  }
  const SphereTree tree = tree_of_spheres(balls).value();
  for (Level level = 0; level <= tree.depth(); ++level) {
    const std::vector<NodeIndex> nodes = tree.nodes_at(level);
    const auto found = overlapping_nodes(tree, nodes);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      std::vector<NodeIndex> expected;
      for (const NodeIndex other : nodes) {
        const Sphere a = tree.sphere(nodes[i]);
        const Sphere b = tree.sphere(other);
        if (other != nodes[i] && (a.center_m - b.center_m).norm() < a.radius_m + b.radius_m) expected.push_back(other);
      }
      EXPECT_EQ(found[i], expected);
    }
  }
}

}  // namespace
}  // namespace poise::geometry
