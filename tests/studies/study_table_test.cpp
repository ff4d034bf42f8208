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

TEST(StudyTable, GivesThePointsOfTheRowsThatAreAskedFor) {
  EXPECT_EQ(io::study_points(some_table(), "d", "x", "y", {}), "$d << EOD\n3 1.25\n5 2\nEOD\n");
  EXPECT_EQ(io::study_points(some_table(), "d", "x", "y", {{"x", "5"}}), "$d << EOD\n5 2\nEOD\n");
  EXPECT_EQ(io::study_points(some_table(), "d", "x", "nothing", {}), "$d << EOD\nEOD\n");
}

}  // namespace
}  // namespace poise::testing
