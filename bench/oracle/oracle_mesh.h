// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "oracle/triangle_features.h"
#include "poise/mesh.h"
#include "poise/result.h"
#include "poise/types.h"

namespace poise::oracle {

/// Pose of a body: its centre of mass in the world, and the rotation from the axes of its mesh to the world.
struct Placed {
  Vec3 position_m = Vec3::Zero();
  Quat orientation = Quat::Identity();
};

/// A solid body as exact triangles, with its mass; distances by libfcl. Shares no code with the engine's collision and
/// response. Immutable; any thread. Its frame has the centre of mass as origin and the axes of the mesh: the body frame
/// of a Shape.
class OracleMesh {
 public:
  /// Refused: a mesh that is not closed or has no volume (mesh_mass_properties), and a density that is not finite and >
  /// 0.
  static Result<OracleMesh> make(const TriangleMesh& mesh, double density_kgpm3);

  /// Distance between two surfaces in metres, 0 if they meet. By libfcl.
  [[nodiscard]] double distance_m(const Placed& at, const OracleMesh& other, const Placed& other_at) const;
  /// The nearest features, in the world. libfcl finds the two triangles. Points, normal and kind are computed again
  /// from their corners, because libfcl's are in the frame of the first body and have no kind.
  [[nodiscard]] NearestFeatures nearest(const Placed& at, const OracleMesh& other, const Placed& other_at) const;

  [[nodiscard]] double mass_kg() const { return mass_kg_; }
  [[nodiscard]] const Mat3& inertia_kgm2() const { return inertia_kgm2_; }  ///< about the centre of mass, body frame
  [[nodiscard]] double radius_m() const {
    return radius_m_;
  }                                                        ///< of the ball about the centre of mass that holds the body
  [[nodiscard]] double size_m() const { return size_m_; }  ///< longest side of the bounding box
  [[nodiscard]] double angular_response_m() const;         ///< sqrt(trace(I) / (3 m))
  [[nodiscard]] const TriangleMesh& mesh() const { return *mesh_; }  ///< in the body frame

 private:
  struct Search;
  OracleMesh() = default;
  [[nodiscard]] TrianglePoints triangle(int index, const Placed& at) const;
  std::shared_ptr<const TriangleMesh> mesh_;
  std::shared_ptr<const Search> search_;
  double mass_kg_ = 0, radius_m_ = 0, size_m_ = 0;
  Mat3 inertia_kgm2_ = Mat3::Zero();
};

}  // namespace poise::oracle
