// SPDX-License-Identifier: MIT
#include "collision/front/pair_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace poise::collision {
namespace {

// The kernel rounds the frame once, three products and sums a coordinate, three squares and two radii: fewer than 16
// roundings, each at most half an ulp of numbers no larger than the sizes and the distance together.
constexpr double kRoundings = 16.0;
// Breadth of the weights of fitted spheres in standard deviations: found by trying 1.5 to 4 (docs/levels.md). Contacts
// whose gaps differ by less than the share of the skin count alike: a tenth of a millimetre for a body 0.4 m across,
// chosen.
constexpr double kWidth = 3;
constexpr double kFinestOfSkin = 0.1;
constexpr double kEpsilon = static_cast<double>(std::numeric_limits<float>::epsilon());

}  // namespace

void set_margin(double margin_m, PairFrame& frame) {
  frame.margin_m = margin_m;
  frame.nearness.inflation_m = static_cast<float>(margin_m + kRoundings * (frame.size_m + margin_m) * kEpsilon);
  frame.closeness_m = frame.nearness.inflation_m - static_cast<float>(margin_m);
}

PairFrame make_pair_frame(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin_m,
                          double skin_m) {
  PairFrame frame;
  frame.a = &a;
  frame.b = &b;
  frame.skin_m = skin_m;
  frame.fast = is_fast(margin_m, skin_m);
  const Mat3 to_a = pose_a.rotation.transpose();
  if (frame.with_plane()) {
    const Vec3 normal = pose_b.rotation * b.plane_normal;
    const double height = normal.dot(pose_b.position_m) + b.plane_offset_m;
    frame.plane_normal.noalias() = to_a * normal;
    frame.plane_height_m = height - normal.dot(pose_a.position_m);
  } else {
    frame.rotation.noalias() = to_a * pose_b.rotation;
    frame.offset_m.noalias() = to_a * (pose_b.position_m - pose_a.position_m);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        frame.rounded.rotation[3 * row + column] = static_cast<float>(frame.rotation(row, column));
      }
      frame.rounded.offset_m[row] = static_cast<float>(frame.offset_m[row]);
    }
  }
  frame.size_m = a.bounding_radius_m + b.bounding_radius_m + frame.offset_m.norm() + std::abs(frame.plane_height_m);
  set_margin(margin_m, frame);
  return frame;
}

void set_expected_fit(double deviation_a_m, double deviation_b_m, double gap_m, PairFrame& frame) {
  const double finest_m = kFinestOfSkin * frame.skin_m;
  frame.width_m =
      kWidth * std::sqrt(deviation_a_m * deviation_a_m + deviation_b_m * deviation_b_m + finest_m * finest_m);
  frame.expected_gap_m = gap_m;
  frame.closeness_m =
      frame.nearness.inflation_m - static_cast<float>(frame.margin_m - std::clamp(gap_m, 0.0, frame.margin_m));
}

Expansion expand(const PairFrame& frame, const Nearness& nearness, std::span<const FrontEntry> front,
                 const ExpansionLists& lists) {
  return expand_front(frame.trees(), nearness, frame.closeness_m, front, lists);
}

Expansion expand(const PairFrame& frame, std::span<const FrontEntry> front, std::span<FrontEntry> out) {
  if (!frame.with_plane()) {
    return expand_front(frame.trees(), frame.nearness, front, out);
  }
  const float normal[3] = {static_cast<float>(frame.plane_normal.x()), static_cast<float>(frame.plane_normal.y()),
                           static_cast<float>(frame.plane_normal.z())};
  return expand_plane_front(frame.a->tree, normal, static_cast<float>(frame.plane_height_m), frame.nearness, front,
                            out);
}

}  // namespace poise::collision
