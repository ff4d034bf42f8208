// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

const std::string kMeshes = POISE_SOURCE_DIR "/scenes/meshes/";

CommandResult study(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"study", "levels"});
  return poise_command(arguments);
}

TEST(StudyLevels, RefusesWhatItCannotStudy) {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"--pairs", "jack"}, "--pairs: \"jack\", must be two names with a comma between them"},
      {{"--pairs", "jack,gear"}, "--pairs: \"gear\" is no file and none of jack, torus, slab, l, bowl, cube, disc"},
      {{"--models", "wrench,magic"}, "--models: \"magic\", must be of paper, wrench, fitted"},
      {{"--models", "paper,paper"}, "--models: paper is named twice"},
      {{"--levels", "0,5"}, "--levels: \"5\", must be polygons or from 0 to 4, the depth of the trees"},
      {{"--levels", "2,1"}, "--levels: must ascend"},
      {{"--levels", "polygons,1"}, "--levels: nothing comes after polygons"},
      {{"--half", "third"}, "--half"},
      {{"--touches", "0"}, "--touches = 0"},
      {{"--pairs", "l,l", kMeshes + "l.obj"}, "MESH has no meaning with --pairs"},
      {{"--json", "-", "--csv", "-"}, "only one of --json, --markdown and --csv"},
      {{"--picture", "a.jpg"}, "a.jpg"},
      {{"--json", "same", "--csv", "same"}, "same"}};
  for (const auto& [arguments, message] : cases) {
    const CommandResult result = study(arguments);
    EXPECT_EQ(result.exit_code, 2) << message;
#ifdef POISE_HAVE_ORACLE
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
#endif
  }
}

#ifdef POISE_HAVE_ORACLE

const std::vector<std::string> kSmall = {"--pairs",   "slab,cube", "--depth",  "2",
                                         "--touches", "6",         "--levels", "1,2,polygons"};

std::vector<std::string> small(const std::vector<std::string>& more) {
  std::vector<std::string> arguments = kSmall;
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(StudyLevels, MakesARowForEachPairModelAndLevel) {
  const TemporaryFolder folder;
  const CommandResult result =
      study(small({"--json", folder.file("s.json"), "--csv", folder.file("s.csv"), "--markdown", folder.file("s.md")}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error.find("warning"), std::string::npos) << "nothing but progress: " << result.error;
  const json found = json::parse(contents(folder.file("s.json")));
  EXPECT_EQ(found.at("schema"), "poise.levels/2");
  ASSERT_EQ(found.at("rows").size(), 3U * 3U);
  for (const json& row : found.at("rows")) {
    EXPECT_EQ(row.at("touches"), 6);
    if (row.at("level") == "polygons") {
      EXPECT_LT(row.at("dv_mean"), 0.03) << "the very features that the oracle finds";
    } else {
      EXPECT_GT(row.at("dv_mean"), 0.001);
    }
    EXPECT_LT(row.at("dv_mean"), 2);
    EXPECT_LE(row.at("dv_median"), row.at("dv_p90"));
    EXPECT_EQ(row.at("unseen_share"), 0) << "a tree covers its mesh";
    EXPECT_GT(row.at("ns_per_pair"), 0);
    EXPECT_GT(row.at("oracle_uncertainty"), 0);
    EXPECT_LT(row.at("oracle_uncertainty"), 0.2);
  }
  EXPECT_EQ(lines(contents(folder.file("s.csv"))).size(), 1U + found.at("rows").size());
  EXPECT_NE(contents(folder.file("s.md")).find("| slab cube | flat | wrench |"), std::string::npos);
  EXPECT_NE(result.out.find("slab cube"), std::string::npos);
}

json without_costs(json document) {
  for (const char* part : {"rows", "summary"}) {
    for (json& row : document.at(part)) {
      for (const char* cost : {"ns_per_pair", "overlap_ns_per_pair", "response_ns_per_pair"}) row.erase(cost);
    }
  }
  document.erase("threads");
  return document;
}

TEST(StudyLevels, FiguresDependOnSeedAndHalfAndNotOnThreads) {
  const auto figures = [](const std::vector<std::string>& more) {
    const CommandResult result = study(small(more));
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return without_costs(json::parse(result.out, nullptr, false));
  };
  const json one = figures({"--models", "wrench", "--threads", "1", "--json", "-"});
  EXPECT_EQ(one, figures({"--models", "wrench", "--threads", "2", "--json", "-"}));
  EXPECT_NE(one.at("rows"), figures({"--models", "wrench", "--half", "tune", "--json", "-"}).at("rows"));
  EXPECT_NE(one.at("rows"), figures({"--models", "wrench", "--seed", "2", "--json", "-"}).at("rows"));
}

TEST(StudyLevels, TakesMeshesAndDrawsThem) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = {kMeshes + "slab.obj",
                                        kMeshes + "l.obj",
                                        "--depth",
                                        "1",
                                        "--touches",
                                        "3",
                                        "--levels",
                                        "1",
                                        "--models",
                                        "wrench",
                                        "--json",
                                        folder.file("s.json")};
  const bool gnuplot = std::filesystem::exists("/usr/bin/gnuplot");
  if (gnuplot) arguments.insert(arguments.end(), {"--picture", folder.file("s.png")});
  const CommandResult result = study(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json found = json::parse(contents(folder.file("s.json")));
  ASSERT_EQ(found.at("pairs").size(), 3U);
  EXPECT_EQ(found.at("pairs").at(1).at("shape_b"), "l");
  EXPECT_EQ(found.at("pairs").at(0).at("group"), "other");
  if (gnuplot) {
    EXPECT_EQ(contents(folder.file("s.png")).substr(0, 4), "\x89PNG");
  }
}

TEST(StudyLevels, RefusesAMeshThatHasNoInside) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("open.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";
  const CommandResult result = study({folder.file("open.obj"), "--depth", "1"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.error.find("open.obj"), std::string::npos) << result.error;
  EXPECT_EQ(study({"none.obj"}).exit_code, 3);
}

TEST(StudyLevels, EndsAtCtrlCWithNothingWritten) {
  const TemporaryFolder folder;
  const CommandResult result = interrupted_on_terminal({"study", "levels", "--pairs", "slab,slab;cube,cube", "--depth",
                                                        "1", "--touches", "100000", "--json", folder.file("s.json")});
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_FALSE(std::filesystem::exists(folder.file("s.json")));
}

#else

TEST(StudyLevels, SaysThatItsJudgeIsMissing) {
  const CommandResult result = study({});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.error.find("libfcl-dev"), std::string::npos) << result.error;
}

#endif

}  // namespace
}  // namespace poise::testing
