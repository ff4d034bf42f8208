// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "poise/result.h"

namespace poise::geometry {

/// A regular file that is open for reading, at its beginning.
struct OpenFile {
  std::ifstream stream;
  std::uint64_t bytes = 0;  ///< when it was opened
};

/// Refused as BadInput, with the name of the file: what is not there, is no regular file or cannot be opened.
Result<OpenFile> open_file(const std::filesystem::path& path);

}  // namespace poise::geometry
