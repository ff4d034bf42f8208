// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "collision/triangles/triangle_pair.h"

namespace poise::collision {

/// A simultaneous descent of the BVHs of two meshes to the pairs of triangles that may be within a reach of each other,
/// nearest first at every node. Each pair of triangles comes at most once. Boxes are compared along the axes of both
/// meshes in single precision; what that may round is added to the reach, so no pair within reach is lost. The order is
/// fixed by the meshes and their poses. About 25 KB.
class SurfaceDescent {
 public:
  enum class Step : std::uint8_t { Split, Triangles, Done };

  /// a's surface must be where its body is (no rotation, no offset): b's placement is relative to it.
  void begin(const PlacedSurface& on_a, const PlacedSurface& on_b);

  /// Takes one pair of nodes: Split where it went one node deeper, Triangles where `triangle_a` and `triangle_b` are a
  /// pair to look at. `reach_m` >= 0 may change from step to step; what is farther apart is passed over.
  Step step(double reach_m);
  [[nodiscard]] std::uint32_t triangle_a() const { return triangle_a_; }
  [[nodiscard]] std::uint32_t triangle_b() const { return triangle_b_; }
  /// False where the boxes of the two triangles are apart.
  [[nodiscard]] bool may_cross() const { return may_cross_; }

 private:
  struct Box {
    std::array<float, 3> center_m, half_m;
  };
  /// A node or triangle of each mesh; boxes in the frame of their mesh.
  struct Waiting {
    std::uint32_t a, b;
    float squared_m2;  ///< the boxes are at least so far apart
    Box box_a, box_b;
  };
  // Each split leaves at most three siblings behind, and neither BVH has more than 63 levels.
  static constexpr std::size_t kStack = 3 * 2 * 63 + 4;

  template <bool kSplitA>
  void split(const Waiting& top, float limit2);

  const geometry::TriangleBvh* bvh_a_ = nullptr;
  const geometry::TriangleBvh* bvh_b_ = nullptr;
  std::array<std::array<float, 3>, 3> rotation_,
      absolute_;                   ///< of b's frame into a's, [row][column]; and its magnitudes
  std::array<float, 3> offset_m_;  ///< of b's boxes from a's
  double rounding_m_ = 0;
  std::size_t waiting_ = 0;
  std::uint32_t triangle_a_ = 0, triangle_b_ = 0;
  bool may_cross_ = false;
  std::array<Waiting, kStack> stack_;
};

}  // namespace poise::collision
