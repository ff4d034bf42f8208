// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "poise/result.h"
#include "record/record.h"
#include "scene/result_file.h"

namespace poise::io {

/// Squeezes or restores blocks that follow each other as one stream of zlib, each to its last byte.
class Squeeze;

/// Writes a record as its run goes. The file appears when it is whole; a program that is killed leaves a part beside
/// its place whose name ends in `.part` and that replays. One thread at a time.
class RecordWriter {
 public:
  /// Refused as AtomicFile refuses.
  static Result<RecordWriter> open(const std::filesystem::path& path);
  RecordWriter(RecordWriter&&) noexcept;
  RecordWriter& operator=(RecordWriter&&) noexcept;
  ~RecordWriter();

  /// Once, before the first frame.
  Status begin(const RecordHeader& header);
  /// Frames in order.
  Status frame(const RecordedFrame& frame);
  /// Closes the record and gives the file its name.
  Status finish(bool stopped);
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  explicit RecordWriter(AtomicFile file);
  Status block(char kind, std::string_view raw);

  AtomicFile file_;
  std::unique_ptr<Squeeze> squeeze_;
  std::string raw_, stored_;
  std::uint64_t frames_ = 0;
  std::uint64_t bytes_ = 0;
};

/// Reads a record up to its end or to the first damage. One thread at a time.
class RecordReader {
 public:
  /// Refused with the file: none, no record, one of another version, or one whose beginning is damaged.
  static Result<RecordReader> open(const std::filesystem::path& path);
  RecordReader(RecordReader&&) noexcept;
  RecordReader& operator=(RecordReader&&) noexcept;
  ~RecordReader();

  [[nodiscard]] const RecordHeader& header() const { return header_; }

  enum class Next : std::uint8_t { Frame, End, Damaged };
  /// The next frame into `frame`, whose room is used again. After End or Damaged it stays at that.
  Next next(RecordedFrame& frame);
  /// After End: how the run ended.
  [[nodiscard]] const RecordEnd& end() const { return end_; }
  /// After Damaged: the byte of the file where the block begins that cannot be read, and what is wrong with it.
  struct Damage {
    std::uint64_t byte = 0;
    std::string what;
  };
  [[nodiscard]] const std::optional<Damage>& damage() const { return damage_; }

 private:
  struct Block {
    char kind = 0;
    std::string_view raw;
  };
  RecordReader();
  Status begin();
  Result<Block> block();
  Next damaged(std::string what);

  std::string name_;
  std::ifstream stream_;
  std::unique_ptr<Squeeze> squeeze_;
  std::string raw_, stored_;
  std::uint64_t size_ = 0;    ///< of the file
  std::uint64_t at_ = 0;      ///< the next block
  std::uint64_t frames_ = 0;  ///< read
  RecordHeader header_;
  RecordEnd end_;
  bool ended_ = false;
  std::optional<Damage> damage_;
};

}  // namespace poise::io
