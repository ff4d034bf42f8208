// SPDX-License-Identifier: MIT
#include "geometry/mesh/mesh_report.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "geometry/mesh/mesh_edges.h"
#include "geometry/mesh/mesh_volume.h"

namespace poise {
namespace {

using namespace geometry;

/// A solid has at least this share of inside points with a winding number above kCertainWinding; a bent sheet has only
/// points with a winding number little above one half. Chosen: an open box has 0.9, half a ball's skin 0.4, a sheet
/// bent by a fifth of its length 0.
constexpr double kCertainShare = 0.1;
/// If the exact volume differs from the sampled one by more than this share, pieces overlap. Chosen.
constexpr double kOverlapShare = 0.02;

/// A count with separators and its noun: 1234567 as 1,234,567.
std::string counted(std::size_t number, std::string_view what) {
  std::string digits = std::to_string(number);
  for (std::size_t place = digits.size(); place > 3; place -= 3) digits.insert(place - 3, ",");
  return fmt::format("{} {}{}", digits, what, number == 1 ? "" : "s");
}

std::size_t count_pieces(const TriangleMesh& mesh, std::span<const EdgeUse> uses) {
  JoinedSets pieces(mesh.triangles.size());
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    for (const EdgeUse& use : edge) pieces.join(edge[0].triangle, use.triangle);
  });
  std::size_t count = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) count += pieces.leader(t) == t ? 1U : 0U;
  return count;
}

std::size_t count_rims(const TriangleMesh& mesh, std::span<const EdgeUse> uses) {
  JoinedSets rims(mesh.vertices_m.size());
  std::vector<bool> on_rim(mesh.vertices_m.size(), false);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 1) return;
    rims.join(edge[0].low, edge[0].high);
    on_rim[edge[0].low] = on_rim[edge[0].high] = true;
  });
  std::size_t count = 0;
  for (std::uint32_t v = 0; v < on_rim.size(); ++v) count += on_rim[v] && rims.leader(v) == v ? 1U : 0U;
  return count;
}

std::string why_open(const ClosedCheck& edges, std::size_t holes) {
  std::string why;
  if (edges.open_edges > 0) {
    why = fmt::format("{} with one triangle alone ({})", counted(edges.open_edges, "edge"), counted(holes, "rim"));
  }
  if (edges.inconsistent_edges > 0) {
    why += fmt::format("{}{} whose triangles disagree on the outside", why.empty() ? "" : ", ",
                       counted(edges.inconsistent_edges, "edge"));
  }
  return why;
}

std::string share(double part, double whole) { return fmt::format("{:.2g} %", 100 * part / whole); }

}  // namespace

namespace geometry {

std::string nothing_inside(const TriangleMesh& mesh) {
  const ClosedCheck edges = check_closed(mesh);
  if (edges.closed()) return "closed, but it encloses nothing";
  return fmt::format("a sheet that encloses nothing to speak of: {}",
                     why_open(edges, count_rims(mesh, edge_uses(mesh.triangles))));
}

bool encloses(const SampledMass& sampled) {
  return sampled.mass.volume_m3 > sampled.volume_error_m3 && sampled.certain_share >= kCertainShare;
}

std::string open_note(const TriangleMesh& mesh, const SampledMass& sampled) {
  return fmt::format("open: {}; inside is where the winding number is above one half, {:.4g} m^3 by sampling (+- {})",
                     why_open(check_closed(mesh), count_rims(mesh, edge_uses(mesh.triangles))), sampled.mass.volume_m3,
                     share(sampled.volume_error_m3, sampled.mass.volume_m3));
}

}  // namespace geometry

Result<MeshReport> assess_mesh(const TriangleMesh& mesh, int threads) {
  const Result<SampledMass> sampled = winding_mass_properties(mesh, threads);
  if (!sampled) return sampled.error();
  const std::vector<EdgeUse> uses = edge_uses(mesh.triangles);
  MeshReport report;
  report.triangles = mesh.triangles.size();
  report.vertices = mesh.vertices_m.size();
  report.pieces = count_pieces(mesh, uses);
  report.holes = count_rims(mesh, uses);
  report.edges = check_closed(mesh);
  report.area_m2 = mesh_area_m2(mesh);
  report.winding_volume_m3 = sampled.value().mass.volume_m3;
  const std::string made_of =
      fmt::format("{} in {}", counted(report.triangles, "triangle"), counted(report.pieces, "piece"));
  if (const Result<MassProperties> exact = mesh_mass_properties(mesh); exact.ok()) {
    report.exact_mass = true;
    report.volume_m3 = exact.value().volume_m3;
    report.text = fmt::format("closed: {}; {:.4g} m^3, and mass from exact integrals", made_of, report.volume_m3);
    const double twice_m3 = report.volume_m3 - report.winding_volume_m3;
    if (std::abs(twice_m3) > std::max(kOverlapShare * report.volume_m3, 2 * sampled.value().volume_error_m3)) {
      report.text += fmt::format(
          "; it winds around {:.4g} m^3 alone, so pieces overlap or cross, and overlaps count more than once",
          report.winding_volume_m3);
    }
    return report;
  }
  if (encloses(sampled.value())) {
    report.volume_m3 = sampled.value().mass.volume_m3;
    report.volume_error_m3 = sampled.value().volume_error_m3;
    report.text = fmt::format("{}; {}", open_note(mesh, sampled.value()), made_of);
    return report;
  }
  report.solidity = Solidity::Shell;
  report.volume_m3 = sampled.value().mass.volume_m3;
  report.volume_error_m3 = sampled.value().volume_error_m3;
  report.text = fmt::format("{}; {}, {:.4g} m^2; give a thickness to use it as a shell", nothing_inside(mesh), made_of,
                            report.area_m2);
  return report;
}

}  // namespace poise
