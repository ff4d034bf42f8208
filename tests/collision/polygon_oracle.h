// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "collision/front/pair_frame.h"
#include "poise/mesh.h"

namespace poise::collision {

/// The triangles of a mesh as the Flexible Collision Library (libfcl) knows them: an exact oracle of whether surfaces
/// meet, written by others. For tests and benchmarks alone. Immutable; any thread. The frame is that of the mesh.
class PolygonOracle {
 public:
  explicit PolygonOracle(const TriangleMesh& mesh);

  /// Do two triangles meet, one of each mesh?
  [[nodiscard]] bool touches(const Pose& pose, const PolygonOracle& other, const Pose& other_pose) const;
  /// Distance between the two surfaces in metres; 0 where they meet.
  [[nodiscard]] double distance_m(const Pose& pose, const PolygonOracle& other, const Pose& other_pose) const;

 private:
  struct Model;
  std::shared_ptr<const Model> model_;
};

}  // namespace poise::collision
