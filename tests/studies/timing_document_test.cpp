// SPDX-License-Identifier: MIT
#include "studies/timing_document.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "scene/run/trace_document.h"

namespace poise::io {
namespace {

using nlohmann::json;

TEST(CostDocument, DividesByBodiesAndByPairsAndShowsTheShareOfAPeriod) {
  CostDocument document;
  document.scene = "jacks";
  document.period_ms = 16;
  document.rows = {{1000, false, "predict", 2, 8000, 500, 60},
                   {1000, false, "all of these", 4, 8000, 500, 60},
                   {1000, true, "predict", 1, 0, 0, 60}};
  const json parsed = json::parse(cost_json(document));
  EXPECT_EQ(parsed.at("rows").at(0).at("ns_per_body"), 2000);
  EXPECT_EQ(parsed.at("rows").at(0).at("ns_per_candidate_pair"), 250);
  EXPECT_EQ(parsed.at("rows").at(2).at("ns_per_candidate_pair"), 0) << "no pair, no division";
  const std::string table = cost_markdown(document);
  EXPECT_NE(table.find("| 1000 | falling | 8000 | 500 | predict | 2.000 | 250.0 | 2000 | 12.5 % |"), std::string::npos)
      << table;
  EXPECT_NE(table.find("| | | | | all of these | 4.000"), std::string::npos) << table;
  EXPECT_NE(table.find("| 1000 | settled |"), std::string::npos) << table;
}

TEST(FreeDocument, IsRightOnlyWhereNothingIsCalledOffAndSomethingIsCalledOn) {
  FreeRow row;
  row.feature = "sleeping";
  EXPECT_FALSE(row.ok()) << "nothing was seen when it was on";
  row.functions_on = 2;
  EXPECT_TRUE(row.ok());
  row.called_off = {"fall_asleep"};
  EXPECT_FALSE(row.ok());
  row.called_off.clear();
  row.off_instructions = 1000;
  row.on_instructions = 1500;
  FreeDocument document;
  document.rows = {row};
  document.rows.push_back({"recording", "", "", 0, 0, true, {}, 0, false});
  const std::string table = free_markdown(document);
  EXPECT_NE(table.find("| sleeping | 1000 | 1500 | 1.500 | 0 | 2 |"), std::string::npos) << table;
  EXPECT_NE(table.find("| recording | | | | not in this program"), std::string::npos) << table;
  EXPECT_TRUE(json::parse(free_json(document)).at("rows").at(1).at("absent"));
}

TEST(TraceDocument, IsOneArrayWhateverThePiecesAndNamesAreEscaped) {
  TraceHead head{"poise run \"odd\\name\"\n", 2, 3};
  const SteadyClock::time_point zero{};
  std::string text = trace_begin(head);
  std::vector<TraceSpan> spans(2);
  spans[0].begin = zero + Nanoseconds(1500);
  spans[0].end = zero + Nanoseconds(4000);
  spans[0].frame = 7;
  spans[0].jobs = 2;
  spans[0].lane = 1;
  spans[0].stage = TraceStage::Worker;
  spans[1] = spans[0];
  spans[1].stage = TraceStage::Piece;
  spans[1].units = 35;
  spans[1].body_a = {4, 0};
  spans[1].body_b = {9, 1};
  const std::array<std::uint64_t, 2> pair = {4, 19};
  append_spans(spans, std::span(&pair, 1), zero, text);
  simulation::RunFrame frame;
  frame.report.lateness = Nanoseconds(1000);
  frame.report.cause = MissCause::Machine;
  frame.releases_skipped = 2;
  std::uint64_t misses = 4;
  append_counters(frame, zero, misses, text);
  text += trace_end(head);
  const json events = json::parse(text);
  EXPECT_EQ(misses, 7U);
  EXPECT_EQ(events.at(0).at("args").at("name"), "poise run \"odd\\name\"\n");
  EXPECT_EQ(events.at(3).at("name"), "jobs");
  EXPECT_EQ(events.at(3).at("ts"), 1.5);
  EXPECT_EQ(events.at(3).at("dur"), 2.5);
  EXPECT_EQ(events.at(3).at("args").at("levels"), 2);
  EXPECT_EQ(events.at(4).at("name"), "piece");
  EXPECT_EQ(events.at(4).at("args"), json({{"frame", 7}, {"body_a", 4}, {"body_b", 19}, {"units", 35}}));
  EXPECT_EQ(events.at(7).at("args").at("count"), 7);
  EXPECT_EQ(events.at(9).at("name"), "miss: machine");
  EXPECT_EQ(events.back().at("args").at("discarded"), 3);
}

TEST(Trace, KeepsItsRoomAndCountsTheRest) {
  Trace trace(2);
  for (int i = 0; i < 5; ++i) trace.add({});
  EXPECT_EQ(trace.spans().size(), 2U);
  EXPECT_EQ(trace.discarded(), 3U);
  trace.clear();
  trace.add({});
  EXPECT_EQ(trace.spans().size(), 1U);
  EXPECT_EQ(trace.discarded(), 3U);
}

}  // namespace
}  // namespace poise::io
