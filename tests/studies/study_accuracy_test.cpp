// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/accuracy_case.h"
#include "accuracy/slope.h"
#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

CommandResult study(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"study", "accuracy"});
  return poise_command(arguments);
}

TEST(StudyAccuracy, RefusesWhatItCannotDo) {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"--only", "teapot"}, "--only: no case has \"teapot\" in its name; --list shows them"},
      {{"--json", "-", "--markdown", "-"}, "only one of --json and --markdown"},
      {{"--picture", "a.jpg"}, "a.jpg"},
      {{"--picture", "-"}, "--picture must be a file"},
      {{"--json", "same", "--markdown", "same"}, "same"},
      {{"--threads", "257"}, "--threads = 257"}};
  for (const auto& [arguments, message] : cases) {
    const CommandResult result = study(arguments);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
  }
}

TEST(StudyAccuracy, ListsEveryCaseOnce) {
  const CommandResult result = study({"--list"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(lines(result.out).size(), accuracy::all_cases().size());
  EXPECT_NE(result.out.find("slope, box on plane"), std::string::npos);
}

// Fast cases; all of them together are run by hand with `poise study accuracy`.
class FastCase : public ::testing::TestWithParam<const char*> {};

TEST_P(FastCase, IsWithinItsBounds) {
  const CommandResult result = study({"--only", GetParam(), "--json", "-"});
  const json found = json::parse(result.out, nullptr, false);
  ASSERT_FALSE(found.is_discarded()) << result.error;
  EXPECT_EQ(found.at("schema"), "poise.accuracy/1");
  EXPECT_FALSE(found.at("rows").empty());
  for (const json& row : found.at("rows")) {
    EXPECT_NE(std::string(row.at("case")).find(GetParam()), std::string::npos);
    EXPECT_TRUE(row.at("ok")) << row.dump();
    if (row.at("at_most").is_number()) {
      EXPECT_LE(row.at("value"), row.at("at_most")) << row.dump();
    }
  }
  EXPECT_EQ(result.exit_code, 0);
}

INSTANTIATE_TEST_SUITE_P(OfTheStudy, FastCase,
                         ::testing::Values("two spheres", "free flight", "spinning top", "dropped ball", "five balls",
                                           "sliding box", "slope, balls on plane", "rolling ball", "skidding ball",
                                           "bouncing 7 x 7", "400 : 1", "bad states", "spinning rings",
                                           "momenta of a cloud"));

TEST(StudyAccuracy, FiguresDoNotDependOnThreads) {
  const auto rows = [](const char* threads) {
    const CommandResult result =
        study({"--only", "five balls", "--only", "rings", "--threads", threads, "--json", "-"});
    return json::parse(result.out, nullptr, false).at("rows");
  };
  EXPECT_EQ(rows("1"), rows("2"));
}

TEST(StudyAccuracy, WritesTablesAndDrawsWhatStands) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = {"--only", "stack of 5", "--markdown", folder.file("a.md")};
  const bool gnuplot = std::filesystem::exists("/usr/bin/gnuplot");
  if (gnuplot) arguments.insert(arguments.end(), {"--picture", folder.file("a.png")});
  const CommandResult result = study(arguments);
  EXPECT_LE(result.exit_code, 1) << result.error;
  EXPECT_NE(contents(folder.file("a.md")).find("| stack of 5 spheres |"), std::string::npos);
  EXPECT_NE(result.out.find("stack of 5 spheres"), std::string::npos);
  if (gnuplot) {
    EXPECT_EQ(contents(folder.file("a.png")).substr(0, 4), "\x89PNG");
  }
  const CommandResult nothing = study({"--only", "five balls", "--picture", folder.file("b.png")});
  EXPECT_EQ(nothing.exit_code, 3);
  EXPECT_NE(nothing.error.find("--picture: none of the chosen cases"), std::string::npos) << nothing.error;
}

TEST(StudyAccuracy, EndsAtCtrlCWithNothingWritten) {
  const TemporaryFolder folder;
  const CommandResult result =
      interrupted_on_terminal({"study", "accuracy", "--only", "million", "--json", folder.file("s.json")});
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_FALSE(std::filesystem::exists(folder.file("s.json")));
}

TEST(AccuracyRow, IsOkWithinItsBoundAndNeverWithoutANumber) {
  EXPECT_TRUE((accuracy::Row{"", "", "", 1, 1, ""}.ok()));
  EXPECT_FALSE((accuracy::Row{"", "", "", 1.001, 1, ""}.ok()));
  EXPECT_TRUE((accuracy::Row{"", "", "", 1e9, {}, ""}.ok()));
  EXPECT_FALSE((accuracy::Row{"", "", "", std::nan(""), {}, ""}.ok()));
  EXPECT_FALSE((accuracy::Row{"", "", "", HUGE_VAL, {}, ""}.ok()));
}

TEST(AccuracyPattern, StarsStandForAnythingInOrder) {
  EXPECT_TRUE(accuracy::matches("hard: mass ratio", ""));
  EXPECT_TRUE(accuracy::matches("hard: mass ratio", "mass"));
  EXPECT_TRUE(accuracy::matches("hard: mass ratio", "hard*ratio"));
  EXPECT_FALSE(accuracy::matches("hard: mass ratio", "ratio*hard"));
  EXPECT_FALSE(accuracy::matches("hard: mass ratio", "ratios"));
}

TEST(AccuracyThreshold, IsFoundByHalving) {
  EXPECT_NEAR(accuracy::begins_at(0, 4, 10, [](double x) { return x > 1.3; }), 1.3, 4.0 / 1024);
  EXPECT_EQ(accuracy::begins_at(0, 4, 10, [](double) { return true; }), 0);
  EXPECT_EQ(accuracy::begins_at(0, 4, 10, [](double) { return false; }), 4);
}

TEST(AccuracyMeshes, AreWhatTheToolMakes) {
  std::size_t meshes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(POISE_SOURCE_DIR "/scenes/accuracy/meshes")) {
    const std::string shipped = contents(entry.path().string());
    const std::string marker = "# made by: poise ";
    ASSERT_EQ(shipped.rfind(marker, 0), 0U) << entry.path();
    std::vector<std::string> arguments;
    std::string word;
    for (const char c : shipped.substr(marker.size(), shipped.find('\n') - marker.size()) + " ") {
      if (c != ' ') {
        word += c;
      } else {
        arguments.push_back(std::exchange(word, ""));
      }
    }
    arguments.insert(arguments.end(), {"-o", "-"});
    const CommandResult made = poise_command(arguments);
    EXPECT_EQ(made.exit_code, 0) << made.error;
    EXPECT_EQ(made.out, shipped) << entry.path();
    ++meshes;
  }
  EXPECT_EQ(meshes, 7U);
}

TEST(ShapeCommand, RefusesOptionsOfOtherShapes) {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"box"}, "box needs --size X,Y,Z"},
      {{"box", "--size", "1,0,1"}, "size = 0, must be from"},
      {{"cube", "--size", "1,1,1"}, "--size has no meaning but with box"},
      {{"wedge", "--inner", "1"}, "wedge needs --inner, --outer, --angle and --depth"},
      {{"jack", "--angle", "5"}, "have no meaning but with wedge"},
      {{"box", "--size", "1,1,1", "--fineness", "2"}, "--fineness has no meaning"}};
  for (const auto& [given, message] : cases) {
    std::vector<std::string> arguments = {"shape"};
    arguments.insert(arguments.end(), given.begin(), given.end());
    arguments.insert(arguments.end(), {"-o", "-"});
    const CommandResult result = poise_command(arguments);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
  }
}

}  // namespace
}  // namespace poise::testing
