// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "geometry/mesh_volume.h"
#include "geometry/random.h"
#include "geometry/tree_protrusion.h"
#include "geometry/triangle_bvh.h"
#include "poise/sphere_tree.h"

namespace poise {
namespace {

using namespace geometry;

std::vector<Vec3> surface_points(const TriangleMesh& mesh, std::size_t samples, Random& random) {
  std::vector<double> area_until;
  double area = 0;
  for (const auto& t : mesh.triangles) {
    area += (mesh.vertices_m[t[1]] - mesh.vertices_m[t[0]]).cross(mesh.vertices_m[t[2]] - mesh.vertices_m[t[0]]).norm();
    area_until.push_back(area);
  }
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < samples; ++i) {
    const auto place = std::ranges::upper_bound(area_until, random.unit() * area);
    const auto index = std::min(static_cast<std::size_t>(place - area_until.begin()), area_until.size() - 1);
    const auto& t = mesh.triangles[index];
    const double s = std::sqrt(random.unit());
    const double u = random.unit();
    points.emplace_back((1 - s) * mesh.vertices_m[t[0]] + s * (1 - u) * mesh.vertices_m[t[1]] + s * u * mesh.vertices_m[t[2]]);
  }
  return points;
}

/// Points drawn from the bounding box, those inside kept; fewer than asked where the mesh fills little of its box.
std::vector<Vec3> inside_points(const TriangleMesh& mesh, const TriangleBvh& bvh, std::size_t samples, Random& random) {
  const Bounds box = bounds_of(mesh.vertices_m);
  std::vector<Vec3> points;
  for (std::size_t tries = 0; tries < 100 * samples && points.size() < samples; ++tries) {
    const Vec3 share(random.unit(), random.unit(), random.unit());
    const Vec3 point = box.low + share.cwiseProduct(box.high - box.low);
    if (bvh.inside(point)) points.push_back(point);
  }
  return points;
}

/// Levels 0 to result - 1 each have a chain of nodes from `node` down that all contain the point.
std::size_t levels_reached(const SphereTree& tree, NodeIndex node, const Vec3& point, std::size_t level, std::size_t levels) {
  const Sphere sphere = tree.sphere(node);
  if ((sphere.center_m - point).squaredNorm() > sphere.radius_m * sphere.radius_m) return level;
  if (tree.child_count[node] == 0) return levels;
  std::size_t reached = level + 1;
  for (NodeIndex c = 0; c < tree.child_count[node] && reached < levels; ++c) {
    reached = std::max(reached, levels_reached(tree, tree.first_child[node] + c, point, level + 1, levels));
  }
  return reached;
}

/// Share of the points that are covered at each level; 1 where there is no point to miss.
std::vector<double> coverage(const SphereTree& tree, const std::vector<Vec3>& points) {
  const std::size_t levels = std::size_t{tree.depth()} + 1;
  std::vector<std::size_t> covered(levels, 0);
  for (const Vec3& point : points) {
    const std::size_t reached = levels_reached(tree, 0, point, 0, levels);
    for (std::size_t level = 0; level < reached; ++level) ++covered[level];
  }
  std::vector<double> shares;
  for (const std::size_t count : covered) {
    shares.push_back(points.empty() ? 1.0 : static_cast<double>(count) / static_cast<double>(points.size()));
  }
  return shares;
}

/// Index of a node drawn with chances by radius^power.
class NodeDraw {
 public:
  // Invariant: until_ ascends and its last entry is the total.
  NodeDraw(const SphereTree& tree, const std::vector<NodeIndex>& nodes, int power) {
    double sum = 0;
    for (const NodeIndex node : nodes) {
      sum += std::pow(static_cast<double>(tree.radius_m[node]), power);
      until_.push_back(sum);
    }
  }
  [[nodiscard]] double total() const { return until_.back(); }
  std::size_t draw(Random& random) const {
    const auto place = std::ranges::upper_bound(until_, random.unit() * total());
    return std::min(static_cast<std::size_t>(place - until_.begin()), until_.size() - 1);
  }

 private:
  std::vector<double> until_;
};

void judge_level(const SphereTree& tree, const TriangleBvh& bvh, double mesh_volume_m3, std::size_t samples, Random& random,
                 parallel::Executor& executor, TreeLevelFigures& figures) {
  const std::vector<NodeIndex> nodes = tree.nodes_at(figures.level);
  figures.spheres = nodes.size();
  const auto overlapping = overlapping_nodes(tree, nodes, executor);
  const NodeDraw by_area(tree, nodes, 2);
  double sum_m = 0;
  std::size_t exposed = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    const std::size_t drawn = by_area.draw(random);
    const Sphere sphere = tree.sphere(nodes[drawn]);
    const Vec3 point = sphere.center_m + sphere.radius_m * random.direction();
    if (hidden_by(tree, overlapping[drawn], point)) continue;
    const double distance_m = bvh.outside_distance_m(point);
    figures.protrusion_max_m = std::max(figures.protrusion_max_m, distance_m);
    sum_m += distance_m;
    ++exposed;
  }
  figures.protrusion_mean_m = exposed > 0 ? sum_m / static_cast<double>(exposed) : 0;

  // The union's volume: every ball's volume, each point counting by one over the number of balls that hold it.
  const NodeDraw by_volume(tree, nodes, 3);
  double shares = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    const std::size_t drawn = by_volume.draw(random);
    const Sphere sphere = tree.sphere(nodes[drawn]);
    const double radius_m = sphere.radius_m * std::cbrt(random.unit());
    const Vec3 point = sphere.center_m + radius_m * random.direction();
    std::size_t holders = 1;
    for (const NodeIndex other : overlapping[drawn]) {
      const Sphere theirs = tree.sphere(other);
      if ((theirs.center_m - point).squaredNorm() <= theirs.radius_m * theirs.radius_m) ++holders;
    }
    shares += 1.0 / static_cast<double>(holders);
  }
  const double balls_m3 = 4.0 / 3.0 * std::numbers::pi * by_volume.total();
  figures.volume_ratio = balls_m3 * shares / static_cast<double>(samples) / mesh_volume_m3;
}

}  // namespace

Result<std::vector<TreeLevelFigures>> judge_tree(const SphereTree& tree, const TriangleMesh& mesh, std::size_t samples,
                                                 std::uint64_t seed) {
  if (tree.node_count() == 0) return bad_input("tree: there is no node, at least one is needed");
  if (samples < 1 || samples > 100000000) return bad_input(fmt::format("samples = {}, must be from 1 to 100000000", samples));
  const Result<MassProperties> mass = mesh_mass_properties(mesh);
  if (!mass) return mass.error();
  const TriangleBvh bvh(mesh);
  Random random(seed);
  const std::vector<double> surface = coverage(tree, surface_points(mesh, samples, random));
  const std::vector<double> inside = coverage(tree, inside_points(mesh, bvh, samples, random));
  const auto serial = parallel::make_executor(ExecutorKind::Serial, 1);
  std::vector<TreeLevelFigures> levels;
  for (Level level = 0; level <= tree.depth(); ++level) {
    TreeLevelFigures figures;
    figures.level = level;
    figures.surface_coverage = surface[level];
    figures.inside_coverage = inside[level];
    judge_level(tree, bvh, mass.value().volume_m3, samples, random, *serial, figures);
    levels.push_back(figures);
  }
  return levels;
}

}  // namespace poise
