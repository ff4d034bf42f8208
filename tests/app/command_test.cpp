// SPDX-License-Identifier: MIT
#include "app/command.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

json figures_of(const std::vector<std::string>& arguments) {
  std::vector<std::string> all = arguments;
  all.insert(all.end(), {"--json", "-", "--quiet"});
  const CommandResult result = poise_command(all);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "");
  return json::parse(result.out, nullptr, false);
}

TEST(Command, PrintsATableThatNamesTheCausesOfMisses) {
  const CommandResult result = poise_command({"run", "two-body", "--frames", "20"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "") << "no progress where stderr is no terminal";
  for (const char* part : {"two-body: 2 bodies", "p99", "misses", "infeasible", "machine", "overrun", "forecast",
                           "levels", "energy", "state hash"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(poise_command({"run", "two-body", "--frames", "2", "--quiet"}).out, "");
}

TEST(Command, ComparesEachKthMeasuredFrameWithItsReferenceAndLeavesTheRunAlone) {
  const TemporaryFolder folder;
  const std::string file = folder.file("frames.csv");
  const auto run = [](std::vector<std::string> options, const std::string& threads) {
    std::vector<std::string> arguments{"run",       "jacks", "--bodies",      "60", "--frames", "100",
                                       "--clock",   "work",  "--budget-work", "40", "--warmup", "3",
                                       "--threads", threads};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return figures_of(arguments);
  };
  const json plain = run({}, "2");
  const json with = run({"--reference", "every=30", "--frames-csv", file}, "2");
  const json alone = run({"--reference", "every=30"}, "1");
  EXPECT_EQ(plain.at("state_hash"), with.at("state_hash"));
  EXPECT_TRUE(plain.at("reference").at("every").is_null());
  EXPECT_TRUE(plain.at("reference").at("e_mps_p50").is_null());
  EXPECT_EQ(with.at("reference").at("every"), 30);
  EXPECT_EQ(with.at("reference").at("frames"), 3);
  EXPECT_EQ(with.at("reference").at("not_converged"), 0);
  EXPECT_GT(with.at("reference").at("e_rel_max"), 0);
  for (const char* name :
       {"e_mps_p50", "e_rel_p90", "e_seen_mps_max", "gap_max_mm_p50", "false_contacts", "missed_rate"}) {
    EXPECT_EQ(alone.at("reference").at(name), with.at("reference").at(name)) << name;
  }
  const std::vector<std::string> rows = lines(contents(file));
  const std::vector<std::string> names = cells(rows.at(0));
  const auto column = std::find(names.begin(), names.end(), "reference_contacts") - names.begin();
  std::vector<std::size_t> filled;
  for (std::size_t row = 1; row < rows.size(); ++row) {
    if (!cells(rows[row]).at(static_cast<std::size_t>(column)).empty()) filled.push_back(row - 1);
  }
  EXPECT_EQ(filled, (std::vector<std::size_t>{32, 62, 92})) << "frames from 0, warm-up included";
}

TEST(Command, PrintsTheReferenceAndTakesItsFiguresAsRequirements) {
  const std::vector<std::string> run{"run",  "two-body",    "--frames", "120",      "--clock",
                                     "wall", "--reference", "every=1",  "--require"};
  const auto require = [&](const std::string& expression) {
    std::vector<std::string> arguments = run;
    arguments.push_back(expression);
    return poise_command(arguments);
  };
  const CommandResult good = require("reference.e_rel_max < 1e-6 && reference.missed_contacts == 0");
  EXPECT_EQ(good.exit_code, 0) << good.error;
  for (const char* part : {"reference      120 frames", "E_seen", "of them false", "of them missed"}) {
    EXPECT_NE(good.out.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(require("reference.e_rel_max > 1").exit_code, 1);
  EXPECT_EQ(require("reference.e_rel > 1").exit_code, 2);
}

TEST(Command, DrawsAPictureAndTellsABadPlaceForItAtOnce) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.png");
  const CommandResult drawn = poise_command({"run", "two-body", "--frames", "3", "--picture", file, "--quiet"});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.error;
  EXPECT_EQ(contents(file).substr(1, 3), "PNG");
  const CommandResult refused = poise_command({"run", "two-body", "--picture", folder.file("none/run.png")});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_NE(refused.error.find("none/run.png"), std::string::npos);
}

TEST(Command, WritesTheStatesOfEveryBodyFromTheStartOn) {
  const TemporaryFolder folder;
  const std::string file = folder.file("states.csv");
  const CommandResult result = poise_command({"run", "two-body", "--frames", "12", "--states", file, "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const std::vector<std::string> rows = lines(contents(file));
  ASSERT_EQ(rows.size(), 1U + 13U * 2U);
  EXPECT_EQ(rows[0], "frame,time_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_mps,vy_mps,vz_mps,wx_radps,wy_radps,wz_radps");
  EXPECT_EQ(rows[1], "0,0,0,-2,0,0.20000000000000001,1,0,0,0,2,0,0,0,0,0");
  const std::vector<std::string> last = cells(rows.back());
  EXPECT_EQ(last[0], "12");
  EXPECT_EQ(last[2], "1");
  EXPECT_NEAR(std::stod(last[1]), 0.2, 1e-15);
  EXPECT_NEAR(std::stod(last[3]), 2 - 0.2, 1e-12) << "free flight before they meet";
  EXPECT_EQ(folder.entries(), 2U) << "the table of bodies is beside it";
}

TEST(Command, WritesWhatEachBodyIsBesideTheStates) {
  const TemporaryFolder folder;
  const CommandResult result = poise_command({"run", "pour", "--bodies", "100", "--frames", "90", "--clock", "work",
                                              "--states", folder.file("a.csv"), "--states-every", "10", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  std::set<std::string> numbers;
  for (const std::string& line : lines(contents(folder.file("a.csv")))) numbers.insert(cells(line)[2]);
  const std::vector<std::string> rows = lines(contents(folder.file("a.bodies.csv")));
  ASSERT_EQ(rows.size(), numbers.size()) << "a row for each body that has a state, and the header";
  EXPECT_EQ(rows[0], "body,name,motion,shape,file,material,mass_kg");
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::vector<std::string> row = cells(rows[i]);
    ASSERT_EQ(row.size(), 7U);
    EXPECT_TRUE(numbers.contains(row[0])) << rows[i];
    EXPECT_EQ(std::stod(row[6]) > 0, row[2] == "dynamic") << rows[i];
  }
  const CommandResult meshes = poise_command(
      {"run", "billiards", "--frames", "1", "--clock", "work", "--states", folder.file("m.csv"), "--quiet"});
  ASSERT_EQ(meshes.exit_code, 0) << meshes.error;
  EXPECT_NE(contents(folder.file("m.bodies.csv")).find(".obj,"), std::string::npos) << "meshes have files";
  const CommandResult twice = poise_command(
      {"run", "two-body", "--states", folder.file("b.csv"), "--json", folder.file("b.bodies.csv"), "--quiet"});
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_NE(twice.error.find("is named for two outputs: --json and the bodies of --states"), std::string::npos)
      << twice.error;
  EXPECT_EQ(poise_command({"run", "two-body", "--frames", "1", "--states", "/dev/null", "--quiet"}).exit_code, 0);
}

TEST(Command, WritesStaticBodiesAndPlanesWithFiniteNumbersAndWarmUpFramesToo) {
  const TemporaryFolder folder;
  const std::string file = folder.file("states.csv");
  const CommandResult result = poise_command({"run", "jacks", "--bodies", "7", "--frames", "3", "--warmup", "2",
                                              "--states", file, "--quiet", "--json", folder.file("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const std::vector<std::string> rows = lines(contents(file));
  ASSERT_EQ(rows.size(), 1U + 6U * 12U);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    for (const std::string& cell : cells(rows[i])) EXPECT_TRUE(std::isfinite(std::stod(cell))) << rows[i];
  }
  const json report = json::parse(contents(folder.file("r.json")));
  EXPECT_EQ(report.at("bodies"), 12);
  EXPECT_EQ(report.at("dynamic_bodies"), 7);
  EXPECT_EQ(report.at("frames"), 3);
  EXPECT_EQ(report.at("warm_up").at("frames"), 2);
}

TEST(Command, WritesOneRowAFrameAndCausesThatSumToTheMisses) {
  const TemporaryFolder folder;
  // No frame ends within a nanosecond or two: every frame is a miss on any machine.
  const CommandResult result = poise_command({"run", "gas", "--frames", "5", "--deadline", "0.000001", "--frames-csv",
                                              folder.file("f.csv"), "--json", folder.file("r.json"), "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const std::vector<std::string> rows = lines(contents(folder.file("f.csv")));
  ASSERT_EQ(rows.size(), 6U);
  for (const std::string& row : rows) EXPECT_EQ(cells(row).size(), cells(rows[0]).size());
  const json misses = json::parse(contents(folder.file("r.json"))).at("misses");
  EXPECT_EQ(misses.at("count"), 5);
  EXPECT_EQ(misses.at("rate"), 1);
  EXPECT_EQ(misses.at("longest_run"), 5);
  EXPECT_EQ(misses.at("infeasible").get<int>() + misses.at("machine").get<int>() + misses.at("overrun").get<int>() +
                misses.at("forecast").get<int>(),
            5);
}

TEST(Command, GivesTheSameHashOnEveryThreadCountAndExecutorForTheSameWork) {
  const std::vector<std::string> base{"run",     "jacks", "--bodies",      "60", "--frames", "40",
                                      "--clock", "work",  "--budget-work", "300"};
  const auto hash = [&base](const std::vector<std::string>& more) {
    std::vector<std::string> all = base;
    all.insert(all.end(), more.begin(), more.end());
    const json report = figures_of(all);
    EXPECT_GT(report.at("contacts_mean").get<double>(), 0);
    EXPECT_TRUE(report.at("misses").at("count").is_null());
    EXPECT_TRUE(report.at("deadline_ms").is_null());
    return report.at("state_hash").get<std::string>();
  };
  const std::string expected = hash({"--threads", "1"});
  EXPECT_EQ(hash({"--threads", "2"}), expected);
  EXPECT_EQ(hash({"--threads", "3", "--executor", "threads"}), expected);
  EXPECT_EQ(hash({"--threads", "8", "--executor", "threads"}), expected);
  EXPECT_EQ(hash({"--executor", "serial"}), expected);
  EXPECT_NE(hash({"--threads", "1", "--seed", "2"}), expected);
  EXPECT_NE(hash({"--threads", "1", "--max-level", "0"}), expected);
}

TEST(Command, TakesItsOptionsIntoTheReport) {
  const json report =
      figures_of({"run",         "jacks", "--bodies",  "20",    "--frames",   "4",         "--threads",   "2",
                  "--policy",    "fifo",  "--contact", "paper", "--deadline", "7.5",       "--host-work", "0.5",
                  "--max-level", "1",     "--seed",    "5",     "--paced",    "--sleeping"});
  EXPECT_EQ(report.at("schema"), "poise.run/2");
  EXPECT_EQ(report.at("scene"), "jacks");
  EXPECT_EQ(report.at("policy"), "fifo");
  EXPECT_EQ(report.at("contact"), "paper");
  EXPECT_EQ(report.at("clock"), "wall");
  EXPECT_EQ(report.at("threads"), 2);
  EXPECT_EQ(report.at("deadline_ms"), 7.5);
  EXPECT_EQ(report.at("settings").at("host_work_ms"), 0.5);
  EXPECT_EQ(report.at("settings").at("max_level"), 1);
  EXPECT_EQ(report.at("settings").at("seed"), 5);
  EXPECT_EQ(report.at("settings").at("paced"), true);
  EXPECT_EQ(report.at("settings").at("sleeping"), true);
  EXPECT_EQ(report.at("sleep").at("asleep_end"), 0);
  EXPECT_NEAR(report.at("tray_side_m").get<double>(), 1.05 * 2, 1e-9);
  EXPECT_FALSE(report.at("build").at("commit").get<std::string>().empty());
}

TEST(Command, TakesAPolicyFileAndWeights) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("mine.json"))
      << R"({"schema": "poise.policy/1", "name": "mine", "policy": {"kind": "size", "closing": 3, "waiting": 2}})";
  const json report = figures_of({"run", "jacks", "--bodies", "20", "--frames", "2", "--clock", "work", "--policy",
                                  folder.file("mine.json"), "--weight", "waiting=0.5", "--weight", "host=0"});
  EXPECT_EQ(report.at("policy"), "size");
  const json& weights = report.at("settings").at("policy_weights");
  EXPECT_EQ(weights.at("closing"), 3);
  EXPECT_EQ(weights.at("waiting"), 0.5) << "the command line comes after the file";
  EXPECT_EQ(weights.at("host"), 0);
  EXPECT_EQ(weights.at("frustum"), 1);
  const CommandResult none = poise_command({"run", "jacks", "--policy", folder.file("none.json")});
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_NE(none.error.find("none.json: no such file"), std::string::npos) << none.error;
}

TEST(Command, KeepsMomentumAndEnergyOfTheTwoBalls) {
  const json report = figures_of({"run", "two-body", "--clock", "work"});
  const json& momentum = report.at("momentum");
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(momentum.at("end").at(i).get<double>(), momentum.at("start").at(i).get<double>(), 1e-9);
  }
  EXPECT_NEAR(report.at("energy_j").at("end").get<double>(), report.at("energy_j").at("start").get<double>(), 1e-9);
  EXPECT_GT(report.at("contacts_mean").get<double>(), 0);
}

TEST(Command, ChecksTheFiguresOfARun) {
  const auto require = [](const std::string& expression) {
    return poise_command({"run", "two-body", "--frames", "5", "--clock", "work", "--quiet", "--require", expression});
  };
  EXPECT_EQ(require("frames == 5 && contacts_mean <= 1").exit_code, 0);
  const CommandResult failed = require("frames == 5 && frames > 7");
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_EQ(failed.error, "poise run: --require: frames > 7 does not hold: frames = 5\n");
  EXPECT_EQ(require("miss_rate < 1").exit_code, 1) << "misses are not defined on the work clock";
  for (const char* name : {"misses.tardiness_ms.p99", "misses.interval_95.low", "misses.longest_run",
                           "longest_job.frame", "worst_frames.0.late_ms", "worst_frames.4.piece.body_a",
                           "out_of_range.first_frame", "capture.left_out", "reference.e_rel_p50", "tail.coverage"}) {
    const CommandResult undefined = require(fmt::format("{} < 1", name));
    EXPECT_EQ(undefined.exit_code, 1);
    EXPECT_EQ(undefined.error,
              fmt::format("poise run: --require: {0} < 1 does not hold: {0} is not defined for this run\n", name));
  }
  EXPECT_EQ(require("worst_frames.5.late_ms < 1").exit_code, 2) << "there are five";
  EXPECT_EQ(require("misses.such < 1").exit_code, 2);
  const CommandResult wall = poise_command({"run", "two-body", "--frames", "5", "--deadline", "1000000", "--quiet",
                                            "--require", "miss_rate<0.01 && frame_ms.p99<1e6"});
  EXPECT_EQ(wall.exit_code, 0) << wall.error;
  const TemporaryFolder folder;
  const auto captured = [&](const std::string& expression) {
    return poise_command({"run", "two-body", "--frames", "5", "--clock", "work", "--quiet", "--capture",
                          folder.file("c"), "--json", folder.file("r.json"), "--require", expression});
  };
  EXPECT_EQ(captured("capture.frames == 6 && capture.left_out == 0").exit_code, 0) << "the start is a frame too";
  const CommandResult few = captured("capture.frames > 9");
  EXPECT_EQ(few.exit_code, 1);
  EXPECT_EQ(few.error, "poise run: --require: capture.frames > 9 does not hold: capture.frames = 6\n");
  EXPECT_EQ(json::parse(contents(folder.file("r.json"))).at("require").at("failed").size(), 1U);
}

TEST(Command, WarnsOfAnOpenMeshOnceAndInTheReport) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("box.obj")) << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                                           "f 4 3 2 1\nf 1 2 6 5\nf 4 8 7 3\nf 2 3 7 6\nf 1 5 8 4\n";
  const std::string scene = folder.file("open.json");
  std::ofstream(scene) << R"({"name": "open", "dt_s": 0.01, "materials": {"m": {}},
    "shapes": {"box": {"mesh": {"file": "box.obj", "depth": 0}}},
    "bodies": [{"shape": "box", "material": "m"}, {"shape": "box", "material": "m", "position_m": [5, 0, 0]}]})";
  const CommandResult result = poise_command({"run", scene, "--frames", "2", "--json", "-", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const std::vector<std::string> told = lines(result.error);
  ASSERT_EQ(told.size(), 1U) << result.error;
  EXPECT_EQ(told[0].rfind("poise run: warning: " + scene + ": shapes.box.mesh: open: 4 edges", 0), 0U) << told[0];
  const json report = json::parse(result.out, nullptr, false);
  ASSERT_EQ(report.at("warnings").size(), 1U);
  EXPECT_EQ("poise run: warning: " + report.at("warnings").at(0).get<std::string>(), told[0]);
}

TEST(Command, EndsAtCtrlCAndAtSigtermWithItsReportsWritten) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const TemporaryFolder folder;
    std::string states;
    const CommandResult result =
        interrupted_command({"run", "gas", "--frames", "1000000", "--json", folder.file("r.json"), "--states",
                             folder.file("states"), "--quiet"},
                            folder.file("states"), states, signal);
    EXPECT_EQ(result.exit_code, 128 + signal) << result.error;
    const json report = json::parse(contents(folder.file("r.json")), nullptr, false);
    ASSERT_TRUE(report.is_object());
    EXPECT_EQ(report.at("stopped"), true);
    EXPECT_EQ(report.at("settings").at("frames_asked"), 1000000);
    const auto frames = report.at("frames").get<std::size_t>();
    EXPECT_EQ(lines(states).size(), 1 + (frames + 1) * 1006);
  }
}

TEST(Command, ListsTheScenesThatShip) {
  const CommandResult table = poise_command({"scenes"});
  EXPECT_EQ(table.exit_code, 0) << table.error;
  for (const char* name : {"boulder", "bullets", "two-body", "pile", "gas", "jacks", "real-meshes", "pour",
                           "metropolis", "gallery", "billiards", "avalanche", "street", "maze"}) {
    EXPECT_NE(table.out.find(name), std::string::npos) << name;
  }
  const json list = json::parse(poise_command({"scenes", "--json"}).out, nullptr, false);
  ASSERT_TRUE(list.is_array());
  EXPECT_EQ(list.size(), 14U);
  EXPECT_EQ(list.at(5).at("name"), "gas");
  EXPECT_EQ(list.at(5).at("bodies"), 1006);
}

TEST(Command, HelpsAndTellsItsVersion) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--help"}, {"run", "--help"}, {"scenes", "--help"}, {"--version"}}) {
    const CommandResult result = poise_command(arguments);
    EXPECT_EQ(result.exit_code, 0) << arguments.back();
    EXPECT_NE(result.out.find("poise"), std::string::npos);
  }
  EXPECT_NE(poise_command({"run", "--help"}).out.find("Examples:"), std::string::npos);
}

}  // namespace
}  // namespace poise::testing
