// SPDX-License-Identifier: MIT
#include "app/tree/tree_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace poise::app {
namespace {

using Out = std::back_insert_iterator<std::string>;

void mesh_lines(const io::TreeDocument& d, Out out) {
  fmt::format_to(out, "{}: {} triangle{}, diagonal {:.6g} m, {}\n", d.mesh, d.triangles, d.triangles == 1 ? "" : "s",
                 d.diagonal_m,
                 d.solidity == Solidity::Shell ? "taken as a shell" : fmt::format("volume {:.6g} m^3", d.volume_m3));
  if (!d.closed) fmt::format_to(out, "  {}\n", d.report);
  const MeshRepair& repair = d.repair;
  if (repair.vertices_welded + repair.triangles_discarded + repair.triangles_turned > 0) {
    fmt::format_to(out, "  {} vertices welded, {} triangles discarded, {} turned over\n", repair.vertices_welded,
                   repair.triangles_discarded, repair.triangles_turned);
  }
}

std::string tree_line(const io::MeasuredTree& tree) {
  const double bytes = static_cast<double>(tree.bytes) / static_cast<double>(std::max<std::size_t>(tree.nodes, 1));
  const std::string size = fmt::format("{} node{} of {:.0f} bytes", tree.nodes, tree.nodes == 1 ? "" : "s", bytes);
  if (!tree.cost) return fmt::format("{}: {}", tree.file, size);
  return fmt::format("built with preset {} to depth {}: {} in {:.2f} s, {:.2f} s of CPU time, {:.0f} MiB",
                     io::preset_name(tree.preset), tree.depth, size, tree.cost->wall_ms / 1000,
                     tree.cost->cpu_ms / 1000, static_cast<double>(tree.cost->peak_bytes) / (1U << 20U));
}

void leak_lines(const io::TreeDocument& d, Out out) {
  for (const io::MeasuredTree& tree : d.trees) {
    if (!io::leaks(tree, d.solidity)) continue;
    double surface = 1;
    double inside = 1;
    std::string levels;
    for (const TreeLevelFigures& f : tree.levels) {
      if (!io::leaks(f, d.solidity)) continue;
      surface = std::min(surface, f.surface_coverage);
      if (d.solidity == Solidity::Solid) inside = std::min(inside, f.inside_coverage);
      levels += fmt::format("{}{}", levels.empty() ? "" : ", ", f.level);
    }
    fmt::format_to(out,
                   "\n{} leaks at level {}: at worst {:.4f} % of the surface and {:.4f} % of the inside are covered. "
                   "Contacts there are missed.\n",
                   tree.cost ? "the tree" : tree.file, levels, 100 * surface, 100 * inside);
  }
}

void one_tree(const io::TreeDocument& d, Out out) {
  const io::MeasuredTree& tree = d.trees.front();
  fmt::format_to(out, "{}; {} samples a figure\n\n", tree_line(tree), d.samples);
  fmt::format_to(out, "{:>5} {:>8} {:>22} {:>22} {:>10} {:>10} {:>8}\n", "", "", "largest protrusion",
                 "mean protrusion", "surface", "inside", "volume");
  fmt::format_to(out, "{:>5} {:>8} {:>12} {:>9} {:>12} {:>9} {:>10} {:>10} {:>8}\n", "level", "spheres", "m", "% diag",
                 "m", "% diag", "% covered", "% covered", "ratio");
  const bool shell = d.solidity == Solidity::Shell;  // has no inside and no volume
  for (const TreeLevelFigures& f : tree.levels) {
    fmt::format_to(out, "{:>5} {:>8} {:>12.6g} {:>9.3f} {:>12.6g} {:>9.3f} {:>10.4f} {:>10} {:>8}{}\n", f.level,
                   f.spheres, f.protrusion_max_m, 100 * f.protrusion_max_m / d.diagonal_m, f.protrusion_mean_m,
                   100 * f.protrusion_mean_m / d.diagonal_m, 100 * f.surface_coverage,
                   shell ? "-" : fmt::format("{:.4f}", 100 * f.inside_coverage),
                   shell ? "-" : fmt::format("{:.3f}", f.volume_ratio), io::leaks(f, d.solidity) ? "  leaks" : "");
  }
}

/// Two figures of the same thing, the smaller or the larger one marked as better; neither where they print alike.
std::string pair_of(double a, double b, int decimals, bool smaller_is_better) {
  const std::string text_a = fmt::format("{:.{}f}", a, decimals);
  const std::string text_b = fmt::format("{:.{}f}", b, decimals);
  const bool alike = text_a == text_b;
  const bool a_better = !alike && (smaller_is_better ? a < b : a > b);
  const bool b_better = !alike && !a_better;
  return fmt::format("{:>9}{}{:>9}{}", text_a, a_better ? '*' : ' ', text_b, b_better ? '*' : ' ');
}

void two_trees(const io::TreeDocument& d, Out out) {
  const io::MeasuredTree& a = d.trees[0];
  const io::MeasuredTree& b = d.trees[1];
  fmt::format_to(out, "A  {}\nB  {}\n{} samples a figure; lengths in % of the diagonal; * is better\n\n", tree_line(a),
                 tree_line(b), d.samples);
  fmt::format_to(out, "{:>5} {:^15} {:^20} {:^20} {:^20} {:^20}  inside % covered\n", "", "spheres",
                 "largest protrusion", "mean protrusion", "volume ratio", "surface % covered");
  fmt::format_to(out, "{:>5} {:>7} {:>7}", "level", "A", "B");
  for (int i = 0; i < 5; ++i) fmt::format_to(out, "{:>10}{:>10}{}", "A", "B", i < 4 ? " " : "\n");
  // Beyond its deepest level a tree stays as it is there.
  const std::size_t levels = std::max(a.levels.size(), b.levels.size());
  for (std::size_t level = 0; level < levels; ++level) {
    const TreeLevelFigures& of_a = a.levels[std::min(level, a.levels.size() - 1)];
    const TreeLevelFigures& of_b = b.levels[std::min(level, b.levels.size() - 1)];
    const double percent = 100 / d.diagonal_m;
    fmt::format_to(out, "{:>5} {:>7} {:>7}", level, of_a.spheres, of_b.spheres);
    fmt::format_to(out, " {}", pair_of(percent * of_a.protrusion_max_m, percent * of_b.protrusion_max_m, 3, true));
    fmt::format_to(out, " {}", pair_of(percent * of_a.protrusion_mean_m, percent * of_b.protrusion_mean_m, 3, true));
    fmt::format_to(out, " {}", pair_of(of_a.volume_ratio, of_b.volume_ratio, 3, true));
    fmt::format_to(out, " {}", pair_of(100 * of_a.surface_coverage, 100 * of_b.surface_coverage, 4, false));
    std::string inside = pair_of(100 * of_a.inside_coverage, 100 * of_b.inside_coverage, 4, false);
    if (inside.ends_with(' ')) inside.pop_back();
    fmt::format_to(out, " {}\n", inside);
  }
}

}  // namespace

std::string tree_table(const io::TreeDocument& document) {
  std::string text;
  const Out out = std::back_inserter(text);
  mesh_lines(document, out);
  if (document.trees.size() > 1) {
    two_trees(document, out);
  } else {
    one_tree(document, out);
  }
  leak_lines(document, out);
  return text;
}

}  // namespace poise::app
