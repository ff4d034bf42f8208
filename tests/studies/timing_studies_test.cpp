// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

TEST(StudyCost, TimesEachMandatoryStageOfEachPopulationFallingAndSettled) {
  const CommandResult result = poise_command({"study", "cost", "--bodies", "30", "60", "--frames", "4", "--skip", "3",
                                              "--settle", "20", "--json", "-", "--threads", "1"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json document = json::parse(result.out);
  EXPECT_EQ(document.at("schema"), "poise.cost/1");
  ASSERT_EQ(document.at("rows").size(), 2U * 2U * 8U);
  double sum = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    const json& row = document.at("rows").at(i);
    EXPECT_EQ(row.at("bodies"), 30);
    EXPECT_EQ(row.at("state"), "falling");
    EXPECT_EQ(row.at("frames"), 4);
    EXPECT_DOUBLE_EQ(row.at("ns_per_body").get<double>(), 1e6 * row.at("ms_p50").get<double>() / 30);
    sum += i < 7 ? row.at("ms_p50").get<double>() : 0;
  }
  EXPECT_EQ(document.at("rows").at(7).at("stage"), "all of these");
  EXPECT_GT(sum, 0);
  EXPECT_EQ(document.at("rows").at(8).at("state"), "settled");
  EXPECT_EQ(document.at("rows").at(31).at("bodies"), 60);
}

TEST(StudyKept, ASettledPileRefinesNextToNothingAndMoreWhereItStartsAnew) {
  const CommandResult result = poise_command(
      {"study", "cache", "--bodies", "60", "--frames", "3", "--settle", "400", "--json", "-", "--threads", "1"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json document = json::parse(result.out);
  EXPECT_EQ(document.at("schema"), "poise.cache/1");
  EXPECT_EQ(document.at("frames_anew"), 3);
  EXPECT_EQ(document.at("frames_cached"), 9);
  EXPECT_GT(document.at("cached_pairs"), 60);
  EXPECT_GT(document.at("levels_anew").get<double>(), 10 * (1 + document.at("levels_cached").get<double>()))
      << "what is kept was not forgotten, or never kept";
  ASSERT_EQ(document.at("rows").size(), 10U);
  EXPECT_EQ(document.at("rows").at(9).at("stage"), "all of these");
}

TEST(StudyScaling, HasARowForEachNumberOfThreadsAndSaysWhereItWasMeasured) {
  const CommandResult result = poise_command(
      {"study", "scaling", "--threads", "1", "2", "--bodies", "60", "--frames", "5", "--settle", "300", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json document = json::parse(result.out);
  EXPECT_EQ(document.at("schema"), "poise.scaling/1");
  ASSERT_EQ(document.at("rows").size(), 2U);
  EXPECT_GT(document.at("units_a_frame"), 100) << "every pair starts anew";
  EXPECT_EQ(document.at("rows").at(0).at("threads"), 1);
  EXPECT_EQ(document.at("rows").at(1).at("threads"), 2);
  EXPECT_EQ(document.at("rows").at(1).at("frames"), 5);
  EXPECT_FALSE(document.at("machine").at("processor").get<std::string>().empty());
  const CommandResult table = poise_command(
      {"study", "scaling", "--threads", "1", "--bodies", "40", "--frames", "2", "--settle", "1", "--markdown", "-"});
  EXPECT_NE(table.out.find("| threads | p10 | p50 |"), std::string::npos) << table.out;
}

TEST(StudyScaling, CountsTheSpanOfEachStageOnOneThread) {
  const CommandResult result = poise_command({"study", "scaling", "--span", "--bodies", "100", "--frames", "3",
                                              "--skip", "20", "--settle", "40", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json document = json::parse(result.out);
  EXPECT_EQ(document.at("schema"), "poise.span/1");
  ASSERT_EQ(document.at("rows").size(), 2U * 9U);
  for (const json& row : document.at("rows")) {
    EXPECT_EQ(row.at("frames"), 3);
    EXPECT_GT(row.at("work_ms_p50"), 0) << row;
    EXPECT_LE(row.at("serial_ms_p50"), row.at("span_ms_p50"));
  }
  EXPECT_EQ(document.at("rows").at(8).at("stage"), "all of these");
  EXPECT_EQ(document.at("rows").at(9).at("state"), "settled");
  EXPECT_EQ(poise_command({"study", "scaling", "--span", "--threads", "2"}).exit_code, 2);
}

TEST(StudyCost, RefusesASceneThatCannotHaveAnyNumberOfBodies) {
  const CommandResult result = poise_command({"study", "cost", "--scene", "two-body", "--bodies", "10"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.error.find("--scene two-body: must have generators"), std::string::npos) << result.error;
  EXPECT_EQ(poise_command({"study", "cost", "--json", "-", "--markdown", "-"}).exit_code, 2);
  EXPECT_EQ(poise_command({"study", "cost", "--frames", "0"}).exit_code, 2);
}

// Its results are checked only in the tests of the release build: valgrind and sanitizers cannot be combined.
TEST(StudyFree, NothingOfAFeatureThatIsOffIsExecuted) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "valgrind cannot run a program with sanitizers";
#else
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
  GTEST_SKIP() << "valgrind cannot run a program with sanitizers";
#endif
#endif
  if (std::system("valgrind --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "valgrind is not installed";
  const CommandResult result = poise_command({"study", "free", "--bodies", "12", "--frames", "6", "--json", "-"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  const json document = json::parse(result.out);
  ASSERT_GE(document.at("rows").size(), 7U);
  for (const json& row : document.at("rows")) {
    if (row.at("absent")) continue;
    EXPECT_TRUE(row.at("ok")) << row.dump(2);
    EXPECT_GT(row.at("off_instructions_a_step"), 0);
    EXPECT_NE(row.at("on_instructions_a_step"), row.at("off_instructions_a_step")) << row.at("feature");
  }
#endif
}

}  // namespace
}  // namespace poise::testing
