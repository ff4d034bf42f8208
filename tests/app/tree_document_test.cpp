// SPDX-License-Identifier: MIT
#include "app/tree/tree_document.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace poise::testing {
namespace {

using nlohmann::json;

TreeLevelFigures level(Level number, double surface, double inside) {
  TreeLevelFigures f;
  f.level = number;
  f.spheres = 8;
  f.protrusion_max_m = 0.2;
  f.protrusion_mean_m = 0.1;
  f.surface_coverage = surface;
  f.inside_coverage = inside;
  f.volume_ratio = 1.5;
  return f;
}

io::TreeDocument document() {
  io::TreeDocument d;
  d.mesh = "cow.obj";
  d.triangles = 12;
  d.diagonal_m = 2;
  io::MeasuredTree built;
  built.depth = 1;
  built.preset = TreePreset::Best;
  built.cost = io::TreeBuildCost{1500, 2500, 4096};
  built.nodes = 9;
  built.bytes = 9 * 41;
  built.levels = {level(0, 1, 1), level(1, 1, 1)};
  d.trees = {built};
  return d;
}

TEST(TreeDocument, KeepsTheFiguresOfTheTreeBesideThoseOfTheMesh) {
  const json found = json::parse(io::tree_json(document()));
  EXPECT_EQ(found.at("schema"), "poise.tree/2");
  EXPECT_EQ(found.at("mesh"), "cow.obj");
  EXPECT_EQ(found.at("tree"), "built");
  EXPECT_EQ(found.at("preset"), "best");
  EXPECT_EQ(found.at("build_ms"), 1500);
  EXPECT_EQ(found.at("build_cpu_ms"), 2500);
  EXPECT_EQ(found.at("build_peak_bytes"), 4096);
  EXPECT_EQ(found.at("bytes_per_node"), 41);
  EXPECT_EQ(found.at("leaks"), false);
  EXPECT_EQ(found.at("levels").at(1).at("protrusion_max_of_diagonal"), 0.1);
  EXPECT_EQ(found.at("levels").at(1).at("protrusion_mean_of_diagonal"), 0.05);
  EXPECT_FALSE(found.contains("trees"));
}

TEST(TreeDocument, PutsTwoTreesIntoAListAndLeavesOutWhatAFileCannotKnow) {
  io::TreeDocument d = document();
  io::MeasuredTree foreign;
  foreign.file = "other.sph";
  foreign.nodes = 9;
  foreign.levels = {level(0, 1, 1), level(1, 0.99, 1)};
  d.trees.push_back(foreign);
  const json found = json::parse(io::tree_json(d));
  EXPECT_EQ(found.at("tree"), "built") << "the first tree's figures stay where they are without a comparison";
  ASSERT_EQ(found.at("trees").size(), 2U);
  EXPECT_EQ(found.at("trees").at(0).at("levels"), found.at("levels"));
  EXPECT_EQ(found.at("trees").at(1).at("tree"), "other.sph");
  EXPECT_TRUE(found.at("trees").at(1).at("build_ms").is_null());
  EXPECT_TRUE(found.at("trees").at(1).at("preset").is_null());
  EXPECT_EQ(found.at("trees").at(1).at("leaks"), true);
  EXPECT_EQ(found.at("trees").at(1).at("levels").at(0).at("leaks"), false);
  EXPECT_EQ(found.at("trees").at(1).at("levels").at(1).at("leaks"), true);
}

TEST(TreeDocument, AShellLeaksOnlyThroughItsSurface) {
  EXPECT_FALSE(io::leaks(level(0, 1, 0.5), Solidity::Shell));
  EXPECT_TRUE(io::leaks(level(0, 1, 0.5), Solidity::Solid));
  EXPECT_TRUE(io::leaks(level(0, 0.999999, 1), Solidity::Shell));
  EXPECT_FALSE(io::leaks(level(0, 1, 1), Solidity::Solid));
}

TEST(TreeDocument, CountsTheBytesOfEveryArray) {
  const std::vector<Sphere> one{{Vec3::Zero(), 1.0}};
  const SphereTree tree = tree_of_spheres(one).value();
  // One node and the padding of eight, 53 bytes each, and two entries for its level.
  EXPECT_EQ(io::bytes_of(tree), 9 * 53 + 2 * sizeof(NodeIndex));
}

}  // namespace
}  // namespace poise::testing
