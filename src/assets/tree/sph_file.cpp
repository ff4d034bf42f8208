// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "assets/files/atomic_file.h"
#include "assets/files/text_cursor.h"
#include "assets/files/text_file.h"
#include "assets/tree/tree_files.h"
#include "geometry/primitives/rounding.h"
#include "geometry/sphere_tree/tree_check.h"
#include "geometry/sphere_tree/tree_layout.h"
#include "poise/assets/sph_file.h"
#include "poise/sphere_tree.h"

namespace poise {
namespace {

using geometry::LooseNode;

/// Ten times the size of seven full levels; chosen.
constexpr std::uint64_t kMostBytes = 256ULL << 20;

struct Row {
  std::array<float, 4> sphere{};  ///< x, y, z, r
  bool used = false;
};

/// Parses the rest of a line as a row; returns what is wrong, or empty.
std::string parse_row(geometry::TextCursor& text, Row& row) {
  constexpr std::size_t kMost = 5;
  std::array<std::string_view, kMost> words;
  std::size_t count = 0;
  for (std::string_view word = text.next_word(); !word.empty(); word = text.next_word(), ++count) {
    if (count < kMost) words[count] = word;
  }
  if (count != kMost - 1 && count != kMost) return fmt::format("has {} numbers, must be 'x y z r occupancy'", count);
  for (std::size_t i = 0; i < 4; ++i) {
    if (!geometry::parse_number(words[i], row.sphere[i]) || !std::isfinite(row.sphere[i]))
      return fmt::format("'{}' must be a finite number in single precision", geometry::shown_word(words[i]));
  }
  double occupancy = 0;
  if (count == kMost && !geometry::parse_finite(words[4], occupancy))
    return fmt::format("occupancy '{}' must be a finite number", geometry::shown_word(words[4]));
  row.used = row.sphere[3] >= 0;
  if (!row.used) return {};
  const auto radius_m = static_cast<double>(row.sphere[3]);
  if (radius_m < geometry::kSmallestLength_m || radius_m > geometry::kLargestLength_m) {
    return fmt::format("radius = {}, must be from {} to {} m, or negative for an unused place", radius_m,
                       geometry::kSmallestLength_m, geometry::kLargestLength_m);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(static_cast<double>(row.sphere[i])) > geometry::kLargestLength_m) {
      return fmt::format("coordinate = {}, must be within {} m", row.sphere[i], geometry::kLargestLength_m);
    }
  }
  return {};
}

/// The rows of a full tree with `branch` children a node.
struct Rows {
  std::size_t branch;
  std::vector<Row> rows;

  [[nodiscard]] std::vector<std::size_t> children(std::size_t index) const {
    std::vector<std::size_t> used;
    for (std::size_t c = index * branch + 1; c <= index * branch + branch && c < rows.size(); ++c) {
      if (rows[c].used) used.push_back(c);
    }
    return used;
  }
  /// Whether all descendants of this row are copies of it: such a node is a leaf.
  [[nodiscard]] bool only_repeats(std::size_t index) const {
    for (;;) {
      const std::vector<std::size_t> used = children(index);
      if (used.empty()) return true;
      if (used.size() > 1 || rows[used[0]].sphere != rows[index].sphere) return false;
      index = used[0];
    }
  }
  /// Adds the subtree of a row.
  std::uint32_t add(std::size_t index, std::vector<LooseNode>& nodes) const {
    const auto added = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    nodes[added].center_m = {rows[index].sphere[0], rows[index].sphere[1], rows[index].sphere[2]};
    nodes[added].radius_m = rows[index].sphere[3];
    if (only_repeats(index)) return added;
    for (const std::size_t c : children(index)) {
      const std::uint32_t child = add(c, nodes);
      nodes[added].children.push_back(child);
    }
    return added;
  }
};

Result<SphereTree> parse_sph(std::string_view text) {
  geometry::TextCursor lines(geometry::without_byte_order_mark(text), false);
  const auto refuse = [&](const std::string& rule) {
    return bad_input(fmt::format("line {}: {}", lines.number(), rule));
  };
  int levels = 0;
  int branch = 0;
  if (!lines.next_line()) return bad_input("is empty; line 1 must be 'levels branch', two whole numbers");
  if (!geometry::parse_number(lines.next_word(), levels) || !geometry::parse_number(lines.next_word(), branch))
    return refuse("must be 'levels branch', two whole numbers");
  if (levels < 1 || levels > kMaxTreeDepth + 1)
    return refuse(fmt::format("levels = {}, must be from 1 to {}", levels, kMaxTreeDepth + 1));
  if (branch < 1 || branch > static_cast<int>(kTreeBranching)) {
    return refuse(fmt::format("branch = {}, must be from 1 to {}", branch, kTreeBranching));
  }
  std::size_t points = 0;
  std::size_t on_level = 1;
  for (int l = 0; l < levels; ++l, on_level *= static_cast<std::size_t>(branch)) points += on_level;
  Rows table{static_cast<std::size_t>(branch), {}};
  std::vector<Row>& rows = table.rows;
  while (rows.size() < points) {
    if (!lines.next_line_with_words()) return refuse(fmt::format("ends after {} of {} rows", rows.size(), points));
    Row row;
    if (const std::string wrong = parse_row(lines, row); !wrong.empty()) return refuse(wrong);
    const std::size_t index = rows.size();
    if (index == 0 && !row.used) return refuse("the root must have a radius > 0");
    if (index > 0 && row.used && !rows[(index - 1) / table.branch].used) {
      return refuse(fmt::format("node {} is used, but its parent {} is not", index, (index - 1) / table.branch));
    }
    rows.push_back(row);
  }
  std::vector<LooseNode> nodes;
  table.add(0, nodes);
  return geometry::flatten_tree(nodes);
}

/// Numbers are written with all digits that a double needs to represent the stored float exactly, so that a reader in
/// double precision gets no smaller sphere.
void append_row(const SphereTree& tree, NodeIndex node, std::string& text) {
  const Sphere sphere = tree.sphere(node);
  fmt::format_to(std::back_inserter(text), "{} {} {} {} 1\n", sphere.center_m.x(), sphere.center_m.y(),
                 sphere.center_m.z(), sphere.radius_m);
}

/// The toolkit's text for a level, which foam reads: its number of points, and the smallest, largest and mean error of
/// its spheres if these are known.
void append_level_figures(const SphereTree& tree, Level level, std::size_t points, std::string& text) {
  fmt::format_to(std::back_inserter(text), "\nLevel {}\nNum : {}\n", level, points);
  if (!geometry::protrusions_known(tree)) return;
  const geometry::LevelErrors errors = geometry::level_errors(tree, tree.nodes_at(level));
  fmt::format_to(std::back_inserter(text), "Best : {}\nWorst : {}\nMean : {}\n", errors.best_m, errors.worst_m,
                 errors.mean_m);
}

std::string sph_text(const SphereTree& tree) {
  std::string text = fmt::format("{} {}\n", tree.depth() + 1, kTreeBranching);
  std::string figures;
  constexpr NodeIndex kUnused = 0xffffffffU;
  std::vector<NodeIndex> points{0};
  for (Level level = 0; level <= tree.depth(); ++level) {
    std::vector<NodeIndex> below;
    for (const NodeIndex node : points) {
      if (node == kUnused) {
        text += "0 0 0 -1 0\n";
        below.insert(below.end(), kTreeBranching, kUnused);
        continue;
      }
      append_row(tree, node, text);
      const NodeIndex children = tree.child_count[node];
      for (NodeIndex c = 0; c < kTreeBranching; ++c) {
        const NodeIndex own = children == 0 && c == 0 ? node : kUnused;
        below.push_back(c < children ? tree.first_child[node] + c : own);
      }
    }
    append_level_figures(tree, level, points.size(), figures);
    if (level < tree.depth()) points = std::move(below);
  }
  return text + figures;
}

}  // namespace

Result<SphereTree> read_sph(const std::filesystem::path& file) {
  try {
    const Result<std::string> text = geometry::read_text_file(file, kMostBytes);
    if (!text) return text.error();
    Result<SphereTree> tree = parse_sph(text.value());
    if (!tree) return bad_input(fmt::format("{}: {}", file.string(), tree.error().message));
    return tree;
  } catch (const std::exception& failure) {
    return bad_input(fmt::format("{}: {}", file.string(), failure.what()));
  }
}

Status write_sph(const SphereTree& tree, const std::filesystem::path& file) {
  if (std::string wrong = geometry::why_not_tree(tree); !wrong.empty()) return bad_input(std::move(wrong));
  try {
    return geometry::write_file(file, sph_text(tree));
  } catch (const std::exception& failure) {
    return Error{ErrorKind::OutputFailed, fmt::format("{}: cannot be written: {}", file.string(), failure.what())};
  }
}

}  // namespace poise
