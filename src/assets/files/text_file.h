// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "poise/result.h"

namespace poise::geometry {

/// The bytes of a regular file. Refused without the file: a file that is missing, a pipe or a device, cannot be read or
/// is larger than `limit_bytes`.
Result<std::string> read_bytes(const std::filesystem::path& file, std::uint64_t limit_bytes);

/// The same; a refusal begins with the file.
Result<std::string> read_text_file(const std::filesystem::path& file, std::uint64_t limit_bytes);

}  // namespace poise::geometry
