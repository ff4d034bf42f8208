// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/scene_text.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

TEST(CheckCommand, TellsWhatASceneNeeds) {
  const CommandResult result = poise_command({"check", "two-body"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "");
  for (const char* part : {"two-body: sound, 2 bodies", "memory", "trees", "deadline"})
    EXPECT_NE(result.out.find(part), std::string::npos) << result.out;
}

TEST(CheckCommand, TellsAllErrorsAtOnceAsRunDoes) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("s.json")) << scene_text(R"("frams": 3, "alpha": 7, )",
                                                     R"([{"shape": "bal", "material": 3}])");
  for (const char* command : {"check", "run"}) {
    const CommandResult result = poise_command({command, folder.file("s.json")});
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_EQ(result.out, "");
    for (const char* part : {"frams: no such field; did you mean \"frames\"?", "alpha = 7, must be <= 0.5",
                             "bodies[0].shape = \"bal\"", "bodies[0].material = 3"})
      EXPECT_NE(result.error.find(part), std::string::npos) << result.error;
  }
  const CommandResult result = poise_command({"check", folder.file("s.json"), "--json", "-"});
  EXPECT_EQ(result.exit_code, 3);
  const json document = json::parse(result.out, nullptr, false);
  EXPECT_EQ(document.at("schema"), "poise.check/1");
  EXPECT_EQ(document.at("sound"), false);
  EXPECT_EQ(document.at("errors").size(), 4U);
  EXPECT_TRUE(document.at("needs").is_null());
  EXPECT_TRUE(document.at("scene_hash").is_null());
  EXPECT_TRUE(document.at("generators").is_null());
}

TEST(CheckCommand, TellsScenesApartAndWhetherTheyHaveGenerators) {
  const auto checked = [](const char* scene) {
    return json::parse(poise_command({"check", scene, "--json", "-", "--quiet"}).out, nullptr, false);
  };
  const json two = checked("two-body"), jacks = checked("jacks");
  EXPECT_EQ(two.at("generators"), 0);
  EXPECT_GT(jacks.at("generators"), 0);
  EXPECT_EQ(two.at("scene_hash").get<std::string>().size(), 32U);
  EXPECT_NE(two.at("scene_hash"), jacks.at("scene_hash"));
}

TEST(CheckCommand, EndsWithOneForWarningsWhereItIsStrict) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("s.json")) << scene_text(
      "", R"([{"shape": "ball", "material": "hard"}, {"shape": "ball", "material": "hard"}])");
  const CommandResult mild = poise_command({"check", folder.file("s.json")});
  EXPECT_EQ(mild.exit_code, 0);
  EXPECT_NE(mild.out.find("start deep in one another: a pair"), std::string::npos) << mild.out;
  EXPECT_EQ(poise_command({"check", folder.file("s.json"), "--strict", "--quiet"}).exit_code, 1);
  EXPECT_EQ(poise_command({"check", "two-body", "--strict"}).exit_code, 0);
  const json document = json::parse(poise_command({"check", folder.file("s.json"), "--json", "-"}).out, nullptr, false);
  EXPECT_EQ(document.at("warnings").size(), 1U);
  EXPECT_EQ(document.at("needs").at("dynamic_bodies"), 2);
}

TEST(StandardInput, IsReadAsASceneWhoseFilesAreRelativeToTheCurrentFolder) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("s.json")) << scene_text("\"frames\": 2, ");
  for (const char* command : {"check", "run"}) {
    const CommandResult result = poise_command_reading(folder.file("s.json"), {command, "-"});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    EXPECT_NE(result.out.find("test"), std::string::npos) << result.out;
  }
  std::ofstream(folder.file("bad.json")) << scene_text("\"frames\": 0, ");
  const CommandResult bad = poise_command_reading(folder.file("bad.json"), {"run", "-"});
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_NE(bad.error.find("standard input: frames = 0"), std::string::npos) << bad.error;
}

TEST(SceneFile, ThatIsAPipeIsRefusedInsteadOfWaitingForIt) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo(folder.file("pipe.json").c_str(), 0600), 0);
  for (const char* command : {"check", "run"}) {
    const CommandResult result = poise_command({command, folder.file("pipe.json")});
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(result.error.find("is a pipe or a device"), std::string::npos) << result.error;
  }
}

TEST(Threads, MoreThanProcessorsAreWarnedOf) {
  const CommandResult result = poise_command({"run", "two-body", "--frames", "2", "--threads", "256"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.error.find("warning: 256 threads on "), std::string::npos) << result.error;
  EXPECT_EQ(poise_command({"run", "two-body", "--frames", "2", "--threads", "1"}).error, "");
}

}  // namespace
}  // namespace poise::testing
