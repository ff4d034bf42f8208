// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "assets/files/open_file.h"
#include "poise/result.h"
#include "poise/time_arithmetic.h"
#include "record/record.h"
#include "scene/result_file.h"

namespace poise::io {

/// Each time that frames are handed to the system costs some 10 us; what is not is lost where a run is killed. Chosen.
inline constexpr std::chrono::milliseconds kRecordFlushInterval{250};

/// Compresses or decompresses successive blocks as one zlib stream, each block complete to its last byte.
class ZlibStream;

/// Writes a record during its run. The file appears when it is complete. If the program is killed, `.NAME.N.part`
/// remains in the same folder; it can be replayed: the header, the first frame, and all frames up to the last that came
/// kRecordFlushInterval or more after the one before that was handed over. It goes when the same record is written
/// again to its end. One thread at a time.
class RecordWriter {
 public:
  /// Refused as AtomicFile refuses.
  static Result<RecordWriter> open(const std::filesystem::path& path);
  RecordWriter(RecordWriter&&) noexcept;
  RecordWriter& operator=(RecordWriter&&) noexcept;
  ~RecordWriter();

  /// Call once, before the first frame.
  Status begin(const RecordHeader& header);
  /// Appends a frame that ended at `now`; call in order. The first frame, and each that ended kRecordFlushInterval or
  /// more after the last such one, is handed to the system with all before it, so that they outlive the program.
  Status frame(const RecordedFrame& frame, SteadyClock::time_point now);
  /// Closes the record and renames the file. Refused: what could not be written, now or before; the frames that were
  /// written whole are then a record that is cut short.
  Status finish(bool stopped);
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  explicit RecordWriter(AtomicFile file);
  Status block(char kind, std::string_view raw);
  Status flush() { return file_.flush(); }

  AtomicFile file_;
  std::unique_ptr<ZlibStream> zlib_;
  std::string raw_, stored_;
  std::uint64_t frames_ = 0;
  Status sound_ = Done{};  ///< the first failure
  std::uint64_t bytes_ = 0;
  SteadyClock::time_point flushed_;
};

/// Reads a record up to its end or to the first damaged block. One thread at a time.
class RecordReader {
 public:
  /// Refused with the file: a file that is missing, not a record, of another version, or damaged at its beginning.
  static Result<RecordReader> open(const std::filesystem::path& path);
  RecordReader(RecordReader&&) noexcept;
  RecordReader& operator=(RecordReader&&) noexcept;
  ~RecordReader();

  [[nodiscard]] const RecordHeader& header() const { return header_; }

  enum class Next : std::uint8_t { Frame, End, Damaged };
  /// Reads the next frame into `frame`, whose capacity is reused. After End or Damaged it returns the same again.
  Next next(RecordedFrame& frame);
  /// After End: how the run ended.
  [[nodiscard]] const RecordEnd& end() const { return end_; }
  /// After Damaged: the byte offset of the block that cannot be read, and what is wrong with it.
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
  std::optional<geometry::OpenFile> file_;
  std::unique_ptr<ZlibStream> zlib_;
  std::string raw_, stored_;
  std::uint64_t size_ = 0;    ///< of the file, when it was opened
  std::uint64_t at_ = 0;      ///< offset of the next block
  std::uint64_t frames_ = 0;  ///< number read so far
  RecordHeader header_;
  RecordEnd end_;
  bool ended_ = false;
  std::optional<Damage> damage_;
};

}  // namespace poise::io
