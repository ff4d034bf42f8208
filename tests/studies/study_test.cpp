// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

const std::string kMeshes = POISE_SOURCE_DIR "/scenes/meshes/";

CommandResult study(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"study", "trees"});
  arguments.insert(arguments.end(), {"--samples", "200", "--threads", "1"});
  return poise_command(arguments);
}

TEST(StudyTrees, MakesARowForEachMeshAndPreset) {
  const TemporaryFolder folder;
  const CommandResult result =
      study({kMeshes + "slab.obj", kMeshes + "l.obj", "--preset", "fast", "--preset", "default", "--depth", "0",
             "--json", folder.file("s.json"), "--csv", folder.file("s.csv"), "--markdown", folder.file("s.md")});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  // Progress is told where it takes long.
  EXPECT_EQ(result.error.find("warning"), std::string::npos) << result.error;
  const json found = json::parse(contents(folder.file("s.json")));
  EXPECT_EQ(found.at("schema"), "poise.trees/1");
  ASSERT_EQ(found.at("rows").size(), 4U);
  EXPECT_EQ(found.at("rows").at(0).at("mesh"), "meshes/slab.obj");
  EXPECT_EQ(found.at("rows").at(1).at("preset"), "default");
  EXPECT_EQ(found.at("rows").at(2).at("triangles"), 20);
  for (const json& row : found.at("rows")) {
    EXPECT_GT(row.at("cpu_s").get<double>(), 0);
    EXPECT_GT(row.at("peak_bytes").get<double>(), 1e6);
    EXPECT_EQ(row.at("levels").at(0).at("surface_coverage"), 1);
  }
  EXPECT_EQ(lines(contents(folder.file("s.csv"))).size(), 1U + 4U);
  EXPECT_EQ(contents(folder.file("s.md")).rfind("| mesh |", 0), 0U);
  EXPECT_NE(result.out.find("meshes/l.obj"), std::string::npos);
}

TEST(StudyTrees, ARefusedMeshIsARowAndOnlyNothingButThemFails) {
  const CommandResult some = study({kMeshes + "slab.obj", "none.obj", "--depth", "0", "--json", "-"});
  EXPECT_EQ(some.exit_code, 0) << some.error;
  const json found = json::parse(some.out, nullptr, false);
  ASSERT_EQ(found.at("rows").size(), 2U);
  EXPECT_EQ(found.at("rows").at(1).at("refused"), "no tree: exit code 3");
  EXPECT_NE(some.error.find("none.obj"), std::string::npos) << "and says why";
  EXPECT_EQ(study({"none.obj"}).exit_code, 3);
}

TEST(StudyTrees, ScalingMakesItsOwnMeshesAndTakesThemAway) {
  const CommandResult result = study({"--scaling", "--most", "4000", "--depth", "0", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json found = json::parse(result.out, nullptr, false);
  EXPECT_EQ(found.at("study"), "scaling");
  ASSERT_EQ(found.at("rows").size(), 2U);
  EXPECT_EQ(found.at("rows").at(0).at("triangles"), 1280);
  EXPECT_EQ(found.at("rows").at(1).at("triangles"), 3380);
  EXPECT_TRUE(found.at("rows").at(0).at("file").is_null());
}

TEST(StudyTrees, WithoutMeshesTakesThoseOfTheDocs) {
  const CommandResult result = study({"--depth", "0", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json found = json::parse(result.out, nullptr, false);
  ASSERT_GE(found.at("rows").size(), 5U);
  EXPECT_EQ(found.at("rows").at(0).at("mesh"), "scenes/meshes/jack.obj");
  for (const json& row : found.at("rows")) EXPECT_FALSE(row.contains("refused")) << row.dump();
}

TEST(StudyTrees, EndsAtASignalWithNothingWritten) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const TemporaryFolder folder;
    const CommandResult result =
        interrupted_on_terminal({"study", "trees", kMeshes + "torus.obj", "--json", folder.file("s.json")}, signal);
    EXPECT_EQ(result.exit_code, 128 + signal) << result.error;
    EXPECT_NE(result.error.find("tree 1 of 1"), std::string::npos) << result.error;
    EXPECT_EQ(folder.entries(), 0U);
  }
}

TEST(StudyTrees, TellsAPathThatCannotBeWrittenBeforeItBuildsAnything) {
  const CommandResult result = study({"none.obj", "--csv", "no/such/folder/s.csv"});
  EXPECT_EQ(result.exit_code, 4) << result.error;
  EXPECT_EQ(result.error, "poise study trees: no/such/folder/s.csv: cannot be written: No such file or directory\n");
}

TEST(StudyTrees, RefusesWhatHasNoMeaning) {
  const TemporaryFolder folder;
  const std::string mesh = folder.file("slab.obj");
  std::filesystem::copy_file(kMeshes + "slab.obj", mesh);
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"--most", "5000"}, "--most needs --scaling"},
      {{"--scaling", kMeshes + "slab.obj"}, "MESH has no meaning with --scaling"},
      {{"--json", "-", "--csv", "-"}, "only one of --json, --markdown and --csv"},
      {{"--json", "a", "--csv", "./a"}, "named for two outputs"},
      {{mesh, "--csv", mesh}, "would overwrite the file that is read as MESH"},
      {{"--preset", "slow"}, "--preset"},
  };
  for (const auto& [arguments, message] : cases) {
    const CommandResult result = study(arguments);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
  }
  EXPECT_EQ(poise_command({"study"}).exit_code, 2);
  EXPECT_EQ(poise_command({"study", "clouds"}).exit_code, 2);
}

}  // namespace
}  // namespace poise::testing
