// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/sphere_tree/cover/cover_cells.h"
#include "parallel/executor.h"

namespace poise::geometry {

/// A candidate for the centre of a ball, and its depth: the distance to the surface, negative outside. A ball of radius
/// depth + s there stands out by at most s.
struct DeepPoint {
  Vec3f center = Vec3f::Zero();
  float depth = 0;
};

/// Centres of balls that touch the surface from inside at `count` points, uniformly distributed by area, found by
/// shrinking (Ma, Bae and Choi, "3D medial axis point approximation using nearest neighbors and the normal field",
/// 2012). If a mesh has no inside, the points lie on the surface. The result does not depend on the executor.
std::vector<DeepPoint> find_deep_points(const TriangleMesh& mesh, const TriangleBvh& bvh, const CoverFrame& frame,
                                        std::size_t count, std::uint64_t seed, parallel::Executor& executor);

}  // namespace poise::geometry
