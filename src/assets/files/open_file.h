// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "poise/result.h"

namespace poise::geometry {

/// A regular file that is open for reading. Every reader of files opens them here, so that none waits for a pipe or
/// reads a device without end. Invariant: owns its descriptor.
class OpenFile {
 public:
  /// Refused as BadInput, without the name of the file: what is not there, is no regular file or cannot be opened.
  static Result<OpenFile> open(const std::filesystem::path& path);
  OpenFile(OpenFile&& other) noexcept;
  OpenFile& operator=(OpenFile&& other) noexcept;
  ~OpenFile();

  /// When it was opened.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  /// Fills `target` with the bytes from `at` on; false if there are fewer, or the system reports an error.
  [[nodiscard]] bool read(std::uint64_t at, std::span<char> target) const;

 private:
  OpenFile(int descriptor, std::uint64_t bytes) : descriptor_(descriptor), bytes_(bytes) {}
  int descriptor_ = -1;
  std::uint64_t bytes_ = 0;
};

}  // namespace poise::geometry
