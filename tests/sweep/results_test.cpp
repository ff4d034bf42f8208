// SPDX-License-Identifier: MIT
#include "sweep/results.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "scene/temporary_folder.h"
#include "sweep/frontier.h"
#include "sweep/specs.h"
#include "sweep/trial_store.h"

namespace poise::testing {
namespace {

using sweep::Outcome;
using sweep::Trial;
using sweep::TrialState;
using Json = nlohmann::ordered_json;

/// A folder of results in which trials end as the test says.
class Ended {
 public:
  explicit Ended(const Json& json)
      : spec(spec_of(json)), trials(sweep::expand(spec, scenes_of(spec), "build").value_or({})), store(folder_.path()) {
    EXPECT_TRUE(store.make());
  }
  void done(std::size_t trial, double miss_rate, double p99 = 1) {
    const std::string work = store.work_file(trials[trial].key, "me").string();
    Json run{{"schema", "poise.run/2"},
             {"bodies", 12},
             {"frame_ms", {{"p99", p99}}},
             {"misses", {{"rate", miss_rate}, {"interval_95", {0, 0.5}}}},
             {"worst_frames", {{{"frame", 3}}}},
             {"sleep", {{"woken", nullptr}}},
             {"state_hash", "00ff"},
             {"machine", {{"processor", "quick, \"new\""}}}};
    std::ofstream(work) << run.dump();
    Outcome outcome;
    outcome.state = TrialState::Done;
    outcome.seconds = 1.5;
    outcome.host = "here";
    outcome.engine = "local";
    EXPECT_TRUE(store.store(trials[trial], outcome, work));
  }
  void ended(std::size_t trial, TrialState state, double time_limit_s = 3600) {
    Outcome outcome;
    outcome.state = state;
    outcome.exit_code = 3;
    outcome.time_limit_s = time_limit_s;
    EXPECT_TRUE(store.store(trials[trial], outcome, "none"));
  }
  sweep::Results results() {
    const Result<sweep::Results> joined = sweep::join(spec, trials, store);
    EXPECT_TRUE(joined) << joined.error().message;
    return joined.value_or({});
  }

  sweep::SweepSpec spec;
  std::vector<Trial> trials;

 private:
  static std::vector<sweep::SceneFile> scenes_of(const sweep::SweepSpec& spec) {
    std::vector<sweep::SceneFile> scenes = small_scenes();
    scenes.resize(spec.scenes.size());
    return scenes;
  }
  TemporaryFolder folder_;

 public:
  sweep::TrialStore store;
};

Json frontier_spec() {
  return {{"schema", "poise.sweep/1"},
          {"scenes", {"a"}},
          {"axes", {{"bodies", {300, 100, 200}}, {"deadline_ms", {8, 4}}}},
          {"requirements", {"miss_rate <= 0.1"}},
          {"frontier", {{"largest", "bodies"}, {"against", "deadline_ms"}}}};
}

TEST(TrialStore, CountsOnlyWhatIsComplete) {
  Ended sweep(frontier_spec());
  const Trial& trial = sweep.trials[0];
  EXPECT_EQ(sweep.store.outcome_of(trial).state, TrialState::Pending);
  sweep.done(0, 0.05);
  const Outcome done = sweep.store.outcome_of(trial);
  EXPECT_EQ(done.state, TrialState::Done);
  EXPECT_EQ(done.seconds, 1.5);
  EXPECT_EQ(done.host, "here");
  std::filesystem::remove(sweep.store.result_file(trial.key));
  EXPECT_EQ(sweep.store.outcome_of(trial).state, TrialState::Pending) << "its result is lost";
  std::ofstream(sweep.store.outcome_file(trial.key)) << "{\"state\": \"fail";
  EXPECT_EQ(sweep.store.outcome_of(trial).state, TrialState::Pending) << "cut short";
}

TEST(TrialStore, TakesNumbersOutOfRangeAsTheNearestWithin) {
  const Outcome outcome =
      sweep::parse_outcome(R"({"state": "failed", "exit_code": 1e300, "affinity": [-1e300, 1, "x"], "seconds": 2})");
  EXPECT_EQ(outcome.state, TrialState::Failed);
  EXPECT_EQ(outcome.exit_code, std::numeric_limits<int>::max());
  EXPECT_EQ(outcome.affinity, (std::vector<int>{-std::numeric_limits<int>::max(), 1, 0}));
  EXPECT_EQ(outcome.seconds, 2);
  EXPECT_EQ(sweep::parse_outcome("[").state, TrialState::Pending);
}

TEST(TrialStore, AHigherTimeLimitMakesATrialPendingThatWasEndedAtALowerOne) {
  Ended sweep(frontier_spec());
  sweep.ended(0, TrialState::TimedOut, 10);
  sweep.ended(1, TrialState::TimedOut, 3600);
  sweep.ended(2, TrialState::Failed, 10);
  EXPECT_EQ(sweep.store.outcome_of(sweep.trials[0]).state, TrialState::Pending);
  EXPECT_EQ(sweep.store.outcome_of(sweep.trials[1]).state, TrialState::TimedOut);
  EXPECT_EQ(sweep.store.outcome_of(sweep.trials[2]).state, TrialState::Failed);
  sweep.store.forget(sweep.trials[2].key);
  EXPECT_EQ(sweep.store.outcome_of(sweep.trials[2]).state, TrialState::Pending);
}

TEST(TrialStore, RefusesAResultThatIsNotThere) {
  Ended sweep(frontier_spec());
  Outcome done;
  done.state = TrialState::Done;
  const Status stored = sweep.store.store(sweep.trials[0], done, sweep.store.work_file("none", "me"));
  ASSERT_FALSE(stored);
  EXPECT_EQ(stored.error().kind, ErrorKind::OutputFailed);
  EXPECT_EQ(sweep.store.outcome_of(sweep.trials[0]).state, TrialState::Pending);
}

TEST(LogTail, IsTheLastLinesWithoutControlCharacters) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("log")) << "one\n\ntwo\x1b[2J\nthree";
  EXPECT_EQ(sweep::log_tail(folder.file("log"), 2).size(), 2U);
  EXPECT_EQ(sweep::log_tail(folder.file("log"), 2)[1], "three");
  EXPECT_EQ(sweep::log_tail(folder.file("log"), 9)[1].find('\x1b'), std::string::npos);
  EXPECT_TRUE(sweep::log_tail(folder.file("none"), 2).empty());
}

TEST(Results, HaveARowForEachTrialAndAColumnForEachSettingAndFigure) {
  Json json = small_spec();
  json["requirements"] = {"miss_rate <= 0.1"};
  json["repeats"] = 1;
  json["settings"]["policy"] = "fifo";
  Ended sweep(json);
  sweep.done(0, 0.05, 2.5);
  sweep.done(1, 0.25);
  sweep.ended(2, TrialState::Failed);
  const std::string csv = sweep::results_csv(sweep.spec, sweep.results());
  const std::vector<std::string> rows = lines(csv);
  ASSERT_EQ(rows.size(), 9U);
  EXPECT_EQ(rows[0],
            "trial,scene,frames,clock,policy,bodies,budget_work,repeat,state,exit_code,seconds,host,engine,cores,"
            "requirements_hold,state_hash,processor,commit,run.bodies,frame_ms.p99,misses.rate,misses.interval_95.0,"
            "misses.interval_95.1,worst_frames.0.frame,sleep.woken,run.miss_rate");
  EXPECT_EQ(rows[1], sweep.trials[0].key +
                         ",a,10,work,fifo,10,100,1,done,0,1.5,here,local,1,1,00ff,\"quick, \"\"new\"\"\",,12,2.5,0.05,"
                         "0,0.5,3,,0.05");
  EXPECT_NE(rows[2].find(",200,1,done,0,1.5,here,local,1,0,"), std::string::npos) << rows[2];
  EXPECT_EQ(rows[3], sweep.trials[2].key + ",a,10,work,fifo,20,100,1,failed,3,0,,,1,,,,,,,,,,,,");
  EXPECT_EQ(rows[4], sweep.trials[3].key + ",a,10,work,fifo,20,200,1,pending,,,,,1,,,,,,,,,,,,");
}

TEST(Results, AreTheSameInTheDatabase) {
  Ended sweep(frontier_spec());
  sweep.done(0, 0.05, 2.5);
  const Result<std::string> bytes = sweep::results_sqlite(sweep.spec, sweep.results());
  ASSERT_TRUE(bytes) << bytes.error().message;
  const TemporaryFolder folder;
  std::ofstream(folder.file("s.sqlite"), std::ios::binary) << bytes.value();
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(folder.file("s.sqlite").c_str(), &database), SQLITE_OK);
  const auto ask = [&](const std::string& sql) {
    std::string text;
    const auto add = [](void* into, int columns, char** values, char** /*names*/) {
      for (int i = 0; i < columns; ++i)
        *static_cast<std::string*>(into) += (values[i] == nullptr ? std::string("null") : values[i]) + ";";
      return 0;
    };
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), add, &text, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    return text;
  };
  EXPECT_EQ(ask("SELECT count(*), sum(state = 'pending'), typeof(max(bodies)), typeof(max(scene)) FROM trials"),
            "6;5;integer;text;");
  EXPECT_EQ(ask("SELECT bodies, deadline_ms, \"frame_ms.p99\", \"misses.rate\" FROM trials WHERE state = 'done'"),
            "300;8;2.5;0.05;");
  EXPECT_EQ(ask("SELECT \"frame_ms.p99\" FROM trials WHERE state <> 'done' LIMIT 1"), "null;");
  EXPECT_EQ(ask("SELECT value FROM sweep WHERE name = 'requirement'"), "miss_rate <= 0.1;");
  EXPECT_EQ(ask("PRAGMA integrity_check"), "ok;");
  sqlite3_close(database);
}

TEST(Results, RefuseAFileThatIsNoRun) {
  Ended sweep(frontier_spec());
  sweep.done(0, 0.05);
  std::ofstream(sweep.store.result_file(sweep.trials[0].key)) << R"({"schema": "poise.scene/1"})";
  const Result<sweep::Results> joined = sweep::join(sweep.spec, sweep.trials, sweep.store);
  ASSERT_FALSE(joined);
  EXPECT_NE(joined.error().message.find("must be the result of a run"), std::string::npos);
}

// Names are as long as their path, so that a long one above many numbers would take their product.
TEST(Results, LimitTheFiguresOfARun) {
  const auto figures = [](const std::string& members) {
    sweep::TrialResult result;
    return sweep::parse_run_result(R"({"schema": "poise.run/2", )" + members + "}", "r.json", result);
  };
  const auto numbers = [](std::size_t count) {
    std::string list = "0";
    for (std::size_t i = 1; i < count; ++i) list += ",0";
    return "[" + list + "]";
  };
  EXPECT_EQ(figures("\"a\": " + numbers(sweep::kMostFigures)).value_or({}).size(), sweep::kMostFigures);
  const auto refused = figures("\"a\": " + numbers(sweep::kMostFigures + 1));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "r.json: has more than 1800 figures");
  const std::string name(sweep::kLongestFigureName, 'n');
  EXPECT_EQ(figures("\"" + name + "\": 1, \"b\": 2").value_or({}).size(), 2U);
  EXPECT_EQ(figures("\"" + name + "n\": 1, \"b\": 2").value_or({}).size(), 1U) << "too long to be one";
}

// Trials in the order of the specification: (300, 8) (300, 4) (100, 8) (100, 4) (200, 8) (200, 4).
TEST(Frontier, IsTheLargestValueUpToWhichAllHold) {
  Ended sweep(frontier_spec());
  sweep.done(2, 0.0);
  sweep.done(4, 0.1);
  sweep.done(0, 0.11);
  sweep.done(3, 0.2);
  sweep.done(5, 0.0);
  sweep.done(1, 0.0);
  const auto lines = sweep::frontier_of(sweep.spec, sweep::groups_of(sweep.spec, sweep.results()));
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].label, "a");
  ASSERT_EQ(lines[0].points.size(), 2U);
  EXPECT_EQ(lines[0].points[0].at, 4);
  EXPECT_EQ(lines[0].points[0].largest, std::nullopt) << "100 does not hold, so larger ones that do are by chance";
  EXPECT_FALSE(lines[0].points[0].open);
  EXPECT_EQ(lines[0].points[1].at, 8);
  EXPECT_EQ(lines[0].points[1].largest, 200);
  EXPECT_FALSE(lines[0].points[1].open);
}

TEST(Frontier, SaysWhereItEndsWithoutAMeasurement) {
  Ended sweep(frontier_spec());
  sweep.done(2, 0.0);
  sweep.done(4, 0.0);
  sweep.done(0, 0.0);
  sweep.done(3, 0.0);
  sweep.ended(5, TrialState::TimedOut);
  const auto points = sweep::frontier_of(sweep.spec, sweep::groups_of(sweep.spec, sweep.results()))[0].points;
  EXPECT_EQ(points[1].largest, 300);
  EXPECT_TRUE(points[1].open) << "no larger value was measured";
  EXPECT_EQ(points[0].largest, 100);
  EXPECT_FALSE(points[0].open) << "a trial that was ended does not hold";
  Ended pending(frontier_spec());
  pending.done(2, 0.0);
  const auto unknown = sweep::frontier_of(pending.spec, sweep::groups_of(pending.spec, pending.results()))[0].points;
  EXPECT_EQ(unknown[1].largest, 100);
  EXPECT_TRUE(unknown[1].open);
  EXPECT_EQ(unknown[0].largest, std::nullopt);
  EXPECT_TRUE(unknown[0].open);
}

TEST(Groups, HoldByTheMeanOverSeedsAndRepeats) {
  Json json = frontier_spec();
  json["axes"] = {{"bodies", {100}}, {"deadline_ms", {4}}};
  json["seeds"] = {1, 2};
  json["repeats"] = 2;
  Ended sweep(json);
  ASSERT_EQ(sweep.trials.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) sweep.done(i, i == 3 ? 0.3 : 0.0, 1.0 + static_cast<double>(i));
  const sweep::Results results = sweep.results();
  const std::vector<sweep::Group> groups = sweep::groups_of(sweep.spec, results);
  ASSERT_EQ(groups.size(), 1U);
  EXPECT_EQ(groups[0].done, 4U);
  EXPECT_EQ(groups[0].holds, true) << "0.075 in the mean";
  const auto p99 =
      static_cast<std::size_t>(std::ranges::find(results.figures, "frame_ms.p99") - results.figures.begin());
  EXPECT_EQ(groups[0].mean[p99], 2.5);
  EXPECT_EQ(groups[0].least[p99], 1);
  EXPECT_EQ(groups[0].most[p99], 4);
  sweep.ended(0, TrialState::Failed);
  EXPECT_EQ(sweep::groups_of(sweep.spec, sweep.results())[0].holds, false) << "a trial failed";
}

}  // namespace
}  // namespace poise::testing
