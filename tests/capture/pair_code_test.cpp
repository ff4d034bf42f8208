// SPDX-License-Identifier: MIT
#include "capture/pair_code.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "capture/bytes.h"
#include "capture/capture_reader.h"
#include "capture/captures.h"
#include "scene/temporary_folder.h"

namespace poise::capture {
namespace {

using testing::TemporaryFolder;

/// A frame of a PAIR chunk as docs/capture.md has it.
std::vector<PackedPair> read_pairs(ByteReader& bytes, std::uint64_t& frame) {
  const auto size = bytes.get<std::uint32_t>();
  const std::size_t begin = bytes.at();
  frame = bytes.get<std::uint64_t>();
  std::vector<PackedPair> pairs(bytes.varint());
  std::int64_t row = 0;
  for (PackedPair& pair : pairs) pair.a = static_cast<std::uint32_t>(row += bytes.zigzag());
  for (PackedPair& pair : pairs) pair.b = static_cast<std::uint32_t>(pair.a + bytes.zigzag());
  for (const auto column : {&PackedPair::state, &PackedPair::level, &PackedPair::deepest, &PackedPair::seen,
                            &PackedPair::error, &PackedPair::outcome, &PackedPair::turn}) {
    for (PackedPair& pair : pairs) pair.*column = bytes.get<std::uint8_t>();
  }
  EXPECT_TRUE(bytes.sound());
  EXPECT_EQ(bytes.at() - begin, size);
  return pairs;
}

TEST(PairCode, GivesBackEveryPairOfEveryFrame) {
  const std::vector<PackedPair> first{
      {7, 2, 18, 1, 3, 90, 80, 10, 200}, {0, 4'000'000, 2, 7, 7, 0, 0, 5, 0}, {9, 8, 5, 0, 3, 1, 255, 4, 1}};
  std::string bytes;
  put_pairs(41, first, bytes);
  put_pairs(42, {}, bytes);
  ByteReader reader(bytes);
  std::uint64_t frame = 0;
  EXPECT_EQ(read_pairs(reader, frame), first);
  EXPECT_EQ(frame, 41U);
  EXPECT_TRUE(read_pairs(reader, frame).empty());
  EXPECT_EQ(frame, 42U);
  EXPECT_EQ(reader.left(), 0U);
}

// The promise of docs/capture.md: a reader skips chunks that it does not know, so files with pairs are of version 1
// too.
TEST(PairChunks, ChangeNothingForAReaderThatDoesNotAskForThem) {
  const TemporaryFolder folder;
  CaptureHeader header = testing::some_header();
  std::vector<SeenFrame> frames = testing::some_frames(3, 130, 20);
  const std::string plain = testing::written(folder.file("plain"), header, frames);
  for (SeenFrame& frame : frames) {
    SeenPair& pair = frame.pairs.emplace_back();
    pair.a = frame.bodies.front().number;
    pair.b = frame.bodies.back().number;
    pair.packed.level = 2;
  }
  EXPECT_EQ(testing::written(folder.file("off"), header, frames), plain) << "off, they cost nothing";
  header.pairs = true;
  const std::string with = testing::written(folder.file("with"), header, frames);
  EXPECT_GT(with.size(), plain.size());
  testing::put_file(folder.file("cut"), with.substr(0, with.size() - 16));  // read in order, without the index
  const auto all = [&](const std::string& name) {
    Result<CaptureReader> reader = CaptureReader::open(folder.file(name));
    EXPECT_TRUE(reader.ok());
    std::vector<std::vector<PackedPose>> poses;
    EXPECT_TRUE(reader.value().read_frames(0, UINT64_MAX, [&](const PackedFrame& frame) {
      poses.push_back(frame.poses);
      return true;
    }));
    return poses;
  };
  EXPECT_EQ(all("plain").size(), 130U);
  EXPECT_EQ(all("with"), all("plain"));
  EXPECT_EQ(all("cut"), all("plain"));
}

}  // namespace
}  // namespace poise::capture
