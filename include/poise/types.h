// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <compare>
#include <cstdint>

namespace poise {

// None of these types needs more than the alignment of double, so that a program built with other SIMD flags than the
// library has the same layouts.
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaternion<double, Eigen::DontAlign>;

/// A level of refinement. 0 is the coarsest: the root sphere.
using Level = std::uint8_t;
/// The deepest level of a sphere tree.
inline constexpr Level kMaxTreeDepth = 6;
/// Index of contacts by polygons in figures by level; it follows the deepest level of trees.
inline constexpr Level kPolygonBin = kMaxTreeDepth + 1;

/// Index of a node in the arrays of its SphereTree.
using NodeIndex = std::uint32_t;

/// Identifies a body of one World. A reused slot gets a new generation, so that a handle to a removed body is refused.
/// The default identifies no body.
struct BodyId {
  std::uint32_t slot = 0xffffffffU;
  std::uint32_t generation = 0;
  friend auto operator<=>(const BodyId&, const BodyId&) = default;
};

/// Identifies a material of one World; by default none.
struct MaterialId {
  std::uint32_t index = 0xffffffffU;
  friend auto operator<=>(const MaterialId&, const MaterialId&) = default;
};

/// Identifies a shape that was added to one World; by default none.
struct ShapeId {
  std::uint32_t index = 0xffffffffU;
  friend auto operator<=>(const ShapeId&, const ShapeId&) = default;
};

/// Implementation of parallel loops. The result of a step depends neither on the kind nor on the number of threads.
enum class ExecutorKind : std::uint8_t {
  Tbb,      ///< oneTBB's threads
  Threads,  ///< threads of the World's own pool
  Serial,   ///< the calling thread alone
  Host,     ///< threads lent by a host (poise/executor.h)
};

/// Which islands may wait in a frame that has no time for them (WorldSettings::islands_wait).
enum class IslandsWait : std::uint8_t { Never, NearRest, Any };

}  // namespace poise
