// SPDX-License-Identifier: MIT
#include "capture/chunks.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <zstd.h>

#include "capture/bytes.h"

namespace poise::capture {
namespace {

constexpr int kLevel = 3;
// A chunk that would be compressed further is stored as it is, so that a reader can refuse a size that would take
// memory out of proportion to the file.
constexpr std::uint64_t kFreeBytes = std::uint64_t{1} << 20U;
constexpr std::uint64_t kMostRatio = 16;

bool in_proportion(std::uint64_t raw, std::uint64_t stored) { return raw <= kFreeBytes + kMostRatio * stored; }

std::uint32_t checksum(std::string_view bytes) { return XXH32(bytes.data(), bytes.size(), 0); }

}  // namespace

struct ChunkPacker::Compressor {
  Compressor() : context(ZSTD_createCCtx()) {}
  ~Compressor() { ZSTD_freeCCtx(context); }
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;
  ZSTD_CCtx* context;
};

ChunkPacker::ChunkPacker() : compressor_(std::make_unique<Compressor>()) {}
ChunkPacker::ChunkPacker(ChunkPacker&&) noexcept = default;
ChunkPacker& ChunkPacker::operator=(ChunkPacker&&) noexcept = default;
ChunkPacker::~ChunkPacker() = default;

Status ChunkPacker::add(std::string_view type, std::string_view raw, std::string& out) {
  if (raw.size() > kMostChunkBytes)
    return Error{ErrorKind::OutputFailed, fmt::format("a chunk {} has more than 1 GiB", type)};
  if (compressor_->context == nullptr) return Error{ErrorKind::OutputFailed, "no memory to compress in"};
  const std::size_t begin = out.size();
  const std::size_t most = ZSTD_compressBound(raw.size());
  out.resize(begin + kChunkHeadBytes + most);
  char* const payload = out.data() + begin + kChunkHeadBytes;
  std::size_t stored = ZSTD_compressCCtx(compressor_->context, payload, most, raw.data(), raw.size(), kLevel);
  if (ZSTD_isError(stored) != 0)
    return Error{ErrorKind::OutputFailed, fmt::format("it cannot be compressed: {}", ZSTD_getErrorName(stored))};
  if (stored >= raw.size() || !in_proportion(raw.size(), stored)) {
    stored = raw.size();
    raw.copy(payload, raw.size());
  }
  out.resize(begin + kChunkHeadBytes + stored);
  std::string head(type);
  put(static_cast<std::uint32_t>(raw.size()), head);
  put(static_cast<std::uint32_t>(stored), head);
  out.replace(begin, kChunkHeadBytes, head);
  put(checksum(std::string_view(out).substr(begin)), out);
  return Done{};
}

Result<ChunkHead> read_chunk_head(std::string_view bytes) {
  ByteReader reader(bytes);
  ChunkHead head;
  head.type = reader.take(4);
  head.raw = reader.get<std::uint32_t>();
  head.stored = reader.get<std::uint32_t>();
  if (!reader.sound()) return bad_input("the file ends within the head of a chunk");
  if (head.raw > kMostChunkBytes || head.stored > ZSTD_compressBound(head.raw) || !in_proportion(head.raw, head.stored))
    return bad_input(
        fmt::format("a chunk of {} bytes, {} before compression: no writer makes one", head.stored, head.raw));
  return head;
}

Status unpack_chunk(std::string_view chunk, std::string& raw) {
  const Result<ChunkHead> head = read_chunk_head(chunk.substr(0, kChunkHeadBytes));
  if (!head) return head.error();
  const std::uint32_t stored = head.value().stored;
  if (chunk.size() != kChunkHeadBytes + std::size_t{stored} + kChunkTailBytes)
    return bad_input("the file ends within a chunk");
  ByteReader tail(chunk.substr(chunk.size() - kChunkTailBytes));
  if (checksum(chunk.substr(0, chunk.size() - kChunkTailBytes)) != tail.get<std::uint32_t>())
    return bad_input("the checksum of a chunk is not that of its bytes");
  const std::string_view payload = chunk.substr(kChunkHeadBytes, stored);
  if (stored == head.value().raw) {
    raw.assign(payload);
    return Done{};
  }
  raw.resize(head.value().raw);
  const std::size_t got = ZSTD_decompress(raw.data(), raw.size(), payload.data(), payload.size());
  if (ZSTD_isError(got) != 0 || got != raw.size())
    return bad_input("a chunk cannot be decompressed to the size that it states");
  return Done{};
}

}  // namespace poise::capture
