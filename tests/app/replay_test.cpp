// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

/// A recorded run with the wall clock; returns its report.
json recorded_run(const std::string& file, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "run");
  arguments.insert(arguments.end(), {"--record", file, "--json", "-", "--quiet"});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return json::parse(result.out, nullptr, false);
}

json replayed(const std::string& file, std::vector<std::string> arguments, int exit_code = 0) {
  arguments.insert(arguments.begin(), {"replay", file});
  arguments.insert(arguments.end(), {"--json", "-", "--quiet"});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, exit_code) << result.error;
  return json::parse(result.out, nullptr, false);
}

void put(const std::string& file, const std::string& bytes) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

const std::vector<std::string> kJacks{"jacks", "--bodies", "60", "--frames", "60", "--warmup", "20", "--deadline", "1"};

TEST(Replay, GivesTheStateOfTheWallClockRunOnAnyThreadsAndExecutor) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--threads", "4", "--executor", "threads"},
        std::vector<std::string>{"--threads", "2", "--contact", "paper", "--sleeping", "--seed", "9"}}) {
    std::vector<std::string> arguments = kJacks;
    arguments.insert(arguments.end(), more.begin(), more.end());
    const json run = recorded_run(file, arguments);
    for (const std::vector<std::string>& how : {std::vector<std::string>{"--threads", "1"},
                                                std::vector<std::string>{"--threads", "3", "--executor", "threads"},
                                                std::vector<std::string>{"--executor", "serial"}}) {
      const json replay = replayed(file, how);
      EXPECT_EQ(replay.at("schema"), "poise.replay/2");
      EXPECT_EQ(replay.at("state_hash"), run.at("state_hash"));
      EXPECT_EQ(replay.at("frames"), 80) << "warm-up included";
      EXPECT_EQ(replay.at("same"), true);
      EXPECT_EQ(replay.at("whole"), true);
    }
  }
}

TEST(Replay, WritesTheStatesOfTheRun) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  std::vector<std::string> arguments = kJacks;
  arguments.insert(arguments.end(), {"--states", folder.file("run.csv")});
  recorded_run(file, arguments);
  replayed(file, {"--states", folder.file("again.csv")});
  EXPECT_EQ(contents(folder.file("again.csv")), contents(folder.file("run.csv")));
  EXPECT_GT(lines(contents(folder.file("run.bodies.csv"))).size(), 30U);
  EXPECT_EQ(contents(folder.file("again.bodies.csv")), contents(folder.file("run.bodies.csv")));
  EXPECT_GT(contents(folder.file("again.csv")).size(), 100000U);
}

TEST(Replay, OfADamagedRecordGoesUpToTheDamageAndSaysWhere) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  recorded_run(file, kJacks);
  const std::string whole = contents(file);
  put(file, whole.substr(0, whole.size() - 20));
  const CommandResult cut = poise_command({"replay", file});
  EXPECT_EQ(cut.exit_code, 3);
  EXPECT_NE(cut.out.find("the state the same to the bit after each"), std::string::npos) << cut.out;
  EXPECT_NE(cut.out.find("DAMAGED after "), std::string::npos);
  EXPECT_NE(cut.error.find("poise replay: " + file + ": damaged at byte "), std::string::npos) << cut.error;
  std::string changed = whole;
  changed[changed.size() / 2] = static_cast<char>(changed[changed.size() / 2] + 1);
  put(file, changed);
  const json replay = replayed(file, {}, 3);
  EXPECT_EQ(replay.at("same"), true);
  EXPECT_EQ(replay.at("whole"), false);
  EXPECT_LT(replay.at("frames"), 80);
  EXPECT_LE(replay.at("damage").at("byte"), whole.size() / 2);
  EXPECT_EQ(replay.at("damage").at("after_frames"), replay.at("frames"));
  put(file, "poise");
  const CommandResult none = poise_command({"replay", file});
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_EQ(none.error, "poise replay: " + file + ": not a record of poise run --record\n");
}

TEST(Replay, ExplainsAFrameAsTheReportCountsIt) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  std::vector<std::string> arguments = kJacks;
  // A budget of counted work leaves pairs coarse on any machine.
  arguments.erase(arguments.end() - 2, arguments.end());
  arguments.insert(arguments.end(),
                   {"--clock", "work", "--budget-work", "8", "--frames-csv", folder.file("frames.csv")});
  recorded_run(file, arguments);
  const json explain = replayed(file, {"--explain", "70"}).at("explain");
  const std::vector<std::string> rows = lines(contents(folder.file("frames.csv")));
  const std::vector<std::string> names = cells(rows.at(0));
  const auto cell = [&](const std::string& name) {
    const auto column = std::find(names.begin(), names.end(), name) - names.begin();
    return std::stoul(cells(rows.at(71)).at(static_cast<std::size_t>(column)));
  };
  EXPECT_EQ(cell("frame"), 70U);
  EXPECT_EQ(explain.at("frame"), 70);
  EXPECT_EQ(explain.at("active_pairs").get<std::size_t>() + explain.at("pairs_apart").get<std::size_t>(),
            cell("coarse_pairs"));
  EXPECT_EQ(explain.at("refined").size(), cell("jobs_done"));
  EXPECT_EQ(explain.at("left_coarse").size(), cell("pairs_left"));
  EXPECT_GT(explain.at("refined").size(), 0U);
  EXPECT_GT(explain.at("left_coarse").size(), 0U);
  EXPECT_EQ(explain.at("pairs").at("unserved"), cell("pairs_left"));
  std::size_t pairs = 0;
  for (const json& count : explain.at("pairs")) pairs += count.get<std::size_t>();
  EXPECT_EQ(pairs, cell("coarse_pairs")) << "each pair has one fate";
  std::size_t order = 0;
  std::uint64_t units = 0;
  for (const json& row : explain.at("refined")) {
    EXPECT_EQ(row.at("order"), ++order);
    units += row.at("units").get<std::uint64_t>();
    EXPECT_GT(row.at("weight"), 0);
    EXPECT_LT(row.at("a"), row.at("b"));
  }
  EXPECT_EQ(units, cell("work_refine"));
  // Rounds are in order of score, so the score of the first completed level is not below that of any level left before
  // it.
  for (const json& row : explain.at("left_coarse"))
    EXPECT_LE(row.at("next_score"), explain.at("left_coarse").at(0).at("next_score"));
  const CommandResult shown = poise_command({"replay", file, "--explain", "70", "--limit", "3"});
  EXPECT_EQ(shown.exit_code, 0) << shown.error;
  EXPECT_NE(shown.out.find(" (3 of "), std::string::npos) << shown.out;
  for (const char* part : {"frame 70: ", "pairs by what became of them", "refined, in the order",
                           "left coarse, the highest score first", "closing m/s", "budget used up"}) {
    EXPECT_NE(shown.out.find(part), std::string::npos) << part;
  }
}

TEST(Replay, ExplainsWhyAFrameWasLateWithTheTimesOfItsStages) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  // No frame can be done in a microsecond, so all of them are late.
  const CommandResult run = poise_command({"run", "jacks", "--bodies", "60", "--frames", "6", "--warmup", "40",
                                           "--deadline", "0.001", "--record", file, "--json", folder.file("run.json")});
  ASSERT_EQ(run.exit_code, 0) << run.error;
  const json worst = json::parse(contents(folder.file("run.json"))).at("worst_frames");
  ASSERT_EQ(worst.size(), 5U);
  const auto frame = worst.at(0).at("frame").get<std::uint64_t>();
  EXPECT_GE(frame, 40U) << "warm-up is counted, and is not in the list";
  EXPECT_GE(worst.at(0).at("late_ms"), worst.at(4).at("late_ms"));
  const std::string command = "poise replay " + file + " --explain " + std::to_string(frame);
  EXPECT_NE(run.out.find(command), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("worst frames"), std::string::npos);

  const json explain = replayed(file, {"--explain", std::to_string(frame)}).at("explain");
  EXPECT_EQ(explain.at("lateness_ms"), worst.at(0).at("late_ms"));
  const json& times = explain.at("times");
  EXPECT_EQ(times.at("cause"), worst.at(0).at("cause"));
  EXPECT_EQ(times.at("stage_ms").at(worst.at(0).at("stage").get<std::string>()), worst.at(0).at("stage_ms"));
  EXPECT_EQ(times.at("stage_ms").size(), 8U);
  const CommandResult shown = poise_command({"replay", file, "--explain", std::to_string(frame)});
  EXPECT_NE(shown.out.find("late by "), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find(" ms: " + times.at("cause").get<std::string>() + ", "), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find("stages in ms: predict "), std::string::npos) << shown.out;
}

TEST(Replay, ExplainsAFrameWhoseStepDidNotEndInIt) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  // No step of as many bodies ends in a microsecond: the first frame begins it.
  const CommandResult run = poise_command({"run", "jacks", "--bodies", "1000", "--frames", "4", "--deadline", "0.001",
                                           "--policy", "fifo", "--record", file});
  ASSERT_EQ(run.exit_code, 0) << run.error;
  const json explain = replayed(file, {"--explain", "0"}).at("explain");
  ASSERT_TRUE(explain.at("unfinished"));
  EXPECT_GT(explain.at("lateness_ms"), 0);
  EXPECT_EQ(explain.at("policy"), "fifo");
  EXPECT_TRUE(explain.at("active_pairs").is_null());
  const CommandResult shown = poise_command({"replay", file, "--explain", "0"});
  const std::string late = " ms: " + explain.at("times").at("cause").get<std::string>() + ", ";
  for (const std::string& part : {std::string("its step did not end in it"), std::string("late by "), late,
                                  std::string("stages in ms: predict ")}) {
    EXPECT_NE(shown.out.find(part), std::string::npos) << part << " in " << shown.out;
  }
}

TEST(Replay, SaysThatARunByWorkHasNoTimes) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  recorded_run(file, {"two-body", "--frames", "3", "--clock", "work"});
  EXPECT_TRUE(replayed(file, {"--explain", "1"}).at("explain").at("times").is_null());
  const CommandResult shown = poise_command({"replay", file, "--explain", "1"});
  EXPECT_NE(shown.out.find("times: none, since the run counted work\n"), std::string::npos) << shown.out;
}

TEST(Replay, ExplainsAFrameFromWhereItsCameraWas) {
  const TemporaryFolder folder;
  // Two bodies that touch, one of which spins; the camera turns away from them within half a second.
  put(folder.file("scene.json"),
      R"({"name": "t", "dt_s": 0.01, "frames": 100, "materials": {"m": {}},
          "camera": {"path": [{"time_s": 0, "position_m": [0, -9, 0], "look_at_m": [0, 0, 0]},
                              {"time_s": 0.5, "position_m": [0, -9, 0], "look_at_m": [1, -18, 0]}]},
          "shapes": {"two": {"spheres": {"centers_m": [[0, 0, 0], [1, 0, 0]], "radii_m": [0.5, 0.5]}}},
          "bodies": [{"shape": "two", "material": "m"}, {"shape": "two", "material": "m", "position_m": [1.9, 0, 0], "angular_velocity_radps": [20, 0, 0]}]})");
  const std::string file = folder.file("run.poise");
  recorded_run(file, {folder.file("scene.json"), "--clock", "work"});
  const auto visibility_in = [&file](const char* frame) {
    const json refined = replayed(file, {"--explain", frame}).at("explain").at("refined");
    EXPECT_FALSE(refined.empty()) << frame;
    return refined.empty() ? -1.0 : refined.at(0).at("cues").at("visibility").get<double>();
  };
  EXPECT_EQ(visibility_in("0"), 1);
  EXPECT_EQ(visibility_in("90"), 0.05);
}

TEST(Replay, OfAFrameThatIsNotThereIsRefused) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  recorded_run(file, {"two-body", "--frames", "5"});
  const CommandResult result = poise_command({"replay", file, "--explain", "5"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.error.find("--explain 5: the record ends after frame 4"), std::string::npos) << result.error;
  EXPECT_EQ(poise_command({"replay", file, "--explain", "4"}).exit_code, 0);
}

TEST(Replay, RefusesAMeshThatHasChangedAndFindsOneThatHasMoved) {
  const TemporaryFolder folder;
  const std::string mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  put(folder.file("tetra.obj"), mesh);
  put(folder.file("scene.json"),
      R"({"name": "t", "dt_s": 0.01, "gravity_mps2": [0, 0, -10], "frames": 20, "materials": {"m": {}},
          "shapes": {"tetra": {"mesh": {"file": "tetra.obj", "depth": 0}}, "floor": {"plane": {"normal": [0, 0, 1], "offset_m": 0}}},
          "bodies": [{"shape": "floor", "material": "m", "static": true}, {"shape": "tetra", "material": "m", "position_m": [0, 0, 0.05]}]})");
  const std::string file = folder.file("run.poise");
  const json run = recorded_run(file, {folder.file("scene.json"), "--max-level", "polygons"});
  EXPECT_EQ(replayed(file, {}).at("state_hash"), run.at("state_hash"));
  std::filesystem::remove(folder.file("scene.json"));
  EXPECT_EQ(replayed(file, {}).at("state_hash"), run.at("state_hash")) << "the scene is in the record";
  const TemporaryFolder elsewhere;
  std::filesystem::rename(folder.file("tetra.obj"), elsewhere.file("tetra.obj"));
  EXPECT_EQ(poise_command({"replay", file}).exit_code, 3);
  EXPECT_EQ(replayed(file, {"--files", elsewhere.path().string()}).at("state_hash"), run.at("state_hash"));
  put(folder.file("tetra.obj"), mesh + "# changed\n");
  const CommandResult changed = poise_command({"replay", file});
  EXPECT_EQ(changed.exit_code, 3);
  EXPECT_NE(changed.error.find("tetra.obj is another file than when the run was recorded"), std::string::npos)
      << changed.error;
}

TEST(Replay, RefusesOptionsThatDoNotGoTogether) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  recorded_run(file, {"two-body", "--frames", "3"});
  EXPECT_EQ(poise_command({"replay", file, "--limit", "3"}).exit_code, 2);
  EXPECT_EQ(poise_command({"replay", file, "--explain", "1", "--frames", "2"}).exit_code, 2);
  const CommandResult over = poise_command({"replay", file, "--states", file});
  EXPECT_EQ(over.exit_code, 2);
  EXPECT_NE(over.error.find("would overwrite the file that is read as RECORD"), std::string::npos) << over.error;
  EXPECT_EQ(poise_command({"replay"}).exit_code, 2);
  EXPECT_EQ(poise_command({"run", "two-body", "--record", "-"}).exit_code, 2);
  EXPECT_EQ(poise_command({"run", "two-body", "--record", folder.file("no/such/run")}).exit_code, 4);
  EXPECT_EQ(replayed(file, {"--frames", "2"}).at("frames"), 2);
  EXPECT_EQ(replayed(file, {"--frames", "1..2"}).at("frames"), 2);
  const auto refused = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"replay", file, "--quiet"});
    const CommandResult result = poise_command(arguments);
    return std::to_string(result.exit_code) + " " + result.error;
  };
  EXPECT_EQ(refused({"--frame", "2"}), "2 poise replay: --frame needs --picture\n");
  EXPECT_EQ(refused({"--frame", "2", "--picture", "a.png", "--frames", "2"}),
            "2 poise replay: --frame and --frames cannot both be given\n");
  EXPECT_EQ(refused({"--frame", "2", "--picture", "a.png", "--explain", "2"}),
            "2 poise replay: --frame and --explain cannot both be given\n");
  EXPECT_EQ(refused({"--frames-every", "2"}), "2 poise replay: --frames-every needs --frames-dir\n");
  for (const char* wrong : {"0", "x", "2..1", "..", "1000001"}) {
    EXPECT_EQ(refused({"--frames", wrong}), std::string("2 poise replay: --frames = ") + wrong +
                                                ", must be N >= 1, A..B, A.. or ..B with whole A <= B, at most "
                                                "1000000\n");
  }
  EXPECT_EQ(refused({"--states", "a.csv", "--json", "a.bodies.csv"}),
            "2 poise replay: a.bodies.csv is named for two outputs: --json and the bodies of --states\n");
  EXPECT_EQ(refused({"--report", "-"}), "2 poise replay: --report must be a folder\n");
  EXPECT_EQ(refused({"--capture-pairs"}), "2 poise replay: --capture-pairs needs --capture\n");
  EXPECT_EQ(refused({"--frame", "9", "--picture", folder.file("a.png")}),
            "3 poise replay: --frame 9: the record ends with frame 3\n");
  EXPECT_EQ(refused({"--frames", "7..9", "--frames-dir", folder.file("film")}),
            "3 poise replay: --frames 7..9: the record ends with frame 3\n");
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.png")));
}

TEST(Replay, DrawsAndCapturesTheFramesOfTheRunThatAreAskedFor) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  const std::vector<std::string> size{"--picture-size", "160x96"};
  const auto with_size = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), size.begin(), size.end());
    return arguments;
  };
  recorded_run(file, with_size({"jacks", "--bodies", "30", "--frames", "60", "--deadline", "1", "--picture",
                                folder.file("run.png"), "--capture", folder.file("run.capture")}));
  replayed(file, with_size({"--picture", folder.file("last.png")}));
  EXPECT_EQ(contents(folder.file("last.png")), contents(folder.file("run.png")));
  EXPECT_EQ(replayed(file, with_size({"--frame", "50", "--picture", folder.file("50.png")})).at("frames"), 50);
  replayed(file, with_size({"--frames", "40..50", "--frames-every", "5", "--frames-dir", folder.file("film"),
                            "--capture", folder.file("part.capture")}));
  EXPECT_EQ(contents(folder.file("film/frame-000050.png")), contents(folder.file("50.png")));
  EXPECT_TRUE(std::filesystem::exists(folder.file("film/frame-000040.png")));
  EXPECT_FALSE(std::filesystem::exists(folder.file("film/frame-000041.png")));
  EXPECT_FALSE(std::filesystem::exists(folder.file("film/frame-000035.png")));
  // The part says of its frames what the capture of the run says of them.
  const auto table = [&](const std::string& capture) {
    const CommandResult result = poise_command({"export", capture, "--csv", "-", "--frames", "40..50"});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return lines(result.out);
  };
  const std::vector<std::string> part = table(folder.file("part.capture"));
  const std::vector<std::string> whole = table(folder.file("run.capture"));
  ASSERT_EQ(part.size(), 12U);
  for (const std::size_t row : {1U, 11U}) {
    for (std::size_t column = 0; column < 4; ++column) EXPECT_EQ(cells(part[row])[column], cells(whole[row])[column]);
  }
}

TEST(Replay, CapturesOfBodiesThatSleepWhatTheRunDid) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise"), scene = folder.file("sleep.json");
  std::ofstream(scene) << R"({"name": "sleep", "dt_s": 0.01, "gravity_mps2": [0, 0, -9.81], "sleeping": true,
    "materials": {"m": {"restitution": 0}}, "shapes": {"floor": {"plane": {"normal": [0, 0, 1]}},
    "bar": {"spheres": {"centers_m": [[-0.3, 0, 0], [0.3, 0, 0]], "radii_m": [0.2, 0.2]}}},
    "bodies": [{"shape": "floor", "material": "m", "static": true},
               {"shape": "bar", "material": "m", "position_m": [0, 0, 0.2]}]})";
  recorded_run(file, {scene, "--frames", "200", "--clock", "work", "--capture", folder.file("run.capture")});
  replayed(file, {"--frames", "190..200", "--capture", folder.file("part.capture")});
  const auto drawn = [&](const std::string& name) {
    const CommandResult result =
        poise_command({"export", folder.file(name + ".capture"), "--frame", "195", "--pvd", folder.file(name)});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return contents(folder.file(name + "/frame-000195.vtp"));
  };
  const std::string whole = drawn("run");
  EXPECT_NE(whole.find("level"), std::string::npos);
  EXPECT_EQ(drawn("part"), whole);
}

TEST(Replay, OfCountedWorkSaysThatThePageHasTheTimesOfTheReplay) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  recorded_run(file, {"jacks", "--bodies", "10", "--frames", "5", "--clock", "work"});
  const CommandResult result = poise_command({"replay", file, "--report", folder.file("out")});
  if (result.error.find("is not built") != std::string::npos) GTEST_SKIP() << result.error;
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(
      result.out.find("report.html: its times are those of this replay, since a record with counted work has none"),
      std::string::npos)
      << result.out;
  for (const char* name : {"report.html", "run.capture", "frame-times.svg", "frame-times.png", "percentiles.svg"})
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "out" / name)) << name;
}

TEST(Replay, OfADeadlineMakesThePageWithTheTimesOfTheRun) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  recorded_run(file, {"jacks", "--bodies", "10", "--frames", "5", "--deadline", "5"});
  const CommandResult result =
      poise_command({"replay", file, "--report", folder.file("out"), "--frames", "2..4", "--capture-pairs"});
  if (result.error.find("is not built") != std::string::npos) GTEST_SKIP() << result.error;
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.out.find("its times are those of the recorded run"), std::string::npos) << result.out;
}

TEST(Replay, ARunStoppedByCtrlCLeavesAWholeRecord) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  std::string states;
  const CommandResult stopped = interrupted_command(
      {"run", "gas", "--frames", "1000000", "--record", file, "--states", folder.file("pipe"), "--quiet"},
      folder.file("pipe"), states);
  EXPECT_EQ(stopped.exit_code, 130) << stopped.error;
  const CommandResult replay = poise_command({"replay", file});
  EXPECT_EQ(replay.exit_code, 0) << replay.error;
  EXPECT_NE(replay.out.find("the record is whole; its run was stopped by Ctrl-C"), std::string::npos) << replay.out;
}

}  // namespace
}  // namespace poise::testing
