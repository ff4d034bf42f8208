// SPDX-License-Identifier: MIT
#include "scene/result_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>
#include <utility>

#include "scene/temporary_folder.h"

namespace poise::io {
namespace {

using testing::contents;
using testing::TemporaryFolder;

TEST(AtomicFile, AppearsWholeAtTheCommitAndNotBefore) {
  const TemporaryFolder folder;
  Result<AtomicFile> file = AtomicFile::open(folder.file("a.txt"));
  ASSERT_TRUE(file);
  const std::string large(1'000'000, 'x');
  EXPECT_TRUE(file.value().write(large));
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.txt")));
  EXPECT_TRUE(file.value().write("end"));
  EXPECT_TRUE(file.value().commit());
  EXPECT_EQ(contents(folder.file("a.txt")), large + "end");
  EXPECT_EQ(folder.entries(), 1U);
}

TEST(AtomicFile, KeepsLinksAndTheModeOfWhatItReplaces) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder.file("real"), "old"));
  ASSERT_EQ(::chmod(folder.file("real").c_str(), 0640), 0);
  std::filesystem::create_symlink("real", folder.file("link"));
  ASSERT_TRUE(write_file(folder.file("link"), "new"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("link")));
  EXPECT_EQ(contents(folder.file("real")), "new");
  struct stat status {};
  ASSERT_EQ(::stat(folder.file("real").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640U);
}

TEST(AtomicFile, FollowsLinksToWhatIsNotThereYet) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("d"));
  std::filesystem::create_symlink("d/real", folder.file("link"));
  std::filesystem::create_symlink("link", folder.file("other"));
  ASSERT_TRUE(write_file(folder.file("other"), "new"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("link")));
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("other")));
  EXPECT_EQ(contents(folder.file("d/real")), "new");
  std::filesystem::create_symlink("loop", folder.file("loop"));
  const Status looped = write_file(folder.file("loop"), "new");
  ASSERT_FALSE(looped);
  EXPECT_NE(looped.error().message.find("Too many levels of symbolic links"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("loop")));
}

std::string part(const TemporaryFolder& folder, const std::string& name, int number) {
  return folder.file("." + name + "." + std::to_string(number) + ".part");
}

TEST(AtomicFile, HasNoNameBeforeItsCommitWhereTheSystemPermitsThat) {
  const TemporaryFolder folder;
  const int nameless = ::open(folder.path().c_str(), O_WRONLY | O_TMPFILE, 0600);
  if (nameless < 0) GTEST_SKIP() << "no files without a name here";
  ::close(nameless);
  ASSERT_TRUE(write_file(folder.file("a.txt"), "old"));
  Result<AtomicFile> file = AtomicFile::open(folder.file("a.txt"));
  ASSERT_TRUE(file);
  EXPECT_TRUE(file.value().write("new"));
  EXPECT_TRUE(file.value().flush());
  EXPECT_EQ(folder.entries(), 1U);
  EXPECT_TRUE(file.value().commit());
  EXPECT_EQ(folder.entries(), 1U);
  EXPECT_EQ(contents(folder.file("a.txt")), "new");
}

TEST(AtomicFile, KeepsClearOfPartsThatWereLeftAndRemovesThemAtItsCommit) {
  const TemporaryFolder folder;
  std::ofstream(part(folder, "a", 0)) << "of a program that was killed";
  std::ofstream(part(folder, "b", 0)) << "of another file";
  Result<AtomicFile> first = AtomicFile::open(folder.file("a"), AtomicFile::Before::Part);
  Result<AtomicFile> second = AtomicFile::open(folder.file("a"), AtomicFile::Before::Part);
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(first.value().write("first"));
  EXPECT_TRUE(first.value().flush());
  EXPECT_EQ(contents(part(folder, "a", 0)), "of a program that was killed");
  EXPECT_EQ(contents(part(folder, "a", 1)), "first");
  EXPECT_TRUE(first.value().commit());
  EXPECT_EQ(contents(folder.file("a")), "first");
  EXPECT_FALSE(std::filesystem::exists(part(folder, "a", 0)));
  EXPECT_TRUE(std::filesystem::exists(part(folder, "a", 2))) << "the second is being written";
  EXPECT_TRUE(second.value().write("second"));
  EXPECT_TRUE(second.value().commit());
  EXPECT_EQ(contents(folder.file("a")), "second");
  EXPECT_EQ(folder.entries(), 2U) << "the part of another file stays";
}

TEST(AtomicFile, TakesAPlaceOfOneThatWasLeftWhereAllAreTaken) {
  const TemporaryFolder folder;
  for (int i = 0; i < 100; ++i) std::ofstream(part(folder, "a", i)) << "left";
  Result<AtomicFile> file = AtomicFile::open(folder.file("a"), AtomicFile::Before::Part);
  ASSERT_TRUE(file);
  EXPECT_TRUE(file.value().write("new"));
  EXPECT_TRUE(file.value().commit());
  EXPECT_EQ(contents(folder.file("a")), "new");
  EXPECT_EQ(folder.entries(), 1U);
}

TEST(AtomicFile, WithoutACommitLeavesTheOldFileOrWhatWasPublishedAndNothingElse) {
  for (const bool publish : {false, true}) {
    const TemporaryFolder folder;
    ASSERT_TRUE(write_file(folder.file("a"), "old"));
    {
      Result<AtomicFile> file = AtomicFile::open(folder.file("a"));
      ASSERT_TRUE(file);
      EXPECT_TRUE(file.value().write("head"));
      EXPECT_EQ(contents(folder.file("a")), "old");
      if (publish) {
        EXPECT_TRUE(file.value().publish());
        EXPECT_EQ(contents(folder.file("a")), "head");
      }
      EXPECT_TRUE(file.value().write(" and more"));
      EXPECT_TRUE(file.value().flush());
    }
    EXPECT_EQ(contents(folder.file("a")), publish ? "head and more" : "old");
    EXPECT_EQ(folder.entries(), 1U);
  }
}

/// No file may be larger than so many bytes, during its lifetime.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(AtomicFile, OnAFullDiskEndsWithTheLastWholeWriteWhereThatIsAskedFor) {
  const TemporaryFolder folder;
  for (const bool keeps : {true, false}) {
    const FileLimit limit(10'000);
    const std::string name = folder.file(keeps ? "keeps" : "does not");
    Result<AtomicFile> file = AtomicFile::open(name, AtomicFile::Before::Part);
    ASSERT_TRUE(file);
    EXPECT_TRUE(file.value().write(std::string(6'000, 'a')) && file.value().flush());
    EXPECT_TRUE(file.value().write(std::string(6'000, 'b')));
    EXPECT_FALSE(file.value().flush());
    EXPECT_TRUE(file.value().failing());
    EXPECT_FALSE(file.value().write("c")) << "the failure stays";
    const Status closed = keeps ? file.value().commit_what_is_whole() : file.value().commit();
    ASSERT_FALSE(closed);
    EXPECT_EQ(closed.error().message,
              name + ": cannot be written: File too large" + (keeps ? "; what was written before is there" : ""));
    EXPECT_EQ(std::filesystem::exists(name), keeps);
    EXPECT_EQ(contents(name), keeps ? std::string(6'000, 'a') : "");
  }
  EXPECT_EQ(folder.entries(), 1U);
}

TEST(AtomicFile, GivesBackTheRoomThatItReservedAndDidNotNeed) {
  const TemporaryFolder folder;
  Result<AtomicFile> opened = AtomicFile::open(folder.file("a"));
  ASSERT_TRUE(opened);
  opened.value().reserve(1U << 20U);
  AtomicFile file = std::move(opened).value();
  EXPECT_TRUE(file.write("text"));
  EXPECT_TRUE(file.commit());
  EXPECT_EQ(contents(folder.file("a")), "text");
  struct stat status {};
  ASSERT_EQ(::stat(folder.file("a").c_str(), &status), 0);
  EXPECT_LT(status.st_blocks * 512, 1 << 18);
}

TEST(AtomicFile, MovesWithItsTemporaryFile) {
  const TemporaryFolder folder;
  Result<AtomicFile> opened = AtomicFile::open(folder.file("a"));
  ASSERT_TRUE(opened);
  AtomicFile moved = std::move(opened).value();
  EXPECT_TRUE(moved.write("text"));
  EXPECT_TRUE(moved.commit());
  EXPECT_EQ(contents(folder.file("a")), "text");
}

TEST(AtomicFile, RefusesAMissingFolderAFolderAndAFullDevice) {
  const TemporaryFolder folder;
  const Status missing = write_file(folder.file("no/such/folder.txt"), "x");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::OutputFailed);
  EXPECT_EQ(missing.error().message,
            folder.file("no/such/folder.txt") + ": cannot be written: No such file or directory");
  EXPECT_EQ(write_file(folder.path(), "x").error().message,
            folder.path().string() + ": cannot be written: Is a directory");
  EXPECT_EQ(write_file("", "x").error().kind, ErrorKind::OutputFailed);
  const Status full = write_file("/dev/full", "x");
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().message, "/dev/full: cannot be written: No space left on device");
  EXPECT_FALSE(std::filesystem::is_regular_file("/dev/full"));
  EXPECT_TRUE(write_file("/dev/null", "x"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace poise::io
