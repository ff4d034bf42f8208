// SPDX-License-Identifier: MIT
#include "app/picture/panel_raster.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace poise::io {
namespace {

/// First sample whose middle is not left of `x`, kept in the panel.
int first_sample(double x, int most) {
  return static_cast<int>(std::clamp(std::ceil(x - 0.5), 0.0, static_cast<double>(most)));
}

}  // namespace

Vec3 usual_front(const Vec3& up) {
  if (up.y() != 0) return Vec3::UnitZ();
  return -Vec3::UnitY();
}

Mat3 three_quarter_view(const Vec3& up, const Vec3& front) {
  // From 25 degrees above, turned 35 degrees away from the front.
  constexpr double kTurn = 35 * std::numbers::pi / 180;
  constexpr double kRise = 25 * std::numbers::pi / 180;
  const Vec3 level = -std::cos(kTurn) * front - std::sin(kTurn) * up.cross(front);
  const Vec3 forward = std::cos(kRise) * level - std::sin(kRise) * up;
  Mat3 to_eye;
  const Vec3 right = forward.cross(up).normalized();
  to_eye.row(0) = right;
  to_eye.row(1) = right.cross(forward);
  to_eye.row(2) = forward;
  return to_eye;
}

PanelRaster::PanelRaster(const ParallelView& view, int width, int height)
    : view_(view),
      width_(width),
      height_(height),
      depth_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
             std::numeric_limits<float>::infinity()),
      item_(depth_.size(), kNothing) {}

Vec3 PanelRaster::in_samples(const Vec3& point_m) const {
  const Vec3 eye = view_.samples_per_m * (view_.to_eye * (point_m - view_.center_m));
  return {0.5 * width_ + eye.x(), 0.5 * height_ - eye.y(), eye.z()};
}

void PanelRaster::draw_ball(const Vec3& center_m, double radius_m, std::uint32_t item) {
  const Vec3 center = in_samples(center_m);
  const double radius = view_.samples_per_m * radius_m;
  const int right = first_sample(center.x() + radius, width_);
  const int below = first_sample(center.y() + radius, height_);
  for (int y = first_sample(center.y() - radius, height_); y < below; ++y) {
    for (int x = first_sample(center.x() - radius, width_); x < right; ++x) {
      const double dx = x + 0.5 - center.x();
      const double dy = y + 0.5 - center.y();
      const double rest = radius * radius - dx * dx - dy * dy;
      if (rest < 0) continue;
      const auto depth = static_cast<float>(center.z() - std::sqrt(rest));
      if (depth >= depth_[place(x, y)]) continue;
      depth_[place(x, y)] = depth;
      item_[place(x, y)] = item;
    }
  }
}

void PanelRaster::fill_triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::uint32_t item) {
  const double area = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
  if (area == 0) return;
  const int right = first_sample(std::max({a.x(), b.x(), c.x()}), width_);
  const int below = first_sample(std::max({a.y(), b.y(), c.y()}), height_);
  for (int y = first_sample(std::min({a.y(), b.y(), c.y()}), height_); y < below; ++y) {
    for (int x = first_sample(std::min({a.x(), b.x(), c.x()}), width_); x < right; ++x) {
      const double px = x + 0.5;
      const double py = y + 0.5;
      const double of_b = ((px - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (py - a.y())) / area;
      const double of_c = ((b.x() - a.x()) * (py - a.y()) - (px - a.x()) * (b.y() - a.y())) / area;
      if (of_b < 0 || of_c < 0 || of_b + of_c > 1) continue;
      const auto depth = static_cast<float>(a.z() + of_b * (b.z() - a.z()) + of_c * (c.z() - a.z()));
      if (depth >= depth_[place(x, y)]) continue;
      depth_[place(x, y)] = depth;
      item_[place(x, y)] = item;
    }
  }
}

void PanelRaster::draw_triangle(const Vec3& a_m, const Vec3& b_m, const Vec3& c_m, std::uint32_t item) {
  fill_triangle(in_samples(a_m), in_samples(b_m), in_samples(c_m), item);
}

void PanelRaster::draw_mesh(const TriangleMesh& mesh) {
  std::vector<Vec3> corners;
  corners.reserve(mesh.vertices_m.size());
  for (const Vec3& vertex_m : mesh.vertices_m) corners.push_back(in_samples(vertex_m));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    fill_triangle(corners[t[0]], corners[t[1]], corners[t[2]], static_cast<std::uint32_t>(i));
  }
}

double PanelRaster::lit_share(const Vec3& point_m, double slack_m) const {
  const Vec3 at = in_samples(point_m);
  const double slack = slack_m * view_.samples_per_m;
  // The four samples around the point, each with the share that a straight line between them gives it.
  const double left = std::floor(at.x() - 0.5);
  const double above = std::floor(at.y() - 0.5);
  const double far = static_cast<double>(std::max(width_, height_));
  if (!(std::abs(left) < far && std::abs(above) < far)) return 1;
  double share = 0;
  for (int k = 0; k < 4; ++k) {
    const int x = static_cast<int>(left) + k % 2;
    const int y = static_cast<int>(above) + k / 2;
    const double weight = (1 - std::abs(x + 0.5 - at.x())) * (1 - std::abs(y + 0.5 - at.y()));
    const bool hidden = item(x, y) != kNothing && static_cast<double>(depth_[place(x, y)]) < at.z() - slack;
    if (!hidden) share += weight;
  }
  return share;
}

std::uint32_t PanelRaster::item(int x, int y) const {
  return x < 0 || y < 0 || x >= width_ || y >= height_ ? kNothing : item_[place(x, y)];
}

Vec3 PanelRaster::point_m(int x, int y) const {
  const Vec3 eye(x + 0.5 - 0.5 * width_, 0.5 * height_ - y - 0.5, static_cast<double>(depth_[place(x, y)]));
  return view_.center_m + view_.to_eye.transpose() * eye / view_.samples_per_m;
}

}  // namespace poise::io
