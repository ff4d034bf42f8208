// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/files/scene_files.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

std::string shipped_mesh(const std::string& name) {
  return (app::shipped_scenes().front().parent_path() / "meshes" / name).string();
}

json rest_of(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"study", "rest", "--json", "-", "--quiet"});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return json::parse(result.out);
}

TEST(StudyRest, WhatLiesOnItsFacesRestsAndWhatRocksOnARoundBottomMoves) {
  // One by a path from here.
  const std::string bowl = std::filesystem::relative(shipped_mesh("bowl.obj")).string();
  const json study = rest_of({shipped_mesh("slab.obj"), bowl, "--drops", "1"});
  EXPECT_EQ(study["schema"], "poise.rest/1");
  EXPECT_EQ(study["drops"], 1);
  const json& rows = study["rows"];
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0]["mesh"], "meshes/slab.obj");
  for (const char* way : {"level_1", "level_2", "level_3", "polygons"}) {
    EXPECT_EQ(rows[0][std::string(way) + "_moving"], 0) << way;
    EXPECT_LT(rows[0][std::string(way) + "_fastest_mmps"].get<double>(), 1e-3) << way;
  }
  // Nothing dissipates what a rigid body rocks with on its round bottom.
  EXPECT_EQ(rows[1]["polygons_moving"], 1);
  EXPECT_GT(rows[1]["polygons_fastest_mmps"].get<double>(), 1);
  EXPECT_LT(rows[1]["polygons_fastest_mmps"].get<double>(), 1000);
}

TEST(StudyRest, MeshesAreNamedWhereTheyCannotBeRead) {
  const TemporaryFolder folder;
  const std::string missing = folder.file("missing.obj");
  const CommandResult none = poise_command({"study", "rest", missing, "--quiet"});
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_NE(none.error.find(missing), std::string::npos) << none.error;
  const CommandResult bad = poise_command({"study", "rest", "--drops", "0"});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_NE(bad.error.find("--drops"), std::string::npos) << bad.error;
  const CommandResult both = poise_command({"study", "rest", "--json", "-", "--markdown", "-"});
  EXPECT_EQ(both.exit_code, 2);
}

}  // namespace
}  // namespace poise::testing
