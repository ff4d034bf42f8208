// SPDX-License-Identifier: MIT
#include "collision/polygon_oracle.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <vector>

namespace poise::collision {

struct PolygonOracle::Model {
  fcl::BVHModel<fcl::OBBRSSd> bvh;
};

namespace {

fcl::Transform3d placed(const Pose& pose) {
  fcl::Transform3d transform = fcl::Transform3d::Identity();
  transform.linear() = pose.rotation;
  transform.translation() = pose.position_m;
  return transform;
}

}  // namespace

PolygonOracle::PolygonOracle(const TriangleMesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  const auto model = std::make_shared<Model>();
  model->bvh.beginModel();
  model->bvh.addSubModel(mesh.vertices_m, triangles);
  model->bvh.endModel();
  model_ = model;
}

bool PolygonOracle::touches(const Pose& pose, const PolygonOracle& other, const Pose& other_pose) const {
  fcl::CollisionResultd result;
  return fcl::collide(&model_->bvh, placed(pose), &other.model_->bvh, placed(other_pose), fcl::CollisionRequestd(),
                      result) > 0;
}

double PolygonOracle::distance_m(const Pose& pose, const PolygonOracle& other, const Pose& other_pose) const {
  fcl::DistanceResultd result;
  fcl::distance(&model_->bvh, placed(pose), &other.model_->bvh, placed(other_pose), fcl::DistanceRequestd(), result);
  return std::max(0.0, result.min_distance);
}

}  // namespace poise::collision
