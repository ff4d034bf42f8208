// SPDX-License-Identifier: MIT
#include "scene/result_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

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

TEST(AtomicFile, LeavesTheOldFileAndNothingElseWithoutACommit) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder.file("a.txt"), "old"));
  {
    Result<AtomicFile> file = AtomicFile::open(folder.file("a.txt"));
    ASSERT_TRUE(file);
    EXPECT_TRUE(file.value().write("new"));
    EXPECT_EQ(folder.entries(), 2U);
  }
  EXPECT_EQ(contents(folder.file("a.txt")), "old");
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
