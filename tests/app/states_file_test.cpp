// SPDX-License-Identifier: MIT
#include "app/run/states_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "scene/temporary_folder.h"

namespace poise::app {
namespace {

using std::chrono::milliseconds;
using testing::contents;
using testing::TemporaryFolder;

constexpr std::chrono::steady_clock::time_point kBegin{std::chrono::hours(1)};

std::vector<io::NumberedState> one_body(double x_m) {
  io::NumberedState state;
  state.body = 7;
  state.state.position_m = Vec3(x_m, 0, 0);
  return {state};
}

TEST(StatesFile, ReachesTheSystemWithTheFirstFrameAndThenFourTimesASecond) {
  const TemporaryFolder folder;
  Result<StatesFile> file = StatesFile::open(folder.file("s"), StatesFile::WrittenBy::Caller);
  ASSERT_TRUE(file);
  const auto bytes_after = [&](std::uint64_t frame, int ms) {
    EXPECT_TRUE(file.value().add(frame, 0.001 * ms, one_body(ms), kBegin + milliseconds(ms)));
    return std::filesystem::file_size(folder.file(".s.0.part"));
  };
  const std::uintmax_t first = bytes_after(0, 0);
  EXPECT_GT(first, 0U);
  EXPECT_EQ(bytes_after(1, 10), first);
  EXPECT_EQ(bytes_after(2, 249), first);
  const std::uintmax_t later = bytes_after(3, 250);
  EXPECT_GT(later, first);
  EXPECT_EQ(bytes_after(4, 499), later);
  EXPECT_GT(bytes_after(5, 500), later);
}

TEST(StatesFile, OfAThreadOfItsOwnIsTheSameTable) {
  const TemporaryFolder folder;
  for (const auto& [name, by] :
       {std::pair{"here", StatesFile::WrittenBy::Caller}, std::pair{"there", StatesFile::WrittenBy::OwnThread}}) {
    Result<StatesFile> file = StatesFile::open(folder.file(name), by);
    ASSERT_TRUE(file);
    StatesFile moved = std::move(file).value();
    // More than may wait.
    for (int i = 0; i < 100; ++i)
      EXPECT_TRUE(moved.add(static_cast<std::uint64_t>(i), 0.01 * i, one_body(i), kBegin + milliseconds(10 * i)));
    EXPECT_TRUE(moved.finish());
  }
  EXPECT_GT(contents(folder.file("here")).size(), 1000U);
  EXPECT_EQ(contents(folder.file("there")), contents(folder.file("here")));
  EXPECT_EQ(folder.entries(), 2U);
}

TEST(StatesFile, TellsAFailureOfItsThreadWithAFrameThatFollowsAndAtTheEnd) {
  Result<StatesFile> file = StatesFile::open("/dev/full", StatesFile::WrittenBy::OwnThread);
  ASSERT_TRUE(file);
  int added = 0;
  // The first is refused when the second was taken from the queue, at the latest.
  while (added < 1000 && file.value().add(static_cast<std::uint64_t>(added), 0, one_body(0), kBegin)) ++added;
  EXPECT_LE(added, static_cast<int>(StatesFile::kFramesWaiting) + 3);
  const Status finished = file.value().finish();
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().message, "/dev/full: cannot be written: No space left on device");
}

}  // namespace
}  // namespace poise::app
