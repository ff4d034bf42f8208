// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <stop_token>

#include "meshes.h"

namespace poise {
namespace {

SphereTree tree_of(const TriangleMesh& mesh, int depth) {
  return build_sphere_tree(mesh, {.depth = static_cast<Level>(depth), .preset = TreePreset::Fast}).value();
}

TriangleMesh shape_mesh(const char* kind) { return geometry::make_procedural_shape(kind).value(); }

/// A unit cube without its top and one side.
TriangleMesh open_box() {
  TriangleMesh mesh = test::box_mesh(Vec3::Ones());
  std::erase_if(mesh.triangles, [&](const auto& t) {
    const auto all_of_it = [&](int axis) {
      return std::ranges::all_of(t, [&](std::uint32_t v) { return mesh.vertices_m[v][axis] > 0; });
    };
    return all_of_it(0) || all_of_it(2);
  });
  return mesh;
}

TEST(MeasureTree, SeesAHoleInTheCoverage) {
  const TriangleMesh mesh = shape_mesh("slab");
  SphereTree tree = tree_of(mesh, 1);
  const auto whole = measure_tree_quality(tree, mesh, {.samples = 3000}).value();
  EXPECT_EQ(whole[1].surface_coverage, 1);
  EXPECT_EQ(whole[1].inside_coverage, 1);
  tree.radius_m[1] *= 0.5F;
  const auto holed = measure_tree_quality(tree, mesh, {.samples = 3000}).value();
  EXPECT_EQ(holed[0].surface_coverage, 1);
  EXPECT_LT(holed[1].surface_coverage, 1);
  EXPECT_LT(holed[1].inside_coverage, 1);
}

TEST(MeasureTree, VolumeAndProtrusionOfTheBallAroundACubeAreTheirClosedForms) {
  const TriangleMesh mesh = test::box_mesh({2, 2, 2});
  const auto figures = measure_tree_quality(tree_of(mesh, 0), mesh, {.samples = 50000}).value();
  EXPECT_NEAR(figures[0].volume_ratio, 4.0 / 3 * std::numbers::pi * std::pow(3.0, 1.5) / 8, 1e-5);
  EXPECT_NEAR(figures[0].protrusion_max_m, std::sqrt(3.0) - 1, 1e-3);
  EXPECT_GE(figures[0].protrusion_bound_max_m, std::sqrt(3.0) - 1);
  EXPECT_EQ(figures[0].spheres, 1U);
}

TEST(MeasureTree, TheVolumeOfTwoOverlappingBallsCountsTheLensOnce) {
  // Unit balls whose centres are 1 apart share a lens of volume 5/12 pi; the mesh gives only the unit of length.
  const std::vector<Sphere> two{{{-0.5, 0, 0}, 1}, {{0.5, 0, 0}, 1}};
  const SphereTree tree = tree_of_spheres(two).value();
  const auto figures = measure_tree_quality(tree, test::box_mesh(Vec3::Ones()), {.samples = 200000}).value();
  EXPECT_NEAR(figures[1].volume_ratio, (8.0 / 3 - 5.0 / 12) * std::numbers::pi, 0.02);
}

TEST(MeasureTree, TheBoundIsTheLargestThatTheLevelStores) {
  const TriangleMesh mesh = shape_mesh("l");
  const SphereTree tree = tree_of(mesh, 2);
  const auto figures = measure_tree_quality(tree, mesh, {.samples = 20000}).value();
  for (const TreeLevelFigures& f : figures) {
    double largest = 0;
    for (const NodeIndex node : tree.nodes_at(f.level))
      largest = std::max(largest, static_cast<double>(tree.protrusion_max_m[node]));
    EXPECT_EQ(f.protrusion_bound_max_m, largest);
    EXPECT_GE(f.protrusion_bound_max_m, f.protrusion_max_m) << int{f.level};
  }
}

TEST(MeasureTree, FiguresAreTheSameOnAnyNumberOfThreads) {
  const TriangleMesh mesh = shape_mesh("jack");
  const SphereTree tree = tree_of(mesh, 1);
  const auto one = measure_tree_quality(tree, mesh, {.samples = 10001, .seed = 4, .threads = 1}).value();
  for (const int threads : {2, 3, 8}) {
    const auto many = measure_tree_quality(tree, mesh, {.samples = 10001, .seed = 4, .threads = threads}).value();
    for (std::size_t level = 0; level < one.size(); ++level) {
      EXPECT_EQ(one[level].protrusion_max_m, many[level].protrusion_max_m);
      EXPECT_EQ(one[level].protrusion_mean_m, many[level].protrusion_mean_m);
      EXPECT_EQ(one[level].volume_ratio, many[level].volume_ratio);
      EXPECT_EQ(one[level].surface_coverage, many[level].surface_coverage);
    }
  }
  EXPECT_NE(measure_tree_quality(tree, mesh, {.samples = 10001, .seed = 5}).value()[1].protrusion_mean_m,
            one[1].protrusion_mean_m);
}

TEST(MeasureTree, AnOpenBoxHasTheVolumeThatItWindsAround) {
  const TriangleMesh mesh = open_box();
  const SphereTree tree = tree_of_spheres(std::vector<Sphere>{{Vec3::Zero(), 1}}).value();
  const auto figures = measure_tree_quality(tree, mesh, {.samples = 20000}).value();
  // Counted by the slow winding number on a grid.
  std::size_t inside = 0;
  for (int x = 0; x < 30; ++x) {
    for (int y = 0; y < 30; ++y) {
      for (int z = 0; z < 30; ++z)
        inside += test::slow_winding(mesh, Vec3(x - 14.5, y - 14.5, z - 14.5) / 30) > 0.5 ? 1U : 0U;
    }
  }
  const double volume = static_cast<double>(inside) / 27000;
  EXPECT_GT(volume, 0.5);
  EXPECT_LT(volume, 0.99);
  EXPECT_NEAR(figures[0].volume_ratio, 4.0 / 3 * std::numbers::pi / volume, 0.2);
  EXPECT_EQ(figures[0].inside_coverage, 1);
}

TEST(MeasureTree, AShellHasNoVolumeAndNoInsideToMiss) {
  const TriangleMesh mesh = test::box_mesh({2, 2, 2});
  const SphereTree tree = tree_of_spheres(std::vector<Sphere>{{Vec3::Zero(), 0.5}}).value();
  const auto shell = measure_tree_quality(tree, mesh, {.samples = 2000, .solidity = Solidity::Shell}).value();
  EXPECT_EQ(shell[0].volume_ratio, 0);
  EXPECT_EQ(shell[0].inside_coverage, 1);
  EXPECT_EQ(shell[0].surface_coverage, 0);
  // The small ball is inside the hollow; its distance from the nearest wall is between half a metre and 1 - 0.5 /
  // sqrt(3).
  EXPECT_NEAR(shell[0].protrusion_max_m, 1 - 0.5 / std::sqrt(3.0), 0.01);
  const auto solid = measure_tree_quality(tree, mesh, {.samples = 2000}).value();
  EXPECT_EQ(solid[0].protrusion_max_m, 0);
}

TEST(MeasureTree, AFlatSheetGivesNumbersThatAreNumbers) {
  TriangleMesh sheet;
  sheet.vertices_m = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), {1, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {1, 3, 2}};
  const SphereTree tree = tree_of_spheres(std::vector<Sphere>{{{0.5, 0.5, 0}, 1}}).value();
  const auto figures = measure_tree_quality(tree, sheet, {.samples = 500}).value();
  EXPECT_EQ(figures[0].volume_ratio, 0);
  EXPECT_EQ(figures[0].surface_coverage, 1);
  EXPECT_NEAR(figures[0].protrusion_max_m, 1, 0.05);
}

TEST(MeasureTree, EndsWhenAskedHoweverManySamplesAreLeft) {
  const TriangleMesh mesh = test::box_mesh(Vec3::Ones());
  const SphereTree tree = tree_of(mesh, 1);
  std::stop_source stop;
  stop.request_stop();
  // These samples would take minutes.
  const auto measured = measure_tree_quality(tree, mesh, {.samples = 100000000, .stop = stop.get_token()});
  ASSERT_FALSE(measured);
  EXPECT_EQ(measured.error().kind, ErrorKind::Cancelled);
}

TEST(MeasureTree, RefusesWhatItCannotJudge) {
  TriangleMesh mesh = test::box_mesh(Vec3::Ones());
  const SphereTree tree = tree_of(mesh, 0);
  const auto why = [&](const TreeQualityOptions& options) {
    return measure_tree_quality(tree, mesh, options).error().message;
  };
  EXPECT_NE(measure_tree_quality({}, mesh, {}).error().message.find("there is no node"), std::string::npos);
  EXPECT_NE(why({.samples = 0}).find("samples = 0, must be from 1"), std::string::npos);
  EXPECT_NE(why({.threads = 257}).find("threads = 257, must be from 0 to 256"), std::string::npos);
  EXPECT_NE(measure_tree_quality(tree, {}, {}).error().message.find("there is no triangle"), std::string::npos);
  mesh.triangles[3][1] = 8;
  EXPECT_NE(why({}).find("triangle 3 names vertex 8, must be below 8"), std::string::npos);
  mesh = test::box_mesh(Vec3::Ones());
  mesh.vertices_m[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(why({}).find("vertex 2"), std::string::npos);
}

}  // namespace
}  // namespace poise
