// SPDX-License-Identifier: MIT
#include "record/record_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "record/record_bytes.h"

namespace poise::io {
namespace {

// A file is kMagic followed by blocks: kind, uncompressed size, stored size, stored bytes, CRC-32 of all of these.
// Sizes and CRC have four bytes, the lowest first.
constexpr std::string_view kMagic = "poise.record/6\n";
constexpr std::string_view kMagicOfAny = "poise.record/";
constexpr std::size_t kHeadBytes = 9;
constexpr std::size_t kTailBytes = 4;
// Chosen: a frame of ten million pairs is smaller. A larger size is damaged data, for which no memory is allocated.
constexpr std::uint32_t kMostBlockBytes = 1U << 28U;
// The fastest level, since the frame of the run waits for it.
constexpr int kLevel = 1;
// A block that would be compressed further is stored as it is, so that a reader can refuse a size that would take
// memory out of proportion to the file.
constexpr std::uint64_t kFreeBytes = std::uint64_t{1} << 20U;
constexpr std::uint64_t kMostRatio = 8;

bool in_proportion(std::uint64_t raw, std::uint64_t stored) { return raw <= kFreeBytes + kMostRatio * stored; }

constexpr char kHeader = 'H';
constexpr char kScene = 'S';
constexpr char kFrame = 'F';
constexpr char kEnd = 'E';

void put32(std::uint32_t value, std::string& out) {
  for (int byte = 0; byte < 4; ++byte) out.push_back(static_cast<char>(value >> (8 * byte)));
}

std::uint32_t get32(const char* bytes) {
  std::uint32_t value = 0;
  for (int byte = 0; byte < 4; ++byte)
    value |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(bytes[byte])) << (8 * byte);
  return value;
}

// zlib reads through pointers to non-const.
Bytef* bytes_of(const char* text) { return const_cast<Bytef*>(reinterpret_cast<const Bytef*>(text)); }

std::uint32_t crc_of(std::string_view text) {
  return static_cast<std::uint32_t>(::crc32_z(0, bytes_of(text.data()), text.size()));
}

}  // namespace

class ZlibStream {
 public:
  static std::unique_ptr<ZlibStream> packer() {
    auto made = std::unique_ptr<ZlibStream>(new ZlibStream(true));
    return made->sound_ ? std::move(made) : nullptr;
  }
  static std::unique_ptr<ZlibStream> unpacker() {
    auto made = std::unique_ptr<ZlibStream>(new ZlibStream(false));
    return made->sound_ ? std::move(made) : nullptr;
  }
  ~ZlibStream() {
    if (!sound_) return;
    if (packs_) {
      ::deflateEnd(&stream_);
    } else {
      ::inflateEnd(&stream_);
    }
  }
  ZlibStream(const ZlibStream&) = delete;
  ZlibStream& operator=(const ZlibStream&) = delete;

  /// Compresses `raw` and appends the result, which is in proportion to it.
  bool pack(std::string_view raw, std::string& stored) {
    if (raw.size() <= kFreeBytes) return pack_at(kLevel, raw, stored);
    const std::size_t begin = stored.size();
    z_stream before{};
    if (::deflateCopy(&before, &stream_) != Z_OK) return false;
    const bool packed = pack_at(kLevel, raw, stored);
    if (packed && in_proportion(raw.size(), stored.size() - begin)) {
      ::deflateEnd(&before);
      return true;
    }
    // Again from the state before, without compression.
    ::deflateEnd(&stream_);
    sound_ = ::deflateCopy(&stream_, &before) == Z_OK;
    ::deflateEnd(&before);
    stored.resize(begin);
    return packed && sound_ && pack_at(Z_NO_COMPRESSION, raw, stored);
  }
  /// Decompresses into `raw`, which must have `size` bytes; returns false otherwise.
  bool unpack(std::string_view stored, std::size_t size, std::string& raw) {
    std::array<char, 1U << 14U> room;
    raw.clear();
    raw.reserve(size);
    stream_.next_in = bytes_of(stored.data());
    stream_.avail_in = static_cast<uInt>(stored.size());
    do {
      stream_.next_out = bytes_of(room.data());
      stream_.avail_out = static_cast<uInt>(room.size());
      const int done = ::inflate(&stream_, Z_SYNC_FLUSH);
      if (done != Z_OK && done != Z_BUF_ERROR) return false;
      raw.append(room.data(), room.size() - stream_.avail_out);
      if (raw.size() > size) return false;
    } while (stream_.avail_out == 0);
    return stream_.avail_in == 0 && raw.size() == size;
  }

 private:
  bool pack_at(int level, std::string_view raw, std::string& stored) {
    std::array<char, 1U << 14U> room;
    // Everything before was flushed, so that nothing is written where the level changes.
    stream_.next_in = nullptr;
    stream_.avail_in = 0;
    stream_.next_out = bytes_of(room.data());
    stream_.avail_out = static_cast<uInt>(room.size());
    if (level != level_ && ::deflateParams(&stream_, level, Z_DEFAULT_STRATEGY) != Z_OK) return false;
    level_ = level;
    stored.append(room.data(), room.size() - stream_.avail_out);
    stream_.next_in = bytes_of(raw.data());
    stream_.avail_in = static_cast<uInt>(raw.size());
    do {
      stream_.next_out = bytes_of(room.data());
      stream_.avail_out = static_cast<uInt>(room.size());
      const int done = ::deflate(&stream_, Z_SYNC_FLUSH);
      if (done != Z_OK && done != Z_BUF_ERROR) return false;
      stored.append(room.data(), room.size() - stream_.avail_out);
    } while (stream_.avail_out == 0);
    return true;
  }
  explicit ZlibStream(bool packs) : packs_(packs) {
    sound_ = (packs ? deflateInit(&stream_, kLevel) : inflateInit(&stream_)) == Z_OK;
  }
  z_stream stream_{};
  int level_ = kLevel;
  bool packs_;
  bool sound_ = false;
};

RecordWriter::RecordWriter(AtomicFile file) : file_(std::move(file)), zlib_(ZlibStream::packer()) {}
RecordWriter::RecordWriter(RecordWriter&&) noexcept = default;
RecordWriter& RecordWriter::operator=(RecordWriter&&) noexcept = default;
RecordWriter::~RecordWriter() = default;

Result<RecordWriter> RecordWriter::open(const std::filesystem::path& path) {
  Result<AtomicFile> file = AtomicFile::open(path, AtomicFile::Before::Part);
  if (!file) return file.error();
  RecordWriter writer(std::move(file).value());
  if (!writer.zlib_) return Error{ErrorKind::OutputFailed, path.string() + ": cannot be written: no memory"};
  return writer;
}

Status RecordWriter::block(char kind, std::string_view raw) {
  if (!sound_) return sound_;
  const auto refused = [&](const char* reason) -> Status {
    return sound_ = Error{ErrorKind::OutputFailed, file_.path().string() + ": cannot be written: " + reason};
  };
  stored_.assign(1, kind);
  if (raw.size() > kMostBlockBytes) return refused("a frame has more than 256 MiB");
  put32(static_cast<std::uint32_t>(raw.size()), stored_);
  put32(0, stored_);
  if (!zlib_->pack(raw, stored_)) return refused("it cannot be compressed");
  std::string size;
  put32(static_cast<std::uint32_t>(stored_.size() - kHeadBytes), size);
  std::copy(size.begin(), size.end(), stored_.begin() + 5);
  put32(crc_of(stored_), stored_);
  bytes_ += stored_.size();
  return sound_ = file_.write(stored_);
}

Status RecordWriter::begin(const RecordHeader& header) {
  const Status written = file_.write(kMagic);
  if (!written) return written;
  bytes_ = kMagic.size();
  const Status first = block(kHeader, header_json(header));
  if (!first) return first;
  const Status scene = block(kScene, header.scene_text);
  return scene ? flush() : scene;
}

Status RecordWriter::frame(const RecordedFrame& frame, SteadyClock::time_point now) {
  raw_.clear();
  write_frame(frame, raw_);
  const Status written = block(kFrame, raw_);
  if (!written) return written;
  ++frames_;
  if ((frames_ > 1 && now - flushed_ < kRecordFlushInterval)) return written;
  flushed_ = now;
  return flush();
}

Status RecordWriter::finish(bool stopped) {
  raw_.clear();
  write_end({frames_, stopped}, raw_);
  const Status written = block(kEnd, raw_);
  const Status closed = file_.commit_what_is_whole();
  return closed ? written : closed;
}

RecordReader::RecordReader() : zlib_(ZlibStream::unpacker()) {}
RecordReader::RecordReader(RecordReader&&) noexcept = default;
RecordReader& RecordReader::operator=(RecordReader&&) noexcept = default;
RecordReader::~RecordReader() = default;

Result<RecordReader> RecordReader::open(const std::filesystem::path& path) {
  RecordReader reader;
  reader.name_ = path.string();
  Result<geometry::OpenFile> file = geometry::OpenFile::open(path);
  if (!file) return bad_input(reader.name_ + ": " + file.error().message);
  reader.file_ = std::move(file).value();
  reader.size_ = reader.file_->bytes();
  if (!reader.zlib_) return bad_input(reader.name_ + ": cannot be read: no memory");
  const Status begun = reader.begin();
  if (!begun) return bad_input(reader.name_ + ": " + begun.error().message);
  return reader;
}

Status RecordReader::begin() {
  std::string magic(std::min<std::uint64_t>(kMagic.size(), size_), '\0');
  if (!file_->read(0, magic)) return bad_input("the file cannot be read");
  if (magic != kMagic) {
    if (!magic.starts_with(kMagicOfAny)) return bad_input("not a record of poise run --record");
    return bad_input("a record of another version, must be " + std::string(kMagic.substr(0, kMagic.size() - 1)));
  }
  at_ = kMagic.size();
  const Result<Block> header = block();
  if (!header) return bad_input("the beginning is damaged: " + header.error().message);
  if (header.value().kind != kHeader) return bad_input("the beginning is damaged: it has no header");
  Result<RecordHeader> read = read_header(header.value().raw, "header");
  if (!read) return read.error();
  header_ = std::move(read).value();
  const Result<Block> scene = block();
  if (!scene) return bad_input("the beginning is damaged: " + scene.error().message);
  if (scene.value().kind != kScene) return bad_input("the beginning is damaged: it has no scene");
  header_.scene_text = scene.value().raw;
  return Done{};
}

Result<RecordReader::Block> RecordReader::block() {
  const std::uint64_t left = size_ - at_;
  if (left == 0) return bad_input("the file ends here, before the end of the run");
  if (left < kHeadBytes + kTailBytes) return bad_input("the file ends within a block");
  stored_.resize(kHeadBytes);
  if (!file_->read(at_, stored_)) return bad_input("the file cannot be read");
  const std::uint32_t raw_bytes = get32(stored_.data() + 1);
  const std::uint32_t stored_bytes = get32(stored_.data() + 5);
  if (stored_bytes > left - kHeadBytes - kTailBytes)
    return bad_input("the file ends within a block, or the block's length is damaged");
  if (raw_bytes > kMostBlockBytes || stored_bytes > kMostBlockBytes || !in_proportion(raw_bytes, size_))
    return bad_input("the block's length is damaged");
  stored_.resize(kHeadBytes + stored_bytes + kTailBytes);
  if (!file_->read(at_ + kHeadBytes, std::span(stored_).subspan(kHeadBytes)))
    return bad_input("the file cannot be read");
  const std::string_view checked = std::string_view(stored_).substr(0, kHeadBytes + stored_bytes);
  if (crc_of(checked) != get32(stored_.data() + checked.size()))
    return bad_input("the block's checksum is not that of its bytes");
  if (!zlib_->unpack(checked.substr(kHeadBytes), raw_bytes, raw_)) return bad_input("the block cannot be decompressed");
  at_ += stored_.size();
  return Block{stored_[0], raw_};
}

RecordReader::Next RecordReader::damaged(std::string what) {
  damage_ = Damage{at_, std::move(what)};
  return Next::Damaged;
}

RecordReader::Next RecordReader::next(RecordedFrame& frame) {
  if (damage_) return Next::Damaged;
  if (ended_) return Next::End;
  const std::uint64_t begin = at_;
  const Result<Block> found = block();
  if (!found) return damaged(found.error().message);
  const auto refuse = [&](std::string what) {
    at_ = begin;
    return damaged(std::move(what));
  };
  if (found.value().kind == kFrame) {
    const Status read = read_frame(found.value().raw, frame);
    if (!read) return refuse(read.error().message);
    if (frame.decisions.frame != frames_)
      return refuse(fmt::format("frame {} stands where frame {} should", frame.decisions.frame, frames_));
    ++frames_;
    return Next::Frame;
  }
  if (found.value().kind != kEnd) return refuse("a block of no known kind");
  const Status read = read_end(found.value().raw, end_);
  if (!read) return refuse(read.error().message);
  if (end_.frames != frames_)
    return refuse(fmt::format("the end counts {} frames, {} are there", end_.frames, frames_));
  if (at_ != size_) return damaged("something stands behind the end");
  ended_ = true;
  return Next::End;
}

}  // namespace poise::io
