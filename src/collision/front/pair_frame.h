// SPDX-License-Identifier: MIT
#pragma once

#include "collision/front/overlap_kernel.h"
#include "poise/shape.h"
#include "poise/types.h"

namespace poise::collision {

/// Pose of a body for contact detection: the one at the start of the step.
struct alignas(32) Pose {
  Vec3 position_m = Vec3::Zero();
  Mat3 rotation = Mat3::Identity();  ///< body to world
};

/// Everything that refining one pair reads: two shapes and where b is, in the frame of a. The origin of each frame is
/// the body's centre of mass. When b is a plane, normal and height stand for it.
struct PairFrame {
  const Shape* a = nullptr;
  const Shape* b = nullptr;
  Mat3 rotation = Mat3::Identity();  ///< frame of b to frame of a
  Vec3 offset_m = Vec3::Zero();      ///< centre of mass of b in the frame of a
  Vec3 plane_normal = Vec3::Zero();  ///< b is a plane: its normal in the frame of a
  double plane_height_m = 0;  ///< b is a plane: its surface is plane_normal . p = plane_height_m in the frame of a
  double size_m = 0;          ///< of both shapes and their distance, for bounds of the rounding
  double margin_m = 0;        ///< gaps below this make contacts: the largest approach in the step; see set_margin
  double skin_m = 0;          ///< gaps below this count as touching
  bool fast = false;          ///< as is_fast says of the pair, at each of its levels
  bool fitted = false;        ///< contacts come from the fitted spheres of the nodes
  bool by_spheres = false;    ///< the spheres themselves are the surface, whatever they protrude
  double width_m = 1;         ///< of the weights of fitted spheres, > 0; see set_expected_fit
  double expected_gap_m = 0;  ///< see set_expected_fit
  float closeness_m = 0;      ///< contacts of nodes nearer than this decide the pair's contact, if there are any
  FloatFrame rounded{};
  Nearness nearness{};  ///< margin and a bound of the rounding of single precision; wide_m is the caller's

  [[nodiscard]] TreePair trees() const { return {a->tree, b->tree, rounded}; }
  [[nodiscard]] bool with_plane() const { return b->kind == ShapeKind::Plane; }
};

/// May the surfaces of a pair come much nearer in the step, by a fifth of the smaller body's radius? Then little of
/// what is near matters: its levels narrow the search.
inline bool is_fast(double margin_m, double skin_m) {
  constexpr double kFastSkins = 40;
  return margin_m >= kFastSkins * skin_m;
}

/// What the levels of a pair that follow look for; `fast` stays as it is.
void set_margin(double margin_m, PairFrame& frame);

PairFrame make_pair_frame(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin_m,
                          double skin_m);

/// With fitted spheres: sets the deviation of the surfaces from the fits of the level in progress (means over its
/// nodes) and the gap that the level before found. The two nodes where the surfaces are nearest have spheres that are
/// at most as far apart as the surfaces.
void set_expected_fit(double deviation_a_m, double deviation_b_m, double gap_m, PairFrame& frame);

/// Expands part of a front of the pair by one level on both sides.
Expansion expand(const PairFrame& frame, std::span<const FrontEntry> front, std::span<FrontEntry> out);
/// The same for two trees, with more lists; what is nearer than the frame's closeness_m is close. `nearness` may be
/// less than the frame's.
Expansion expand(const PairFrame& frame, const Nearness& nearness, std::span<const FrontEntry> front,
                 const ExpansionLists& lists);

}  // namespace poise::collision
