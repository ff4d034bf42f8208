// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "poise/result.h"

namespace poise::app {

/// Keeps other sweeps out of a folder as long as it lives; the system ends it with the program, however that ends.
/// Invariant: owns a locked descriptor.
class FolderLock {
 public:
  /// Refused: another program has it, or the folder cannot be written.
  static Result<FolderLock> take(const std::filesystem::path& folder);
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  ~FolderLock();

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace poise::app
