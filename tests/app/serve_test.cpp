// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/files/scene_files.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

const std::vector<std::string> kStates{"compare", "jacks",    "--bodies", "40",        "--frames", "3",      "--every",
                                       "10",      "--warmup", "40",       "--budgets", "10%,40%",  "--quiet"};

std::vector<json> served(const std::string& policies, const std::vector<std::string>& more = {}) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("in")) << policies;
  std::vector<std::string> arguments = kStates;
  arguments.emplace_back("--serve");
  arguments.insert(arguments.end(), more.begin(), more.end());
  const CommandResult result = poise_command_reading(folder.file("in"), arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  std::vector<json> lines;
  std::istringstream out(result.out);
  for (std::string line; std::getline(out, line);) lines.push_back(json::parse(line));
  return lines;
}

double mean_seen(const json& answer, std::size_t budget) {
  double sum = 0;
  for (const json& state : answer.at("E_seen")) sum += state.at(budget).get<double>();
  return sum / static_cast<double>(answer.at("E_seen").size());
}

TEST(Serve, AnswersAsAComparisonOfAllPoliciesWould) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = kStates;
  arguments.insert(arguments.end(), {"--policies", "perceptual,oracle,fifo", "--json", folder.file("c.json")});
  ASSERT_EQ(poise_command(arguments).exit_code, 0);
  const json whole = json::parse(contents(folder.file("c.json")));
  const std::vector<json> lines = served("fifo\n\noracle\nperceptual\nfifo\n");
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_EQ(lines[0].at("schema"), "poise.compare-steps/1");
  EXPECT_EQ(lines[0].at("states"), 3);
  EXPECT_EQ(lines[0].at("budgets"), json({10.0, 40.0}));
  EXPECT_EQ(lines[1], lines[4]) << "an answer does not depend on those before it";
  for (const json& row : whole.at("rows")) {
    for (const json& line : lines) {
      if (!line.contains("policy") || line.at("policy") != row.at("policy")) continue;
      EXPECT_DOUBLE_EQ(mean_seen(line, row.at("budget") == 10 ? 0 : 1), row.at("E_seen")) << row;
    }
  }
}

TEST(Serve, SaysWhichSceneAndProgramTheStatesAreOf) {
  const TemporaryFolder folder;
  const std::string text = contents(app::find_scene("two-body").value().string());
  const auto facts = [&](const std::string& more) {
    std::ofstream(folder.file("s.json")) << text << more;
    std::ofstream(folder.file("in"));
    const CommandResult result = poise_command_reading(
        folder.file("in"), {"compare", folder.file("s.json"), "--frames", "1", "--quiet", "--serve"});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    const json checked =
        json::parse(poise_command({"check", folder.file("s.json"), "--json", "-", "--quiet"}).out, nullptr, false);
    const json served = json::parse(result.out, nullptr, false);
    EXPECT_EQ(served.at("scene_hash"), checked.at("scene_hash"));
    return served;
  };
  const json first = facts(""), same = facts(""), other = facts(" ");
  EXPECT_EQ(first.at("scene_hash"), same.at("scene_hash"));
  EXPECT_NE(first.at("scene_hash"), other.at("scene_hash"));
  EXPECT_FALSE(first.at("program").get<std::string>().empty());
}

TEST(Serve, RefusesAPolicyAndGoesOn) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("bad.json")) << R"({"schema": "poise.policy/1", "name": "a", "policy": {"closing": 11}})";
  const std::vector<json> lines = served("best\n" + folder.file("bad.json") + "\n/none.json\nsize\n");
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_TRUE(lines[1].at("error").get<std::string>().starts_with("\"best\", must be of perceptual")) << lines[1];
  EXPECT_NE(lines[2].at("error").get<std::string>().find("policy.closing = 11, must be"), std::string::npos);
  EXPECT_NE(lines[3].at("error").get<std::string>().find("no such file"), std::string::npos) << lines[3];
  EXPECT_EQ(lines[4].at("policy"), "size");
  EXPECT_NE(served("oracle\n", {"--history", "2"})[1].at("error").get<std::string>().find("one frame"),
            std::string::npos);
}

TEST(Serve, StatesDependOnTheRunThatMakesThem) {
  const json all = served("size\n")[1];
  const json share = served("size\n", {"--from", "20%"})[1];
  const json fifo = served("size\n", {"--from", "20%", "--from-policy", "fifo"})[1];
  EXPECT_NE(all.at("E_seen"), share.at("E_seen"));
  EXPECT_NE(share.at("E_seen"), fifo.at("E_seen"));
  EXPECT_EQ(served("size\n", {"--from", "100%"})[1].at("E").size(), 3U);
}

}  // namespace
}  // namespace poise::testing
