// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "poise/result.h"

/// The frame of the file: chunks with type, sizes and checksum (docs/capture.md).
namespace poise::capture {

inline constexpr std::string_view kMagic = "poise.capture/1\n";
inline constexpr std::string_view kMagicOfAny = "poise.capture/";
inline constexpr std::string_view kTrailerMagic = "capindex";
inline constexpr std::size_t kTrailerBytes = 16;

inline constexpr std::string_view kHeaderChunk = "HEAD";
inline constexpr std::string_view kShapeChunk = "SHAP";
inline constexpr std::string_view kBodiesChunk = "BODY";
inline constexpr std::string_view kFramesChunk = "FRAM";
inline constexpr std::string_view kSumsChunk = "SUMS";
inline constexpr std::string_view kPairsChunk = "PAIR";
inline constexpr std::string_view kIndexChunk = "INDX";

inline constexpr std::size_t kChunkHeadBytes = 12;
inline constexpr std::size_t kChunkTailBytes = 4;
/// The largest chunk before compression.
inline constexpr std::uint64_t kMostChunkBytes = std::uint64_t{1} << 30U;

/// What stands before the bytes of a chunk.
struct ChunkHead {
  std::string_view type;  ///< four bytes
  std::uint32_t raw = 0, stored = 0;
};

/// Makes chunks. Invariant: has a compressor of Zstandard, unless memory for it was missing.
class ChunkPacker {
 public:
  ChunkPacker();
  ChunkPacker(ChunkPacker&&) noexcept;
  ChunkPacker& operator=(ChunkPacker&&) noexcept;
  ~ChunkPacker();
  /// Appends a chunk. Refused as OutputFailed: more than kMostChunkBytes, and where memory is missing.
  Status add(std::string_view type, std::string_view raw, std::string& out);

 private:
  struct Compressor;
  std::unique_ptr<Compressor> compressor_;
};

/// The head of a chunk from its kChunkHeadBytes; `type` refers to them. Refused: sizes that no writer makes.
Result<ChunkHead> read_chunk_head(std::string_view bytes);
/// The bytes of a whole chunk before compression; reuses the memory of `raw`. Refused: a wrong checksum, and what
/// cannot be decompressed to the stated size.
Status unpack_chunk(std::string_view chunk, std::string& raw);

}  // namespace poise::capture
