// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/program.h"
#include "faults/left_files.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

namespace fs = std::filesystem;

/// No file of the program may be larger, whatever the file system is.
void limit_files_to_72_kib() {
  constexpr rlim_t kBytes = 73728;
  const rlimit limit{kBytes, kBytes};
  ::setrlimit(RLIMIT_FSIZE, &limit);
}

bool says(const std::string& error, const std::string& file, const char* reason) {
  return error.find(file + ": cannot be written: " + reason) != std::string::npos;
}

// All outgrow the limit but the JSON; a frame of the states does not. With a budget the record says in each frame who
// was refined: without one it hardly grows once the jacks rest, least where one worker did all.
TEST(Disk, AnOutputThatCannotBeWrittenTakesNothingFromTheOthers) {
  const TemporaryFolder folder;
  std::vector<std::string> words{"run",
                                 "jacks",
                                 "--bodies",
                                 "300",
                                 "--frames",
                                 "300",
                                 "--clock",
                                 "work",
                                 "--budget-work",
                                 "3000",
                                 "--quiet",
                                 "--capture-pairs",
                                 "--capture-contacts"};
  const std::vector<std::string> outputs = all_outputs(folder.path());
  words.insert(words.end(), outputs.begin(), outputs.end());
  Program program(folder.path(), words, limit_files_to_72_kib);
  EXPECT_EQ(program.wait(), 4) << program.error();
  const std::string error = program.error();
  for (const char* file : {"states.csv", "run.poise", "run.capture"})
    EXPECT_TRUE(says(error, file, "File too large")) << error;
  // When it happens, and not at the end alone.
  for (const char* file : {"states.csv", "run.capture"}) {
    EXPECT_NE(
        error.find("poise run: warning: " + folder.file(file) + ": cannot be written: File too large; the run goes"),
        std::string::npos)
        << error;
  }
  EXPECT_NE(error.find("File too large; what was written before is there"), std::string::npos) << error;
  const LeftFiles left = read_left_files(folder.path());
  EXPECT_TRUE(left.problems.empty()) << left.problems.front();
  EXPECT_TRUE(left.parts.empty()) << left.parts.front();
  EXPECT_EQ(left.json_frames, 300U);
  for (const std::optional<std::uint64_t>& frames : {left.states, left.record, left.capture}) {
    EXPECT_GT(frames.value_or(0), 0U) << "whole frames, the first ones";
    EXPECT_LT(frames.value_or(0), 300U);
  }
  for (const char* name : {"states.csv", "run.poise", "run.capture"})
    EXPECT_LE(fs::file_size(folder.file(name)), 73728U);
}

TEST(Disk, ADeviceThatIsFullTakesNothingFromTheOthers) {
  const TemporaryFolder folder;
  Program program(folder.path(), {"run", "two-body", "--frames", "20", "--quiet", "--json", folder.file("run.json"),
                                  "--frames-csv", "/dev/full", "--trace", "/dev/full", "--picture", "/dev/full",
                                  "--record", folder.file("run.poise")});
  EXPECT_EQ(program.wait(), 4);
  const std::string error = program.error();
  // Each is named, in one refusal.
  std::size_t named = 0;
  for (std::size_t at = 0; (at = error.find("/dev/full: cannot be written: No space left", at)) != std::string::npos;
       ++at)
    ++named;
  EXPECT_EQ(named, 3U) << error;
  const LeftFiles left = read_left_files(folder.path());
  EXPECT_EQ(left.json_frames, 20U);
  EXPECT_TRUE(left.record_whole);
}

/// A scene with a warning: its mesh is open.
std::string scene_that_warns(const TemporaryFolder& folder) {
  std::ofstream(folder.file("open.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
  std::ofstream(folder.file("warns.json"))
      << R"({"name":"w","dt_s":0.0166667,"frames":3,"materials":{"m":{}},"shapes":{"b":{"mesh":{"file":"open.obj","depth":1}}},)"
      << R"("bodies":[{"shape":"b","material":"m"}]})";
  return folder.file("warns.json");
}

// What is printed may be lost, results are not; and no file gets what was to be printed.
TEST(Disk, AStandardErrorThatTakesNothingTakesNoResult) {
  const std::pair<const char*, void (*)()> streams[] = {
      {"full", [] { ::dup2(::open("/dev/full", O_WRONLY | O_CLOEXEC), STDERR_FILENO); }},
      {"closed", [] { ::close(STDERR_FILENO); }},
      {"its neighbour closed too",
       [] {
         ::close(STDOUT_FILENO);
         ::close(STDERR_FILENO);
       }},
      {"all closed", [] {
         for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::close(stream);
       }}};
  for (const auto& [name, spoil] : streams) {
    const TemporaryFolder folder;
    std::vector<std::string> words{"run", scene_that_warns(folder), "--quiet"};
    const std::vector<std::string> outputs = all_outputs(folder.path());
    words.insert(words.end(), outputs.begin(), outputs.end());
    Program program(folder.path(), words, spoil);
    EXPECT_EQ(program.wait(), 0) << name;
    const LeftFiles left = read_left_files(folder.path());
    EXPECT_TRUE(left.problems.empty()) << name << ": " << left.problems.front();
    EXPECT_EQ(left.json_frames, 3U) << name;
    EXPECT_TRUE(left.record_whole && left.capture_whole) << name;
  }
}

TEST(Disk, AStandardErrorThatIsFullKeepsTheExitCode) {
  const TemporaryFolder folder;
  Program program(
      folder.path(),
      {"run", "two-body", "--frames", "5", "--quiet", "--json", "/dev/full", "--states", folder.file("states.csv")},
      [] { ::dup2(::open("/dev/full", O_WRONLY | O_CLOEXEC), STDERR_FILENO); });
  EXPECT_EQ(program.wait(), 4);
  EXPECT_EQ(read_left_files(folder.path()).states, 6U);
}

TEST(Disk, ARecordOrACaptureThatTakesNotEvenItsBeginningTakesNothingFromTheOthers) {
  for (const char* full : {"--record", "--capture"}) {
    const TemporaryFolder folder;
    Program program(folder.path(), {"run", "two-body", "--frames", "20", "--quiet", "--json", folder.file("run.json"),
                                    "--states", folder.file("states.csv"), full, "/dev/full"});
    EXPECT_EQ(program.wait(), 4) << full;
    EXPECT_NE(program.error().find("/dev/full: cannot be written: No space left"), std::string::npos) << full;
    const LeftFiles left = read_left_files(folder.path());
    EXPECT_EQ(left.json_frames, 20U) << full;
    EXPECT_EQ(left.states, 21U) << full;
  }
}

TEST(Disk, EveryPathThatCannotBeWrittenIsNamedBeforeTheFirstFrame) {
  const TemporaryFolder folder;
  const std::string record = folder.file("r"), capture = folder.file("c");
  {
    const TemporaryFolder said;
    Program program(said.path(),
                    {"run", "two-body", "--frames", "3", "--quiet", "--record", record, "--capture", capture});
    ASSERT_EQ(program.wait(), 0) << program.error();
  }
  const std::string here = folder.file("states.csv"), no = folder.file("no/a"), none = folder.file("none/b.png");
  const std::vector<std::vector<std::string>> commands{
      {"run", "two-body", "--quiet", "--json", no, "--picture", none, "--states", here},
      {"replay", record, "--quiet", "--json", no, "--picture", none, "--states", here},
      {"export", capture, "--csv", no, "--picture", none, "--gltf", folder.file("here.glb")},
      {"tree", std::string(POISE_SOURCE_DIR) + "/scenes/meshes/torus.obj", "--json", no, "--picture", none, "-o",
       folder.file("here.sph")},
      {"compare", "gas", "--json", no, "--svg", none, "--csv", here}};
  for (const std::vector<std::string>& words : commands) {
    const TemporaryFolder said;
    Program program(said.path(), words);
    EXPECT_EQ(program.wait(), 4) << words.front();
    EXPECT_TRUE(says(program.error(), "no/a", "No such file")) << program.error();
    EXPECT_TRUE(says(program.error(), "none/b.png", "No such file")) << program.error();
    EXPECT_EQ(folder.entries(), 2U) << words.front() << " left something";
  }
}

/// The command fails with one /dev/full, and all other files are written.
void expect_others(const std::vector<std::string>& words, const std::vector<std::string>& others) {
  const TemporaryFolder said;
  Program program(said.path(), words);
  EXPECT_EQ(program.wait(), 4) << program.error();
  EXPECT_NE(program.error().find("/dev/full: cannot be written: No space left"), std::string::npos) << program.error();
  for (const std::string& file : others) EXPECT_TRUE(fs::exists(file) && fs::file_size(file) > 0) << file;
}

TEST(Disk, OfEveryOtherCommandOneFullOutputTakesNothingFromTheOthers) {
  const TemporaryFolder folder;
  const std::string record = folder.file("r"), capture = folder.file("c"), json = folder.file("j.json");
  {
    const TemporaryFolder said;
    Program program(said.path(),
                    {"run", "two-body", "--frames", "70", "--quiet", "--record", record, "--capture", capture});
    ASSERT_EQ(program.wait(), 0) << program.error();
  }
  expect_others(
      {"replay", record, "--quiet", "--states", "/dev/full", "--json", json, "--picture", folder.file("r.png")},
      {json, folder.file("r.png")});
  fs::remove(json);
  expect_others(
      {"export", capture, "--csv", "/dev/full", "--picture", folder.file("e.png"), "--gltf", folder.file("e.glb")},
      {folder.file("e.png"), folder.file("e.glb")});
  expect_others({"tree", std::string(POISE_SOURCE_DIR) + "/scenes/meshes/torus.obj", "--depth", "1", "--picture",
                 "/dev/full", "--json", json, "-o", folder.file("t.sph"), "--quiet"},
                {json, folder.file("t.sph")});
  fs::remove(json);
  expect_others({"compare", "gas", "--bodies", "20", "--policies", "perceptual,fifo", "--budgets", "50%", "--frames",
                 "2", "--csv", "/dev/full", "--svg", folder.file("c.svg"), "--json", json, "--quiet"},
                {json, folder.file("c.svg")});
}

/// In a name space of its own: a small disk at `folder`. Ends the new process with 77 where that is not permitted.
void mount_small_disk(const std::string& folder, const char* options) {
  const bool own = ::unshare(CLONE_NEWNS) == 0 && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
  if (!own || ::mount("tmpfs", folder.c_str(), "tmpfs", 0, options) != 0) ::_exit(77);
}

// All outputs on one disk, which the states fill. The disk goes with the program, so a child of the shell looks at it.
TEST(Disk, AFullDiskLeavesFilesThatOpenUpToWhereTheyEndAndTheJson) {
  const TemporaryFolder folder;
  const std::string disk = folder.file("disk"), copy = folder.file("copy");
  fs::create_directory(disk);
  fs::create_directory(copy);
  std::string words = "'" + std::string(POISE_COMMAND) + "' run gas --bodies 500 --frames 100 --clock work --quiet";
  for (const std::string& word : all_outputs(disk)) words += " '" + word + "'";
  const std::string script = words + "; code=$?; cp -a '" + disk + "/.' '" + copy + "'; exit $code";
  Program shell(folder.path(), {}, [&] {
    mount_small_disk(disk, "size=2m");
    ::execl("/bin/sh", "sh", "-c", script.c_str(), nullptr);
  });
  const int exit_code = shell.wait();
  if (exit_code == 77) GTEST_SKIP() << "a disk can be mounted by root alone";
  EXPECT_EQ(exit_code, 4) << shell.error();
  EXPECT_TRUE(says(shell.error(), "states.csv", "No space left on device")) << shell.error();
  const LeftFiles left = read_left_files(copy);
  EXPECT_TRUE(left.problems.empty()) << left.problems.front();
  EXPECT_TRUE(left.parts.empty()) << left.parts.front();
  EXPECT_EQ(left.json_frames, 100U) << shell.error();
  EXPECT_GT(left.states.value_or(0), 0U);
  EXPECT_LT(left.states.value_or(101), 101U);
}

}  // namespace
}  // namespace poise::testing
