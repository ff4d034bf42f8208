// SPDX-License-Identifier: MIT
#include "studies/trees_document.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

io::TreeDocument one_tree() {
  io::TreeDocument d;
  d.mesh = "models/cow.obj";
  d.triangles = 5856;
  d.diagonal_m = 4;
  io::MeasuredTree tree;
  tree.depth = 1;
  tree.preset = TreePreset::Fast;
  tree.cost = io::TreeBuildCost{1250, 2500, std::uint64_t{3} << 20U};
  tree.nodes = 9;
  TreeLevelFigures level;
  level.spheres = 1;
  level.protrusion_max_m = 1;
  level.protrusion_mean_m = 0.5;
  level.surface_coverage = 1;
  level.inside_coverage = 1;
  level.volume_ratio = 6;
  tree.levels.push_back(level);
  level.level = 1;
  level.spheres = 8;
  level.protrusion_max_m = 0.4;
  level.protrusion_mean_m = 0.2;
  level.inside_coverage = 0.9999;
  level.volume_ratio = 2.25;
  tree.levels.push_back(level);
  d.trees = {tree};
  return d;
}

io::TreesDocument trees_study() {
  io::TreesDocument d;
  d.study = "meshes";
  io::TreesRow row = io::row_of_tree_json(io::tree_json(one_tree())).value();
  row.mesh = "a \"cow\"";
  io::TreesRow refused;
  refused.mesh = "none.obj";
  refused.refusal = "no tree: exit code 3";
  d.rows = {row, refused};
  return d;
}

TEST(TreesDocument, ReadsARowFromWhatPoiseTreeWrites) {
  const Result<io::TreesRow> row = io::row_of_tree_json(io::tree_json(one_tree()));
  ASSERT_TRUE(row) << row.error().message;
  EXPECT_EQ(row.value().file, "models/cow.obj");
  EXPECT_EQ(row.value().triangles, 5856U);
  EXPECT_EQ(row.value().tree.preset, TreePreset::Fast);
  EXPECT_EQ(row.value().tree.cost->cpu_ms, 2500);
  EXPECT_EQ(row.value().tree.cost->peak_bytes, std::uint64_t{3} << 20U);
  ASSERT_EQ(row.value().tree.levels.size(), 2U);
  EXPECT_EQ(row.value().tree.levels[1].protrusion_mean_m, 0.2);
  for (const char* bad : {"", "[]", "{}", R"({"schema": "poise.run/2"})", R"({"schema": "poise.tree/2", "mesh": 3})"}) {
    EXPECT_FALSE(io::row_of_tree_json(bad)) << bad;
  }
}

TEST(TreesDocument, WritesTheSameFiguresAsJsonMarkdownTableAndCsv) {
  const json found = json::parse(io::trees_json(trees_study()));
  EXPECT_EQ(found.at("schema"), "poise.trees/1");
  EXPECT_EQ(found.at("rows").at(0).at("cpu_s"), 2.5);
  EXPECT_EQ(found.at("rows").at(0).at("levels").at(1).at("protrusion_max_of_diagonal"), 0.1);
  EXPECT_EQ(found.at("rows").at(1).at("refused"), "no tree: exit code 3");

  const std::vector<std::string> markdown = lines(io::trees_markdown(trees_study()));
  EXPECT_EQ(markdown[0], "| mesh | triangles | preset | CPU s | MiB | nodes | level 1 | covered % |");
  EXPECT_EQ(markdown[1], "|---|---|---|---|---|---|---|---|");
  EXPECT_EQ(markdown[2], "| a \"cow\" | 5856 | fast | 2.50 | 3 | 9 | 10.00 / 5.00 / 2.250 | 99.9900 |");

  const std::string table = io::trees_table(trees_study());
  EXPECT_NE(table.find("10.00 / 5.00 / 2.250"), std::string::npos) << table;
  EXPECT_NE(table.find("none.obj  no tree: exit code 3"), std::string::npos) << table;

  const std::vector<std::string> csv = lines(io::trees_csv(trees_study()));
  ASSERT_EQ(csv.size(), 3U) << "a line a level; a refused mesh has none";
  EXPECT_EQ(csv[2], "\"a \"\"cow\"\"\",5856,fast,1,2.5,1.25,3145728,9,1,8,10,5,2.25,1,0.9999");
  EXPECT_EQ(std::ranges::count(csv[0], ','), 14);
}

TEST(TreesDocument, AStudyOfRefusedMeshesAloneIsATableToo) {
  io::TreesDocument d = trees_study();
  d.rows.erase(d.rows.begin());
  EXPECT_NE(io::trees_table(d).find("none.obj  no tree"), std::string::npos) << io::trees_table(d);
  EXPECT_EQ(lines(io::trees_csv(d)).size(), 1U);
}

}  // namespace
}  // namespace poise::testing
