// SPDX-License-Identifier: MIT
#include "poise/shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "geometry/mesh/mesh_report.h"
#include "geometry/mesh/mesh_volume.h"
#include "geometry/primitives/rounding.h"
#include "geometry/shape/shape_surface.h"
#include "geometry/sphere_tree/tree_check.h"
#include "geometry/sphere_tree/tree_layout.h"
#include "geometry/sphere_tree/tree_of_spheres.h"

namespace poise {
namespace {

/// Off-diagonal moments below this share of the trace are rounding errors (of a file or of this computation): the frame
/// of the mesh is principal.
constexpr double kDiagonalShare = 1e-9;

void set_principal(Shape& shape, const Mat3& inertia_m5) {
  const double off = std::max({std::abs(inertia_m5(0, 1)), std::abs(inertia_m5(0, 2)), std::abs(inertia_m5(1, 2))});
  if (off <= kDiagonalShare * inertia_m5.trace()) {
    shape.principal_m5 = inertia_m5.diagonal();
    shape.principal_axes = Quat::Identity();
    return;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia_m5);
  Mat3 axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  shape.principal_m5 = solver.eigenvalues();
  shape.principal_axes = Quat(axes).normalized();
}

/// Mass properties of balls; each contributes its whole mass.
MassProperties mass_of_balls(std::span<const Sphere> balls) {
  MassProperties mass;
  constexpr double kBallVolume = 4.0 / 3.0 * std::numbers::pi;
  // Moments relative to the first centre, so that no digits are lost far from the origin.
  const Vec3 near = balls[0].center_m;
  Vec3 first_m4 = Vec3::Zero();
  for (const Sphere& ball : balls) {
    const double volume_m3 = kBallVolume * ball.radius_m * ball.radius_m * ball.radius_m;
    mass.volume_m3 += volume_m3;
    first_m4 += volume_m3 * (ball.center_m - near);
  }
  mass.center_of_mass_m = near + first_m4 / mass.volume_m3;
  for (const Sphere& ball : balls) {
    const double volume_m3 = kBallVolume * ball.radius_m * ball.radius_m * ball.radius_m;
    const Vec3 arm = ball.center_m - mass.center_of_mass_m;
    mass.inertia_m5 += volume_m3 * (0.4 * ball.radius_m * ball.radius_m + arm.squaredNorm()) * Mat3::Identity() -
                       volume_m3 * arm * arm.transpose();
  }
  return mass;
}

std::shared_ptr<Shape> finish(SphereTree tree, const MassProperties& mass, std::string note = {}) {
  auto shape = std::make_shared<Shape>();
  shape->tree = std::move(tree);
  const Sphere root = shape->tree.sphere(0);
  const double bound_m = root.center_m.norm() + root.radius_m;
  shape->bounding_radius_m = root.center_m.isZero(0) ? root.radius_m : bound_m * (1 + 1e-15);
  shape->origin_offset_m = mass.center_of_mass_m;
  shape->volume_m3 = mass.volume_m3;
  set_principal(*shape, mass.inertia_m5);
  shape->note = std::move(note);
  return shape;
}

/// The mass of a mesh, and a note of what is uncertain about it.
struct NotedMass {
  MassProperties mass;
  std::string note;
};

Result<NotedMass> mass_of_mesh(const TriangleMesh& mesh, double shell_thickness_m, int threads) {
  if (shell_thickness_m != 0) {
    const Result<MassProperties> shell = shell_mass_properties(mesh, shell_thickness_m);
    if (!shell) return shell.error();
    return NotedMass{shell.value(), {}};
  }
  if (std::string wrong = geometry::why_unusable(mesh); !wrong.empty()) return bad_input(std::move(wrong));
  if (check_closed(mesh).closed()) {
    const Result<MassProperties> exact = mesh_mass_properties(mesh);
    if (exact) return NotedMass{exact.value(), {}};
    return bad_input(exact.error().message + "; a shell_thickness_m > 0 would make it a shell");
  }
  const Result<SampledMass> sampled = winding_mass_properties(mesh, threads);
  if (!sampled) return sampled.error();
  if (!geometry::encloses(sampled.value())) {
    return bad_input(geometry::nothing_inside(mesh) + "; a shell_thickness_m > 0 would make it a shell");
  }
  return NotedMass{sampled.value().mass, geometry::open_note(mesh, sampled.value())};
}

ShapePtr finish_mesh(const TriangleMesh& mesh, SphereTree tree, const NotedMass& noted, Solidity solidity) {
  geometry::recenter_tree(tree, noted.mass.center_of_mass_m, false);
  std::shared_ptr<Shape> shape = finish(std::move(tree), noted.mass, noted.note);
  shape->surface = std::make_shared<const ShapeSurface>(
      geometry::make_surface(mesh, noted.mass.center_of_mass_m, solidity, shape->tree));
  return shape;
}

}  // namespace

Result<ShapePtr> make_sphere_shape(double radius_m) {
  if (!(radius_m >= geometry::kSmallestLength_m && radius_m <= geometry::kLargestLength_m)) {
    return bad_input(fmt::format("radius_m = {}, must be > 0 (from {} to {} m)", radius_m, geometry::kSmallestLength_m,
                                 geometry::kLargestLength_m));
  }
  const Sphere ball{Vec3::Zero(), radius_m};
  return make_spheres_shape({&ball, 1});
}

Result<ShapePtr> make_plane_shape(const Vec3& normal, double offset_m) {
  // Scales in two steps, so that the square of a tiny or a huge normal neither underflows nor overflows.
  const double largest = normal.cwiseAbs().maxCoeff();
  if (!normal.allFinite() || !(largest > 0)) {
    return bad_input(
        fmt::format("normal = ({}, {}, {}), must be finite and not 0", normal.x(), normal.y(), normal.z()));
  }
  if (!(std::abs(offset_m) <= geometry::kLargestLength_m)) {
    return bad_input(
        fmt::format("offset_m = {}, must be finite and at most {} m from 0", offset_m, geometry::kLargestLength_m));
  }
  auto shape = std::make_shared<Shape>();
  shape->kind = ShapeKind::Plane;
  const Vec3 scaled = normal / largest;
  // Eigen's normalized() may multiply by a reciprocal; a division turns (0, 0, 2) into exactly (0, 0, 1).
  shape->plane_normal = scaled / scaled.norm();
  shape->plane_offset_m = offset_m;
  return ShapePtr(shape);
}

Result<ShapePtr> make_spheres_shape(std::span<const Sphere> spheres, const UnionTreeOptions& options) {
  if (std::string wrong = geometry::why_not_threads(options.threads); !wrong.empty())
    return bad_input(std::move(wrong));
  if (std::string wrong = geometry::why_not_spheres(spheres); !wrong.empty()) return bad_input(std::move(wrong));
  MassProperties mass = mass_of_balls(spheres);
  double reach_m = 0;
  for (const Sphere& sphere : spheres) {
    reach_m = std::max(reach_m, (sphere.center_m - spheres[0].center_m).norm() + sphere.radius_m);
  }
  // A smaller offset of a symmetric list is rounding error, and would turn exact zeros into tiny numbers.
  if (mass.center_of_mass_m.norm() <= 1e-15 * reach_m) mass.center_of_mass_m.setZero();
  // The tree is built about that centre, so that its leaves are rounded once.
  std::vector<Sphere> centered(spheres.begin(), spheres.end());
  for (Sphere& sphere : centered) sphere.center_m -= mass.center_of_mass_m;
  Result<SphereTree> tree = geometry::union_tree(centered, options);
  if (!tree) return tree.error();
  return ShapePtr(finish(std::move(tree).value(), mass));
}

Result<ShapePtr> make_tree_shape(const SphereTree& tree) {
  if (std::string wrong = geometry::why_not_tree(tree); !wrong.empty()) return bad_input(std::move(wrong));
  std::vector<Sphere> leaves;
  for (const NodeIndex node : tree.nodes_at(tree.depth())) {
    leaves.push_back(tree.sphere(node));
    if (leaves.back().radius_m < geometry::kSmallestLength_m) {
      return bad_input(fmt::format("tree: radius_m[{}] = {} of a leaf, must be at least {} m", node,
                                   leaves.back().radius_m, geometry::kSmallestLength_m));
    }
  }
  const MassProperties mass = mass_of_balls(leaves);
  SphereTree centered = tree;
  geometry::recenter_tree(centered, mass.center_of_mass_m, true);
  return ShapePtr(finish(std::move(centered), mass));
}

Result<ShapePtr> make_mesh_shape(const TriangleMesh& mesh, const TreeBuildOptions& options, double shell_thickness_m) {
  if (options.solidity == Solidity::Shell && shell_thickness_m == 0)
    return bad_input("shell_thickness_m = 0, must be > 0 for a shell");
  const Result<NotedMass> mass = mass_of_mesh(mesh, shell_thickness_m, options.threads);
  if (!mass) return mass.error();
  TreeBuildOptions build = options;
  if (shell_thickness_m != 0) build.solidity = Solidity::Shell;
  Result<SphereTree> tree = build_sphere_tree(mesh, build);
  if (!tree) return tree.error();
  return finish_mesh(mesh, std::move(tree).value(), mass.value(), build.solidity);
}

Result<ShapePtr> make_mesh_shape_with_tree(const TriangleMesh& mesh, const SphereTree& tree, double shell_thickness_m) {
  if (std::string wrong = geometry::why_not_tree(tree); !wrong.empty()) return bad_input(std::move(wrong));
  const Result<NotedMass> mass = mass_of_mesh(mesh, shell_thickness_m, 0);
  if (!mass) return mass.error();
  return finish_mesh(mesh, tree, mass.value(), shell_thickness_m != 0 ? Solidity::Shell : Solidity::Solid);
}

}  // namespace poise
