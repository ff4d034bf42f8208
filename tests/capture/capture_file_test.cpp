// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <future>
#include <map>

#include "capture/capture_reader.h"
#include "capture/captures.h"
#include "scene/temporary_folder.h"

namespace poise::capture {
namespace {

using testing::some_frames;
using testing::some_header;
using testing::TemporaryFolder;
using testing::written;

// What a frame read must be of the one that was written.
void expect_same(const CaptureReader& reader, const PackedFrame& read, const SeenFrame& was) {
  EXPECT_EQ(read.facts.frame, was.facts.frame);
  EXPECT_EQ(read.facts.times, was.facts.times);
  if (read.facts.frame == 0) {
    EXPECT_TRUE(std::isnan(read.facts.momentum_ns[0])) << "the start was not measured";
  } else {
    EXPECT_EQ(read.facts.momentum_ns, was.facts.momentum_ns);
  }
  ASSERT_EQ(read.rows.size(), was.bodies.size());
  for (std::size_t i = 0; i < read.rows.size(); ++i) {
    const SeenBody& body = was.bodies[i];
    EXPECT_EQ(reader.bodies()[read.rows[i]].number, body.number);
    EXPECT_EQ(read.activity[i], body.activity);
    EXPECT_EQ(read.level[i], body.level);
    EXPECT_EQ(read.priority[i], body.priority);
    const Pose pose = reader.pose(read.poses[i]);
    const double half = reader.header().position_step_m / 2;
    EXPECT_LE((pose.position_m - body.pose.position_m).cwiseAbs().maxCoeff(), half * (1 + 1e-9));
    EXPECT_LE(pose.orientation.angularDistance(body.pose.orientation),
              orientation_error_rad(reader.header().orientation_steps));
  }
  ASSERT_EQ(read.contacts.size(), was.contacts.size());
  for (std::size_t i = 0; i < read.contacts.size(); ++i) {
    EXPECT_EQ(reader.bodies()[read.contacts[i].a].number, was.contacts[i].a);
    EXPECT_EQ(reader.bodies()[read.contacts[i].b].number, was.contacts[i].b);
    EXPECT_EQ(read.contacts[i].level, was.contacts[i].level);
    for (std::size_t point = 0; point < was.contacts[i].point_count; ++point) {
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(static_cast<double>(read.contacts[i].points[point][static_cast<std::size_t>(axis)]) *
                        reader.header().position_step_m,
                    was.contacts[i].points_m[point][axis], reader.header().position_step_m);
      }
    }
  }
}

TEST(CaptureFile, GivesBackEveryFrameWithinItsPrecision) {
  const TemporaryFolder folder;
  for (const bool contacts : {false, true}) {
    const std::vector<SeenFrame> frames = some_frames(7, 150, 40, contacts);
    written(folder.file("a"), some_header(contacts), frames, true);
    Result<CaptureReader> reader = CaptureReader::open(folder.file("a"));
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    EXPECT_FALSE(reader.value().damage());
    EXPECT_EQ(reader.value().frames(), 150U);
    EXPECT_EQ(reader.value().blocks().size(), 3U);
    ASSERT_TRUE(reader.value().end());
    EXPECT_TRUE(reader.value().end()->stopped);
    EXPECT_EQ(reader.value().header().shapes[1].corners.size(), 12U);
    EXPECT_EQ(reader.value().bodies()[0].name, "first");
    std::size_t next = 0;
    const Status read = reader.value().read_frames(0, 1000, [&](const PackedFrame& frame) {
      expect_same(reader.value(), frame, frames[next++]);
      return !::testing::Test::HasFailure();
    });
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(next, 150U);
  }
}

TEST(CaptureFile, GivesAnyRangeOfFrames) {
  const TemporaryFolder folder;
  written(folder.file("a"), some_header(), some_frames(8, 130, 5));
  Result<CaptureReader> reader = CaptureReader::open(folder.file("a"));
  ASSERT_TRUE(reader.ok());
  for (const auto& [from, to, count] : {std::tuple(0U, 0U, 1U), std::tuple(59U, 60U, 2U), std::tuple(61U, 129U, 69U),
                                        std::tuple(100U, 500U, 30U), std::tuple(130U, 500U, 0U)}) {
    std::vector<std::uint64_t> got;
    ASSERT_TRUE(reader.value().read_frames(from, to, [&](const PackedFrame& frame) {
      got.push_back(frame.facts.frame);
      return true;
    }));
    EXPECT_EQ(got.size(), count);
    if (!got.empty()) {
      EXPECT_EQ(got.front(), from);
      EXPECT_LE(got.back(), to);
    }
  }
}

TEST(CaptureFile, OfARunWithoutFramesIsWhole) {
  const TemporaryFolder folder;
  written(folder.file("a"), some_header(), {});
  const Result<CaptureReader> reader = CaptureReader::open(folder.file("a"));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  EXPECT_EQ(reader.value().frames(), 0U);
  EXPECT_FALSE(reader.value().damage());
}

TEST(CaptureFile, KeepsWhatWasThereUntilTheRunBegins) {
  const TemporaryFolder folder;
  testing::put_file(folder.file("a"), "an older capture");
  { ASSERT_TRUE(CaptureWriter::open(folder.file("a")).ok()); }
  EXPECT_EQ(testing::contents(folder.file("a")), "an older capture");
  written(folder.file("a"), some_header(), {});
  EXPECT_TRUE(CaptureReader::open(folder.file("a")).ok()) << "nothing is left of it";
}

TEST(CaptureFile, IsNotLeftEmptyWhereTheRunNeverBeginsAndStaysWhereItEndsEarly) {
  const TemporaryFolder folder;
  {
    ASSERT_TRUE(CaptureWriter::open(folder.file("a")).ok());
    Result<CaptureWriter> writer = CaptureWriter::open(folder.file("b"));
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE(writer.value().begin(some_header()).ok());
  }
  EXPECT_EQ(folder.entries(), 1U);
  const Result<CaptureReader> reader = CaptureReader::open(folder.file("b"));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  EXPECT_EQ(reader.value().frames(), 0U);
  EXPECT_FALSE(reader.value().end()) << "it was not finished";
}

TEST(CaptureFile, ThatCannotBeWrittenIsRefusedWithItsPath) {
  const TemporaryFolder folder;
  const Result<CaptureWriter> none = CaptureWriter::open(folder.path() / "no" / "a");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().kind, ErrorKind::OutputFailed);
  EXPECT_NE(none.error().message.find("no/a: cannot be written: No such file"), std::string::npos);
  Result<CaptureWriter> full = CaptureWriter::open("/dev/full");
  if (!full) GTEST_SKIP() << "this system has no /dev/full";
  EXPECT_FALSE(full.value().begin(some_header()).ok());
  const Status finished = full.value().finish(false);
  ASSERT_FALSE(finished.ok());
  EXPECT_EQ(finished.error().message, "/dev/full: cannot be written: No space left on device");
}

// Nobody reads the pipe, so the writer stands still as soon as it is full.
TEST(CaptureFile, SaysHowManyFramesWereLeftOutAndWhere) {
  const TemporaryFolder folder;
  const std::string pipe = folder.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int end = ::open(pipe.c_str(), O_RDWR);
  ASSERT_GE(end, 0);
  Result<CaptureWriter> writer = CaptureWriter::open(pipe, 2);
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE(writer.value().begin(some_header()).ok());
  std::vector<SeenFrame> frames = some_frames(9, 4000, 60);
  // No body comes after the first frames, as none may be new in a frame that is left out.
  for (std::size_t k = 1; k < frames.size(); ++k) {
    frames[k].new_bodies.clear();
    frames[k].bodies = frames[0].bodies;
    for (SeenBody& body : frames[k].bodies) body.pose.position_m *= 1 + std::sin(static_cast<double>(k * body.number));
  }
  std::size_t k = 0;
  std::uint64_t left_out = 0;
  std::map<std::uint64_t, std::uint32_t> expected;
  std::uint32_t now = 0;
  for (; k + 1 < frames.size(); ++k) {
    if (writer.value().has_room()) {
      expected[k] = std::exchange(now, 0);
      writer.value().add(frames[k]);
    } else {
      writer.value().leave_out();
      ++left_out;
      ++now;
    }
  }
  ASSERT_GT(left_out, 100U);
  std::string bytes;
  std::future<void> reading = std::async(std::launch::async, [&] {
    char part[4096];
    while (!bytes.ends_with("capindex")) {
      const ssize_t count = ::read(end, part, sizeof(part));
      if (count <= 0) return;
      bytes.append(part, static_cast<std::size_t>(count));
    }
  });
  expected[k] = now;
  writer.value().add(frames[k]);
  EXPECT_TRUE(writer.value().finish(false).ok());
  reading.get();
  ::close(end);
  EXPECT_EQ(writer.value().left_out(), left_out);
  testing::put_file(folder.file("a"), bytes);
  Result<CaptureReader> reader = CaptureReader::open(folder.file("a"));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  EXPECT_FALSE(reader.value().damage());
  EXPECT_EQ(reader.value().end()->left_out, left_out);
  std::map<std::uint64_t, std::uint32_t> told;
  ASSERT_TRUE(reader.value().read_frames(0, 10000, [&](const PackedFrame& frame) {
    told[frame.facts.frame] = frame.facts.left_out;
    return true;
  }));
  EXPECT_EQ(told, expected);
}

}  // namespace
}  // namespace poise::capture
