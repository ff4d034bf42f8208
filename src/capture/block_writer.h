// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture_writer.h"
#include "capture/chunks.h"
#include "capture/frame_code.h"
#include "capture/frame_packer.h"
#include "capture/header.h"
#include "capture/sums_code.h"

namespace poise::capture {

/// Makes the bytes of a capture of frames, one after the other. Invariant: `index_` has the places of all chunks that
/// were made.
class BlockWriter {
 public:
  /// Appends what stands before the first frame.
  Status begin(const CaptureHeader& header, std::string& out);
  /// Appends the chunks that end with this frame, if any.
  Status add(const SeenFrame& frame, std::string& out);
  /// Appends the last block, the index and the trailer.
  Status finish(std::uint64_t left_out, bool stopped, std::string& out);

 private:
  Status chunk(std::string_view type, std::string_view raw, std::string& out);
  Status end_block(std::string& out);

  ChunkPacker packer_;
  std::optional<FramePacker> frames_;
  std::optional<FrameEncoder> encoder_;
  std::vector<CapturedBody> pending_;  // rows of this block
  std::string block_;
  bool with_pairs_ = false;
  std::string pairs_block_;
  std::vector<FrameSums> sums_;  // of the frames of this block
  std::uint32_t block_frames_ = 0;
  std::uint64_t block_first_ = 0;
  std::uint64_t at_ = 0;  // where the next chunk is put in the file
  CaptureIndex index_;
};

}  // namespace poise::capture
