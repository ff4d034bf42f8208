// SPDX-License-Identifier: MIT
#include "capture/block_writer.h"

#include <algorithm>
#include <span>

#include "capture/bytes.h"

namespace poise::capture {
namespace {

// A reader that takes JSON apart needs memory for a chunk at a time. Chosen.
constexpr std::size_t kRowsOfChunk = 10'000;

}  // namespace

Status BlockWriter::chunk(std::string_view type, std::string_view raw, std::string& out) {
  const std::size_t before = out.size();
  const Status added = packer_.add(type, raw, out);
  at_ += out.size() - before;
  return added;
}

Status BlockWriter::begin(const CaptureHeader& header, std::string& out) {
  frames_.emplace(header.position_step_m, header.orientation_steps);
  encoder_.emplace(header.contacts);
  with_pairs_ = header.pairs;
  out += kMagic;
  at_ = kMagic.size();
  Status written = chunk(kHeaderChunk, header_json(header), out);
  for (std::size_t i = 0; i < header.shapes.size() && written; ++i)
    written = chunk(kShapeChunk, shape_bytes(static_cast<std::uint32_t>(i), header.shapes[i]), out);
  return written;
}

Status BlockWriter::add(const SeenFrame& frame, std::string& out) {
  pending_.insert(pending_.end(), frame.new_bodies.begin(), frame.new_bodies.end());
  const PackedFrame& packed = frames_->pack(frame);
  if (with_pairs_) {
    if (block_frames_ == 0) {
      pairs_block_.clear();
      put(std::uint32_t{0}, pairs_block_);
    }
    put_pairs(frame.facts.frame, frames_->pack_pairs(frame), pairs_block_);
  }
  if (block_frames_ == 0) {
    block_.clear();
    put(std::uint32_t{0}, block_);
    block_first_ = frame.facts.frame;
    encoder_->begin_block();
  }
  encoder_->add(packed, block_);
  sums_.push_back(frame.facts.momentum_ns);
  ++block_frames_;
  ++index_.end.frames;
  return block_frames_ == kMostBlockFrames || block_.size() >= kBlockBytes ? end_block(out) : Status(Done{});
}

Status BlockWriter::end_block(std::string& out) {
  if (block_frames_ == 0) return Done{};
  const std::size_t first = frames_->rows() - pending_.size();
  for (std::size_t done = 0; done < pending_.size(); done += kRowsOfChunk) {
    const std::span<const CapturedBody> rows =
        std::span(pending_).subspan(done, std::min(kRowsOfChunk, pending_.size() - done));
    index_.bodies.push_back(at_);
    const Status written = chunk(kBodiesChunk, bodies_json(first + done, rows), out);
    if (!written) return written;
  }
  pending_.clear();
  std::string count;
  put(block_frames_, count);
  block_.replace(0, count.size(), count);
  index_.blocks.push_back({at_, block_first_, block_frames_});
  block_frames_ = 0;
  Status written = chunk(kFramesChunk, block_, out);
  const std::string sums = sums_bytes(sums_);
  sums_.clear();
  if (written && !sums.empty()) written = chunk(kSumsChunk, sums, out);
  if (!written || !with_pairs_) return written;
  pairs_block_.replace(0, count.size(), count);
  return chunk(kPairsChunk, pairs_block_, out);
}

Status BlockWriter::finish(std::uint64_t left_out, bool stopped, std::string& out) {
  Status written = end_block(out);
  if (!written) return written;
  index_.end.left_out = left_out;
  index_.end.stopped = stopped;
  const std::uint64_t at = at_;
  written = chunk(kIndexChunk, index_json(index_), out);
  put(at, out);
  out += kTrailerMagic;
  return written;
}

}  // namespace poise::capture
