// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <compare>
#include <cstdint>

namespace poise {

// None of these asks for more than the alignment of double, so that a program built with other
// SIMD flags than the library agrees with it on every layout.
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaternion<double, Eigen::DontAlign>;

/// A level of refinement. 0 is the coarsest: the root sphere.
using Level = std::uint8_t;
inline constexpr Level kMaxTreeDepth = 6;
/// Index of contacts by polygons in figures that count by level, after those of the deepest tree.
inline constexpr Level kPolygonBin = kMaxTreeDepth + 1;

/// Index of a node in the arrays of its SphereTree.
using NodeIndex = std::uint32_t;

/// Names a body of one World. A slot that is used again gets a new generation, so that a handle to
/// a removed body is refused and never followed.
struct BodyId {
  std::uint32_t slot = 0xffffffffU;
  std::uint32_t generation = 0;
  friend auto operator<=>(const BodyId&, const BodyId&) = default;
};

/// Names a material of one World; by default none.
struct MaterialId {
  std::uint32_t index = 0xffffffffU;
  friend auto operator<=>(const MaterialId&, const MaterialId&) = default;
};

/// Names a shape that was added to one World; by default none.
struct ShapeId {
  std::uint32_t index = 0xffffffffU;
  friend auto operator<=>(const ShapeId&, const ShapeId&) = default;
};

/// Which implementation runs parallel parts. The result of a step depends on neither kind nor threads.
enum class ExecutorKind : std::uint8_t {
  Tbb,      ///< oneTBB's threads
  Threads,  ///< threads of its own
  Serial,   ///< the calling thread alone
  Host,     ///< threads that a host lends (poise/executor.h)
};

}  // namespace poise
