// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/node_fit.h"

#include <gtest/gtest.h>

#include <cstring>

#include "geometry/mesh/procedural.h"
#include "geometry/primitives/random.h"
#include "geometry/sphere_tree/nearest_leaf.h"
#include "geometry/sphere_tree/tree_layout.h"
#include "meshes.h"

namespace poise::geometry {
namespace {

SphereTree single_sphere(const Vec3& center_m, double radius_m) {
  LooseNode node;
  node.center_m = center_m.cast<float>();
  node.radius_m = static_cast<float>(radius_m);
  return flatten_tree({node});
}

NodeFit fit_of(const SphereTree& start, const TriangleMesh& mesh) {
  SphereTree tree = start;
  fit_nodes(tree, mesh, TriangleBvh(mesh), *parallel::make_executor(ExecutorKind::Serial, 1));
  return tree.fit[0];
}

Vec3 center(const NodeFit& fit) {
  return {static_cast<double>(fit.x_m), static_cast<double>(fit.y_m), static_cast<double>(fit.z_m)};
}

TEST(NodeFit, OfACurvedPieceTouchesItFromInside) {
  const TriangleMesh mesh = make_procedural_shape("torus", 8).value();
  // A piece of the tube's outer side has two curvatures, 1/0.15 m and 1/0.5 m. The fit lies between them, and nearer to
  // the surface than the tree's own sphere.
  const NodeFit fit = fit_of(single_sphere({0.35, 0, 0}, 0.2), mesh);
  EXPECT_NEAR(center(fit).norm() + static_cast<double>(fit.radius_m), 0.5, 0.02);
  EXPECT_LT(std::sqrt(static_cast<double>(fit.variance_m2)), 0.03);
}

TEST(NodeFit, OfABoxFacesCentreLiesUnderTheFace) {
  const TriangleMesh mesh = test::box_mesh({2, 2, 2});
  // Only the face z = 1 is inside the sphere.
  const NodeFit fit = fit_of(single_sphere({0, 0, 0.7}, 0.5), mesh);
  EXPECT_NEAR(center(fit).z() + static_cast<double>(fit.radius_m), 1, 0.05);
  EXPECT_LT(center(fit).head<2>().norm(), 0.03);
  EXPECT_LT(center(fit).z(), 0.7);
}

TEST(NodeFit, OfASphereWithoutSurfaceNeverAnswersAndKnowsItsCore) {
  const TriangleMesh mesh = test::box_mesh({2, 2, 2});
  const NodeFit fit = fit_of(single_sphere({0.1, 0.2, 0.3}, 0.25), mesh);
  EXPECT_LT(fit.radius_m, -mesh.diagonal_m());
  EXPECT_NEAR(static_cast<double>(fit.core_m), 0.7, 1e-4);
}

TEST(NodeFit, ACoreIsInsideTheObject) {
  const TriangleMesh mesh = make_procedural_shape("l").value();
  const TriangleBvh bvh(mesh);
  const SphereTree tree = build_sphere_tree(mesh, {.depth = 2, .preset = TreePreset::Fast}).value();
  int cores = 0;
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    const NodeFit& fit = tree.fit[node];
    const double depth_m = -bvh.signed_distance_m(center(fit));
    EXPECT_LE(static_cast<double>(fit.core_m), depth_m);
    EXPECT_NEAR(static_cast<double>(fit.core_m), depth_m, 1e-5);
    cores += fit.core_m > 0;
  }
  EXPECT_GT(cores, 30);
}

TEST(NodeFit, IsTheSameOnAnyNumberOfThreads) {
  const TriangleMesh mesh = make_procedural_shape("bowl").value();
  const TriangleBvh bvh(mesh);
  SphereTree one = build_sphere_tree(mesh, {.depth = 2, .preset = TreePreset::Fast}).value();
  SphereTree three = one;
  fit_nodes(three, mesh, bvh, *parallel::make_executor(ExecutorKind::Threads, 3));
  fit_nodes(one, mesh, bvh, *parallel::make_executor(ExecutorKind::Serial, 1));
  EXPECT_EQ(std::memcmp(one.fit.data(), three.fit.data(), one.node_count() * sizeof(NodeFit)), 0);
}

TEST(NodeFit, ComesNearerToTheSurfaceFromLevelToLevel) {
  const TriangleMesh mesh = make_procedural_shape("disc").value();
  const SphereTree tree = build_sphere_tree(mesh, {.depth = 3, .preset = TreePreset::Fast}).value();
  double last = 1;
  for (std::size_t level = 0; level <= tree.depth(); ++level) {
    double sum = 0;
    int count = 0;
    for (NodeIndex node = tree.level_begin[level]; node < tree.level_begin[level + 1]; ++node) {
      const NodeFit& fit = tree.fit[node];
      if (fit.radius_m < 0) continue;
      sum += std::sqrt(static_cast<double>(fit.variance_m2));
      ++count;
    }
    ASSERT_GT(count, 0);
    EXPECT_LT(sum / count, 0.5 * last) << "level " << level;
    last = sum / count;
  }
}

TEST(NodeFit, OfAUnionOfBallsIsEachLeafsOwnAndHoldsItsCoreInside) {
  std::vector<Sphere> spheres;
  for (int i = 0; i < 20; ++i) spheres.push_back({Vec3(0.1 * i, 0.02 * i * i, 0), 0.15});
  const SphereTree tree = tree_of_spheres(spheres).value();
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    const NodeFit& fit = tree.fit[node];
    if (tree.child_count[node] == 0) {
      EXPECT_EQ(center(fit), tree.sphere(node).center_m);
      EXPECT_EQ(fit.radius_m, tree.radius_m[node]);
      EXPECT_EQ(fit.variance_m2, 0);
    } else {
      EXPECT_LE(static_cast<double>(fit.core_m), -nearest_leaf(tree, center(fit)).distance_m);
      EXPECT_GT(fit.variance_m2, 0);
    }
  }
}

TEST(NodeFit, MovesWithItsTree) {
  SphereTree tree = tree_of_spheres(std::vector<Sphere>{{Vec3(1, 2, 3), 0.5}, {Vec3(2, 2, 3), 0.25}}).value();
  const SphereTree before = tree;
  recenter_tree(tree, {1, 2, 3}, true);
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    EXPECT_LT((center(tree.fit[node]) + Vec3(1, 2, 3) - center(before.fit[node])).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace poise::geometry
