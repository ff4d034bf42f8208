// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "scene/run/run_document.h"
#include "scene/run/run_tables.h"
#include "scene/temporary_folder.h"

namespace poise::io {
namespace {

using testing::cells;
using testing::lines;

TEST(StatesTable, HasTheStatedColumnsAndGivesEveryNumberBackExactly) {
  EXPECT_EQ(states_header(),
            "frame,time_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_mps,vy_mps,vz_mps,wx_radps,wy_radps,wz_radps\n");
  BodyState state;
  state.position_m = {0.1, -1.0 / 3, 1e-300};
  state.orientation = Quat(0.5, -0.5, 0.5, std::nextafter(0.5, 1));
  state.velocity_mps = {M_PI, 1e9, -0.0};
  state.angular_velocity_radps = {1, 2, 3};
  std::string text;
  append_states(7, 7.0 / 60, std::vector<NumberedState>{{0, BodyState{}}, {5, state}}, text);
  ASSERT_EQ(lines(text).size(), 2U);
  const std::vector<std::string> row = cells(lines(text)[1]);
  ASSERT_EQ(row.size(), 16U);
  EXPECT_EQ(row[0], "7");
  EXPECT_EQ(std::stod(row[1]), 7.0 / 60);
  EXPECT_EQ(row[2], "5");
  const double expected[] = {0.1, -1.0 / 3, 1e-300, 0.5, -0.5, 0.5, std::nextafter(0.5, 1), M_PI, 1e9, -0.0, 1, 2, 3};
  for (std::size_t i = 0; i < 13; ++i) EXPECT_EQ(std::stod(row[3 + i]), expected[i]) << i;
}

TEST(FramesTable, HasOneCellForEachColumn) {
  simulation::RunFrame frame;
  frame.report.frame = 3;
  frame.report.times.total = Nanoseconds(1234567);
  frame.report.lateness = Nanoseconds(1);
  frame.report.cause = MissCause::Overrun;
  frame.report.level_histogram = {9, 8, 7};
  frame.report.level_histogram[kPolygonBin] = 6;
  frame.report.asleep = 12;
  frame.report.fell_asleep = 5;
  frame.report.woken = 3;
  frame.report.momentum_ns = {0.5, -2, 8};
  std::string text;
  append_frame(frame, 0.05, text);
  const std::vector<std::string> names = cells(lines(frames_header())[0]);
  const std::vector<std::string> row = cells(lines(text)[0]);
  ASSERT_EQ(names.size(), row.size());
  const auto cell = [&](const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? "no such column" : row[static_cast<std::size_t>(found - names.begin())];
  };
  EXPECT_EQ(cell("frame"), "3");
  EXPECT_EQ(cell("total_ms"), "1.234567");
  EXPECT_EQ(cell("miss"), "1");
  EXPECT_EQ(cell("cause"), "overrun");
  EXPECT_EQ(cell("level_1"), "8");
  EXPECT_EQ(cell("polygons"), "6");
  EXPECT_EQ(cell("asleep"), "12");
  EXPECT_EQ(cell("fell_asleep"), "5");
  EXPECT_EQ(cell("woken"), "3");
  EXPECT_EQ(cell("momentum_x_kgmps"), "0.5");
  EXPECT_EQ(cell("momentum_y_kgmps"), "-2");
  EXPECT_EQ(cell("momentum_z_kgmps"), "8");
  EXPECT_EQ(cell("status"), "done");
}

TEST(FramesTable, LeavesTheCellsOfAReferenceEmptyWhereThereIsNone) {
  simulation::RunFrame frame;
  std::string text;
  append_frame(frame, 0, text);
  frame.report.reference.emplace();
  frame.report.reference->e_mps = 0.25;
  frame.report.reference->gap_max_m = 0.5;
  frame.report.reference->missed_contacts = 3;
  frame.report.reference->converged = true;
  append_frame(frame, 0, text);
  const std::vector<std::string> names = cells(lines(frames_header())[0]);
  std::size_t members = 0;
  std::size_t checked = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].rfind("reference_", 0) != 0) continue;
    ++members;
    const auto cell = [&](std::size_t row) {
      const std::vector<std::string> found = cells(lines(text)[row]);
      return i < found.size() ? found[i] : std::string();
    };
    EXPECT_EQ(cell(0), "") << names[i];
    const std::map<std::string, std::string> expected = {{"reference_e_mps", "0.25"},
                                                         {"reference_e_rel", ""},
                                                         {"reference_gap_max_mm", "500"},
                                                         {"reference_missed_contacts", "3"},
                                                         {"reference_converged", "1"}};
    const auto known = expected.find(names[i]);
    if (known != expected.end()) {
      EXPECT_EQ(cell(1), known->second) << names[i];
      ++checked;
    }
  }
  EXPECT_EQ(checked, 5U);
  EXPECT_EQ(members, 18U);
  // Both rows need the same number of commas, or columns would shift.
  EXPECT_EQ(std::count(text.begin(), text.end(), ','), 2 * static_cast<std::ptrdiff_t>(names.size() - 1));
}

RunDocument sample() {
  simulation::RunFrame frame;
  frame.report.times.total = Nanoseconds(10'000'000);
  frame.report.lateness = Nanoseconds(1000);
  frame.report.cause = MissCause::Machine;
  RunDocument document;
  document.scene = "sample";
  document.deadline_ms = 0.1 + 0.2;
  document.figures = simulation::run_figures(std::vector<simulation::RunFrame>{frame}, {true});
  document.start.momentum_ns = {1, 2, 3};
  document.state_hash = 0xfedcba9876543210ULL;
  document.origin_offsets_m.emplace_back("cow", Vec3(0.25, 0, 0));
  document.warnings = {"sample.json: shapes.cow.mesh: open"};
  document.tree_cache_use.hits = 3;
  return document;
}

TEST(RunDocument, HasTheMembersOfItsSchemaWithFullPrecision) {
  const nlohmann::json json = nlohmann::json::parse(run_json(sample()));
  EXPECT_EQ(json.at("schema"), "poise.run/2");
  for (const char* name :
       {"scene", "bodies", "frames", "threads", "policy", "contact", "clock", "deadline_ms", "refinement_used",
        "contacts_mean", "state_hash", "machine", "build", "settings", "stage_ms", "tail", "work", "capacity"}) {
    EXPECT_TRUE(json.contains(name)) << name;
  }
  for (const char* name : {"p50", "p90", "p95", "p99", "p99_9", "max"})
    EXPECT_EQ(json.at("frame_ms").at(name), 10) << name;
  for (const char* stage :
       {"predict", "broad_phase", "coarse", "refine", "manifolds", "solve", "integrate", "publish", "total"}) {
    EXPECT_TRUE(json.at("stage_ms").contains(stage)) << stage;
  }
  EXPECT_EQ(json.at("stage_ms").size(), 9U);
  for (const char* name : {"count", "rate", "release", "infeasible", "machine", "overrun", "forecast"}) {
    EXPECT_TRUE(json.at("misses").at(name).is_number()) << name;
  }
  ASSERT_EQ(json.at("worst_frames").size(), 1U);
  EXPECT_EQ(json.at("worst_frames").at(0), nlohmann::json({{"frame", 0},
                                                           {"late_ms", 0.001},
                                                           {"cause", "machine"},
                                                           {"release_delay_ms", 0.0},
                                                           {"stage", "publish"},
                                                           {"stage_ms", 0.0},
                                                           {"piece", nullptr}}));
  EXPECT_TRUE(json.at("levels").contains("mean"));
  EXPECT_TRUE(json.at("levels").at("histogram").is_array());
  for (const char* name : {"energy_j", "momentum"}) {
    EXPECT_TRUE(json.at(name).contains("start")) << name;
    EXPECT_TRUE(json.at(name).contains("end")) << name;
  }
  EXPECT_EQ(json.at("deadline_ms").get<double>(), 0.1 + 0.2);
  EXPECT_EQ(json.at("state_hash"), "fedcba9876543210");
  EXPECT_EQ(json.at("origin_offset_m").at("cow").at(0), 0.25);
  EXPECT_EQ(json.at("tree_cache").at("hits"), 3);
  EXPECT_EQ(json.at("warnings"), nlohmann::json({"sample.json: shapes.cow.mesh: open"}));
  EXPECT_TRUE(nlohmann::json::parse(run_json({})).at("warnings").empty());
  EXPECT_GE(json.at("machine").at("cores"), 0);
}

TEST(RunDocument, NamesItsNumbersByDottedPaths) {
  const std::vector<NamedFigure> figures = named_figures(sample());
  const auto value = [&](const std::string& name) {
    for (const NamedFigure& figure : figures) {
      if (figure.name == name) return figure.value.value_or(-1);
    }
    return -2.0;
  };
  EXPECT_EQ(value("frame_ms.p99"), 10);
  EXPECT_EQ(value("misses.rate"), 1);
  EXPECT_EQ(value("miss_rate"), 1);
  EXPECT_EQ(value("momentum.start.2"), 3);
  EXPECT_EQ(value("levels.mean"), -1);
  EXPECT_EQ(value("no.such"), -2);
}

TEST(RunDocument, LeavesMissesUndefinedOnTheWorkClock) {
  RunDocument document = sample();
  document.figures = simulation::run_figures({}, {false});
  const nlohmann::json work = nlohmann::json::parse(run_json(document));
  const nlohmann::json wall = nlohmann::json::parse(run_json(sample()));
  const std::function<void(const nlohmann::json&, const nlohmann::json&)> null_for_each =
      [&](const nlohmann::json& none, const nlohmann::json& defined) {
        if (!defined.is_object()) {
          EXPECT_TRUE(none.is_null()) << none;
          return;
        }
        ASSERT_EQ(none.size(), defined.size());
        for (const auto& [name, value] : defined.items()) {
          ASSERT_TRUE(none.contains(name)) << name;
          null_for_each(none.at(name), value);
        }
      };
  null_for_each(work.at("misses"), wall.at("misses"));
  EXPECT_EQ(work.at("longest_job"), nlohmann::json({{"frame", nullptr}, {"body_a", nullptr}, {"body_b", nullptr}}));
}

TEST(RunDocument, NamesWhatARunMayHaveBeforeItHasIt) {
  const auto names_of = [](const RunDocument& document) {
    std::vector<std::string> names;
    for (const NamedFigure& figure : named_figures(document)) names.push_back(figure.name);
    std::ranges::sort(names);
    return names;
  };
  RunDocument before;
  before.figures = simulation::run_figures({}, {false});
  const std::vector<std::string> known = names_of(before);
  EXPECT_EQ(std::ranges::adjacent_find(known), known.end()) << "each once";
  RunDocument after;
  simulation::RunFrame late;
  late.report.lateness = Nanoseconds(5);
  late.report.cause = MissCause::Overrun;
  late.report.longest_job = Nanoseconds(7);
  late.report.out_of_range = 1;
  after.figures = simulation::run_figures(std::vector<simulation::RunFrame>(9, late), {true});
  after.capture = RunDocument::Capture{"a.capture", 9, 0, 100};
  for (const std::string& name : names_of(after)) EXPECT_TRUE(std::ranges::binary_search(known, name)) << name;
  for (const char* name :
       {"worst_frames.4.piece.ms", "worst_frames.0.late_ms", "capture.frames", "out_of_range.first_body",
        "longest_job.body_b", "misses.tardiness_ms.p99", "misses.interval_95.high"}) {
    EXPECT_TRUE(std::ranges::binary_search(known, name)) << name;
    const std::vector<NamedFigure> figures = named_figures(after);
    EXPECT_TRUE(std::ranges::find(figures, name, &NamedFigure::name)->value) << name;
  }
}

TEST(RunDocument, GivesTheReferencesOfARunAndNullsWithoutOne) {
  const auto value = [](const RunDocument& document, const std::string& name) {
    for (const NamedFigure& figure : named_figures(document)) {
      if (figure.name == name) return figure.value.value_or(-1);
    }
    return -2.0;
  };
  for (const char* name :
       {"reference.every", "reference.e_mps_p50", "reference.e_rel_p50", "reference.e_seen_mps_p90",
        "reference.gap_max_mm_max", "reference.gap_max_px_p50", "reference.false_rate", "reference.missed_rate_max"}) {
    EXPECT_EQ(value(sample(), name), -1) << name;
  }
  EXPECT_EQ(value(sample(), "reference.frames"), 0);
  RunDocument document = sample();
  document.reference_every = 7;
  simulation::RunFrame frame;
  frame.report.reference.emplace();
  frame.report.reference->converged = true;
  frame.report.reference->e_rel = 0.5;
  frame.report.reference->gap_max_m = 0.002;
  frame.report.reference->run_contacts = 4;
  frame.report.reference->false_contacts = 1;
  frame.report.reference->false_rate = 0.25;
  document.figures = simulation::run_figures(std::vector<simulation::RunFrame>{frame}, {true});
  EXPECT_EQ(value(document, "reference.every"), 7);
  EXPECT_EQ(value(document, "reference.frames"), 1);
  EXPECT_EQ(value(document, "reference.e_rel_p50"), 0.5);
  EXPECT_EQ(value(document, "reference.gap_max_mm_max"), 2);
  EXPECT_EQ(value(document, "reference.false_rate"), 0.25);
  EXPECT_EQ(value(document, "reference.false_rate_p90"), 0.25);
  EXPECT_EQ(value(document, "reference.missed_rate"), -1);
  EXPECT_EQ(value(document, "reference.not_converged"), 0);
}

TEST(Machine, KnowsItsSystemAndCores) {
  EXPECT_NE(this_machine().system.find("Linux"), std::string::npos);
  EXPECT_GE(this_machine().cores, 1);
}

}  // namespace
}  // namespace poise::io
