// SPDX-License-Identifier: MIT
#include "studies/study_table.h"

#include <gtest/gtest.h>

#include <string>

namespace poise::testing {
namespace {

io::StudyTable some_table() {
  io::StudyTable table;
  table.schema = "poise.some/1";
  table.command = "poise study some";
  table.columns = {{"name", "name", 0}, {"x", "x of it", 1}, {"hidden", "", 3}, {"y", "y", 2}};
  table.rows = {{std::string("a"), std::uint64_t{3}, 0.5, 1.25},
                {std::string("b"), std::uint64_t{4}, {}, {}},
                {std::string("a"), std::uint64_t{5}, true, 2.0}};
  table.facts = {{"scene", std::string("pile")}, {"frames", std::uint64_t{7}}};
  return table;
}

TEST(StudyTable, ShowsItsColumnsAndKeepsTheOthersForJson) {
  const std::string markdown = io::study_markdown(some_table());
  EXPECT_NE(markdown.find("| name | x of it | y |\n|---|---|---|\n| a | 3 | 1.25 |\n| b | 4 | - |\n| a | 5 | 2.00 |\n"),
            std::string::npos)
      << markdown;
  EXPECT_NE(markdown.find("`poise study some`"), std::string::npos);
  EXPECT_EQ(io::study_text(some_table()).substr(0, 40), "name  x of it     y\na           3  1.25\n");
  const std::string json = io::study_json(some_table());
  for (const char* part : {"\"schema\": \"poise.some/1\"", "\"scene\": \"pile\"", "\"frames\": 7", "\"hidden\": 0.5",
                           "\"hidden\": null", "\"hidden\": true"}) {
    EXPECT_NE(json.find(part), std::string::npos) << part;
  }
}

TEST(StudyTable, ShowsTheSummaryAfterTheRows) {
  io::StudyTable table = some_table();
  table.summary = io::StudySummary{"loops", {{"a", "a of it", 1}, {"b", "", 0}}, {{0.25, std::uint64_t{9}}}};
  EXPECT_NE(io::study_markdown(table).find("| a | 5 | 2.00 |\n\n| a of it |\n|---|\n| 0.2 |\n\nscene: pile; "),
            std::string::npos)
      << io::study_markdown(table);
  EXPECT_NE(io::study_text(table).find("\n\na of it\n0.2    \nscene: pile\n"), std::string::npos)
      << io::study_text(table);
  const std::string json = io::study_json(table);
  EXPECT_LT(json.find("\"rows\""), json.find("\"loops\""));
  EXPECT_NE(json.find("\"b\": 9"), std::string::npos);
}

TEST(StudyTable, ShowsFurtherTablesAfterTheSummaryAndKeepsThoseWithoutTitlesForJson) {
  io::StudyTable table = some_table();
  table.summary = io::StudySummary{"loops", {{"a", "a of it", 1}}, {{0.25}}};
  table.more = {{"points", {{"p", "p of it", 0}}, {{std::uint64_t{4}}}}, {"cells", {{"c", "", 0}}, {{7.5}}}};
  const std::string markdown = io::study_markdown(table);
  EXPECT_NE(markdown.find("| a of it |\n|---|\n| 0.2 |\n\n| p of it |\n|---|\n| 4 |\n\nscene: pile; "),
            std::string::npos)
      << markdown;
  const std::string text = io::study_text(table);
  EXPECT_NE(text.find("\n\np of it\n4      \nscene: pile\n"), std::string::npos) << text;
  const std::string json = io::study_json(table);
  EXPECT_LT(json.find("\"loops\""), json.find("\"points\""));
  EXPECT_NE(json.find("\"c\": 7.5"), std::string::npos) << json;
}

TEST(StudyTable, LeavesOutColumnsThatAreEmptyInEveryRow) {
  io::StudyTable table = some_table();
  for (auto& row : table.rows) row[3] = {};
  EXPECT_NE(io::study_markdown(table).find("| name | x of it |\n|---|---|\n| a | 3 |\n"), std::string::npos);
  EXPECT_NE(io::study_json(table).find("\"y\": null"), std::string::npos);
  table.rows.clear();
  EXPECT_NE(io::study_markdown(table).find("| name | x of it | y |\n"), std::string::npos);
}

TEST(StudyTable, ReadsItsFirstRowBackAndRefusesWhatIsNone) {
  const io::StudyTable table = some_table();
  const auto row = io::first_row_of(io::study_json(table), table.columns);
  ASSERT_TRUE(row);
  EXPECT_EQ(row.value(), table.rows[0]);
  for (const char* wrong : {"", "[]", "{}", R"({"rows": []})", R"({"rows": [3]})", R"({"rows": [{"name": "a"}]})",
                            R"({"rows": [{"name": "a", "x": [1], "hidden": 1, "y": 2}]})"}) {
    const auto refused = io::first_row_of(wrong, table.columns);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().message, "a study in a child process wrote no row");
  }
}

TEST(StudyTable, GivesThePointsOfTheRowsThatAreAskedFor) {
  const std::vector<app::LinePoint> all = io::study_points(some_table(), "x", "y", {});
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].x, 3);
  EXPECT_EQ(all[0].y, 1.25);
  EXPECT_EQ(all[1].x, 5);
  const std::vector<app::LinePoint> one = io::study_points(some_table(), "x", "y", {{"x", "5"}});
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0].y, 2);
  EXPECT_TRUE(io::study_points(some_table(), "x", "nothing", {}).empty());
}

}  // namespace
}  // namespace poise::testing
