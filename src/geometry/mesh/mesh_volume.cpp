// SPDX-License-Identifier: MIT
#include "geometry/mesh/mesh_volume.h"

#include <cmath>

#include <fmt/format.h>
#include <Eigen/LU>

#include "geometry/primitives/bounds.h"
#include "geometry/primitives/rounding.h"

namespace poise {
namespace geometry {

MassProperties mesh_volume(const TriangleMesh& mesh) {
  MassProperties mass;
  if (mesh.vertices_m.empty()) return mass;
  // Relative to the middle of the box: far from the origin the second moments would lose digits.
  const Vec3 near = bounds_of(mesh.vertices_m).center();
  double six_volumes = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const auto& triangle : mesh.triangles) {
    const Vec3 a = mesh.vertices_m[triangle[0]] - near;
    const Vec3 b = mesh.vertices_m[triangle[1]] - near;
    const Vec3 c = mesh.vertices_m[triangle[2]] - near;
    // Moments of the tetrahedron (0, a, b, c) with determinant d: d/6, d/24 (a+b+c), d/120
    // (aa'+bb'+cc'+(a+b+c)(a+b+c)').
    const double determinant = a.dot(b.cross(c));
    const Vec3 sum = a + b + c;
    six_volumes += determinant;
    first += determinant * sum;
    second += determinant * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  mass.volume_m3 = six_volumes / 6;
  if (mass.volume_m3 == 0) return mass;
  const Vec3 center = first / 24 / mass.volume_m3;
  mass.center_of_mass_m = near + center;
  const Mat3 about_center = second / 120 - mass.volume_m3 * center * center.transpose();
  mass.inertia_m5 = about_center.trace() * Mat3::Identity() - about_center;
  return mass;
}

double mesh_area_m2(const TriangleMesh& mesh) {
  double doubled_m2 = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3& a = mesh.vertices_m[t[0]];
    doubled_m2 += (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).norm();
  }
  return 0.5 * doubled_m2;
}

std::string why_unusable(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return "mesh: there is no triangle";
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) {
      if (v >= mesh.vertices_m.size())
        return fmt::format("mesh: a triangle names vertex {} of {}", v, mesh.vertices_m.size());
    }
  }
  for (const Vec3& v : mesh.vertices_m) {
    if (!v.allFinite()) return "mesh: a vertex is not finite";
    if (v.cwiseAbs().maxCoeff() > kLargestLength_m)
      return fmt::format("mesh: a vertex is farther than {} m from 0", kLargestLength_m);
  }
  const double diagonal_m = mesh.diagonal_m();
  if (diagonal_m < kSmallestLength_m)
    return fmt::format("mesh: {} m across, must be at least {} m", diagonal_m, kSmallestLength_m);
  return {};
}

std::string why_not_threads(int threads) {
  if (threads >= 0 && threads <= 256) return {};
  return fmt::format("threads = {}, must be from 0 to 256", threads);
}

std::string why_not_closed(const TriangleMesh& mesh) {
  if (std::string wrong = why_unusable(mesh); !wrong.empty()) return wrong;
  const ClosedCheck check = check_closed(mesh);
  if (check.closed()) return {};
  return fmt::format(
      "mesh is not closed: {} open edges, {} edges whose triangles disagree on the outside; must be closed",
      check.open_edges, check.inconsistent_edges);
}

}  // namespace geometry

Result<MassProperties> mesh_mass_properties(const TriangleMesh& mesh) {
  if (std::string wrong = geometry::why_not_closed(mesh); !wrong.empty()) return bad_input(std::move(wrong));
  const MassProperties mass = geometry::mesh_volume(mesh);
  // Below this share of the cube of the diagonal the volume is rounding error. A plate 1 m wide may still be a few
  // picometres thick.
  const double diagonal_m = mesh.diagonal_m();
  const double smallest_m3 = 1e-12 * (diagonal_m * diagonal_m * diagonal_m);
  if (!(mass.volume_m3 > smallest_m3) || !mass.inertia_m5.allFinite()) {
    return bad_input(fmt::format("mesh encloses {} m^3, must be > 0 (> {})", mass.volume_m3, smallest_m3));
  }
  return mass;
}

Result<MassProperties> shell_mass_properties(const TriangleMesh& mesh, double thickness_m) {
  if (!(thickness_m >= geometry::kSmallestLength_m && thickness_m <= geometry::kLargestLength_m)) {
    return bad_input(fmt::format("shell_thickness_m = {}, must be > 0 (from {} to {} m)", thickness_m,
                                 geometry::kSmallestLength_m, geometry::kLargestLength_m));
  }
  if (std::string wrong = geometry::why_unusable(mesh); !wrong.empty()) return bad_input(std::move(wrong));
  const Vec3 near = geometry::bounds_of(mesh.vertices_m).center();
  double area_m2 = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const auto& triangle : mesh.triangles) {
    const Vec3 a = mesh.vertices_m[triangle[0]] - near;
    const Vec3 b = mesh.vertices_m[triangle[1]] - near;
    const Vec3 c = mesh.vertices_m[triangle[2]] - near;
    const Vec3 doubled_normal = (b - a).cross(c - a);
    const double doubled_m2 = doubled_normal.norm();
    if (!(doubled_m2 > 0)) continue;
    const Vec3 normal = doubled_normal / doubled_m2;
    // Moments of a triangle of area A: A, A/3 (a+b+c), A/12 (aa'+bb'+cc'+(a+b+c)(a+b+c)'), and across a plate A t^2/12
    // nn'.
    const double area = 0.5 * doubled_m2;
    const Vec3 sum = a + b + c;
    area_m2 += area;
    first += area / 3 * sum;
    second += area / 12 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose() +
               thickness_m * thickness_m * normal * normal.transpose());
  }
  // Below this share of the squared diagonal the area is rounding error.
  const double diagonal_m = mesh.diagonal_m();
  if (!(area_m2 > 1e-12 * (diagonal_m * diagonal_m)))
    return bad_input(fmt::format("mesh has an area of {} m^2, must be > 0", area_m2));
  MassProperties mass;
  mass.volume_m3 = area_m2 * thickness_m;
  const Vec3 center = first / area_m2;
  mass.center_of_mass_m = near + center;
  const Mat3 about_center = thickness_m * (second - area_m2 * center * center.transpose());
  mass.inertia_m5 = about_center.trace() * Mat3::Identity() - about_center;
  return mass;
}

}  // namespace poise
