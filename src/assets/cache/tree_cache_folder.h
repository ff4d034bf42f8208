// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace poise::geometry {

enum class EntryRead : std::uint8_t {
  Missing,
  Found,     ///< its bytes were read, valid or not
  Unusable,  ///< the path exists, but it is not a readable file of a valid size
};

/// Reads a whole file of the cache. Never blocks: a pipe in its place is not opened for its data.
EntryRead read_entry(const std::filesystem::path& file, std::uint64_t most_bytes, std::string& bytes);

/// Marks an entry as used now. A failure is ignored.
void touch_entry(const std::filesystem::path& file);

/// Writes an entry to a temporary file and renames it; creates a missing folder. Returns false on failure.
bool write_entry(const std::filesystem::path& file, std::string_view bytes);

/// Removes the least recently used entries until all together have at most `limit_bytes`, but never `kept`. Also
/// removes what killed programs left of entries (PartFile). Other files are not touched. Returns the number of removed
/// entries.
std::size_t keep_limit(const std::filesystem::path& kept, std::uint64_t limit_bytes);

}  // namespace poise::geometry
