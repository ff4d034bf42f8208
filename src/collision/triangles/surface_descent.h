// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "collision/triangles/surface_kernel.h"
#include "collision/triangles/triangle_pair.h"

namespace poise::collision {

/// How far a search of two surfaces looks: features facing each other within `apart_m` count, and those that have
/// passed each other by up to `beneath_m`. Both >= 0.
struct SurfaceReach {
  double apart_m = 0;
  double beneath_m = 0;
};

/// A simultaneous descent of the BVHs of two meshes to the pairs of triangles that may be within a reach of each other,
/// nearest first at every pair of nodes. Each pair of triangles comes at most once. Boxes are compared along the axes
/// of both meshes, and then triangles by their planes and sides, in single precision, several at a time; what that may
/// round is added to the reach, so no pair within reach is lost. The order is fixed by the meshes and their poses.
/// About 25 KB.
class SurfaceDescent {
 public:
  enum class Step : std::uint8_t { Split, Triangles, Done };
  /// A pair of triangles that may pass through each other, or have features that face each other, or both.
  struct Candidate {
    std::uint32_t a, b;
    bool may_cross, may_face;
  };

  /// a's surface must be where its body is (no rotation, no offset): b's placement is relative to it.
  void begin(const PlacedSurface& on_a, const PlacedSurface& on_b);

  /// Takes one pair of nodes and goes one node deeper; Triangles where it compared pairs of triangles instead, at most
  /// 16 that came before. The reach may become less from step to step; what is farther apart is passed over.
  Step step(const SurfaceReach& reach);
  /// Those of the last step that are worth a closer look; may be none.
  [[nodiscard]] std::span<const Candidate> candidates() const { return std::span(candidates_).first(candidate_count_); }
  /// Pairs of triangles of the last step that came near each other and own a feature.
  [[nodiscard]] std::uint32_t near() const { return near_; }
  [[nodiscard]] const SurfaceFrame& frame() const { return frame_; }
  /// For compare_triangles in this frame.
  [[nodiscard]] TriangleTest test(const SurfaceReach& reach) const;

 private:
  /// A child of a node: the node's number, and the child's in the two lowest bits.
  using Child = std::uint32_t;
  static constexpr Child kRoot = 0xffffffffU;
  struct Waiting {
    Child a, b;
    float squared_m2;  ///< the boxes are at least so far apart
  };
  // Each step leaves at most fifteen siblings behind, and neither BVH has more than 63 levels.
  static constexpr std::size_t kStack = (kBoxPairs - 1) * 2 * 63 + kBoxPairs;

  struct Side;
  void split(const Waiting& top, float limit_m2);
  void compare(const SurfaceReach& reach);

  const ShapeSurface* surface_a_ = nullptr;
  const ShapeSurface* surface_b_ = nullptr;
  SurfaceFrame frame_;
  double scale_m_ = 0;  ///< no coordinate in the frame of either is larger
  std::size_t waiting_ = 0;
  std::size_t triangle_count_ = 0;
  std::size_t candidate_count_ = 0;
  std::uint32_t near_ = 0;
  std::array<Candidate, NearRows::kPairs> candidates_;
  std::array<Waiting, NearRows::kPairs + kBoxPairs> triangles_;  ///< pairs to compare, by their places among the leaves
  std::array<Waiting, kStack> stack_;
};

}  // namespace poise::collision
