// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <random>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "capture/bytes.h"
#include "capture/capture_reader.h"
#include "capture/captures.h"
#include "capture/chunks.h"
#include "capture/frame_code.h"
#include "capture/sums_code.h"
#include "scene/temporary_folder.h"

namespace poise::capture {
namespace {

using testing::put_file;
using testing::some_frames;
using testing::some_header;
using testing::TemporaryFolder;
using testing::written;

/// All that a file gives.
struct Given {
  bool opened = false;
  std::string refusal;  ///< of opening, or of a block
  std::optional<CaptureReader::Damage> damage;
  std::vector<PackedFrame> frames;
};

Given given_by(const std::string& file) {
  Given given;
  Result<CaptureReader> reader = CaptureReader::open(file);
  if (!reader) {
    given.refusal = reader.error().message;
    return given;
  }
  given.opened = true;
  given.damage = reader.value().damage();
  const Status read = reader.value().read_frames(0, UINT64_MAX, [&](const PackedFrame& frame) {
    given.frames.push_back(frame);
    return true;
  });
  if (!read) given.refusal = read.error().message;
  return given;
}

bool same(const PackedFrame& a, const PackedFrame& b) {
  return a.facts.frame == b.facts.frame && a.facts.times == b.facts.times && a.rows == b.rows && a.poses == b.poses &&
         a.activity == b.activity && a.level == b.level && a.priority == b.priority && a.contacts == b.contacts;
}

/// A file whose frames are the first ones of another.
void expect_beginning(const Given& part, const Given& whole) {
  ASSERT_LE(part.frames.size(), whole.frames.size());
  for (std::size_t i = 0; i < part.frames.size(); ++i) ASSERT_TRUE(same(part.frames[i], whole.frames[i])) << i;
}

/// Where chunks begin, and the end of the last one.
std::vector<std::size_t> chunk_borders(const std::string& bytes) {
  std::vector<std::size_t> borders;
  std::size_t at = kMagic.size();
  while (at + kTrailerBytes < bytes.size()) {
    borders.push_back(at);
    at += kChunkHeadBytes + read_chunk_head(std::string_view(bytes).substr(at, kChunkHeadBytes)).value().stored +
          kChunkTailBytes;
  }
  borders.push_back(at);
  return borders;
}

TEST(DamagedCapture, CutAnywhereGivesAllFramesOfTheWholeBlocksBeforeTheCut) {
  const TemporaryFolder folder;
  const std::string bytes = written(folder.file("whole"), some_header(true), some_frames(11, 130, 4, true));
  const Given whole = given_by(folder.file("whole"));
  ASSERT_EQ(whole.frames.size(), 130U);
  const std::vector<std::size_t> borders = chunk_borders(bytes);
  ASSERT_EQ(borders.size(), 1U + 3 + 3 + 3 + 3 + 1 + 1)
      << "HEAD, shapes, BODY, FRAM and SUMS of each block, INDX, trailer";
  std::set<std::size_t> cuts(borders.begin(), borders.end());
  for (const std::size_t border : borders) cuts.insert({border - 1, border + 1, border + kChunkHeadBytes});
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) cuts.insert(random() % bytes.size());
  for (const std::size_t cut : cuts) {
    if (cut >= bytes.size()) continue;
    put_file(folder.file("cut"), bytes.substr(0, cut));
    const Given given = given_by(folder.file("cut"));
    // HEAD and three shapes must be whole.
    ASSERT_EQ(given.opened, cut >= borders[4]) << cut << ": " << given.refusal;
    if (!given.opened) continue;
    EXPECT_EQ(given.refusal, "") << cut;
    ASSERT_TRUE(given.damage) << cut;
    expect_beginning(given, whole);
    const std::size_t blocks = cut >= borders[12] ? 3 : cut >= borders[9] ? 2 : cut >= borders[6] ? 1 : 0;
    EXPECT_EQ(given.frames.size(), std::min<std::size_t>(60 * blocks, 130)) << cut;
    if (std::ranges::find(borders, cut) != borders.end() && cut < borders[13]) {
      EXPECT_EQ(given.damage->what, "the file ends here, before the end of the run");
    }
  }
}

TEST(DamagedCapture, WithAnyByteChangedGivesNoWrongFrame) {
  const TemporaryFolder folder;
  std::string bytes = written(folder.file("whole"), some_header(), some_frames(12, 70, 3));
  const Given whole = given_by(folder.file("whole"));
  std::mt19937_64 random(6);
  for (int i = 0; i < 600; ++i) {
    const std::size_t at = random() % bytes.size();
    const char was = bytes[at];
    bytes[at] = static_cast<char>(was ^ static_cast<char>(1 + random() % 255));
    put_file(folder.file("changed"), bytes);
    const Given given = given_by(folder.file("changed"));
    EXPECT_TRUE(!given.opened || !given.refusal.empty() || given.damage) << at;
    expect_beginning(given, whole);
    bytes[at] = was;
  }
}

TEST(DamagedCapture, InABlockBehindAGoodIndexIsToldWithFileAndByte) {
  const TemporaryFolder folder;
  std::string bytes = written(folder.file("a"), some_header(), some_frames(13, 130, 3));
  const std::size_t block = chunk_borders(bytes)[8];
  ASSERT_EQ(bytes.substr(block, 4), "FRAM");
  bytes[block + 40] = static_cast<char>(bytes[block + 40] ^ 1);
  put_file(folder.file("a"), bytes);
  const Given given = given_by(folder.file("a"));
  EXPECT_TRUE(given.opened);
  EXPECT_EQ(given.frames.size(), 60U);
  EXPECT_EQ(given.refusal, folder.file("a") + ": byte " + std::to_string(block) +
                               ": the checksum of a chunk is not that of its bytes");
}

TEST(DamagedCapture, OfAnotherKindOrVersionIsRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(given_by(folder.file("none")).refusal, folder.file("none") + ": no such file");
  const auto refusal = [&](const std::string& bytes) {
    put_file(folder.file("a"), bytes);
    return given_by(folder.file("a")).refusal;
  };
  const std::string name = folder.file("a");
  EXPECT_EQ(refusal(""), name + ": is empty: not a capture, or its run was killed before it began");
  EXPECT_EQ(refusal("poise"), name + ": not a capture of poise run --capture");
  EXPECT_EQ(refusal("poise.record/6\n and more"), name + ": not a capture of poise run --capture");
  EXPECT_EQ(refusal("poise.capture/9\n and more"), name + ": a capture of another version, must be poise.capture/1");
  EXPECT_EQ(refusal("poise.capture/1\n"), name + ": byte 16: the file ends within a chunk");
  ChunkPacker packer;
  std::string bytes(kMagic);
  ASSERT_TRUE(packer.add(kFramesChunk, "x", bytes).ok());
  EXPECT_EQ(refusal(bytes), name + ": byte 16: the first chunk is not HEAD");
  bytes = kMagic;
  ASSERT_TRUE(packer.add(kHeaderChunk, header_json(some_header()), bytes).ok());
  const std::string after_head = std::to_string(bytes.size());
  ASSERT_TRUE(packer.add(kBodiesChunk, "{}", bytes).ok());
  EXPECT_EQ(refusal(bytes), name + ": byte " + after_head + ": has 0 shapes, HEAD.shapes has 3");
}

/// A file with one body and these chunks behind it.
std::string file_of(const std::vector<std::pair<std::string_view, std::string>>& chunks) {
  std::string bytes(kMagic);
  ChunkPacker packer;
  const CaptureHeader header = some_header();
  EXPECT_TRUE(packer.add(kHeaderChunk, header_json(header), bytes).ok());
  for (std::uint32_t i = 0; i < header.shapes.size(); ++i)
    EXPECT_TRUE(packer.add(kShapeChunk, shape_bytes(i, header.shapes[i]), bytes).ok());
  const CapturedBody body;
  EXPECT_TRUE(packer.add(kBodiesChunk, bodies_json(0, std::span(&body, 1)), bytes).ok());
  for (const auto& [type, raw] : chunks) EXPECT_TRUE(packer.add(type, raw, bytes).ok());
  return bytes;
}

/// A block that states `count` frames and has those of these numbers, with the body of this row.
std::string block_of(std::uint32_t count, const std::vector<std::uint64_t>& numbers, std::uint32_t row = 0) {
  std::string block;
  put(count, block);
  FrameEncoder encoder(false);
  for (const std::uint64_t number : numbers) {
    PackedFrame frame;
    frame.facts.frame = number;
    frame.rows = {row};
    frame.poses.resize(1);
    frame.activity = frame.level = frame.priority = {0};
    encoder.add(frame, block);
  }
  return block;
}

TEST(DamagedCapture, OfChunksThatAreSoundAndDoNotFitTogetherIsRefused) {
  const TemporaryFolder folder;
  const std::string name = folder.file("a");
  const std::size_t start = file_of({}).size();
  const auto given = [&](const std::string& bytes) {
    put_file(name, bytes);
    return given_by(name);
  };
  const std::string at = name + ": byte " + std::to_string(start) + ": FRAM: ";
  const auto refusal = [&](const std::string& block) { return given(file_of({{kFramesChunk, block}})).refusal; };
  EXPECT_EQ(refusal(block_of(2, {0, 5})), "");
  EXPECT_EQ(refusal(block_of(2, {5, 5})), at + "frame = 5, must be at least 6");
  EXPECT_EQ(refusal(block_of(2, {5})), at + "frame 1 of the block: it ends within a frame");
  EXPECT_EQ(refusal(block_of(1, {0, 5})).substr(0, at.size()), at);
  EXPECT_EQ(refusal(block_of(1, {0}, 1)), at + "frame 0 of the block: added[0] = 1, must ascend and be below 1");
  const auto damage = [&](const std::vector<std::pair<std::string_view, std::string>>& chunks) {
    const Given read = given(file_of(chunks));
    return read.damage ? read.damage->what : std::string("none");
  };
  EXPECT_EQ(damage({{kFramesChunk, block_of(0, {})}}), "FRAM: frames = 0, must be 1 to 60");
  EXPECT_EQ(damage({{kFramesChunk, block_of(61, {0})}}), "FRAM: frames = 61, must be 1 to 60");
  EXPECT_EQ(damage({{kFramesChunk, block_of(1, {7})}, {kFramesChunk, block_of(1, {7})}}),
            "FRAM: its first frame 7 does not follow on those before");
  CaptureIndex index;
  index.end.frames = 2;
  EXPECT_EQ(damage({{kFramesChunk, block_of(1, {0})}, {kIndexChunk, index_json(index)}}),
            "the index counts 2 frames, 1 are there");
  index.end.frames = 1;
  EXPECT_EQ(damage({{kFramesChunk, block_of(1, {0})}, {kIndexChunk, index_json(index)}}),
            "the trailer is not that of the index");
  EXPECT_EQ(damage({{kBodiesChunk, "{}"}}), "BODY: first: missing, and it is required");
}

TEST(DamagedCapture, WhoseIndexNamesOtherPlacesIsReadWithoutIt) {
  const TemporaryFolder folder;
  std::string bytes = file_of({{kFramesChunk, block_of(1, {3})}});
  const std::size_t block = file_of({}).size();
  for (const std::uint64_t wrong : {std::uint64_t{16}, std::uint64_t{block + 1}, std::uint64_t{1} << 40U}) {
    CaptureIndex index;
    index.blocks = {{wrong, 3, 1}};
    index.end.frames = 1;
    std::string whole = bytes;
    ChunkPacker packer;
    ASSERT_TRUE(packer.add(kIndexChunk, index_json(index), whole).ok());
    put(std::uint64_t{bytes.size()}, whole);
    whole += kTrailerMagic;
    put_file(folder.file("a"), whole);
    const Given given = given_by(folder.file("a"));
    // Either the block is refused, or the places were found by going through the file.
    EXPECT_TRUE(given.opened);
    EXPECT_TRUE(!given.refusal.empty() || given.frames.size() == 1) << wrong;
  }
}

TEST(DamagedCapture, WithAChunkThatNobodyKnowsIsReadBeyondIt) {
  const TemporaryFolder folder;
  const std::string bytes = written(folder.file("a"), some_header(), some_frames(14, 70, 3));
  const std::size_t second = chunk_borders(bytes)[7];
  std::string extra;
  ChunkPacker packer;
  ASSERT_TRUE(packer.add("MORE", "of a later version", extra).ok());
  // Its index is gone, as in a run that was killed.
  put_file(folder.file("a"), bytes.substr(0, second) + extra + bytes.substr(second, chunk_borders(bytes)[10] - second));
  const Given given = given_by(folder.file("a"));
  EXPECT_EQ(given.refusal, "");
  EXPECT_EQ(given.frames.size(), 70U);
}

TEST(DamagedCapture, CutBehindItsFramesOrOfAnEarlierVersionHasNoMomentumAndAllFrames) {
  const TemporaryFolder folder;
  std::vector<SeenFrame> frames = some_frames(15, 130, 3);
  const std::string bytes = written(folder.file("a"), some_header(), frames);
  const std::size_t sums = chunk_borders(bytes)[9];
  ASSERT_EQ(bytes.substr(sums, 4), "SUMS");
  for (const std::size_t cut : {sums, sums + 7, sums + kChunkHeadBytes + 3}) {
    put_file(folder.file("a"), bytes.substr(0, cut));
    const Given given = given_by(folder.file("a"));
    EXPECT_EQ(given.refusal, "");
    ASSERT_EQ(given.frames.size(), 120U);
    EXPECT_EQ(given.frames[59].facts.momentum_ns[0], 59);
    EXPECT_TRUE(std::isnan(given.frames[60].facts.momentum_ns[0])) << "nothing of the block before";
  }
  for (SeenFrame& frame : frames) frame.facts.momentum_ns = FrameFacts{}.momentum_ns;
  std::string old = written(folder.file("a"), some_header(), frames);
  EXPECT_EQ(old.find("SUMS"), std::string::npos);
  EXPECT_TRUE(std::isnan(given_by(folder.file("a")).frames.at(129).facts.momentum_ns[0]));
  // Damage of a block is that of no other one.
  const std::size_t block = chunk_borders(old)[7];
  ASSERT_EQ(old.substr(block, 4), "FRAM");
  old[block + 40] = static_cast<char>(old[block + 40] ^ 1);
  put_file(folder.file("a"), old);
  EXPECT_EQ(given_by(folder.file("a")).frames.size(), 60U);
}

TEST(DamagedCapture, WithSumsThatAreNotThoseOfTheirBlockIsRefused) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& sums) {
    const std::string bytes = file_of({{kFramesChunk, block_of(2, {0, 5})}, {kSumsChunk, sums}});
    put_file(folder.file("a"), bytes);
    const std::string text = given_by(folder.file("a")).refusal;
    return text.substr(std::min(text.size(), text.find("SUMS")));
  };
  const std::vector<FrameSums> two{{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(refusal(sums_bytes(two)), "");
  EXPECT_EQ(refusal(sums_bytes(std::span(two).first(1))), "SUMS: frames = 1, its block has 2");
  EXPECT_EQ(refusal(sums_bytes(two) + "x"), "SUMS: has 29 bytes for 2 frames");
}

TEST(DamagedCapture, APipeOrADeviceIsRefusedInsteadOfWaitedFor) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo(folder.file("pipe").c_str(), 0600), 0);
  EXPECT_EQ(given_by(folder.file("pipe")).refusal, folder.file("pipe") + ": not a file: a folder, a pipe or a device");
  EXPECT_EQ(given_by("/dev/zero").refusal, "/dev/zero: not a file: a folder, a pipe or a device");
}

}  // namespace
}  // namespace poise::capture
