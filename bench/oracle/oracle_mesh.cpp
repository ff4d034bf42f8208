// SPDX-License-Identifier: MIT
#include "oracle/oracle_mesh.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace poise::oracle {

struct OracleMesh::Search {
  fcl::BVHModel<fcl::OBBRSSd> triangles;
};

namespace {

fcl::Transform3d transform_of(const Placed& at) {
  fcl::Transform3d transform = fcl::Transform3d::Identity();
  transform.linear() = at.orientation.toRotationMatrix();
  transform.translation() = at.position_m;
  return transform;
}

}  // namespace

Result<OracleMesh> OracleMesh::make(const TriangleMesh& mesh, double density_kgpm3) {
  if (!(density_kgpm3 > 0) || !std::isfinite(density_kgpm3)) return bad_input("density_kgpm3: must be finite and > 0");
  const Result<MassProperties> unit = mesh_mass_properties(mesh);
  if (!unit) return unit.error();
  OracleMesh made;
  made.mass_kg_ = density_kgpm3 * unit.value().volume_m3;
  made.inertia_kgm2_ = density_kgpm3 * unit.value().inertia_m5;
  auto centred = std::make_shared<TriangleMesh>(mesh);
  Vec3 least = Vec3::Constant(HUGE_VAL);
  Vec3 most = Vec3::Constant(-HUGE_VAL);
  for (Vec3& vertex : centred->vertices_m) {
    vertex -= unit.value().center_of_mass_m;
    made.radius_m_ = std::max(made.radius_m_, vertex.norm());
    least = least.cwiseMin(vertex);
    most = most.cwiseMax(vertex);
  }
  made.size_m_ = (most - least).maxCoeff();
  std::vector<fcl::Triangle> triangles;
  triangles.reserve(centred->triangles.size());
  for (const auto& t : centred->triangles) triangles.emplace_back(t[0], t[1], t[2]);
  auto search = std::make_shared<Search>();
  search->triangles.beginModel();
  search->triangles.addSubModel(centred->vertices_m, triangles);
  search->triangles.endModel();
  made.mesh_ = std::move(centred);
  made.search_ = std::move(search);
  return made;
}

double OracleMesh::angular_response_m() const { return std::sqrt(inertia_kgm2_.trace() / (3 * mass_kg_)); }

TrianglePoints OracleMesh::triangle(int index, const Placed& at) const {
  TrianglePoints points;
  const auto& corners = mesh_->triangles[static_cast<std::size_t>(index)];
  for (std::size_t i = 0; i < 3; ++i) points[i] = at.position_m + at.orientation * mesh_->vertices_m[corners[i]];
  return points;
}

double OracleMesh::distance_m(const Placed& at, const OracleMesh& other, const Placed& other_at) const {
  fcl::DistanceResultd result;
  fcl::distance(&search_->triangles, transform_of(at), &other.search_->triangles, transform_of(other_at),
                fcl::DistanceRequestd(), result);
  return std::max(0.0, result.min_distance);
}

NearestFeatures OracleMesh::nearest(const Placed& at, const OracleMesh& other, const Placed& other_at) const {
  fcl::DistanceResultd result;
  fcl::distance(&search_->triangles, transform_of(at), &other.search_->triangles, transform_of(other_at),
                fcl::DistanceRequestd(true), result);
  return nearest_features(triangle(static_cast<int>(result.b1), at),
                          other.triangle(static_cast<int>(result.b2), other_at));
}

}  // namespace poise::oracle
