// SPDX-License-Identifier: MIT
#include "capture/frame_code.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <random>

namespace poise::capture {
namespace {

constexpr std::uint32_t kSteps = 8192;

PackedPose some_pose(std::mt19937_64& random, std::int64_t reach) {
  PackedPose pose;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    pose.position[axis] = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(2 * reach)) - reach;
    pose.orientation[axis] = static_cast<std::int32_t>(random() % (2 * kSteps)) - static_cast<std::int32_t>(kSteps);
  }
  pose.largest = static_cast<std::uint8_t>(random() % 4);
  return pose;
}

/// Frames whose rows come and go, and rest, glide or jump.
std::vector<PackedFrame> some_frames(std::uint64_t seed, bool contacts) {
  std::mt19937_64 random(seed);
  std::vector<PackedFrame> frames;
  std::uint32_t next_row = 0;
  PackedFrame now;
  for (std::uint64_t k = 0; k < 1 + random() % 12; ++k) {
    now.facts.frame = 7 * k;
    now.facts.time_s = 0.25 * static_cast<double>(k);
    now.facts.cause = static_cast<MissCause>(random() % 6);
    now.facts.measured = random() % 2 == 0;
    now.facts.kinetic_j = 1.5;
    now.facts.potential_j = -3;
    for (std::size_t i = 0; i < now.rows.size();) {
      if (random() % 6 != 0) {
        ++i;
        continue;
      }
      const auto at = static_cast<std::ptrdiff_t>(i);
      now.rows.erase(now.rows.begin() + at);
      now.poses.erase(now.poses.begin() + at);
      now.activity.erase(now.activity.begin() + at);
      now.level.erase(now.level.begin() + at);
      now.priority.erase(now.priority.begin() + at);
    }
    for (std::size_t i = 0; i < now.rows.size(); ++i) {
      if (random() % 3 == 0) now.poses[i] = some_pose(random, random() % 5 == 0 ? kMostSteps : 1000);
      if (random() % 3 == 0) now.poses[i].position[0] += now.poses[i].position[0] < 0 ? 5 : -5;
      if (random() % 4 == 0) now.activity[i] = static_cast<std::uint8_t>(random() % kActivities);
      if (random() % 4 == 0) now.level[i] = static_cast<std::uint8_t>(random() % (kMostBodyLevel + 1U));
      if (random() % 4 == 0) now.priority[i] = static_cast<std::uint8_t>(random());
    }
    for (std::uint64_t come = random() % 20; come > 0; --come) {
      next_row += static_cast<std::uint32_t>(random() % 3);
      now.rows.push_back(next_row++);
      now.poses.push_back(some_pose(random, 1000));
      now.activity.push_back(static_cast<std::uint8_t>(random() % kActivities));
      now.level.push_back(static_cast<std::uint8_t>(random() % 2));
      now.priority.push_back(static_cast<std::uint8_t>(random()));
    }
    now.contacts.clear();
    for (std::size_t i = 1; contacts && i < now.rows.size(); ++i) {
      PackedContact contact;
      contact.a = now.rows[random() % now.rows.size()];
      contact.b = now.rows[i];
      contact.level = static_cast<Level>(random() % (kPolygonBin + 1));
      contact.normal = {1, -2, 32767};
      contact.point_count = static_cast<std::uint8_t>(1 + random() % 4);
      for (std::size_t p = 0; p < contact.point_count; ++p) contact.points[p] = some_pose(random, 1 << 20).position;
      now.contacts.push_back(contact);
    }
    frames.push_back(now);
  }
  return frames;
}

std::string coded(const std::vector<PackedFrame>& frames, bool contacts) {
  FrameEncoder encoder(contacts);
  std::string bytes;
  encoder.begin_block();
  for (const PackedFrame& frame : frames) encoder.add(frame, bytes);
  return bytes;
}

RC_GTEST_PROP(FrameCode, GivesBackEveryFrameExactly, (std::uint64_t seed, bool contacts)) {
  const std::vector<PackedFrame> frames = some_frames(seed, contacts);
  const std::string bytes = coded(frames, contacts);
  ByteReader reader(bytes);
  FrameDecoder decoder({100'000, kSteps, contacts});
  PackedFrame read;
  for (const PackedFrame& frame : frames) {
    const Status next = decoder.next(reader, read);
    RC_ASSERT(next.ok());
    RC_ASSERT(read.facts.frame == frame.facts.frame);
    RC_ASSERT(read.facts.cause == frame.facts.cause);
    RC_ASSERT(read.facts.measured == frame.facts.measured);
    RC_ASSERT(read.facts.kinetic_j == frame.facts.kinetic_j);
    RC_ASSERT(read.rows == frame.rows);
    RC_ASSERT(read.poses == frame.poses);
    RC_ASSERT(read.activity == frame.activity);
    RC_ASSERT(read.level == frame.level);
    RC_ASSERT(read.priority == frame.priority);
    RC_ASSERT(read.contacts == frame.contacts);
  }
  RC_ASSERT(reader.left() == 0U);
}

// Reads all frames; every row must be below the limit and every pose in range whatever the bytes are.
void read_any(const std::string& bytes, std::uint32_t rows, bool contacts) {
  ByteReader reader(bytes);
  FrameDecoder decoder({rows, kSteps, contacts});
  PackedFrame frame;
  while (reader.left() > 0) {
    if (!decoder.next(reader, frame)) return;
    for (const std::uint32_t row : frame.rows) RC_ASSERT(row < rows);
    for (const PackedPose& pose : frame.poses) RC_ASSERT(pose.largest < 4);
    for (const std::uint8_t activity : frame.activity) RC_ASSERT(activity < kActivities);
    RC_ASSERT(frame.poses.size() == frame.rows.size());
  }
}

RC_GTEST_PROP(FrameCode, OfDamagedBytesIsRefusedOrInRange, (std::uint64_t seed, bool contacts)) {
  std::string bytes = coded(some_frames(seed, contacts), contacts);
  std::mt19937_64 random(seed);
  for (int i = 0; i < 20; ++i) {
    std::string damaged = bytes;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = static_cast<char>(random());
    read_any(damaged, 500, contacts);
    read_any(bytes.substr(0, random() % bytes.size()), 500, contacts);
  }
}

TEST(FrameCode, OfBodiesAtRestTakesAFewBitsForEach) {
  PackedFrame frame;
  std::mt19937_64 random(3);
  for (std::uint32_t row = 0; row < 8000; ++row) {
    frame.rows.push_back(row);
    frame.poses.push_back(some_pose(random, 1000));
  }
  frame.activity.assign(8000, 2);
  frame.level.assign(8000, 3);
  frame.priority.assign(8000, 100);
  FrameEncoder encoder(false);
  std::string bytes;
  encoder.add(frame, bytes);
  const std::size_t first = bytes.size();
  encoder.add(frame, bytes);
  EXPECT_LT(bytes.size() - first, 8000 / 2 + 300) << "four masks, a bit a body each, and the fixed part";
}

struct Refusal {
  std::string bytes;
  std::string message;
};

// One frame, with what comes behind its facts.
std::string frame_of(const std::string& rest) {
  std::string facts;
  put_facts({}, facts);
  std::string bytes;
  put(static_cast<std::uint32_t>(facts.size() + rest.size()), bytes);
  return bytes + facts + rest;
}

TEST(FrameCode, RefusesWhatNoWriterMakes) {
  const std::string pose(6, '\0');
  const std::vector<Refusal> refusals{
      {"\x01", "it ends within a frame"},
      {frame_of({}), "it ends within removed"},
      {frame_of({'\x01'}), "removed lists 1 rows, more than its bytes can hold"},
      {frame_of({0, 1, 9, 0}), "added[0] = 9, must ascend and be below 4"},
      {frame_of({0, 2, 1, 0, 0, 0}), "added[1] = 1, must ascend and be below 4"},
      {frame_of({1, 2, 0, 0}), "removed has row 2, which is not there"},
      {frame_of({0, 1, 0, 2}), "the mask of poses is cut short or has bits beyond its bodies"},
      {frame_of({0, 1, 3, 0}), "row 3 is new and has no pose"},
      {frame_of(std::string({0, 1, 3, 1, 0}) + pose.substr(1)), "it ends within the poses"},
      {frame_of(std::string({0, 1, 3, 1, 4}) + pose), "largest of row 3 = 4, must be at most 3"},
      {frame_of(std::string({0, 1, 3, 1, 0}) + std::string({0, 0, 0, '\x82', '\x80', 1, 0, 0})),
       "the pose of row 3 is out of range"},
      {frame_of(std::string({0, 1, 3, 1, 0}) + pose + std::string({1, 6, 0, 0})),
       "state of row 3 = 6, must be at most 5"},
      {frame_of(std::string({0, 1, 3, 1, 0}) + pose + std::string({0, 1, 9, 0})),
       "level of row 3 = 9, must be at most 8"},
      {frame_of(std::string({0, 1, 3, 1, 0}) + pose + std::string({0, 0, 2})),
       "the mask of priority is cut short or has bits beyond its bodies"},
      {frame_of(std::string({0, 1, 3, 1, 0}) + pose + std::string({0, 0, 0, 7})), "1 bytes stand behind a frame"},
      {frame_of(std::string({0, 1, 3, 1, 0}) + pose + std::string({0, 0, 0, 7})),
       "contacts lists 7 pairs, more than its bytes can hold"},
      {frame_of(std::string({0, 1, 3, 1, 0}) + pose + std::string({0, 0, 0, 1, 3, 2}) + std::string(20, '\0')),
       "contacts[0] names a row that is not there"},
      {frame_of(std::string({0, 1, 3, 1, 0}) + pose + std::string({0, 0, 0, 1, 3, 3}) + std::string(20, '\0')),
       "contacts[0] has level 0 and 0 points, must be at most 7 and 1 to 8"}};
  for (const auto& [bytes, message] : refusals) {
    const bool contacts = message.starts_with("contacts");
    ByteReader reader(bytes);
    FrameDecoder decoder({4, kSteps, contacts});
    PackedFrame frame;
    const Status read = decoder.next(reader, frame);
    ASSERT_FALSE(read.ok()) << message;
    EXPECT_EQ(read.error().message, message);
  }
}

TEST(FrameCode, RefusesARowThatIsAddedTwice) {
  const std::string first = frame_of(std::string({0, 1, 3, 1, 0}) + std::string(6, '\0') + std::string({0, 0, 0}));
  const std::string bytes = first + first;
  ByteReader reader(bytes);
  FrameDecoder decoder({4, kSteps, false});
  PackedFrame frame;
  ASSERT_TRUE(decoder.next(reader, frame).ok());
  const Status again = decoder.next(reader, frame);
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().message, "added has row 3, which is there already");
}

TEST(FrameFacts, RefuseWhatDoesNotExist) {
  const auto refused = [](std::size_t at, char value) {
    std::string bytes;
    put_facts({}, bytes);
    EXPECT_EQ(bytes.size(), 248U) << "docs/capture.md";
    bytes[at] = value;
    ByteReader reader(bytes);
    FrameFacts facts;
    const Status read = get_facts(reader, facts);
    return read ? std::string() : read.error().message;
  };
  EXPECT_EQ(refused(20, 8), "flags = 8, must be at most 7");
  EXPECT_EQ(refused(21, 6), "cause = 6, must be at most 5");
  EXPECT_EQ(refused(22, 1), "reserved = 1, must be 0");
  EXPECT_EQ(refused(0, 1), "");
}

}  // namespace
}  // namespace poise::capture
