// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/node_fit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Cholesky>

#include "geometry/primitives/random.h"
#include "geometry/primitives/rounding.h"
#include "geometry/sphere_tree/nearest_leaf.h"
#include "geometry/sphere_tree/shell_samples.h"
#include "math/functions.h"

namespace poise::geometry {
namespace {

// Chosen by trials on one half of the contacts of the study (docs/method.md has the figures). Doubling or halving any
// of them changes the error by less than a twentieth.
constexpr double kRoomOfRadius = 2;      ///< depth of the sampled outside, in mean radii of the level
constexpr double kRoomOfDiagonal = 0.3;  ///< upper bound of that depth, as a share of the object's diagonal
constexpr double kTowardNode = 0.03;     ///< weight of the node's own sphere relative to the mean over the samples
constexpr std::size_t kSamplesANode = 128;
constexpr std::size_t kSamplesOfMesh = 24000;   ///< least number for a level
constexpr std::size_t kSamplesOfLeaves = 4000;  ///< the same for unions of balls, which are smoother than meshes
constexpr std::size_t kFitSamples = 256;        ///< most for a node
constexpr std::size_t kFewSamples = 16;         ///< with fewer samples the node's own sphere has more weight
constexpr std::size_t kFewestSamples = 4;       ///< a sphere has four unknowns
constexpr int kSteps = 8;
constexpr std::uint64_t kSeed = 7;
constexpr double kFitRounding = 1e-6;

/// A surface point, and the direction to a point outside whose nearest surface point it is.
struct SurfaceSample {
  Vec3 point_m = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
};

/// The object that the spheres are fitted to.
struct Object {
  double diagonal_m = 0;
  std::size_t fewest_samples = 0;  ///< for a level
  std::function<std::vector<SurfaceSample>(double room_m, std::size_t target)> sample;
  std::function<double(const Vec3&)> depth_m;  ///< from a point inside to the surface, negative outside
};

double mean_radius_m(const SphereTree& tree, std::size_t level) {
  double sum = 0;
  for (NodeIndex node = tree.level_begin[level]; node < tree.level_begin[level + 1]; ++node)
    sum += static_cast<double>(tree.radius_m[node]);
  return sum / static_cast<double>(tree.level_begin[level + 1] - tree.level_begin[level]);
}

struct FittedSphere {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
  double variance_m2 = 0;
};

/// Gauss-Newton iterations for the sphere that fits the samples best.
FittedSphere fit_sphere(const std::vector<SurfaceSample>& samples, double rho_m, const FittedSphere& own) {
  FittedSphere fit = own;
  const double weight = 1.0 / static_cast<double>(std::max(samples.size(), kFewSamples));
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix4d normal_matrix = kTowardNode * Eigen::Matrix4d::Identity();
    Eigen::Vector4d slope;
    slope << kTowardNode * (fit.center_m - own.center_m), kTowardNode * (fit.radius_m - own.radius_m);
    for (const SurfaceSample& sample : samples) {
      const Vec3 way = sample.point_m + rho_m * sample.normal - fit.center_m;
      const double distance = way.norm();
      if (!(distance > 0)) continue;
      Eigen::Vector4d gradient;
      gradient << -way / distance, -1.0;
      normal_matrix += weight * gradient * gradient.transpose();
      slope += weight * (distance - rho_m - fit.radius_m) * gradient;
    }
    const Eigen::Vector4d change = normal_matrix.ldlt().solve(slope);
    if (!change.allFinite()) return own;
    fit.center_m -= change.head<3>();
    fit.radius_m -= change[3];
  }
  double squares = 0;
  for (const SurfaceSample& sample : samples) {
    const double residual = (sample.point_m + rho_m * sample.normal - fit.center_m).norm() - rho_m - fit.radius_m;
    squares += residual * residual;
  }
  fit.variance_m2 = squares / static_cast<double>(samples.size());
  return fit;
}

NodeFit stored(const FittedSphere& fit, double core_m) {
  const Eigen::Vector3f center = to_float(fit.center_m);
  // The stored centre differs from the requested one by at most this, also after the move to a body's frame.
  const double rounding_m = kFitRounding * (fit.center_m.norm() + std::abs(fit.radius_m));
  return {center.x(),
          center.y(),
          center.z(),
          static_cast<float>(fit.radius_m),
          static_cast<float>(fit.variance_m2),
          static_cast<float>(core_m - rounding_m)};
}

/// The samples inside a sphere, evenly thinned; `samples` must ascend in x.
std::vector<SurfaceSample> samples_in(const std::vector<SurfaceSample>& samples, const Sphere& sphere) {
  const auto x_of = [](const SurfaceSample& sample) { return sample.point_m.x(); };
  const auto first = std::ranges::lower_bound(samples, sphere.center_m.x() - sphere.radius_m, {}, x_of);
  std::vector<SurfaceSample> found;
  for (auto it = first; it != samples.end() && x_of(*it) <= sphere.center_m.x() + sphere.radius_m; ++it) {
    if ((it->point_m - sphere.center_m).squaredNorm() <= sphere.radius_m * sphere.radius_m) found.push_back(*it);
  }
  if (found.size() <= kFitSamples) return found;
  std::vector<SurfaceSample> thinned(kFitSamples);
  for (std::size_t i = 0; i < kFitSamples; ++i) thinned[i] = found[i * found.size() / kFitSamples];
  return thinned;
}

void fit_level(SphereTree& tree, std::size_t level, const Object& object, parallel::Executor& executor) {
  const NodeIndex begin = tree.level_begin[level];
  const std::size_t count = tree.level_begin[level + 1] - begin;
  const double rho_m = mean_radius_m(tree, level);
  const double room_m = std::min(kRoomOfRadius * rho_m, kRoomOfDiagonal * object.diagonal_m);
  std::vector<SurfaceSample> samples = object.sample(room_m, std::max(object.fewest_samples, kSamplesANode * count));
  std::ranges::stable_sort(samples, {}, [](const SurfaceSample& sample) { return sample.point_m.x(); });
  parallel::parallel_for(executor, count, 8, [&](std::size_t from, std::size_t to, int) {
    for (std::size_t i = from; i < to; ++i) {
      const auto node = static_cast<NodeIndex>(begin + i);
      const Sphere sphere = tree.sphere(node);
      FittedSphere own{sphere.center_m, sphere.radius_m - static_cast<double>(tree.protrusion_mean_m[node]), 0};
      const std::vector<SurfaceSample> near = samples_in(samples, sphere);
      if (near.size() >= kFewestSamples) {
        own = fit_sphere(near, rho_m, own);
      } else {
        own.radius_m = -4 * object.diagonal_m;
      }
      tree.fit[node] = stored(own, object.depth_m(own.center_m));
    }
  });
}

std::vector<SurfaceSample> sample_mesh(const TriangleMesh& mesh, const TriangleBvh& bvh, double room_m,
                                       std::size_t target, parallel::Executor& executor) {
  const Bounds box = bounds_of(mesh.vertices_m);
  const CoverFrame frame{0.5 * (box.low + box.high), mesh.diagonal_m()};
  const ShellSamples shell =
      sample_shell(mesh, bvh, frame, static_cast<float>(room_m / frame.diagonal_m), target, kSeed, executor);
  std::vector<SurfaceSample> samples(shell.size());
  parallel::parallel_for(executor, shell.size(), 256, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 place = frame.from(shell.points.at(i));
      const Vec3 nearest = bvh.closest(place).point_m;
      const double distance = (place - nearest).norm();
      if (distance > 0) samples[i] = {nearest, (place - nearest) / distance};
    }
  });
  return samples;
}

/// Leaf spheres are chosen with probabilities by the volume of the shell around them; points nearer to another leaf are
/// skipped.
std::vector<SurfaceSample> sample_leaves(const SphereTree& tree, double room_m, std::size_t target) {
  std::vector<NodeIndex> leaves;
  std::vector<double> volume_below;
  double volume = 0;
  const auto cube = [](double x) { return x * x * x; };
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    if (tree.child_count[node] != 0) continue;
    const auto radius = static_cast<double>(tree.radius_m[node]);
    leaves.push_back(node);
    volume += cube(radius + room_m) - cube(radius);
    volume_below.push_back(volume);
  }
  std::vector<SurfaceSample> samples;
  Random random(kSeed);
  for (std::size_t i = 0; i < target; ++i) {
    const auto place = std::ranges::lower_bound(volume_below, random.unit() * volume);
    const auto chosen = static_cast<std::size_t>(std::min(place, volume_below.end() - 1) - volume_below.begin());
    const Sphere leaf = tree.sphere(leaves[chosen]);
    const Vec3 normal = random.direction();
    const double low = cube(leaf.radius_m);
    const double out = math::cbrt(low + random.unit() * (cube(leaf.radius_m + room_m) - low));
    if (nearest_leaf(tree, leaf.center_m + out * normal).node != leaves[chosen]) continue;
    samples.push_back({leaf.center_m + leaf.radius_m * normal, normal});
  }
  return samples;
}

}  // namespace

void fit_nodes(SphereTree& tree, const TriangleMesh& mesh, const TriangleBvh& bvh, parallel::Executor& executor) {
  fit_nodes_to_themselves(tree);
  Object object;
  object.diagonal_m = mesh.diagonal_m();
  object.fewest_samples = kSamplesOfMesh;
  object.sample = [&](double room_m, std::size_t target) { return sample_mesh(mesh, bvh, room_m, target, executor); };
  object.depth_m = [&](const Vec3& point) { return -bvh.signed_distance_m(point); };
  for (std::size_t level = 0; level + 1 < tree.level_begin.size(); ++level) fit_level(tree, level, object, executor);
}

void fit_nodes_to_leaves(SphereTree& tree) {
  fit_nodes_to_themselves(tree);
  if (tree.depth() == 0) return;
  Object object;
  object.diagonal_m = 2 * static_cast<double>(tree.radius_m[0]);
  object.fewest_samples = kSamplesOfLeaves;
  object.sample = [&](double room_m, std::size_t target) { return sample_leaves(tree, room_m, target); };
  object.depth_m = [&](const Vec3& point) { return -nearest_leaf(tree, point).distance_m; };
  std::vector<NodeFit> leaves = tree.fit;
  const auto serial = parallel::make_executor(ExecutorKind::Serial, 1);
  for (std::size_t level = 0; level < tree.depth(); ++level) fit_level(tree, level, object, *serial);
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    if (tree.child_count[node] == 0) tree.fit[node] = leaves[node];
  }
}

void fit_nodes_to_themselves(SphereTree& tree) {
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    tree.fit[node] = {tree.x_m[node], tree.y_m[node], tree.z_m[node], tree.radius_m[node], 0, tree.radius_m[node]};
  }
}

}  // namespace poise::geometry
