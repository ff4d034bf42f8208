// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "collision/front/pair_frame.h"
#include "poise/mesh.h"

namespace poise::collision {

/// The triangles of a mesh in the Flexible Collision Library (libfcl): an independent exact oracle of whether surfaces
/// meet. Only for tests and benchmarks. Immutable; any thread. The frame is that of the mesh.
class PolygonOracle {
 public:
  explicit PolygonOracle(const TriangleMesh& mesh);

  /// Whether two triangles meet, one of each mesh.
  [[nodiscard]] bool touches(const Pose& pose, const PolygonOracle& other, const Pose& other_pose) const;
  /// Distance between the two surfaces in metres; 0 if they meet.
  [[nodiscard]] double distance_m(const Pose& pose, const PolygonOracle& other, const Pose& other_pose) const;

 private:
  struct Model;
  std::shared_ptr<const Model> model_;
};

}  // namespace poise::collision
