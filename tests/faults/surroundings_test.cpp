// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/program.h"
#include "faults/left_files.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string state_hash(const std::string& file) {
  return json::parse(contents(file), nullptr, false).value("state_hash", "");
}

/// A scene of one torus, whose trees take a while.
std::string torus_scene(const TemporaryFolder& folder, int depth) {
  const std::string file = folder.file("torus.json");
  std::ofstream(file)
      << R"({"name": "torus", "dt_s": 0.01, "materials": {"m": {}}, "shapes": {"t": {"mesh": {"file": ")"
      << POISE_SOURCE_DIR << R"(/scenes/meshes/torus.obj", "depth": )" << depth << R"(}}},
    "bodies": [{"shape": "t", "material": "m"}, {"shape": "t", "material": "m", "position_m": [3, 0, 0]}]})";
  return file;
}

// Another process removes the folder again and again while trees are built and put there.
TEST(Surroundings, ACacheThatIsRemovedWhileRunningChangesNoResult) {
  const TemporaryFolder folder;
  const std::string scene = torus_scene(folder, 2), cache = folder.file("cache");
  const auto words = [&](const std::string& out) {
    return std::vector<std::string>{"run",     scene,    "--frames", "20",           "--clock", "work",
                                    "--quiet", "--json", out,        "--tree-cache", cache};
  };
  Program first(folder.path(), words(folder.file("first.json")));
  ASSERT_EQ(first.wait(), 0) << first.error();
  for (int i = 0; i < 2; ++i) {
    const std::string out = folder.file("again.json");
    Program program(folder.path(), words(out));
    while (!program.ended()) {
      std::error_code ignored;
      fs::remove_all(cache, ignored);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(program.wait(), 0) << program.error();
    EXPECT_EQ(state_hash(out), state_hash(folder.file("first.json")));
  }
}

TEST(Surroundings, ASignalWhileTreesAreBuiltLeavesNothing) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const TemporaryFolder folder, outputs;
    std::vector<std::string> words{"run", torus_scene(folder, 6), "--tree-cache", "off"};
    const std::vector<std::string> files = all_outputs(outputs.path());
    words.insert(words.end(), files.begin(), files.end());
    Program program(folder.path(), words);
    // The record is the last file that is opened before trees are built, which takes minutes at this depth.
    while (!program.ended() && !fs::exists(outputs.file(".run.poise.0.part")))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    program.signal(signal);
    EXPECT_EQ(program.wait(), 128 + signal) << program.error();
    EXPECT_NE(program.error().find("poise run: stopped by " + std::string(signal == SIGINT ? "Ctrl-C" : "SIGTERM") +
                                   "; nothing was written"),
              std::string::npos)
        << program.error();
    EXPECT_EQ(outputs.entries(), 0U);
  }
}

// As when the other processors are taken offline: the system moves all threads to one that is left.
// However early, and whichever thread of the step asks for it.
TEST(Surroundings, MemoryThatRunsOutEndsARunWithAMessage) {
  const TemporaryFolder folder;
  for (const rlim_t limit_mb : {150U, 400U}) {
    const rlimit limit{limit_mb << 20U, limit_mb << 20U};
    Program program(folder.path(),
                    {"run", "jacks", "--bodies", "8000", "--frames", "20", "--deadline", "4", "--json",
                     folder.file("run.json"), "--record", folder.file("run.record")},
                    [&] { setrlimit(RLIMIT_AS, &limit); });
    EXPECT_EQ(program.wait(), 3) << program.error();
    EXPECT_NE(program.error().find("poise: memory: "), std::string::npos) << program.error();
    EXPECT_FALSE(fs::exists(folder.file("run.json")));
    EXPECT_TRUE(read_left_files(folder.path()).problems.empty());
  }
}

TEST(Surroundings, AProcessorThatIsTakenAwayChangesNoResult) {
  cpu_set_t all;
  ASSERT_EQ(::sched_getaffinity(0, sizeof all, &all), 0);
  if (CPU_COUNT(&all) < 2) GTEST_SKIP() << "one processor";
  std::size_t last = 0;
  for (std::size_t i = 0; i < CPU_SETSIZE; ++i) last = CPU_ISSET(i, &all) ? i : last;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(last, &one);
  const TemporaryFolder folder;
  const auto words = [&](const char* out) {
    return std::vector<std::string>{
        "run",     "gas",  "--bodies", "300",    "--frames",       "300",      "--threads",     "2",
        "--clock", "work", "--quiet",  "--json", folder.file(out), "--record", folder.file("r")};
  };
  Program whole(folder.path(), words("whole.json"));
  ASSERT_EQ(whole.wait(), 0) << whole.error();
  fs::remove(folder.file("r"));
  Program program(folder.path(), words("less.json"));
  // In its frames, whose first is in the record at once.
  std::error_code none;
  while (!program.ended() &&
         (!fs::exists(folder.file(".r.0.part")) || fs::file_size(folder.file(".r.0.part"), none) == 0))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  int moved = 0;
  for (const auto& thread : fs::directory_iterator("/proc/" + std::to_string(program.id()) + "/task", none))
    moved += ::sched_setaffinity(std::stoi(thread.path().filename()), sizeof one, &one) == 0 ? 1 : 0;
  EXPECT_GE(moved, 2);
  EXPECT_EQ(program.wait(), 0) << program.error();
  EXPECT_EQ(state_hash(folder.file("less.json")), state_hash(folder.file("whole.json")));
}

// A clock that can be set is read nowhere but for the times of files: deadlines, releases and figures are of the steady
// one, which does not jump.
TEST(Surroundings, NoSourceReadsAClockThatCanBeSet) {
  for (const char* room : {"src", "include", "scheduler", "bench"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(POISE_SOURCE_DIR) / room)) {
      const std::string ending = entry.path().extension().string();
      if (ending != ".cpp" && ending != ".h") continue;
      const std::string text = contents(entry.path());
      for (const char* clock : {"system_clock", "high_resolution_clock", "gettimeofday", "clock_gettime(CLOCK_REALTIME",
                                "::time(nullptr)", "utc_clock"})
        EXPECT_EQ(text.find(clock), std::string::npos) << entry.path() << ": " << clock;
    }
  }
}

}  // namespace
}  // namespace poise::testing
