// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <map>
#include <random>
#include <thread>

#include "app/program.h"
#include "faults/left_files.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using Clock = std::chrono::steady_clock;

/// A number from the environment, which cmake/faults.sh sets.
std::uint64_t setting(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

std::vector<std::string> small_run(const std::string& folder) {
  std::vector<std::string> words{"run",
                                 "gas",
                                 "--bodies",
                                 "250",
                                 "--frames",
                                 "400",
                                 "--clock",
                                 "work",
                                 "--quiet",
                                 "--threads",
                                 "2",
                                 "--capture-contacts",
                                 "--picture-size",
                                 "320x180"};
  const std::vector<std::string> outputs = all_outputs(folder);
  words.insert(words.end(), outputs.begin(), outputs.end());
  return words;
}

/// What came of the moments of one signal.
struct Tally {
  int moments = 0, ended_before = 0, with_json = 0, with_record = 0, with_capture = 0, parts = 0;
  std::uint64_t frames = 0;
};

/// What a run that was told to end must have left: all or nothing, by its exit code.
void expect_ended(const LeftFiles& left, int exit_code, int signal) {
  EXPECT_TRUE(left.parts.empty()) << left.parts.front();
  if (!left.json) {
    EXPECT_EQ(exit_code, 128 + signal) << "nothing is there, because the signal came before the first frame";
    EXPECT_FALSE(left.record.has_value() || left.frames_csv.has_value() || left.states.has_value());
    return;
  }
  EXPECT_TRUE(exit_code == 0 || exit_code == 128 + signal) << exit_code;
  EXPECT_GT(left.json_frames.value(), 0U) << "the files of no frame are worth less than those that were there";
  EXPECT_EQ(left.frames_csv, left.json_frames);
  EXPECT_EQ(left.record, left.json_frames);
  EXPECT_EQ(left.states, left.json_frames.value() + 1) << "the start counts";
  EXPECT_EQ(left.capture, left.json_frames.value() + 1);
  EXPECT_TRUE(left.record_whole && left.capture_whole);
}

// A run whose files all have older ones in their places gets a signal at a random moment, from before its first file to
// after its last.
TEST(Kill, AtAnyMomentLeavesWholeFilesOrSuchThatOpenUpToWhereTheyEnd) {
  const std::uint64_t moments = setting("POISE_FAULT_MOMENTS", 30);
  const std::uint64_t seed = setting("POISE_FAULT_SEED", 1);
  std::mt19937_64 random(seed);
  Clock::duration whole{};
  {
    const TemporaryFolder folder;
    const Clock::time_point begin = Clock::now();
    Program program(folder.path(), small_run(folder.path()));
    ASSERT_EQ(program.wait(), 0) << program.error();
    whole = Clock::now() - begin;
    const LeftFiles left = read_left_files(folder.path());
    ASSERT_TRUE(left.problems.empty()) << left.problems.front();
    expect_ended(left, 0, SIGTERM);
  }
  std::map<int, Tally> tallies;
  const TemporaryFolder used;
  for (std::uint64_t i = 0; i < moments; ++i) {
    const int signal = std::array{SIGKILL, SIGTERM, SIGINT}[i % 3];
    const double share = std::uniform_real_distribution<double>(0, 1.1)(random);
    SCOPED_TRACE(fmt::format("moment {}, signal {}, at {:.3f} of a run; POISE_FAULT_SEED={}", i, signal, share, seed));
    // Every other moment in a folder where others left their files.
    const TemporaryFolder fresh;
    const TemporaryFolder& folder = i % 2 == 0 ? fresh : used;
    if (&folder == &used && signal != SIGKILL) {
      for (const auto& entry : std::filesystem::directory_iterator(used.path())) std::filesystem::remove(entry.path());
    }
    Program program(folder.path(), small_run(folder.path()));
    std::this_thread::sleep_for(std::chrono::duration_cast<Clock::duration>(whole * share));
    Tally& tally = tallies[signal];
    ++tally.moments;
    tally.ended_before += program.ended() ? 1 : 0;
    program.signal(signal);
    const int exit_code = program.wait();
    const LeftFiles left = read_left_files(folder.path());
    for (const std::string& problem : left.problems) ADD_FAILURE() << problem;
    if (signal != SIGKILL) expect_ended(left, exit_code, signal);
    // After SIGKILL the others may have their files from an earlier run.
    if (signal == SIGKILL && &folder == &used) continue;
    tally.with_json += left.json ? 1 : 0;
    tally.with_record += left.record || left.record_part ? 1 : 0;
    tally.with_capture += left.capture ? 1 : 0;
    tally.parts += static_cast<int>(left.parts.size());
    tally.frames += left.record.value_or(left.record_part.value_or(0));
  }
  for (const auto& [signal, t] : tallies) {
    fmt::print(
        "signal {}: {} moments, {} after the end; JSON {}, record {}, capture {}, .part {}; {} frames a record\n",
        signal, t.moments, t.ended_before, t.with_json, t.with_record, t.with_capture, t.parts,
        t.with_record > 0 ? t.frames / static_cast<std::uint64_t>(t.with_record) : 0);
  }
  // What killed runs left goes with the next that is written to its end.
  Program program(used.path(), small_run(used.path()));
  EXPECT_EQ(program.wait(), 0) << program.error();
  const LeftFiles left = read_left_files(used.path());
  for (const std::string& problem : left.problems) ADD_FAILURE() << problem;
  expect_ended(left, 0, SIGTERM);
}

/// Waits until `there` says so, or for so long that a program that works was there before.
bool wait_until(Program& program, const std::function<bool()>& there) {
  const Clock::time_point latest = Clock::now() + std::chrono::minutes(5);
  while (!there()) {
    if (program.ended() || Clock::now() > latest) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

std::string part_of(const TemporaryFolder& folder, const std::string& name) {
  return folder.file("." + name + ".0.part");
}

// Of a paced run another thread writes the states. Two bodies fill no block in the time of a test: what is in the files
// has come there by its time.
TEST(Kill, LeavesRecordAndStatesAsTheyGrowUntilTheNextRun) {
  for (const bool paced : {false, true}) {
    const TemporaryFolder folder;
    std::vector<std::string> words{
        "run",      paced ? "two-body" : "gas", "--quiet", "--record", folder.file("run.poise"),
        "--states", folder.file("states.csv"),  "--frames"};
    std::vector<std::string> long_run = words;
    long_run.emplace_back("200000");
    if (paced) long_run.emplace_back("--paced");
    {
      Program program(folder.path(), long_run);
      std::uintmax_t size = 0;
      int grown = 0;
      ASSERT_TRUE(wait_until(program, [&] {
        std::error_code none;
        const auto bytes = std::filesystem::file_size(part_of(folder, "states.csv"), none);
        if (!none && bytes > size) {
          size = bytes;
          ++grown;
        }
        // More than what begins the file: its head and the first frame.
        return grown > 3 && std::filesystem::file_size(part_of(folder, "run.poise"), none) > 2'000;
      })) << program.error();
      program.signal(SIGKILL);
      EXPECT_EQ(program.wait(), 128 + SIGKILL);
      if (paced) {
        EXPECT_LT(size, 262'144U) << "a block was full, so that nothing is known of times";
      }
    }
    const LeftFiles killed = read_left_files(folder.path());
    EXPECT_EQ(killed.parts.size(), 2U);
    EXPECT_TRUE(killed.problems.empty()) << killed.problems.front();
    EXPECT_GT(killed.record_part.value_or(0), 3U);
    EXPECT_GT(killed.states_part.value_or(0), 3U);
    words.emplace_back("3");
    Program again(folder.path(), words);
    EXPECT_EQ(again.wait(), 0) << again.error();
    const LeftFiles left = read_left_files(folder.path());
    EXPECT_TRUE(left.parts.empty()) << left.parts.front();
    EXPECT_EQ(left.record, 3U);
    EXPECT_EQ(left.states, 4U);
  }
}

/// In a name space of its own: no /proc, without which a file that has no name cannot get one. Ends the new process
/// with 77 where that is not permitted.
void hide_proc() {
  const bool own = ::unshare(CLONE_NEWNS) == 0 && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
  if (!own || ::mount("tmpfs", "/proc", "tmpfs", 0, "size=64k") != 0) ::_exit(77);
}

// As on a file system that has no files without a name.
TEST(Kill, WhereAllFilesHaveATemporaryNameASignalLeavesNoneOfThem) {
  for (const int signal : {SIGTERM, SIGKILL, SIGINT}) {
    const TemporaryFolder folder;
    const auto run = [&](const char* frames) {
      std::vector<std::string> words{"run", "gas", "--bodies", "50", "--quiet", "--frames", frames};
      const std::vector<std::string> outputs = all_outputs(folder.path());
      words.insert(words.end(), outputs.begin(), outputs.end());
      return words;
    };
    Program program(folder.path(), run("100000"), hide_proc);
    const bool begun = wait_until(program, [&] {
      std::error_code none;
      const auto bytes = std::filesystem::file_size(part_of(folder, "run.poise"), none);
      return !none && bytes > 20'000;
    });
    if (program.ended() && program.wait() == 77) GTEST_SKIP() << "/proc can be hidden by root alone";
    ASSERT_TRUE(begun) << program.error();
    EXPECT_TRUE(std::filesystem::exists(part_of(folder, "run.json"))) << "it has a temporary name";
    program.signal(signal);
    EXPECT_EQ(program.wait(), 128 + signal) << program.error();
    if (signal != SIGKILL) {
      expect_ended(read_left_files(folder.path()), 128 + signal, signal);
      continue;
    }
    EXPECT_GE(read_left_files(folder.path()).parts.size(), 7U);
    // The next run takes their places, and leaves nothing of them.
    Program again(folder.path(), run("3"), hide_proc);
    EXPECT_EQ(again.wait(), 0) << again.error();
    expect_ended(read_left_files(folder.path()), 0, signal);
  }
}

TEST(Kill, AnExportThatIsStoppedLeavesWholePicturesAlone) {
  const TemporaryFolder folder;
  const std::string capture = folder.file("c"), film = folder.file("film");
  {
    Program program(folder.path(), {"run", "two-body", "--frames", "300", "--quiet", "--capture", capture});
    ASSERT_EQ(program.wait(), 0) << program.error();
  }
  for (const int signal : {SIGTERM, SIGINT}) {
    Program program(folder.path(), {"export", capture, "--frames-dir", film, "--picture", folder.file("last.png")});
    ASSERT_TRUE(wait_until(program, [&] { return std::filesystem::exists(film + "/frame-000001.png"); }))
        << program.error();
    program.signal(signal);
    EXPECT_EQ(program.wait(), 128 + signal) << program.error();
    EXPECT_NE(program.error().find("files that were not complete were not written"), std::string::npos)
        << program.error();
    for (const auto& entry : std::filesystem::directory_iterator(film)) {
      EXPECT_TRUE(contents(entry.path()).ends_with("IEND\xae\x42\x60\x82")) << entry.path();
    }
    EXPECT_FALSE(std::filesystem::exists(folder.file("last.png")));
    std::filesystem::remove_all(film);
  }
}

// Two runs of the same files at once: neither takes the other's for one that was left.
TEST(Kill, ALivingRunKeepsItsPartsFromAnother) {
  const TemporaryFolder folder, other;
  const std::string record = folder.file("run.poise");
  const auto run = [&](const char* frames) {
    return std::vector<std::string>{"run", "gas", "--bodies", "50", "--quiet", "--record", record, "--frames", frames};
  };
  Program living(folder.path(), run("200000"));
  ASSERT_TRUE(wait_until(living, [&] { return std::filesystem::exists(part_of(folder, "run.poise")); }));
  Program second(other.path(), run("3"));
  EXPECT_EQ(second.wait(), 0) << second.error();
  EXPECT_EQ(read_left_files(folder.path()).record, 3U);
  EXPECT_TRUE(std::filesystem::exists(part_of(folder, "run.poise")));
  living.signal(SIGTERM);
  EXPECT_EQ(living.wait(), 128 + SIGTERM) << living.error();
  const LeftFiles left = read_left_files(folder.path());
  EXPECT_TRUE(left.record_whole);
  EXPECT_TRUE(left.parts.empty()) << left.parts.front();
}

}  // namespace
}  // namespace poise::testing
