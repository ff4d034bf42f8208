// SPDX-License-Identifier: MIT
#include "frame/cues/depth_buffer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace poise::simulation {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
// What is nearer to the eye than this is not drawn, and not hidden.
constexpr double kNearestDrawnM = 0.05;
// Depths are rounded away from the eye by more than single precision.
constexpr double kAway = 1 + 1e-6;

// Depth at which the ray t * (u, v, 1) enters a ball; infinite where it misses.
double enters_ball(const Vec3& ray, const Vec3& center_m, double radius_m) {
  const double a = ray.squaredNorm();
  const double b = ray.dot(center_m);
  const double root = b * b - a * (center_m.squaredNorm() - radius_m * radius_m);
  return root > 0 ? (b - std::sqrt(root)) / a : static_cast<double>(kNothing);
}

// Likewise a box, with ray and eye in its frame.
double enters_box(const Vec3& ray, const Vec3& eye_m, const Vec3& half_m) {
  double enters = 0;
  double leaves = static_cast<double>(kNothing);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (ray[axis] == 0.0) {
      if (std::abs(eye_m[axis]) >= half_m[axis]) return static_cast<double>(kNothing);
      continue;
    }
    const double t0 = (-half_m[axis] - eye_m[axis]) / ray[axis];
    const double t1 = (half_m[axis] - eye_m[axis]) / ray[axis];
    enters = std::max(enters, std::min(t0, t1));
    leaves = std::min(leaves, std::max(t0, t1));
  }
  return enters < leaves ? enters : static_cast<double>(kNothing);
}

int cell_at(double of_image, int cells) {
  const double cell = std::floor(0.5 * (of_image + 1.0) * cells);
  return static_cast<int>(std::clamp(cell, -1.0, static_cast<double>(cells)));
}

}  // namespace

void DepthBuffer::begin(const ViewQuery& view_query) {
  view_query_ = view_query;
  depth_m_.fill(kNothing);
}

Vec3 DepthBuffer::seen_from(const Vec3& point_m) const {
  const Vec3 ray = point_m - view_query_.view.position_m;
  return {ray.dot(view_query_.right), ray.dot(view_query_.up), ray.dot(view_query_.view.forward)};
}

DepthBuffer::Cells DepthBuffer::cells_of(const Vec3& seen_m, double radius_m) const {
  const double near = seen_m.z() - radius_m;
  const double far = seen_m.z() + radius_m;
  const auto most = [&](double x) { return (x + radius_m) / (x + radius_m > 0 ? near : far); };
  Cells cells;
  cells.left = std::max(0, cell_at(-most(-seen_m.x()) / view_query_.tangent_right, kWidth));
  cells.right = std::min(kWidth - 1, cell_at(most(seen_m.x()) / view_query_.tangent_right, kWidth));
  cells.low = std::max(0, cell_at(-most(-seen_m.y()) / view_query_.tangent_up, kHeight));
  cells.high = std::min(kHeight - 1, cell_at(most(seen_m.y()) / view_query_.tangent_up, kHeight));
  return cells;
}

template <class Enters>
void DepthBuffer::draw(const Cells& cells, Enters&& enters) {
  std::array<double, kWidth + 1> below{}, above{};
  const auto fill_row = [&](int row, std::array<double, kWidth + 1>& at) {
    const double v = (2.0 * row / kHeight - 1.0) * view_query_.tangent_up;
    for (int column = cells.left; column <= cells.right + 1; ++column) {
      const double u = (2.0 * column / kWidth - 1.0) * view_query_.tangent_right;
      at[static_cast<std::size_t>(column)] = enters(Vec3(u, v, 1.0));
    }
  };
  fill_row(cells.low, below);
  for (int row = cells.low; row <= cells.high; ++row) {
    fill_row(row + 1, above);
    for (int column = cells.left; column <= cells.right; ++column) {
      const auto c = static_cast<std::size_t>(column);
      const double deepest = std::max({below[c], below[c + 1], above[c], above[c + 1]});
      float& depth_m = depth_m_[static_cast<std::size_t>(row) * kWidth + c];
      depth_m = std::min(depth_m, static_cast<float>(deepest * kAway));
    }
    std::swap(below, above);
  }
}

void DepthBuffer::add(const query::InnerSolid& solid, const Vec3& position_m, const Mat3& rotation) {
  const Vec3 center_m = seen_from(position_m + rotation * solid.center_m);
  const double radius_m = solid.radius_m > 0 ? solid.radius_m : solid.half_extents_m.norm();
  // An eye that is inside, or nearly, would need clipping; nothing is lost but an occluder.
  const double near = center_m.z() - radius_m;
  if (near < kNearestDrawnM) return;
  // What is smaller than a cell fills none.
  const double half_wide = view_query_.tangent_right / kWidth;
  const double half_high = view_query_.tangent_up / kHeight;
  if (radius_m < std::sqrt(half_wide * half_wide + half_high * half_high) * near) return;
  const Cells cells = cells_of(center_m, radius_m);
  if (cells.left > cells.right || cells.low > cells.high) return;
  if (solid.radius_m > 0) {
    draw(cells, [&](const Vec3& ray) { return enters_ball(ray, center_m, solid.radius_m); });
    return;
  }
  Mat3 world_of_view;
  world_of_view << view_query_.right, view_query_.up, view_query_.view.forward;
  const Mat3 turn = rotation.transpose() * world_of_view;
  const Vec3 eye_m = -(turn * center_m);
  draw(cells, [&](const Vec3& ray) { return enters_box(turn * ray, eye_m, solid.half_extents_m); });
}

bool DepthBuffer::hides(const Vec3& center_m, double radius_m) const {
  const Vec3 seen_m = seen_from(center_m);
  const double near = seen_m.z() - radius_m;
  if (!(near > kNearestDrawnM)) return false;
  const Cells cells = cells_of(seen_m, radius_m);
  if (cells.left > cells.right || cells.low > cells.high) return false;
  for (int row = cells.low; row <= cells.high; ++row) {
    for (int column = cells.left; column <= cells.right; ++column) {
      const float depth_m = depth_m_[static_cast<std::size_t>(row) * kWidth + static_cast<std::size_t>(column)];
      if (!(static_cast<double>(depth_m) < near)) return false;
    }
  }
  return true;
}

}  // namespace poise::simulation
