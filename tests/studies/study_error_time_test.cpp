// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"

namespace poise::testing {
namespace {

using nlohmann::json;

CommandResult error_time(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"study", "error-time", "--quiet"});
  return poise_command(arguments);
}

const json& row_of(const json& study, const std::string& group, double setting) {
  const auto found = std::ranges::find_if(study.at("rows"), [&](const json& row) {
    return row.at("group") == group && row.at("setting").get<double>() == setting;
  });
  EXPECT_NE(found, study.at("rows").end()) << group << ' ' << setting;
  return *found;
}

TEST(ErrorTime, DeeperLevelsAreTruerAndEnginesComeToTheirOwnLimit) {
  const CommandResult result =
      error_time({"--bodies", "60", "--warmup", "90", "--states", "3", "--every", "5", "--history", "3", "--policies",
                  "perceptual", "--deadlines", "1000", "--iterations", "1,400", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out);
  EXPECT_EQ(study.at("schema"), "poise.error-time/1");
  ASSERT_EQ(study.at("states").get<int>(), 3);
  const double coarse = row_of(study, "levels", 0).at("e_rel").get<double>();
  const double deep = row_of(study, "levels", 2).at("e_rel").get<double>();
  EXPECT_LT(deep, 0.5 * coarse);
  // With all the time there is every pair comes to its finest level.
  EXPECT_LT(row_of(study, "perceptual", 1000).at("e_rel").get<double>(), 0.5 * coarse);
  EXPECT_TRUE(row_of(study, "perceptual", 1000).at("own_e_rel").is_null());
  for (const json& row : study.at("rows")) EXPECT_GT(row.at("time_p50_ms").get<double>(), 0) << row;
  if (study.at("engines") == "none are built in") GTEST_SKIP() << "libbullet-dev or libode-dev is not installed";
  for (const char* engine : {"bullet", "ode"}) {
    const double once = row_of(study, engine, 1).at("own_e_rel").get<double>();
    EXPECT_GT(once, 0.1) << engine;
    EXPECT_LT(row_of(study, engine, 400).at("own_e_rel").get<double>(), 0.5 * once) << engine;
    // They model impacts otherwise, but not another world.
    EXPECT_LT(row_of(study, engine, 400).at("e_rel").get<double>(), 2) << engine;
  }
}

TEST(ErrorTime, RefusesScenesThatEnginesCannotHaveAndStatesWithoutContacts) {
  const CommandResult before = error_time({"--bodies", "8", "--warmup", "0", "--states", "1", "--every", "1",
                                           "--history", "1", "--deadlines", "5", "--iterations", "1"});
  EXPECT_EQ(before.exit_code, 3);
  EXPECT_NE(before.error.find("take a later --warmup"), std::string::npos) << before.error;
  const CommandResult bad = error_time({"--iterations", "0"});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_NE(bad.error.find("--iterations"), std::string::npos) << bad.error;
}

}  // namespace
}  // namespace poise::testing
