// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "poise/types.h"

namespace poise::oracle {

/// Which features of two surfaces are nearest to each other; the first word is that of a.
enum class Feature : std::uint8_t {
  VertexFace,
  FaceVertex,
  EdgeEdge,
  Other,  ///< vertex against vertex or edge, or an intersection: no plane is defined
};

using TrianglePoints = std::array<Vec3, 3>;  ///< metres

/// The nearest points of two triangles.
struct NearestFeatures {
  double distance_m = 0;  ///< 0 where the triangles cross
  Vec3 on_a_m = Vec3::Zero();
  Vec3 on_b_m = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< unit, from a to b: the face's normal, the cross product of two edges, else the
                               ///< direction between the points; 0 if these coincide
  Feature feature = Feature::Other;
};

/// In double precision, from all six vertices against the other face and all nine pairs of edges. A triangle without
/// area has only edges. Any thread.
NearestFeatures nearest_features(const TrianglePoints& a, const TrianglePoints& b);

}  // namespace poise::oracle
