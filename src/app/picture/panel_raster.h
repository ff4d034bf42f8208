// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "poise/mesh.h"
#include "poise/types.h"

namespace poise::io {

/// A view from infinitely far: the same scale everywhere, so that pictures beside one another can be compared.
struct ParallelView {
  Mat3 to_eye = Mat3::Identity();  ///< rows: right, up, forward; unit vectors
  Vec3 center_m = Vec3::Zero();    ///< the point in the middle of the panel
  double samples_per_m = 1;        ///< > 0
};

/// Towards where an object usually looks when `up` (a unit vector along an axis) is upward: -y with z upward, z with y
/// upward.
Vec3 usual_front(const Vec3& up);

/// A view from the front, turned to one side and from above, with `up` upward in the picture; unit vectors square to
/// each other.
Mat3 three_quarter_view(const Vec3& up, const Vec3& front);

/// What is seen in each sample of a panel. Invariant: depth_m and item have width x height entries, rows from the top.
class PanelRaster {
 public:
  static constexpr std::uint32_t kNothing = std::numeric_limits<std::uint32_t>::max();

  PanelRaster(const ParallelView& view, int width, int height);

  /// Draws a ball where it is nearer than what is there. `item` is what the sample will say.
  void draw_ball(const Vec3& center_m, double radius_m, std::uint32_t item);
  /// Draws a triangle, either side.
  void draw_triangle(const Vec3& a_m, const Vec3& b_m, const Vec3& c_m, std::uint32_t item);
  /// Draws every triangle, either side; the item is its number.
  void draw_mesh(const TriangleMesh& mesh);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Number given with what is seen here; kNothing where nothing is, and outside the panel.
  [[nodiscard]] std::uint32_t item(int x, int y) const;
  /// The point seen at a sample, in the frame of the mesh; meaningless where nothing is.
  [[nodiscard]] Vec3 point_m(int x, int y) const;
  [[nodiscard]] const ParallelView& view() const { return view_; }
  /// For a raster seen from a light: how much of it comes to a point past what is drawn, 0 to 1: the share of the
  /// samples around it where nothing lies more than `slack_m` before it.
  [[nodiscard]] double lit_share(const Vec3& point_m, double slack_m) const;

 private:
  [[nodiscard]] Vec3 in_samples(const Vec3& point_m) const;
  void fill_triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::uint32_t item);
  [[nodiscard]] std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  ParallelView view_;
  int width_, height_;
  std::vector<float> depth_;  // in samples, from the middle
  std::vector<std::uint32_t> item_;
};

}  // namespace poise::io
