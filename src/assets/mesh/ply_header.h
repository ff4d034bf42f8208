// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"

namespace poise::geometry {

enum class PlyType : std::uint8_t { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

/// Bytes of a number in a binary file.
std::size_t size_of(PlyType type);
bool is_whole(PlyType type);

struct PlyProperty {
  std::string_view name;
  PlyType type = PlyType::Float32;
  std::optional<PlyType> count;  ///< of a list: the type of its length
};

struct PlyElement {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  [[nodiscard]] std::optional<std::size_t> find(std::string_view property) const;
  /// Bytes that an entry takes at least.
  [[nodiscard]] std::size_t least_bytes(bool is_text) const;
};

enum class PlyForm : std::uint8_t { Text, LittleEndFirst, BigEndFirst };

struct PlyHeader {
  PlyForm form = PlyForm::Text;
  std::vector<PlyElement> elements;
  std::size_t bytes = 0;  ///< up to the first entry
  std::size_t lines = 0;
  char line_end = '\n';
};

/// Reads the header of a PLY file (Turk 1994), which the names in it refer to. Refused with the line: what is no
/// header.
Result<PlyHeader> read_ply_header(std::string_view whole);

}  // namespace poise::geometry
