// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "frame/view_cues.h"
#include "query/inner_solids.h"

namespace poise::simulation {

/// What stands in front, in cells of the image: for each the depth beyond which nothing is seen in it. Conservative: a
/// cell is covered by a solid only if the solid fills it, at the largest depth of the solid's front in it.
///
/// A solid is convex, so it fills a cell if the rays through the cell's four corners meet it. 1 / depth of its front is
/// concave over the image (a projective map keeps the solid convex), so the largest depth in a cell is at a corner.
class DepthBuffer {
 public:
  static constexpr int kWidth = 64, kHeight = 36;

  /// Empties the buffer for a view, which is present.
  void begin(const ViewQuery& view_query);
  /// Draws a solid of a body.
  void add(const query::InnerSolid& solid, const Vec3& position_m, const Mat3& rotation);
  /// Whether a ball is surely not seen: all its cells within the image are covered by something nearer. False of what
  /// is outside the image.
  [[nodiscard]] bool hides(const Vec3& center_m, double radius_m) const;

 private:
  // Cells of the image that a ball may show in, ends included; nothing where the first is beyond the last.
  struct Cells {
    int left = 0, right = -1, low = 0, high = -1;
  };
  [[nodiscard]] Vec3 seen_from(const Vec3& point_m) const;
  [[nodiscard]] Cells cells_of(const Vec3& seen_m, double radius_m) const;
  template <class Enters>
  void draw(const Cells& cells, Enters&& enters);

  ViewQuery view_query_{View{}};
  std::array<float, std::size_t{kWidth} * kHeight> depth_m_{};
};

}  // namespace poise::simulation
