// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace poise::tests {

/// What a room holds.
struct RoomContent {
  int rank = 0;                   ///< its place in the order (source_rules.h)
  std::set<std::string> folders;  ///< inside of it, by name
  std::size_t files = 0, lines = 0;
};

/// The rooms of the code and how many #include lines lead from one to another.
struct IncludeGraph {
  std::map<std::string, RoomContent> rooms;
  std::map<std::pair<std::string, std::string>, std::size_t> includes;  ///< (from, to), from != to
};

/// Reads every .h and .cpp below include/, scheduler/, src/, bench/ and examples/ of a checkout. Includes in angle
/// brackets, and those of files that are made by the build, lead nowhere. Throws std::filesystem::filesystem_error
/// where the checkout cannot be read.
IncludeGraph read_include_graph(const std::filesystem::path& root);

/// The includes that lead to a later room or to another of the same rank, a line each: `from -> to`. None in a sound
/// tree.
std::set<std::string> against_order(const IncludeGraph& graph);

/// The graph as a picture (SVG): rooms in order from top to bottom, the latest on top, in the colours of the library
/// that they are linked into; an arrow on the right for each room that a room includes. An arrow against the order is
/// red and on the left.
std::string to_svg(const IncludeGraph& graph);

}  // namespace poise::tests
