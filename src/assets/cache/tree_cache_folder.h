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
  Found,     ///< its bytes were read, whatever they are
  Unusable,  ///< something stands there that is not a readable file of a sound size
};

/// Reads a file of the cache whole. Never waits: a pipe in its place is not opened for its data.
EntryRead read_entry(const std::filesystem::path& file, std::uint64_t most_bytes, std::string& bytes);

/// Marks an entry as used now. Failing does no harm.
void touch_entry(const std::filesystem::path& file);

/// Puts an entry in its place by renaming; makes the folder where it is missing. False if that cannot be.
bool write_entry(const std::filesystem::path& file, std::string_view bytes);

/// Removes the entries that were not used for longest until all together have at most `limit_bytes`, never `kept`, and
/// what writers that died left more than an hour before `kept` was written. Files that are not of the cache are not
/// touched. Returns how many entries went.
std::size_t keep_limit(const std::filesystem::path& kept, std::uint64_t limit_bytes);

}  // namespace poise::geometry
