// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace poise::tests {

/// The content of a room.
struct RoomContent {
  int rank = 0;                   ///< its rank in the order (source_rules.h)
  std::set<std::string> folders;  ///< names of the folders in it
  std::size_t files = 0, lines = 0;
};

/// The rooms of the code, and the number of #include lines from one to another.
struct IncludeGraph {
  std::map<std::string, RoomContent> rooms;
  std::map<std::pair<std::string, std::string>, std::size_t> includes;  ///< (from, to), from != to
};

/// Reads every .h and .cpp below include/, scheduler/, src/, bench/ and examples/ of a checkout. Includes in angle
/// brackets, and of generated files, are ignored. Throws std::filesystem::filesystem_error if the checkout cannot be
/// read.
IncludeGraph read_include_graph(const std::filesystem::path& root);

/// The includes of a later room or of another one of the same rank, a line each: `from -> to`. Empty in a correct tree.
std::set<std::string> against_order(const IncludeGraph& graph);

/// The graph as an SVG picture: rooms in order from top to bottom, the latest on top, in the colours of their
/// libraries; on the right an arrow for each room that a room includes. An arrow against the order is red and on the
/// left.
std::string to_svg(const IncludeGraph& graph);

}  // namespace poise::tests
