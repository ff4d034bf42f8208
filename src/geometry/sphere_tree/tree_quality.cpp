// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stop_token>

#include <fmt/format.h>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/mesh/mesh_volume.h"
#include "geometry/primitives/random.h"
#include "geometry/primitives/rounding.h"
#include "geometry/sphere_tree/tree_protrusion.h"
#include "math/functions.h"
#include "poise/sphere_tree.h"

namespace poise {
namespace {

using namespace geometry;

/// Samples that share one random generator. Parts are combined in order, so threads do not change a figure.
constexpr std::size_t kPart = 2048;
/// Most tries for each sample inside; a thin object then gets fewer samples.
constexpr std::size_t kMostTries = 100;

enum class Figure : std::uint64_t { Surface = 1, Inside = 2, Levels = 16 };

/// One sampled figure, divided into parts that may run in parallel.
struct Sampling {
  std::size_t samples;
  std::uint64_t seed;
  parallel::Executor& executor;
  std::stop_token stop;

  /// Sums of work(random, count) -> Part over all parts, in order; parts are skipped once the measurement is asked to
  /// stop.
  template <class Part, class Work>
  Part sum(std::uint64_t figure, Work&& work) const {
    const std::size_t count = (samples + kPart - 1) / kPart;
    std::vector<Part> parts(count);
    const std::uint64_t own_seed = Random::of(seed, figure).next();
    parallel::parallel_for(executor, count, 1, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t part = begin; part < end && !stop.stop_requested(); ++part) {
        Random random = Random::of(own_seed, part);
        parts[part] = work(random, std::min(kPart, samples - part * kPart));
      }
    });
    Part total{};
    for (const Part& part : parts) total += part;
    return total;
  }
};

/// Draws an index with probabilities by weight.
class WeightedDraw {
 public:
  // Invariant: until_ ascends and its last entry is the total.
  template <class Weight>
  WeightedDraw(std::size_t count, Weight&& weight) {
    double sum = 0;
    until_.reserve(count);
    for (std::size_t i = 0; i < count; ++i) until_.push_back(sum += weight(i));
  }
  [[nodiscard]] double total() const { return until_.back(); }
  std::size_t operator()(Random& random) const {
    const auto place = std::ranges::upper_bound(until_, random.unit() * total());
    return std::min(static_cast<std::size_t>(place - until_.begin()), until_.size() - 1);
  }

 private:
  std::vector<double> until_;
};

/// Number of levels from 0 on that have a chain of nodes from `node` down which all contain the point.
std::size_t levels_reached(const SphereTree& tree, NodeIndex node, const Vec3& point, std::size_t level,
                           std::size_t levels) {
  const Sphere sphere = tree.sphere(node);
  if ((sphere.center_m - point).squaredNorm() > sphere.radius_m * sphere.radius_m) return level;
  if (tree.child_count[node] == 0) return levels;
  std::size_t reached = level + 1;
  for (NodeIndex c = 0; c < tree.child_count[node] && reached < levels; ++c) {
    reached = std::max(reached, levels_reached(tree, tree.first_child[node] + c, point, level + 1, levels));
  }
  return reached;
}

/// Number of points that each level covers.
struct Coverage {
  std::vector<std::size_t> covered;
  std::size_t points = 0;
  std::size_t tries = 0;

  void add(const SphereTree& tree, const Vec3& point) {
    const std::size_t levels = std::size_t{tree.depth()} + 1;
    covered.resize(levels);
    const std::size_t reached = levels_reached(tree, 0, point, 0, levels);
    for (std::size_t level = 0; level < reached; ++level) ++covered[level];
    ++points;
  }
  Coverage& operator+=(const Coverage& other) {
    covered.resize(std::max(covered.size(), other.covered.size()));
    for (std::size_t i = 0; i < other.covered.size(); ++i) covered[i] += other.covered[i];
    points += other.points;
    tries += other.tries;
    return *this;
  }
  /// 1 if there are no points.
  [[nodiscard]] double share(Level level) const {
    return points == 0 ? 1.0 : static_cast<double>(covered[level]) / static_cast<double>(points);
  }
};

Coverage surface_coverage(const SphereTree& tree, const TriangleMesh& mesh, const Sampling& sampling) {
  const auto corners = [&mesh](std::size_t i, std::size_t corner) -> const Vec3& {
    return mesh.vertices_m[mesh.triangles[i][corner]];
  };
  const WeightedDraw by_area(mesh.triangles.size(), [&](std::size_t i) {
    return (corners(i, 1) - corners(i, 0)).cross(corners(i, 2) - corners(i, 0)).norm();
  });
  return sampling.sum<Coverage>(static_cast<std::uint64_t>(Figure::Surface), [&](Random& random, std::size_t count) {
    Coverage part;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = by_area(random);
      const double s = std::sqrt(random.unit());
      const double u = random.unit();
      part.add(tree, (1 - s) * corners(i, 0) + s * (1 - u) * corners(i, 1) + s * u * corners(i, 2));
    }
    return part;
  });
}

/// Points drawn uniformly from the bounding box; those inside are used. Fewer than requested if the mesh fills little
/// of its box.
Coverage inside_coverage(const SphereTree& tree, const Bounds& box, const TriangleBvh& bvh, const Sampling& sampling) {
  return sampling.sum<Coverage>(static_cast<std::uint64_t>(Figure::Inside), [&](Random& random, std::size_t count) {
    Coverage part;
    for (; part.tries < kMostTries * count && part.points < count; ++part.tries) {
      const double x = random.unit();
      const double y = random.unit();
      const Vec3 point = box.low + Vec3(x, y, random.unit()).cwiseProduct(box.high - box.low);
      if (bvh.inside(point)) part.add(tree, point);
    }
    return part;
  });
}

struct Protrusion {
  double max_m = 0;
  double sum_m = 0;
  std::size_t exposed = 0;

  Protrusion& operator+=(const Protrusion& other) {
    max_m = std::max(max_m, other.max_m);
    sum_m += other.sum_m;
    exposed += other.exposed;
    return *this;
  }
};

void measure_level(const SphereTree& tree, const TriangleBvh& bvh, double volume_m3, const Sampling& sampling,
                   TreeLevelFigures& figures) {
  const std::vector<NodeIndex> nodes = tree.nodes_at(figures.level);
  figures.spheres = nodes.size();
  for (const NodeIndex node : nodes) {
    figures.protrusion_bound_max_m =
        std::max(figures.protrusion_bound_max_m, static_cast<double>(tree.protrusion_max_m[node]));
  }
  const auto overlapping = overlapping_nodes(tree, nodes);
  const std::uint64_t figure = static_cast<std::uint64_t>(Figure::Levels) + 2ULL * figures.level;
  const auto radius_m = [&](std::size_t i) { return static_cast<double>(tree.radius_m[nodes[i]]); };
  const WeightedDraw by_area(nodes.size(), [&](std::size_t i) { return radius_m(i) * radius_m(i); });
  const auto protrusion = sampling.sum<Protrusion>(figure, [&](Random& random, std::size_t count) {
    Protrusion part;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t drawn = by_area(random);
      const Sphere sphere = tree.sphere(nodes[drawn]);
      const Vec3 point = sphere.center_m + sphere.radius_m * random.direction();
      if (hidden_by(tree, overlapping[drawn], point)) continue;
      const double distance_m = bvh.outside_distance_m(point);
      part.max_m = std::max(part.max_m, distance_m);
      part.sum_m += distance_m;
      ++part.exposed;
    }
    return part;
  });
  figures.protrusion_max_m = protrusion.max_m;
  figures.protrusion_mean_m = protrusion.exposed > 0 ? protrusion.sum_m / static_cast<double>(protrusion.exposed) : 0;
  if (!(volume_m3 > 0)) return;

  // The union's volume: points are drawn by the volume of the balls, and each counts one over the number of balls that
  // contain it.
  const WeightedDraw by_volume(nodes.size(), [&](std::size_t i) { return radius_m(i) * radius_m(i) * radius_m(i); });
  const auto shares = sampling.sum<double>(figure + 1, [&](Random& random, std::size_t count) {
    double part = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t drawn = by_volume(random);
      const Sphere sphere = tree.sphere(nodes[drawn]);
      const double out_m = sphere.radius_m * math::cbrt(random.unit());
      const Vec3 point = sphere.center_m + out_m * random.direction();
      std::size_t holders = 1;
      for (const NodeIndex other : overlapping[drawn]) {
        const Sphere theirs = tree.sphere(other);
        if ((theirs.center_m - point).squaredNorm() <= theirs.radius_m * theirs.radius_m) ++holders;
      }
      part += 1.0 / static_cast<double>(holders);
    }
    return part;
  });
  const double balls_m3 = 4.0 / 3.0 * std::numbers::pi * by_volume.total();
  figures.volume_ratio = balls_m3 * shares / static_cast<double>(sampling.samples) / volume_m3;
}

Error cancelled() { return {ErrorKind::Cancelled, "measuring was asked to end before it was done"}; }

/// Why tree and mesh cannot be measured; empty if they can.
std::string why_not_measurable(const SphereTree& tree, const TriangleMesh& mesh, const TreeQualityOptions& options) {
  if (tree.node_count() == 0) return "tree: there is no node, at least one is needed";
  if (options.samples < 1 || options.samples > 100000000)
    return fmt::format("samples = {}, must be from 1 to 100000000", options.samples);
  if (std::string wrong = why_not_threads(options.threads); !wrong.empty()) return wrong;
  if (mesh.triangles.empty()) return "mesh: there is no triangle, at least one is needed";
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    const Vec3& v = mesh.vertices_m[i];
    if (!v.allFinite() || v.cwiseAbs().maxCoeff() > kLargestLength_m) {
      return fmt::format("mesh: vertex {} = ({}, {}, {}), must be finite and at most {} m from 0", i, v.x(), v.y(),
                         v.z(), kLargestLength_m);
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) {
      if (v < mesh.vertices_m.size()) continue;
      return fmt::format("mesh: triangle {} names vertex {}, must be below {}", i, v, mesh.vertices_m.size());
    }
  }
  return {};
}

}  // namespace

Result<std::vector<TreeLevelFigures>> measure_tree_quality(const SphereTree& tree, const TriangleMesh& mesh,
                                                           const TreeQualityOptions& options) {
  if (std::string wrong = why_not_measurable(tree, mesh, options); !wrong.empty()) return bad_input(std::move(wrong));
  const TriangleBvh bvh(mesh, options.solidity);
  const auto executor = parallel::make_executor(ExecutorKind::Tbb, options.threads);
  const Sampling sampling{options.samples, options.seed, *executor, options.stop};
  const Coverage surface = surface_coverage(tree, mesh, sampling);
  Coverage inside;
  double volume_m3 = 0;
  if (options.solidity == Solidity::Solid) {
    Bounds box;
    for (const auto& t : mesh.triangles) {
      for (const std::uint32_t v : t) box.add(mesh.vertices_m[v]);
    }
    inside = inside_coverage(tree, box, bvh, sampling);
    const Result<MassProperties> mass = mesh_mass_properties(mesh);
    volume_m3 =
        mass ? mass.value().volume_m3
             : (box.high - box.low).prod() * static_cast<double>(inside.points) / static_cast<double>(inside.tries);
  }
  std::vector<TreeLevelFigures> levels;
  for (Level level = 0; level <= tree.depth(); ++level) {
    if (options.stop.stop_requested()) return cancelled();
    TreeLevelFigures figures;
    figures.level = level;
    figures.surface_coverage = surface.share(level);
    figures.inside_coverage = inside.share(level);
    measure_level(tree, bvh, volume_m3, sampling, figures);
    levels.push_back(figures);
  }
  if (options.stop.stop_requested()) return cancelled();
  return levels;
}

}  // namespace poise
