// SPDX-License-Identifier: MIT
#include "poise/shape.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stop_token>

#include "meshes.h"

namespace poise {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<Sphere> jack_spheres() {
  std::vector<Sphere> spheres{{Vec3::Zero(), 0.28}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      spheres.push_back({sign * 0.35 * Vec3::Unit(axis), 0.22});
      spheres.push_back({sign * 0.68 * Vec3::Unit(axis), 0.18});
    }
  }
  return spheres;
}

std::vector<Sphere> random_spheres(std::mt19937_64& random, std::size_t count) {
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < count; ++i) {
    spheres.push_back(
        {test::random_in_box(random, Vec3::Constant(-2), Vec3::Constant(3)), 0.05 + 0.4 * test::uniform(random)});
  }
  return spheres;
}

TEST(SphereShape, IsOneNodeAtItsCentreWithTheMassOfABall) {
  const ShapePtr shape = make_sphere_shape(0.5).value();
  EXPECT_EQ(shape->kind, ShapeKind::Tree);
  EXPECT_EQ(shape->tree.node_count(), 1U);
  EXPECT_EQ(shape->tree.depth(), 0);
  EXPECT_EQ(shape->tree.sphere(0).center_m, Vec3(0, 0, 0));
  EXPECT_EQ(shape->tree.sphere(0).radius_m, 0.5);
  EXPECT_EQ(shape->tree.protrusion_max_m[0], 0);
  EXPECT_EQ(shape->bounding_radius_m, 0.5);
  EXPECT_EQ(shape->origin_offset_m, Vec3(0, 0, 0));
  EXPECT_NEAR(shape->volume_m3, kPi / 6, 1e-15);
  EXPECT_NEAR(shape->principal_m5.x(), 0.4 * 0.25 * kPi / 6, 1e-16);
  EXPECT_EQ(shape->principal_m5.x(), shape->principal_m5.y());
  EXPECT_EQ(shape->principal_m5.x(), shape->principal_m5.z());
  EXPECT_EQ(shape->principal_axes.coeffs(), Quat::Identity().coeffs());
}

TEST(SphereShape, RefusesRadiiThatAreNotPositiveAndFinite) {
  for (const double radius : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity(), 1e300, 1e-300}) {
    const auto shape = make_sphere_shape(radius);
    ASSERT_FALSE(shape.ok()) << radius;
    EXPECT_NE(shape.error().message.find("radius_m"), std::string::npos);
    EXPECT_NE(shape.error().message.find("must be > 0"), std::string::npos);
  }
}

TEST(PlaneShape, NormalisesItsNormal) {
  for (const double length : {1e-200, 2.0, 1e200}) {
    const ShapePtr shape = make_plane_shape({0, 0, length}, 1.5).value();
    EXPECT_EQ(shape->kind, ShapeKind::Plane);
    EXPECT_EQ(shape->plane_normal, Vec3(0, 0, 1));
    EXPECT_EQ(shape->plane_offset_m, 1.5);
  }
  EXPECT_NEAR(make_plane_shape({1, 2, -3}, 0).value()->plane_normal.norm(), 1, 1e-15);
}

TEST(PlaneShape, RefusesANormalOfZeroAndNumbersThatAreNotFinite) {
  EXPECT_FALSE(make_plane_shape({0, 0, 0}, 0).ok());
  EXPECT_FALSE(make_plane_shape({0, std::nan(""), 1}, 0).ok());
  EXPECT_FALSE(make_plane_shape({0, 0, std::numeric_limits<double>::infinity()}, 0).ok());
  EXPECT_FALSE(make_plane_shape({0, 0, 1}, std::nan("")).ok());
  EXPECT_FALSE(make_plane_shape({0, 0, 1}, 1e300).ok());
}

TEST(SpheresShape, OfAJackHasTheSumOfItsBallsAndTwoLevels) {
  const ShapePtr shape = make_spheres_shape(jack_spheres()).value();
  double volume = 0;
  double moment = 0;
  for (const Sphere& s : jack_spheres()) {
    const double v = 4.0 / 3 * kPi * std::pow(s.radius_m, 3);
    volume += v;
    moment += v * (0.4 * s.radius_m * s.radius_m + s.center_m.y() * s.center_m.y() + s.center_m.z() * s.center_m.z());
  }
  EXPECT_NEAR(shape->volume_m3, volume, 1e-15);
  EXPECT_LT((shape->principal_m5 - Vec3::Constant(moment)).norm(), 1e-14);
  EXPECT_EQ(shape->principal_axes.coeffs(), Quat::Identity().coeffs());
  EXPECT_EQ(shape->origin_offset_m, Vec3(0, 0, 0));
  EXPECT_EQ(shape->tree.depth(), 2);
  EXPECT_LE(shape->tree.child_count[0], kTreeBranching);
  EXPECT_NEAR(shape->bounding_radius_m, 0.86, 0.005);
  EXPECT_GE(shape->bounding_radius_m, 0.86);
}

TEST(SpheresShape, TurnsADiagonalRodIntoItsPrincipalFrame) {
  const Vec3 along = Vec3(1, 2, -2) / 3;
  std::vector<Sphere> rod;
  for (int i = -3; i <= 3; ++i) rod.push_back({Vec3(5, 5, 5) + 0.3 * i * along, 0.2});
  const ShapePtr shape = make_spheres_shape(rod).value();
  EXPECT_LT((shape->origin_offset_m - Vec3(5, 5, 5)).norm(), 1e-14);
  EXPECT_LE(shape->principal_m5.x(), shape->principal_m5.y());
  EXPECT_LE(shape->principal_m5.y(), shape->principal_m5.z());
  const Mat3 axes = shape->principal_axes.toRotationMatrix();
  EXPECT_NEAR(axes.determinant(), 1, 1e-14);
  EXPECT_NEAR(std::abs(axes.col(0).dot(along)), 1, 1e-12);
}

TEST(SpheresShape, RefusesEachBadSphereByItsPlace) {
  EXPECT_FALSE(make_spheres_shape({}).ok());
  const auto message = [](const Sphere& bad) {
    const std::vector<Sphere> spheres{{Vec3::Zero(), 1}, bad};
    const auto shape = make_spheres_shape(spheres);
    return shape.ok() ? std::string() : shape.error().message;
  };
  EXPECT_NE(message({Vec3::Zero(), 0}).find("spheres[1].radius_m = 0, must be > 0"), std::string::npos);
  EXPECT_NE(message({Vec3::Zero(), std::nan("")}).find("spheres[1].radius_m"), std::string::npos);
  EXPECT_NE(message({{0, std::numeric_limits<double>::infinity(), 0}, 1}).find("spheres[1].center_m"),
            std::string::npos);
  EXPECT_NE(message({{1e10, 0, 0}, 1}).find("spheres[1].center_m"), std::string::npos);
  const std::vector<Sphere> many(kMaxUnionSpheres + 1, Sphere{Vec3::Zero(), 1});
  EXPECT_NE(make_spheres_shape(many).error().message.find("at most 32768"), std::string::npos);
}

TEST(TreeOfSpheres, TheLeavesAreTheSpheresRoundedToFloat) {
  const std::vector<Sphere> spheres = jack_spheres();
  const SphereTree tree = tree_of_spheres(spheres).value();
  std::vector<bool> found(spheres.size(), false);
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    if (tree.child_count[node] > 0) continue;
    EXPECT_EQ(tree.protrusion_max_m[node], 0);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      const bool same = tree.x_m[node] == static_cast<float>(spheres[i].center_m.x()) &&
                        tree.y_m[node] == static_cast<float>(spheres[i].center_m.y()) &&
                        tree.z_m[node] == static_cast<float>(spheres[i].center_m.z()) &&
                        tree.radius_m[node] == static_cast<float>(spheres[i].radius_m);
      if (same) found[i] = true;
    }
  }
  EXPECT_EQ(tree.nodes_at(tree.depth()).size(), spheres.size());
  for (std::size_t i = 0; i < spheres.size(); ++i) EXPECT_TRUE(found[i]) << i;
}

/// Checks that every leaf lies inside all nodes above it.
void expect_leaves_inside(const SphereTree& tree, NodeIndex node, std::vector<NodeIndex>& above) {
  if (tree.child_count[node] == 0) {
    const Sphere leaf = tree.sphere(node);
    for (const NodeIndex a : above) {
      const Sphere holder = tree.sphere(a);
      EXPECT_LE((holder.center_m - leaf.center_m).norm() + leaf.radius_m, holder.radius_m);
    }
    return;
  }
  above.push_back(node);
  for (NodeIndex c = 0; c < tree.child_count[node]; ++c) expect_leaves_inside(tree, tree.first_child[node] + c, above);
  above.pop_back();
}

TEST(TreeOfSpheres, EveryInnerSphereHoldsTheLeavesBelowItAndTheLevelsAreFewest) {
  std::mt19937_64 random(3);
  const std::vector<std::pair<std::size_t, int>> counts{{1, 0},  {2, 1},  {8, 1},  {9, 2},
                                                        {13, 2}, {64, 2}, {65, 3}, {500, 3}};
  for (const auto& [count, depth] : counts) {
    const SphereTree tree = tree_of_spheres(random_spheres(random, count)).value();
    EXPECT_EQ(tree.depth(), depth) << count;
    EXPECT_EQ(tree.nodes_at(tree.depth()).size(), count);
    std::vector<NodeIndex> above;
    expect_leaves_inside(tree, 0, above);
    for (NodeIndex node = 0; node < tree.node_count(); ++node) EXPECT_LE(tree.child_count[node], kTreeBranching);
  }
}

TEST(TreeOfSpheres, CanBeStoppedAndIsTheSameOnAnyThreads) {
  std::mt19937_64 random(6);
  const std::vector<Sphere> spheres = random_spheres(random, 600);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(tree_of_spheres(spheres, {.stop = stop.get_token()}).error().kind, ErrorKind::Cancelled);
  EXPECT_EQ(make_spheres_shape(spheres, {.stop = stop.get_token()}).error().kind, ErrorKind::Cancelled);
  const SphereTree one = tree_of_spheres(spheres, {.threads = 1}).value();
  const SphereTree three = tree_of_spheres(spheres, {.threads = 3}).value();
  EXPECT_EQ(one.protrusion_max_m, three.protrusion_max_m);
  EXPECT_EQ(one.protrusion_mean_m, three.protrusion_mean_m);
  EXPECT_EQ(tree_of_spheres(spheres, {.threads = -3}).error().message, "threads = -3, must be from 0 to 256");
}

// What is refused is what the caller gave, not what moving it about its centre of mass makes of it.
TEST(SpheresShape, OfSpheresAtTheEndsOfTheRangeIsMade) {
  const std::vector<Sphere> spheres = {{Vec3(1e9, 0, 0), 1e9}, {Vec3(-1e9, 0, 0), 1e-9}};
  EXPECT_TRUE(tree_of_spheres(spheres).ok());
  EXPECT_TRUE(make_spheres_shape(spheres).ok());
}

TEST(TreeOfSpheres, EqualSpheresAreGroupedToo) {
  const std::vector<Sphere> same(100, Sphere{Vec3(1, 2, 3), 0.5});
  const SphereTree tree = tree_of_spheres(same).value();
  EXPECT_EQ(tree.depth(), 3);
  EXPECT_EQ(tree.nodes_at(3).size(), 100U);
}

TEST(TreeOfSpheres, TheProtrusionOfARootOverTwoBallsIsItsWaist) {
  // Two unit balls at +-2: the root has radius 3 and protrudes most at its waist, by sqrt(4 + 9) - 1.
  const std::vector<Sphere> two{{{-2, 0, 0}, 1}, {{2, 0, 0}, 1}};
  const SphereTree tree = tree_of_spheres(two).value();
  EXPECT_NEAR(tree.radius_m[0], 3, 0.03);
  const double waist = std::sqrt(13.0) - 1;
  EXPECT_GE(static_cast<double>(tree.protrusion_max_m[0]), waist);
  EXPECT_LE(static_cast<double>(tree.protrusion_max_m[0]), 1.03 * waist);
  // The mean over the sphere of |p - nearer centre| - 1, with x = 3 t uniform: the mean of sqrt(13 - 12 t) over t in
  // [0, 1], minus 1.
  const double mean = (std::pow(13.0, 1.5) - 1) / 18 - 1;
  EXPECT_GE(static_cast<double>(tree.protrusion_mean_m[0]), mean);
  EXPECT_LE(static_cast<double>(tree.protrusion_mean_m[0]), 1.06 * mean);
}

TEST(TreeShape, KeepsItsLeavesAndItsInnerSpheresHoldThem) {
  std::mt19937_64 random(4);
  std::vector<Sphere> spheres = random_spheres(random, 70);
  for (Sphere& s : spheres) s.center_m += Vec3(1000, -2000, 500);
  const SphereTree tree = tree_of_spheres(spheres).value();
  const ShapePtr shape = make_tree_shape(tree).value();
  std::vector<NodeIndex> above;
  expect_leaves_inside(shape->tree, 0, above);
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    if (tree.child_count[node] == 0) {
      EXPECT_EQ(shape->tree.radius_m[node], tree.radius_m[node]);
    }
    EXPECT_GE(shape->tree.radius_m[node], tree.radius_m[node]);
  }
  EXPECT_FALSE(make_tree_shape({}).ok());
}

// A tree is plain data that a caller may make or change.
TEST(TreeShape, RefusesATreeThatIsNotArrangedAsItShould) {
  std::mt19937_64 random(5);
  const SphereTree sound = tree_of_spheres(random_spheres(random, 70)).value();
  const TriangleMesh mesh = test::box_mesh({1, 1, 1});
  const auto refused = [&](const auto& change) {
    SphereTree tree = sound;
    change(tree);
    const Result<ShapePtr> with_mesh = make_mesh_shape_with_tree(mesh, tree);
    const Result<ShapePtr> alone = make_tree_shape(tree);
    EXPECT_EQ(with_mesh.ok(), alone.ok());
    return alone.ok() ? std::string() : alone.error().message;
  };
  EXPECT_EQ(refused([](SphereTree&) {}), "");
  EXPECT_EQ(refused([](SphereTree& t) { t.level_begin = {5}; }), "tree: there is no node, at least one is needed");
  EXPECT_NE(refused([](SphereTree& t) { t.level_begin.back() = 100000; }).find("x_m has 1"), std::string::npos);
  EXPECT_NE(refused([](SphereTree& t) { t.level_begin[1] = 2; }).find("must be 0, 1"), std::string::npos);
  EXPECT_NE(refused([](SphereTree& t) { t.fit.clear(); }).find("fit has 0 entries"), std::string::npos);
  EXPECT_NE(refused([](SphereTree& t) { t.x_m.resize(1); }).find("x_m has 1 entries"), std::string::npos);
  EXPECT_NE(refused([](SphereTree& t) { t.child_count[0] = 200; }).find("child_count[0] = 200"), std::string::npos);
  EXPECT_NE(refused([](SphereTree& t) { t.first_child[0] = 1000; }).find("first_child[0] = 1000"), std::string::npos);
  EXPECT_NE(refused([](SphereTree& t) { t.radius_m[1] = std::nanf(""); }).find("radius_m[1] = nan"), std::string::npos);
  EXPECT_NE(refused([](SphereTree& t) { t.fit[2].core_m = std::nanf(""); }).find("fit[2]"), std::string::npos);
}

TEST(TreeShape, OfATreeAboutItsCentreOfMassIsThatTree) {
  const SphereTree tree = tree_of_spheres(jack_spheres()).value();
  const ShapePtr shape = make_tree_shape(tree).value();
  EXPECT_LT(shape->origin_offset_m.norm(), 1e-8);  // the leaves are floats
  EXPECT_NEAR(shape->volume_m3, make_spheres_shape(jack_spheres()).value()->volume_m3, 1e-7);
}

TEST(MeshShape, OfAnLStandsAboutItsCentreOfMassAndStillCoversIt) {
  const Vec3 shift(40, -30, 20);
  const TriangleMesh mesh = test::moved(geometry::make_procedural_shape("l").value(), 1, Mat3::Identity(), shift);
  const ShapePtr shape = make_mesh_shape(mesh, {.depth = 2, .preset = TreePreset::Fast}).value();
  const Vec3 offset = mesh_mass_properties(mesh).value().center_of_mass_m;
  EXPECT_EQ(shape->origin_offset_m, offset);
  for (const Vec3& p : test::surface_points(mesh, 2000)) {
    EXPECT_EQ(test::levels_covered(shape->tree, p - offset), 3U);
    EXPECT_LE((p - offset).norm(), shape->bounding_radius_m);
  }
  const Mat3 axes = shape->principal_axes.toRotationMatrix();
  const Mat3 inertia = axes * shape->principal_m5.asDiagonal() * axes.transpose();
  const Mat3 expected = mesh_mass_properties(mesh).value().inertia_m5;
  EXPECT_LT((inertia - expected).norm(), 1e-12 * expected.norm());
  EXPECT_NEAR(axes.determinant(), 1, 1e-14);
}

TEST(MeshShape, OfABoxKeepsTheAxesOfTheMesh) {
  const ShapePtr shape = make_mesh_shape(test::box_mesh({3, 1, 2}), {.depth = 1, .preset = TreePreset::Fast}).value();
  EXPECT_EQ(shape->principal_axes.coeffs(), Quat::Identity().coeffs());
  EXPECT_NEAR(shape->principal_m5.x(), 6.0 / 12 * 5, 1e-13);
  EXPECT_NEAR(shape->principal_m5.y(), 6.0 / 12 * 13, 1e-13);
  EXPECT_NEAR(shape->principal_m5.z(), 6.0 / 12 * 10, 1e-13);
}

TEST(MeshShape, OfAnOpenMeshIsSolidWhereItWindsAndSaysSo) {
  TriangleMesh mesh = test::torus_mesh(0.7, 0.2, 24, 12);
  mesh.triangles.pop_back();
  const auto made = make_mesh_shape(mesh, {.depth = 1, .preset = TreePreset::Fast});
  ASSERT_TRUE(made.ok()) << made.error().message;
  const Shape& shape = *made.value();
  EXPECT_NE(shape.note.find("3 edges with one triangle alone"), std::string::npos) << shape.note;
  EXPECT_NEAR(shape.volume_m3, mesh_mass_properties(test::torus_mesh(0.7, 0.2, 24, 12)).value().volume_m3, 0.01);
  for (const Vec3& p : test::surface_points(mesh, 500))
    EXPECT_EQ(test::levels_covered(shape.tree, p - shape.origin_offset_m), 2U);
  for (const Vec3& p : test::inside_points(mesh, 500))
    EXPECT_EQ(test::levels_covered(shape.tree, p - shape.origin_offset_m), 2U);
  EXPECT_EQ(make_mesh_shape(test::torus_mesh(0.7, 0.2, 24, 12), {.depth = 1, .preset = TreePreset::Fast}).value()->note,
            "");
}

TEST(MeshShape, WithAThicknessIsAShell) {
  TriangleMesh sheet;
  sheet.vertices_m = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto made = make_mesh_shape(sheet, {.depth = 2, .preset = TreePreset::Fast}, 0.01);
  ASSERT_TRUE(made.ok()) << made.error().message;
  const Shape& shape = *made.value();
  EXPECT_EQ(shape.note, "");
  EXPECT_NEAR(shape.volume_m3, 0.02, 1e-15);
  EXPECT_GT(shape.principal_m5.minCoeff(), 0);
  for (const Vec3& p : test::surface_points(sheet, 500))
    EXPECT_EQ(test::levels_covered(shape.tree, p - shape.origin_offset_m), 3U);
  // A closed mesh may be a shell too.
  EXPECT_NEAR(
      make_mesh_shape(test::box_mesh(Vec3::Ones()), {.depth = 1, .preset = TreePreset::Fast}, 0.01).value()->volume_m3,
      0.06, 1e-15);
}

TEST(MeshShape, RefusesASheetWithoutAThicknessAndSaysToGiveOne) {
  TriangleMesh sheet;
  sheet.vertices_m = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}};
  sheet.triangles = {{0, 1, 2}};
  const auto refusal = [&](const TriangleMesh& mesh, const TreeBuildOptions& options, double thickness) {
    const auto made = make_mesh_shape(mesh, options, thickness);
    return made.ok() ? std::string("accepted") : made.error().message;
  };
  EXPECT_NE(refusal(sheet, {}, 0).find("3 edges with one triangle alone"), std::string::npos);
  EXPECT_NE(refusal(sheet, {}, 0).find("shell_thickness_m > 0"), std::string::npos);
  sheet.triangles.push_back({0, 2, 1});
  EXPECT_NE(refusal(sheet, {}, 0).find("shell_thickness_m > 0"), std::string::npos);
  EXPECT_NE(refusal(sheet, {}, -1).find("shell_thickness_m = -1, must be > 0"), std::string::npos);
  EXPECT_NE(refusal(sheet, {}, std::nan("")).find("shell_thickness_m = nan, must be > 0"), std::string::npos);
  EXPECT_NE(refusal(test::box_mesh(Vec3::Ones()), {.solidity = Solidity::Shell}, 0).find("must be > 0 for a shell"),
            std::string::npos);
}

TEST(MeshShape, WithATreeThatIsThereAlreadyIsTheSame) {
  const TriangleMesh mesh = geometry::make_procedural_shape("l").value();
  const TreeBuildOptions options{.depth = 1, .preset = TreePreset::Fast};
  const ShapePtr built = make_mesh_shape(mesh, options).value();
  const ShapePtr given = make_mesh_shape_with_tree(mesh, build_sphere_tree(mesh, options).value()).value();
  EXPECT_TRUE(test::same_tree(built->tree, given->tree));
  EXPECT_EQ(built->volume_m3, given->volume_m3);
  EXPECT_EQ(built->bounding_radius_m, given->bounding_radius_m);
  EXPECT_FALSE(make_mesh_shape_with_tree(mesh, {}).ok());
}

}  // namespace
}  // namespace poise
