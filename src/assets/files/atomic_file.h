// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "poise/result.h"

namespace poise::geometry {

/// A file that appears complete or not at all: written to a temporary file in the same folder and renamed by commit().
/// Devices and pipes are written to directly. Invariant: while open, the descriptor is valid and, for a regular file,
/// the temporary file exists. Without a commit the destructor removes it.
class AtomicFile {
 public:
  /// Refused as OutputFailed with the path and the system's reason: a missing folder, no permission, or a path that is
  /// a folder.
  static Result<AtomicFile> open(const std::filesystem::path& path);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  ~AtomicFile();

  /// Buffers text and writes it in blocks. A failure is stored, and commit() returns it too.
  Status write(std::string_view text);
  /// Hands what is buffered to the system, so that it outlives the program.
  Status flush();
  /// Writes the rest, closes and renames. The file is closed afterwards, whatever the result.
  Status commit();
  [[nodiscard]] const std::filesystem::path& path() const { return shown_; }

 private:
  AtomicFile() = default;
  void discard();
  Error failed(int reason) const;

  std::filesystem::path shown_;      ///< the caller's path
  std::filesystem::path target_;     ///< the path with links resolved
  std::filesystem::path temporary_;  ///< empty: the target is written directly
  std::string buffer_;
  int descriptor_ = -1;
  int failure_ = 0;
};

/// Writes `text` to a file that appears complete or not at all.
Status write_file(const std::filesystem::path& path, std::string_view text);

/// Writes all of `text` to an open descriptor. Returns 0 or the error number.
int write_all(int descriptor, std::string_view text);

}  // namespace poise::geometry
