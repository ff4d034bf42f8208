// SPDX-License-Identifier: MIT
#include "capture/capture_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "capture/bytes.h"
#include "capture/chunks.h"
#include "capture/frame_code.h"

namespace poise::capture {
namespace {

/// Frames of a block and the number of its first.
Result<BlockPlace> place_of(std::string_view raw, std::uint64_t at) {
  ByteReader bytes(raw);
  BlockPlace place;
  place.at = at;
  place.frames = bytes.get<std::uint32_t>();
  bytes.get<std::uint32_t>();
  place.first_frame = bytes.get<std::uint64_t>();
  if (!bytes.sound() || place.frames < 1 || place.frames > kMostBlockFrames)
    return bad_input(fmt::format("FRAM: frames = {}, must be 1 to {}", place.frames, kMostBlockFrames));
  return place;
}

}  // namespace

Result<CaptureReader> CaptureReader::open(const std::filesystem::path& path) {
  CaptureReader reader;
  reader.name_ = path.string();
  Result<geometry::OpenFile> file = geometry::OpenFile::open(path);
  if (!file) return bad_input(reader.name_ + ": " + file.error().message);
  reader.file_ = std::move(file).value();
  reader.size_ = reader.file_->bytes();
  const Status begun = reader.begin();
  if (!begun) return begun.error();
  if (!reader.read_by_index()) reader.read_in_order(reader.shapes_end_);
  return reader;
}

Error CaptureReader::failed(std::uint64_t at, const std::string& what) const {
  return bad_input(fmt::format("{}: byte {}: {}", name_, at, what));
}

// Reads a chunk into stored_ and raw_; returns its type.
Result<std::string> CaptureReader::chunk_at(std::uint64_t at) {
  const std::uint64_t left = size_ - std::min(at, size_);
  if (left < kChunkHeadBytes + kChunkTailBytes) return bad_input("the file ends within a chunk");
  stored_.resize(kChunkHeadBytes);
  if (!file_->read(at, stored_)) return bad_input("the file cannot be read");
  const Result<ChunkHead> head = read_chunk_head(stored_);
  if (!head) return head.error();
  const std::size_t stored = head.value().stored;
  if (stored > left - kChunkHeadBytes - kChunkTailBytes) return bad_input("the file ends within a chunk");
  std::string type(head.value().type);
  stored_.resize(kChunkHeadBytes + stored + kChunkTailBytes);
  if (!file_->read(at + kChunkHeadBytes, std::span(stored_).subspan(kChunkHeadBytes)))
    return bad_input("the file cannot be read");
  const Status unpacked = unpack_chunk(stored_, raw_);
  if (!unpacked) return unpacked.error();
  return type;
}

// Those of a block that ends here; empty where the file has none for it.
Result<std::vector<FrameSums>> CaptureReader::sums_at(std::uint64_t at, std::size_t frames) {
  std::vector<FrameSums> none;
  // What is behind the frames may be cut off or damaged: the frames are whole, and that was told.
  if (damage_ && damage_->byte <= at) return none;
  // Another chunk that is in order here is not read.
  std::string head(kChunkHeadBytes, '\0');
  if (at > size_ || size_ - at < head.size() || !file_->read(at, head)) return none;
  for (const std::string_view other : {kFramesChunk, kBodiesChunk, kPairsChunk, kIndexChunk}) {
    if (head.starts_with(other)) return none;
  }
  const Result<std::string> type = chunk_at(at);
  if (!type) return failed(at, type.error().message);
  if (type.value() != kSumsChunk) return none;
  Result<std::vector<FrameSums>> sums = read_sums(raw_, frames);
  return sums ? sums : failed(at, sums.error().message);
}

Status CaptureReader::begin() {
  std::string magic(std::min<std::uint64_t>(kMagic.size(), size_), '\0');
  if (!file_->read(0, magic)) return bad_input(name_ + ": cannot be read");
  if (magic != kMagic) {
    if (size_ == 0) return bad_input(name_ + ": is empty: not a capture, or its run was killed before it began");
    if (!magic.starts_with(kMagicOfAny)) return bad_input(name_ + ": not a capture of poise run --capture");
    return bad_input(fmt::format("{}: a capture of another version, must be {}", name_, kSchema));
  }
  std::uint64_t at = kMagic.size();
  const Result<std::string> type = chunk_at(at);
  if (!type) return failed(at, type.error().message);
  if (type.value() != kHeaderChunk) return failed(at, "the first chunk is not HEAD");
  Result<CaptureHeader> header = read_header(raw_);
  if (!header) return failed(at, header.error().message);
  header_ = std::move(header).value();
  at += stored_.size();
  const Status shapes = read_shapes(at);
  shapes_end_ = at;
  return shapes;
}

Status CaptureReader::read_shapes(std::uint64_t& at) {
  for (std::size_t i = 0; i < header_.shapes.size(); ++i) {
    const Result<std::string> type = chunk_at(at);
    if (!type) return failed(at, type.error().message);
    if (type.value() != kShapeChunk)
      return failed(at, fmt::format("has {} shapes, HEAD.shapes has {}", i, header_.shapes.size()));
    const Status read = read_shape(raw_, static_cast<std::uint32_t>(i), header_.shapes[i]);
    if (!read) return failed(at, read.error().message);
    at += stored_.size();
  }
  return Done{};
}

// False where the index cannot be used: then nothing was changed.
bool CaptureReader::read_by_index() {
  if (size_ < shapes_end_ + kTrailerBytes) return false;
  std::string trailer(kTrailerBytes, '\0');
  if (!file_->read(size_ - kTrailerBytes, trailer) || !trailer.ends_with(kTrailerMagic)) return false;
  const auto at = ByteReader(trailer).get<std::uint64_t>();
  if (at < shapes_end_ || at >= size_) return false;
  const Result<std::string> type = chunk_at(at);
  if (!type || type.value() != kIndexChunk || at + stored_.size() + kTrailerBytes != size_) return false;
  Result<CaptureIndex> index = read_index(raw_);
  if (!index) return false;
  std::uint64_t frames = 0;
  std::uint64_t before = 0;
  for (const BlockPlace& block : index.value().blocks) {
    if (block.at <= before || block.at >= at || block.frames == 0) return false;
    before = block.at;
    frames += block.frames;
  }
  if (frames != index.value().end.frames) return false;
  std::vector<CapturedBody> bodies;
  for (const std::uint64_t place : index.value().bodies) {
    const Result<std::string> found = chunk_at(place);
    if (!found || found.value() != kBodiesChunk || !read_bodies(raw_, header_, bodies)) return false;
  }
  bodies_ = std::move(bodies);
  blocks_ = std::move(index.value().blocks);
  frames_ = frames;
  end_ = index.value().end;
  return true;
}

Status CaptureReader::take_chunk(const std::string& type, std::uint64_t at) {
  if (type == kBodiesChunk) {
    const std::size_t before = bodies_.size();
    const Status read = read_bodies(raw_, header_, bodies_);
    if (!read) bodies_.resize(before);
    return read;
  }
  if (type == kFramesChunk) {
    const Result<BlockPlace> place = place_of(raw_, at);
    if (!place) return place.error();
    if (!blocks_.empty() && place.value().first_frame <= blocks_.back().first_frame)
      return bad_input(
          fmt::format("FRAM: its first frame {} does not follow on those before", place.value().first_frame));
    blocks_.push_back(place.value());
    frames_ += place.value().frames;
  } else if (type == kIndexChunk) {
    const Result<CaptureIndex> index = read_index(raw_);
    if (!index) return index.error();
    end_ = index.value().end;
  }
  return Done{};
}

void CaptureReader::read_in_order(std::uint64_t at) {
  while (!end_) {
    if (at == size_) {
      damage_ = Damage{at, "the file ends here, before the end of the run"};
      return;
    }
    const Result<std::string> type = chunk_at(at);
    const Status taken = type ? take_chunk(type.value(), at) : Status(type.error());
    if (!taken) {
      damage_ = Damage{at, taken.error().message};
      return;
    }
    at += stored_.size();
  }
  if (end_->frames != frames_) {
    damage_ = Damage{at, fmt::format("the index counts {} frames, {} are there", end_->frames, frames_)};
  } else {
    damage_ = Damage{at, "the trailer is not that of the index"};
  }
}

Status CaptureReader::read_block(std::size_t block, const FrameSink& sink) {
  if (block >= blocks_.size())
    return bad_input(fmt::format("{}: block {}, must be below {}", name_, block, blocks_.size()));
  const BlockPlace& place = blocks_[block];
  const Result<std::string> type = chunk_at(place.at);
  if (!type) return failed(place.at, type.error().message);
  if (type.value() != kFramesChunk) return failed(place.at, "the chunk is not FRAM, which the index names here");
  block_.swap(raw_);
  ByteReader bytes(block_);
  const auto frames = bytes.get<std::uint32_t>();
  if (frames != place.frames)
    return failed(place.at, fmt::format("FRAM: frames = {}, the index has {}", frames, place.frames));
  const Result<std::vector<FrameSums>> sums = sums_at(place.at + stored_.size(), frames);
  if (!sums) return sums.error();
  FrameDecoder decoder({static_cast<std::uint32_t>(bodies_.size()), header_.orientation_steps, header_.contacts});
  PackedFrame frame;
  std::uint64_t least = place.first_frame;
  for (std::uint32_t i = 0; i < frames; ++i) {
    const Status read = decoder.next(bytes, frame);
    if (!read) return failed(place.at, fmt::format("FRAM: frame {} of the block: {}", i, read.error().message));
    if (frame.facts.frame < least || (i == 0 && frame.facts.frame != least))
      return failed(place.at,
                    fmt::format("FRAM: frame = {}, must be {}{}", frame.facts.frame, i == 0 ? "" : "at least ", least));
    least = frame.facts.frame + 1;
    frame.facts.momentum_ns = sums.value().empty() ? FrameFacts{}.momentum_ns : sums.value()[i];
    if (!sink(frame)) return Done{};
  }
  if (bytes.left() != 0) return failed(place.at, fmt::format("FRAM: {} bytes stand behind its frames", bytes.left()));
  return Done{};
}

Status CaptureReader::read_frames(std::uint64_t from, std::uint64_t to, const FrameSink& sink) {
  bool going = true;
  const FrameSink wanted = [&](const PackedFrame& frame) {
    if (frame.facts.frame < from) return true;
    going = frame.facts.frame <= to && sink(frame);
    return going;
  };
  for (std::size_t block = 0; block < blocks_.size() && going; ++block) {
    if (block + 1 < blocks_.size() && blocks_[block + 1].first_frame <= from) continue;
    const Status read = read_block(block, wanted);
    if (!read) return read;
  }
  return Done{};
}

}  // namespace poise::capture
