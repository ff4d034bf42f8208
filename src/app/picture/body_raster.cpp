// SPDX-License-Identifier: MIT
#include "app/picture/body_raster.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace poise::io {
namespace {

constexpr double kNear = 1e-4;   // metres; chosen, far below what a scene has before its eye
constexpr double kSmooth = 0.8;  // cosine of the angle up to which triangles are parts of one round surface; chosen

/// The first sample whose middle is not before `x`, kept in [from, to].
int first_sample(double x, int from, int to) {
  return static_cast<int>(std::clamp(std::ceil(x - 0.5), static_cast<double>(from), static_cast<double>(to)));
}

/// From where to where a ball reaches along one axis of the image plane at distance 1: the tangents of the angles of
/// the two lines through the eye that touch its circle in the plane of this axis and the forward axis.
std::pair<double, double> reach(double across, double forward, double radius) {
  const double distance2 = across * across + forward * forward;
  const double touch = radius * std::sqrt(std::max(0.0, distance2 - radius * radius));
  const double below = forward * forward - radius * radius;
  return {(across * forward - touch) / below, (across * forward + touch) / below};
}

}  // namespace

Eye::Eye(const View& view, int width, int height) : position_m(view.position_m) {
  const Vec3 right = view.forward.cross(view.up).normalized();
  to_eye.row(0) = right;
  to_eye.row(1) = right.cross(view.forward);
  to_eye.row(2) = view.forward;
  focal_samples = 0.5 * height / std::tan(0.5 * view.vertical_fov_rad);
  center_x = 0.5 * width;
  center_y = 0.5 * height;
}

DrawnShape::DrawnShape(const capture::CapturedShape& shape) : radius_m(shape.radius_m) {
  for (std::size_t i = 0; i + 2 < shape.vertices_m.size(); i += 3)
    vertices_m.emplace_back(static_cast<double>(shape.vertices_m[i]), static_cast<double>(shape.vertices_m[i + 1]),
                            static_cast<double>(shape.vertices_m[i + 2]));
  for (std::size_t i = 0; i + 2 < shape.corners.size(); i += 3)
    triangles.push_back({shape.corners[i], shape.corners[i + 1], shape.corners[i + 2]});
  for (const std::vector<capture::CapturedSphere>& spheres : shape.levels) {
    std::vector<Sphere>& level = levels.emplace_back();
    for (const capture::CapturedSphere& s : spheres)
      level.push_back({Vec3(static_cast<double>(s.x_m), static_cast<double>(s.y_m), static_cast<double>(s.z_m)),
                       static_cast<double>(s.radius_m)});
  }
  std::vector<Vec3> faces;  // normals with the area as their length
  std::vector<std::vector<std::uint32_t>> around(vertices_m.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t];
    faces.emplace_back((vertices_m[b] - vertices_m[a]).cross(vertices_m[c] - vertices_m[a]));
    for (const std::uint32_t corner : triangles[t]) around[corner].push_back(t);
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    std::array<Vec3, 3>& own = normals.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t other : around[triangles[t][k]]) {
        if (faces[other].dot(faces[t]) >= kSmooth * faces[other].norm() * faces[t].norm()) sum += faces[other];
      }
      own[k] = sum.norm() > 0 ? Vec3(sum.normalized()) : Vec3(Vec3::UnitZ());
    }
  }
}

std::span<const Sphere> DrawnShape::balls(double radius_samples) const {
  // A ball of less than about two samples across is not seen as one.
  const double most = std::max(1.0, radius_samples * radius_samples);
  std::span<const Sphere> chosen;
  for (const std::vector<Sphere>& level : levels) {
    if (chosen.empty() || static_cast<double>(level.size()) <= most) chosen = level;
  }
  return chosen;
}

BodyRaster::BodyRaster(const Eye& eye, int width, int top, int below)
    : eye_(eye), width_(width), top_(top), below_(below) {
  const auto size = static_cast<std::size_t>(width) * static_cast<std::size_t>(below - top);
  depth_m_.assign(size, std::numeric_limits<float>::infinity());
  body_.assign(size, kNothing);
  normal_.resize(size);
}

void BodyRaster::put(int x, int y, double depth_m, const Vec3& normal, std::uint32_t body) {
  const auto depth = static_cast<float>(depth_m);
  const std::size_t at = place(x, y);
  if (depth >= depth_m_[at]) return;
  depth_m_[at] = depth;
  body_[at] = body;
  const Vec3 scaled = 127 * normal.normalized();
  for (int k = 0; k < 3; ++k)
    normal_[at][static_cast<std::size_t>(k)] = static_cast<std::int8_t>(std::lround(scaled[k]));
}

void BodyRaster::draw_ball(const Vec3& center_m, double radius_m, std::uint32_t body) {
  const Vec3 center = eye_.to_eye * (center_m - eye_.position_m);
  if (center.z() - radius_m <= kNear) return;
  const auto [left, right] = reach(center.x(), center.z(), radius_m);
  const auto [low, high] = reach(center.y(), center.z(), radius_m);
  const double f = eye_.focal_samples;
  const int right_end = first_sample(eye_.center_x + f * right, 0, width_);
  const int below_end = first_sample(eye_.center_y - f * low, top_, below_);
  const double c = center.squaredNorm() - radius_m * radius_m;
  for (int y = first_sample(eye_.center_y - f * high, top_, below_); y < below_end; ++y) {
    for (int x = first_sample(eye_.center_x + f * left, 0, width_); x < right_end; ++x) {
      const Vec3 ray = eye_.ray(x, y);
      const double a = ray.squaredNorm();
      const double b = ray.dot(center);
      const double discriminant = b * b - a * c;
      if (discriminant < 0) continue;
      const double depth = (b - std::sqrt(discriminant)) / a;
      put(x, y, depth, eye_.to_eye.transpose() * (depth * ray - center), body);
    }
  }
}

void BodyRaster::draw(const DrawnShape& shape, const capture::Pose& pose, std::uint32_t body) {
  const Vec3 center = eye_.to_eye * (pose.position_m - eye_.position_m);
  if (center.z() + shape.radius_m <= kNear) return;
  double radius_samples = std::numeric_limits<double>::infinity();
  if (center.z() - shape.radius_m > kNear) {
    const auto [low, high] = reach(center.y(), center.z(), shape.radius_m);
    if (eye_.center_y - eye_.focal_samples * low < top_ || eye_.center_y - eye_.focal_samples * high > below_) return;
    const auto [left, right] = reach(center.x(), center.z(), shape.radius_m);
    if (eye_.center_x + eye_.focal_samples * right < 0 || eye_.center_x + eye_.focal_samples * left > width_) return;
    radius_samples = eye_.focal_samples * shape.radius_m / center.z();
  }
  constexpr double kTooSmallForTriangles = 2;
  if (shape.triangles.empty() || radius_samples < kTooSmallForTriangles) {
    for (const Sphere& ball : shape.balls(radius_samples))
      draw_ball(pose.position_m + pose.orientation * ball.center_m, ball.radius_m, body);
    return;
  }
  const Mat3 turn = pose.orientation.toRotationMatrix();
  corners_.clear();
  for (const Vec3& vertex_m : shape.vertices_m) corners_.emplace_back(center + eye_.to_eye * (turn * vertex_m));
  for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
    std::array<Corner, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = {corners_[shape.triangles[t][k]], turn * shape.normals[t][k]};
    draw_triangle(corners, body);
  }
}

void BodyRaster::draw_triangle(const std::array<Corner, 3>& corners, std::uint32_t body) {
  // What lies before the eye: the triangle, or what is left of it, at most four corners.
  std::array<Corner, 4> kept;
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Corner& a = corners[k];
    const Corner& b = corners[(k + 1) % 3];
    const bool inside = a.eye_m.z() > kNear;
    if (inside) kept[count++] = a;
    if (inside == (b.eye_m.z() > kNear)) continue;
    const double t = (kNear - a.eye_m.z()) / (b.eye_m.z() - a.eye_m.z());
    kept[count++] = {a.eye_m + t * (b.eye_m - a.eye_m), a.normal + t * (b.normal - a.normal)};
  }
  for (std::size_t k = 2; k < count; ++k) draw_before_eye(kept[0], kept[k - 1], kept[k], body);
}

void BodyRaster::draw_before_eye(const Corner& a, const Corner& b, const Corner& c, std::uint32_t body) {
  const auto in_image = [&](const Corner& corner) {
    const double scale = eye_.focal_samples / corner.eye_m.z();
    return std::array{eye_.center_x + scale * corner.eye_m.x(), eye_.center_y - scale * corner.eye_m.y()};
  };
  const auto [ax, ay] = in_image(a);
  const auto [bx, by] = in_image(b);
  const auto [cx, cy] = in_image(c);
  const double area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
  if (area == 0) return;
  const bool from_within = area > 0;  // rows count downwards; meshes that are not closed show their inside
  const int right = first_sample(std::max({ax, bx, cx}), 0, width_);
  const int below = first_sample(std::max({ay, by, cy}), top_, below_);
  for (int y = first_sample(std::min({ay, by, cy}), top_, below_); y < below; ++y) {
    for (int x = first_sample(std::min({ax, bx, cx}), 0, width_); x < right; ++x) {
      const double px = x + 0.5;
      const double py = y + 0.5;
      const double of_b = ((px - ax) * (cy - ay) - (cx - ax) * (py - ay)) / area;
      const double of_c = ((bx - ax) * (py - ay) - (px - ax) * (by - ay)) / area;
      if (of_b < 0 || of_c < 0 || of_b + of_c > 1) continue;
      // The inverse of the depth is linear in the image.
      const double of_a = 1 - of_b - of_c;
      const double depth = 1 / (of_a / a.eye_m.z() + of_b / b.eye_m.z() + of_c / c.eye_m.z());
      const Vec3 normal = of_a * a.normal + of_b * b.normal + of_c * c.normal;
      put(x, y, depth, from_within ? Vec3(-normal) : normal, body);
    }
  }
}

std::uint32_t BodyRaster::body(int x, int y) const {
  return x < 0 || x >= width_ || y < top_ || y >= below_ ? kNothing : body_[place(x, y)];
}

double BodyRaster::depth_m(int x, int y) const { return static_cast<double>(depth_m_[place(x, y)]); }

Vec3 BodyRaster::normal(int x, int y) const {
  const std::array<std::int8_t, 3>& n = normal_[place(x, y)];
  return Vec3(n[0], n[1], n[2]).normalized();
}

}  // namespace poise::io
