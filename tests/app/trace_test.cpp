// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/pages.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

struct Span {
  std::string name;
  double begin_us, end_us;
};

TEST(Trace, HasTheStagesOfEveryFrameAndTheWorkersInsideOfRefinement) {
  const TemporaryFolder folder;
  const std::string file = folder.file("trace.json");
  const CommandResult result = poise_command({"run", "jacks", "--bodies", "80", "--frames", "30", "--deadline", "4",
                                              "--threads", "2", "--executor", "threads", "--trace", file, "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json events = json::parse(contents(file), nullptr, false);
  ASSERT_TRUE(events.is_array());
  std::map<int, std::vector<Span>> lanes;
  std::map<std::string, int> counters;
  double last_frame_us = -1;
  for (const json& event : events) {
    const std::string kind = event.at("ph");
    if (kind == "C") ++counters[event.at("name")];
    if (kind != "X") continue;
    EXPECT_GE(event.at("ts"), 0);
    EXPECT_GE(event.at("dur"), 0);
    lanes[event.at("tid")].push_back(
        {event.at("name"), event.at("ts"), event.at("ts").get<double>() + event.at("dur").get<double>()});
    if (event.at("name") != "frame") continue;
    EXPECT_GT(event.at("ts"), last_frame_us) << "frames come one after another";
    last_frame_us = event.at("ts");
  }
  const std::vector<Span>& calling = lanes.at(0);
  EXPECT_EQ(std::count_if(calling.begin(), calling.end(), [](const Span& s) { return s.name == "frame"; }), 30);
  const std::vector<std::string> stages{"predict",   "broad_phase", "coarse",    "refine",
                                        "manifolds", "solve",       "integrate", "publish"};
  constexpr double kRoundingUs = 0.01;
  for (std::size_t i = 0; i < calling.size(); ++i) {
    if (calling[i].name != "frame") continue;
    double before = calling[i].begin_us;
    for (std::size_t s = 0; s < stages.size(); ++s) {
      ASSERT_LT(i + 1 + s, calling.size());
      const Span& stage = calling[i + 1 + s];
      EXPECT_EQ(stage.name, stages[s]);
      EXPECT_GE(stage.begin_us, before - kRoundingUs) << stage.name << " follows what is before it";
      EXPECT_LE(stage.end_us, calling[i].end_us + kRoundingUs) << stage.name << " lies in its frame";
      before = stage.end_us;
    }
  }
  for (const auto& [lane, spans] : lanes) {
    for (const Span& span : spans) {
      if (span.name != "jobs") continue;
      const bool inside = std::any_of(calling.begin(), calling.end(), [&](const Span& s) {
        return s.name == "refine" && span.begin_us >= s.begin_us - kRoundingUs && span.end_us <= s.end_us + kRoundingUs;
      });
      EXPECT_TRUE(inside) << "jobs of lane " << lane;
    }
  }
  std::size_t pieces = 0;
  for (const json& event : events) {
    if (event.at("name") != "piece") continue;
    ++pieces;
    const double begin_us = event.at("ts");
    const double end_us = begin_us + event.at("dur").get<double>();
    const std::vector<Span>& spans = lanes.at(event.at("tid"));
    EXPECT_TRUE(std::any_of(spans.begin(), spans.end(), [&](const Span& s) {
      return s.name == "jobs" && begin_us >= s.begin_us - kRoundingUs && end_us <= s.end_us + kRoundingUs;
    })) << "a piece is a part of its thread's jobs";
    EXPECT_LT(event.at("args").at("body_a"), event.at("args").at("body_b"));
    EXPECT_GT(event.at("args").at("units"), 0);
  }
  EXPECT_GT(pieces, 0U);
  for (const char* name : {"budget", "reserve", "misses", "contacts by level"}) EXPECT_EQ(counters[name], 30) << name;
  EXPECT_EQ(events.back().at("args").at("discarded"), 0);
}

TEST(Trace, OfTheWorkClockLeavesTheRunAsItWas) {
  const TemporaryFolder folder;
  EXPECT_EQ(hash_of_jacks(), hash_of_jacks({"--trace", folder.file("t.json")}));
}

TEST(Trace, IsRefusedWhereItWouldOverwriteAnotherOutput) {
  const TemporaryFolder folder;
  const std::string file = folder.file("x.json");
  EXPECT_EQ(poise_command({"run", "two-body", "--trace", file, "--json", file}).exit_code, 2);
  EXPECT_EQ(poise_command({"run", "two-body", "--trace", folder.file("none/x.json"), "--frames", "1"}).exit_code, 4);
  EXPECT_EQ(poise_command({"run", "two-body", "--trace", "-"}).exit_code, 2);
}

TEST(Affinity, IsRefusedByOptionValueAndRule) {
  const CommandResult outside = poise_command({"run", "two-body", "--affinity", "99999"});
  EXPECT_EQ(outside.exit_code, 3);
  EXPECT_NE(outside.error.find("--affinity: processors = 99999, must be processors that this process may use"),
            std::string::npos)
      << outside.error;
  const CommandResult tbb = poise_command({"run", "two-body", "--affinity", "0", "--executor", "tbb"});
  EXPECT_NE(tbb.exit_code, 0);
  EXPECT_NE(tbb.error.find("executor tbb"), std::string::npos) << tbb.error;
  for (const char* wrong : {"x", "1-", "3-1", "1,,2", "1,", "-1", "0-99999"}) {
    const CommandResult refused = poise_command({"run", "two-body", "--affinity", wrong});
    EXPECT_EQ(refused.exit_code, 2) << wrong;
    EXPECT_NE(refused.error.find("--affinity"), std::string::npos) << refused.error;
  }
  EXPECT_EQ(poise_command({"run", "two-body", "--realtime", "100"}).exit_code, 2);
}

TEST(Affinity, IsToldInTheReport) {
  const CommandResult result =
      poise_command({"run", "two-body", "--frames", "5", "--spin", "0", "--json", "-", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json settings = json::parse(result.out, nullptr, false).at("settings");
  EXPECT_EQ(settings.at("affinity"), json::array());
  EXPECT_EQ(settings.at("spin_us"), 0);
  EXPECT_EQ(settings.at("realtime_priority"), 0);
}

// Either the system permits it, or the refusal says what is needed.
TEST(Realtime, IsRunOrRefusedWithWhatItNeeds) {
  const CommandResult result = poise_command({"run", "two-body", "--frames", "3", "--realtime", "5", "--threads", "2"});
  if (result.exit_code == 0) {
    EXPECT_NE(result.out.find("real-time priority 5"), std::string::npos) << result.out;
  } else {
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(result.error.find("--realtime: realtime_priority = 5, must be granted by the system"), std::string::npos)
        << result.error;
  }
}

}  // namespace
}  // namespace poise::testing
