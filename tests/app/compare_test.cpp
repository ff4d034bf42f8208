// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

std::vector<std::string> compare(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"compare", "jacks",   "--bodies", "40",       "--frames",
                                     "3",       "--every", "10",       "--warmup", "40"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

json compared(const std::vector<std::string>& more) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = compare(more);
  arguments.insert(arguments.end(), {"--quiet", "--json", folder.file("compare.json")});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.out, "");
  return json::parse(contents(folder.file("compare.json")), nullptr, false);
}

TEST(Compare, WritesAllThatItFound) {
  const TemporaryFolder folder;
  const CommandResult result =
      poise_command(compare({"--policies", "perceptual,fifo,oracle", "--budgets", "0%,30%,100%", "--csv",
                             folder.file("c.csv"), "--svg", folder.file("c.svg"), "--json", folder.file("c.json")}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json report = json::parse(contents(folder.file("c.json")));
  ASSERT_EQ(report.at("rows").size(), 9U);
  EXPECT_EQ(report.at("budget_unit"), "percent");
  EXPECT_NE(result.out.find(report.at("conclusion").get<std::string>()), std::string::npos);
  const std::string svg = contents(folder.file("c.svg"));
  for (const char* part : {">oracle</text>", " frames: E_seen, m/s</text>", "<polyline", "prefers-color-scheme: dark"})
    EXPECT_NE(svg.find(part), std::string::npos) << part;
  EXPECT_TRUE(contents(folder.file("c.csv")).starts_with("scene,policy,budget,"));
  for (const json& row : report.at("rows")) {
    if (row.at("budget") == 0) {
      EXPECT_EQ(row.at("work_units"), 0);
      EXPECT_EQ(row.at("E"), report.at("rows")[0].at("E")) << "without a budget no policy decides anything";
    }
    if (row.at("budget") == 100) {
      EXPECT_NEAR(row.at("E").get<double>(), report.at("rows")[2].at("E").get<double>(), 1e-9) << "all is refined";
      EXPECT_LT(row.at("E"), report.at("rows")[0].at("E"));
    }
  }
}

TEST(Compare, GivesTheSameOnAnyNumberOfThreads) {
  const json one = compared({"--threads", "1", "--budgets", "20,100"});
  const json two = compared({"--threads", "2", "--budgets", "20,100"});
  ASSERT_EQ(one.at("rows").size(), 8U);
  for (std::size_t i = 0; i < one.at("rows").size(); ++i) EXPECT_EQ(one["rows"][i]["E_seen"], two["rows"][i]["E_seen"]);
  EXPECT_EQ(one.at("conclusion"), two.at("conclusion"));
}

// The states are those of the base run, whatever was stepped from the states before.
TEST(Compare, TakesTheSameStatesWhateverPoliciesTakePart) {
  const json few = compared({"--policies", "fifo", "--budgets", "50"});
  const json many = compared({"--policies", "oracle,random,fifo", "--budgets", "0,50,500"});
  EXPECT_EQ(few["rows"][0]["E_seen"], many["rows"][7]["E_seen"]);
  EXPECT_EQ(few["rows"][0]["policy"], many["rows"][7]["policy"]);
}

TEST(Compare, WithAHistoryEachPolicyIsMeasuredByAReferenceOfItsOwn) {
  const json once = compared({"--policies", "fifo", "--budgets", "0,100000"});
  const json after = compared({"--policies", "fifo", "--budgets", "0,100000", "--history", "5"});
  EXPECT_EQ(after.at("history"), 5);
  EXPECT_NE(once["rows"][0]["E_seen"], after["rows"][0]["E_seen"]);
  EXPECT_LT(after["rows"][1]["E_seen"], after["rows"][0]["E_seen"]);
}

TEST(Compare, TakesBudgetsOfTime) {
  const json report = compared({"--clock", "wall", "--budgets", "0.5,40", "--policies", "perceptual"});
  ASSERT_EQ(report.at("rows").size(), 2U);
  EXPECT_EQ(report["rows"][0]["budget_unit"], "ms");
  EXPECT_EQ(report["rows"][1]["budget"], 40);
}

TEST(Compare, TakesPolicyFilesByTheirNames) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("mine.json"))
      << R"({"schema": "poise.policy/1", "name": "mine", "policy": {"kind": "fifo"}})";
  const json report = compared({"--policies", "fifo," + folder.file("mine.json"), "--budgets", "60"});
  ASSERT_EQ(report.at("rows").size(), 2U);
  EXPECT_EQ(report["rows"][1]["policy"], "mine");
  EXPECT_EQ(report["rows"][1]["E_seen"], report["rows"][0]["E_seen"]);
  std::ofstream(folder.file("same.json")) << R"({"schema": "poise.policy/1", "name": "fifo", "policy": {}})";
  const CommandResult same = poise_command(compare({"--policies", "fifo," + folder.file("same.json")}));
  EXPECT_EQ(same.exit_code, 3);
  EXPECT_NE(same.error.find("name = \"fifo\", is that of another policy"), std::string::npos) << same.error;
  EXPECT_EQ(poise_command(compare({"--policies", folder.file("none.json")})).exit_code, 3);
  std::ofstream(folder.file("oracle.json")) << R"({"schema": "poise.policy/1", "name": "oracle", "policy": {}})";
  const CommandResult oracle = poise_command(compare({"--policies", "fifo," + folder.file("oracle.json")}));
  EXPECT_EQ(oracle.exit_code, 3);
  EXPECT_NE(oracle.error.find("name = \"oracle\", must be another"), std::string::npos) << oracle.error;
  std::ofstream(folder.file("quoted.json"))
      << R"({"schema": "poise.policy/1", "name": "near, \"first\"", "policy": {"kind": "fifo"}})";
  static_cast<void>(compared({"--policies", folder.file("quoted.json"), "--csv", folder.file("c.csv")}));
  EXPECT_NE(contents(folder.file("c.csv")).find(",\"near, \"\"first\"\"\","), std::string::npos);
}

TEST(Compare, RefusesWhatItCannotDo) {
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"--policies", "best"},
       "--policies: \"best\", must be of perceptual, fifo, random, round-robin, size, deepest, equal-levels, oracle, "
       "or a policy file"},
      {{"--policies", "fifo,"}, "--policies: \"\", must be of"},
      {{"--policies", "fifo,fifo"}, "--policies: fifo is given twice"},
      {{"--policies", "oracle", "--history", "2"}, "--policies oracle knows one frame"},
      {{"--budgets", "many"}, "--budgets: \"many\", must be a number of work units from 0, or a share"},
      {{"--budgets", "-1"}, "--budgets: \"-1\", must be"},
      {{"--budgets", "nan"}, "--budgets: \"nan\", must be"},
      {{"--budgets", "101%"}, "--budgets: \"101%\", must be"},
      {{"--budgets", "5,5%"}, "cannot be mixed"},
      {{"--budgets", "5,7,5"}, "--budgets: 5 is given twice"},
      {{"--clock", "wall", "--budgets", "5%"}, "--budgets: \"5%\", must be a number of ms above 0"},
      {{"--clock", "wall", "--budgets", "0"}, "--budgets: \"0\", must be a number of ms above 0"},
      {{"--clock", "wall", "--from", "0"}, "--from = 0, must be above 0 with --clock wall"},
      {{"--clock", "sun"}, "--clock"},
      {{"--from", "-1"}, "--from = -1, must be a number of work units from 0, or a share"},
      {{"--from", "101%"}, "--from = 101%, must be"},
      {{"--from", "much"}, "--from = much, must be"},
      {{"--clock", "wall", "--from", "5%"}, "--from = 5%, must be a number of ms above 0"},
      {{"--from-policy", "best"}, "--from-policy: \"best\", must be of perceptual"},
      {{"--from-policy", "oracle"}, "--from-policy: the oracle knows single frames"},
      {{"--serve", "--json", "-"}, "--serve writes to the standard output alone"},
      {{"--serve", "--report", "r"}, "--serve writes to the standard output alone"},
      {{"--report", "-"}, "--report must be a folder"},
      {{"--report", "r", "--json", "r/report.html"}, "is named for two outputs: --json and --report"},
      {{"--every", "0"}, "--every = 0, must be"},
      {{"--history", "0"}, "--history = 0, must be"},
      {{"--csv", "-"}, "only --json can go to the standard output"},
      {{"--csv", "same", "--svg", "same"}, "same"}};
  for (const auto& [options, message] : cases) {
    std::vector<std::string> arguments{"compare", "jacks"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const CommandResult result = poise_command(arguments);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
  }
  const CommandResult fixed = poise_command({"compare", "two-body", "--bodies", "5"});
  EXPECT_EQ(fixed.exit_code, 2);
  EXPECT_NE(fixed.error.find("--bodies: the scene two-body has no generators"), std::string::npos) << fixed.error;
  EXPECT_EQ(poise_command({"compare", "no-such-scene"}).exit_code, 3);
  EXPECT_EQ(poise_command(compare({"--json", "/no-such-folder/c.json"})).exit_code, 4);
}

}  // namespace
}  // namespace poise::testing
