// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assets/files/open_file.h"
#include "capture/capture.h"
#include "capture/header.h"
#include "capture/packed_pose.h"
#include "capture/sums_code.h"
#include "poise/result.h"

namespace poise::capture {

/// Reads a capture up to its end or to the first chunk that is damaged or cut short. Shapes and the table of bodies
/// stay in memory; of frames one block at a time. One thread at a time.
class CaptureReader {
 public:
  /// Where a file cannot be read on.
  struct Damage {
    std::uint64_t byte = 0;
    std::string what;
  };
  /// Told a frame; false ends the reading.
  using FrameSink = std::function<bool(const PackedFrame&)>;

  /// Refused with the file: a file that is missing, not a capture, of another version, or damaged before its first
  /// frame.
  static Result<CaptureReader> open(const std::filesystem::path& path);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const CaptureHeader& header() const { return header_; }  ///< with all of the shapes
  [[nodiscard]] std::span<const CapturedBody> bodies() const { return bodies_; }
  [[nodiscard]] std::span<const BlockPlace> blocks() const { return blocks_; }
  [[nodiscard]] std::uint64_t frames() const { return frames_; }  ///< of all blocks
  /// What the end says; empty where the file has none, because the run was killed or the file is damaged.
  [[nodiscard]] const std::optional<CaptureEnd>& end() const { return end_; }
  /// Empty if the file is whole, as far as it was read.
  [[nodiscard]] const std::optional<Damage>& damage() const { return damage_; }

  /// Tells the frames of a block to `sink`, in order. Refused with file and byte: a damaged block, which may follow
  /// frames that were told; and a block that is not there.
  Status read_block(std::size_t block, const FrameSink& sink);
  /// The same for all frames from the first whose number is at least `from`, up to the last whose number is at most
  /// `to`.
  Status read_frames(std::uint64_t from, std::uint64_t to, const FrameSink& sink);
  [[nodiscard]] Pose pose(const PackedPose& packed) const {
    return unpack(packed, header_.position_step_m, header_.orientation_steps);
  }

 private:
  CaptureReader() = default;
  Status begin();
  Result<std::string> chunk_at(std::uint64_t at);
  Result<std::vector<FrameSums>> sums_at(std::uint64_t at, std::size_t frames);
  Status read_shapes(std::uint64_t& at);
  bool read_by_index();
  void read_in_order(std::uint64_t at);
  Status take_chunk(const std::string& type, std::uint64_t at);
  [[nodiscard]] Error failed(std::uint64_t at, const std::string& what) const;

  std::string name_;
  std::optional<geometry::OpenFile> file_;
  std::uint64_t size_ = 0;
  std::uint64_t shapes_end_ = 0;
  CaptureHeader header_;
  std::vector<CapturedBody> bodies_;
  std::vector<BlockPlace> blocks_;
  std::uint64_t frames_ = 0;
  std::optional<CaptureEnd> end_;
  std::optional<Damage> damage_;
  std::string stored_, raw_, block_;
};

}  // namespace poise::capture
