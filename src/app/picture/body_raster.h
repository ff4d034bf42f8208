// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "capture/capture.h"
#include "capture/packed_pose.h"
#include "poise/step.h"
#include "poise/types.h"

namespace poise::io {

/// A view in perspective. Samples are the points at which the image is computed, several a pixel.
struct Eye {
  Vec3 position_m = Vec3::Zero();
  Mat3 to_eye = Mat3::Identity();  ///< rows: right, up, forward; unit vectors
  double focal_samples = 1;        ///< distance of the image plane
  double center_x = 0, center_y = 0;

  Eye(const View& view, int width, int height);
  /// Through the middle of a sample, in the eye's frame; forward is 1.
  [[nodiscard]] Vec3 ray(int x, int y) const {
    return {(x + 0.5 - center_x) / focal_samples, (center_y - y - 0.5) / focal_samples, 1};
  }
};

/// A shape made ready for drawing. A corner of a triangle has the mean normal of the triangles that meet there at a
/// small angle, so that what is round looks round and edges stay sharp.
struct DrawnShape {
  std::vector<Vec3> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<Vec3, 3>> normals;  ///< one a triangle; unit
  std::vector<std::vector<Sphere>> levels;   ///< of the sphere tree
  double radius_m = 0;                       ///< of the ball around the centre of mass; 0 for planes

  explicit DrawnShape(const capture::CapturedShape& shape);
  DrawnShape() = default;
  /// The balls to draw where the shape has no triangles, or looks this large: the deepest level that has no more of
  /// them than the size can show.
  [[nodiscard]] std::span<const Sphere> balls(double radius_samples) const;
};

/// What is seen at each sample of a band of rows of an image. Invariant: the arrays have (below - top) x width entries.
class BodyRaster {
 public:
  static constexpr std::uint32_t kNothing = std::numeric_limits<std::uint32_t>::max();

  BodyRaster(const Eye& eye, int width, int top, int below);

  /// Draws a body where it is nearer than what is there; what is before the eye by less than a small distance is not
  /// drawn.
  void draw(const DrawnShape& shape, const capture::Pose& pose, std::uint32_t body);
  void draw_ball(const Vec3& center_m, double radius_m, std::uint32_t body);

  [[nodiscard]] int top() const { return top_; }
  [[nodiscard]] int below() const { return below_; }
  /// The body seen at a sample of the image; kNothing where there is none, and outside of the band.
  [[nodiscard]] std::uint32_t body(int x, int y) const;
  /// Distance along the forward axis; infinite where nothing is.
  [[nodiscard]] double depth_m(int x, int y) const;
  /// Normal of what is seen, world frame, towards the eye.
  [[nodiscard]] Vec3 normal(int x, int y) const;

 private:
  struct Corner {
    Vec3 eye_m, normal;
  };
  void draw_triangle(const std::array<Corner, 3>& corners, std::uint32_t body);
  void draw_before_eye(const Corner& a, const Corner& b, const Corner& c, std::uint32_t body);
  void put(int x, int y, double depth_m, const Vec3& normal, std::uint32_t body);
  [[nodiscard]] std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(y - top_) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  Eye eye_;
  int width_, top_, below_;
  std::vector<float> depth_m_;
  std::vector<std::uint32_t> body_;
  std::vector<std::array<std::int8_t, 3>> normal_;
  std::vector<Vec3> corners_;  // of the shape at hand, in the eye's frame
};

}  // namespace poise::io
