// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/sphere_tree/node_fit.h"
#include "geometry/sphere_tree/tree_protrusion.h"
#include "poise/assets/tree_formats.h"

namespace poise {
namespace {

/// A share as a percentage that is 100 only if the share is exactly 1.
std::string percent(double share) {
  if (share >= 1) return "100 %";
  return fmt::format("{:.2f} %", std::min(100 * share, 99.99));
}

}  // namespace

std::string ForeignTreeReport::summary() const {
  const auto worst = [&](double TreeLevelFigures::*coverage) {
    return std::ranges::min_element(levels, {}, coverage)->level;
  };
  if (levels.empty()) return "not measured";
  std::string text = "surface covered to " + percent(surface_coverage);
  if (surface_coverage < 1) text += fmt::format(" (level {})", worst(&TreeLevelFigures::surface_coverage));
  text += ", inside to " + percent(inside_coverage);
  if (inside_coverage < 1) text += fmt::format(" (level {})", worst(&TreeLevelFigures::inside_coverage));
  return text;
}

Result<ForeignTreeReport> adopt_tree(SphereTree& tree, const TriangleMesh& mesh, const TreeQualityOptions& options) {
  Result<std::vector<TreeLevelFigures>> measured = measure_tree_quality(tree, mesh, options);
  if (!measured) return measured.error();
  ForeignTreeReport report;
  report.levels = std::move(measured).value();
  for (const TreeLevelFigures& level : report.levels) {
    report.surface_coverage = std::min(report.surface_coverage, level.surface_coverage);
    report.inside_coverage = std::min(report.inside_coverage, level.inside_coverage);
  }
  const geometry::TriangleBvh bvh(mesh, options.solidity);
  const auto executor = parallel::make_executor(ExecutorKind::Threads, options.threads);
  geometry::measure_protrusions(tree, bvh, *executor);
  geometry::fit_nodes(tree, mesh, bvh, *executor);
  return report;
}

}  // namespace poise
