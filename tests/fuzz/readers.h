// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>

/// Every reader of what may come from strangers, as a function of bytes (docs/reliability.md).
namespace poise::fuzz {

struct Reader {
  std::string_view name;  ///< also of its folder of seeds
  /// Reads and ends the program where it breaks a promise: an error has one line that says something, a mesh has only
  /// corners that exist and finite coordinates, and so on. True if the bytes were accepted.
  bool (*read)(std::string_view bytes);
};

std::span<const Reader> readers();

/// None of this name: nullptr.
const Reader* find_reader(std::string_view name);

}  // namespace poise::fuzz
