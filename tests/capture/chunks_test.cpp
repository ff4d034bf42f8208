// SPDX-License-Identifier: MIT
#include "capture/chunks.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <random>

#include "capture/bytes.h"

namespace poise::capture {
namespace {

RC_GTEST_PROP(Chunk, GivesBackItsBytes, (const std::string& raw)) {
  ChunkPacker packer;
  std::string chunk = "before";
  RC_ASSERT(packer.add(kHeaderChunk, raw, chunk).ok());
  chunk.erase(0, 6);
  const Result<ChunkHead> head = read_chunk_head(chunk);
  RC_ASSERT(head.ok());
  RC_ASSERT(head.value().type == kHeaderChunk);
  std::string read;
  RC_ASSERT(unpack_chunk(chunk, read).ok());
  RC_ASSERT(read == raw);
}

TEST(Chunk, WithAnyByteChangedIsRefused) {
  ChunkPacker packer;
  std::string chunk;
  ASSERT_TRUE(packer.add(kFramesChunk, std::string(300, 'a') + "and something else", chunk).ok());
  std::string read;
  for (std::size_t i = 0; i < chunk.size(); ++i) {
    std::string changed = chunk;
    changed[i] = static_cast<char>(changed[i] ^ 0x10);
    EXPECT_FALSE(unpack_chunk(changed, read).ok()) << i;
  }
  for (std::size_t size = kChunkHeadBytes; size < chunk.size(); ++size)
    EXPECT_FALSE(unpack_chunk(chunk.substr(0, size), read).ok()) << size;
}

TEST(Chunk, ThatWouldBeCompressedOutOfProportionIsStoredAsItIs) {
  ChunkPacker packer;
  const std::string zeros(std::size_t{4} << 20U, '\0');
  std::string chunk;
  ASSERT_TRUE(packer.add(kShapeChunk, zeros, chunk).ok());
  EXPECT_GT(chunk.size(), zeros.size());
  std::string read;
  ASSERT_TRUE(unpack_chunk(chunk, read).ok());
  EXPECT_EQ(read, zeros);
}

TEST(Chunk, ThatClaimsMoreThanItCanHoldIsRefusedBeforeMemoryIsTaken) {
  std::string head(kFramesChunk);
  put(std::uint32_t{1} << 29U, head);
  put(std::uint32_t{100}, head);
  const Result<ChunkHead> read = read_chunk_head(head);
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().message, "a chunk of 100 bytes, 536870912 before compression: no writer makes one");
}

RC_GTEST_PROP(Varint, GivesBackItsNumber, (std::int64_t any)) {
  const std::int64_t number = any % (std::int64_t{1} << 52U);
  std::string bytes;
  put_zigzag(number, bytes);
  put_varint(static_cast<std::uint64_t>(std::abs(number)), bytes);
  ByteReader reader(bytes);
  RC_ASSERT(reader.zigzag() == number);
  RC_ASSERT(reader.varint() == static_cast<std::uint64_t>(std::abs(number)));
  RC_ASSERT(reader.sound());
  RC_ASSERT(reader.left() == 0U);
}

TEST(Varint, ThatADoubleCannotHoldIsNotSound) {
  for (const std::string& bytes :
       {std::string(8, '\xff'), std::string("\x80\x80\x80\x80\x80\x80\x80\x10"), std::string("\x80"), std::string()}) {
    ByteReader reader(bytes);
    EXPECT_EQ(reader.varint(), 0U);
    EXPECT_FALSE(reader.sound());
  }
}

}  // namespace
}  // namespace poise::capture
