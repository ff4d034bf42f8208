// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "capture/bytes.h"
#include "capture/capture.h"
#include "poise/result.h"

/// Frames as bytes, each coded against the one before it in its block (docs/capture.md, FRAM).
namespace poise::capture {

/// What both ends of the code know of a body after a frame.
struct BodyTrack {
  std::uint32_t row = 0;
  bool is_new = true;  ///< no frame of the block has told its pose
  PackedPose pose;
  std::array<std::int64_t, 3> position_step{}, orientation_step{};  ///< changes in the frame before
  std::uint8_t activity = 0, level = 0, priority = 0;
};

/// Codes frames. Invariant: `tracks_` is what a decoder knows after the same frames.
class FrameEncoder {
 public:
  explicit FrameEncoder(bool contacts) : contacts_(contacts) {}
  /// The next frame is the first of a block.
  void begin_block() { tracks_.clear(); }
  /// Appends a frame, with its size before it. Its rows ascend; a row that has left does not come back.
  void add(const PackedFrame& frame, std::string& out);

 private:
  void change_rows(const PackedFrame& frame);
  void put_poses(const PackedFrame& frame);
  void put_bytes(const std::vector<std::uint8_t>& column, std::uint8_t BodyTrack::*held);

  bool contacts_;
  std::vector<BodyTrack> tracks_, next_;
  std::string body_, mask_;
  std::vector<std::uint32_t> list_;
  std::vector<std::array<std::int64_t, 6>> residuals_;
};

/// Reads what FrameEncoder wrote.
class FrameDecoder {
 public:
  /// What frames may refer to.
  struct Limits {
    std::uint32_t rows = 0;  ///< of the table of bodies that were read before the block
    std::uint32_t orientation_steps = 0;
    bool contacts = false;
  };
  explicit FrameDecoder(const Limits& limits) : limits_(limits) {}
  /// Reads the next frame of a block; reuses the memory of `frame`, which is unspecified after a refusal. Refused:
  /// bytes that no encoder writes. Uses memory in proportion to the bytes.
  Status next(ByteReader& bytes, PackedFrame& frame);

 private:
  Status change_rows(ByteReader& bytes);
  Status get_poses(ByteReader& bytes);
  Status get_bytes(ByteReader& bytes, const char* name, std::uint8_t most, std::uint8_t BodyTrack::*held);
  Status get_contacts(ByteReader& bytes, PackedFrame& frame);
  bool get_mask(ByteReader& bytes, std::vector<std::uint32_t>& set) const;

  Limits limits_;
  std::vector<BodyTrack> tracks_, next_;
  std::vector<std::uint32_t> removed_, added_, set_;
};

/// The fixed part of a frame.
void put_facts(const FrameFacts& facts, std::string& out);
/// Refused: flags or causes that do not exist, and numbers that are not finite where they must be.
Status get_facts(ByteReader& bytes, FrameFacts& facts);

}  // namespace poise::capture
