// SPDX-License-Identifier: MIT
#include "app/picture/picture_legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "app/picture/frame_picture.h"
#include "app/picture/picture.h"
#include "app/picture/pixel_text.h"

namespace poise::io {
namespace {

using Color = std::array<double, 3>;

constexpr std::array<std::uint8_t, 3> kLegendInk = {35, 40, 48};
constexpr std::uint32_t kLegendLeastPx = 360;  // width of a picture

void blend(Image& image, std::int64_t x, std::int64_t y, const Color& color, double share) {
  if (x < 0 || y < 0 || x >= image.width_px || y >= image.height_px) return;
  const std::size_t at = 3 * (static_cast<std::size_t>(y) * image.width_px + static_cast<std::size_t>(x));
  for (std::size_t k = 0; k < 3; ++k)
    image.rgb[at + k] =
        static_cast<std::uint8_t>(std::lround(image.rgb[at + k] * (1 - share) + 255 * color[k] * share));
}

/// Distance at which a ray meets a triangle from either side, in lengths of `ray`; infinite if it does not.
double meets(const Vec3& from, const Vec3& ray, const Vec3& a, const Vec3& b, const Vec3& c) {
  // T. Möller and B. Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997.
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const Vec3 p = ray.cross(c - a);
  const double determinant = p.dot(b - a);
  if (determinant == 0) return kNone;
  const double u = p.dot(from - a) / determinant;
  const Vec3 q = (from - a).cross(b - a);
  const double v = q.dot(ray) / determinant;
  const double t = q.dot(c - a) / determinant;
  return u >= 0 && v >= 0 && u + v <= 1 && t > 0 ? t : kNone;
}

double meets(const Vec3& from, const Vec3& ray, const Vec3& center, double radius) {
  const double b = ray.dot(center - from);
  const double rest = b * b - (center - from).squaredNorm() + radius * radius;
  return rest >= 0 && b - std::sqrt(rest) > 0 ? b - std::sqrt(rest) : std::numeric_limits<double>::infinity();
}

double meets(const Vec3& from_m, const Vec3& ray, const DrawnShape& shape, const capture::Pose& pose) {
  const Vec3 from = pose.orientation.conjugate() * (from_m - pose.position_m);
  const Vec3 along = pose.orientation.conjugate() * ray;
  double nearest = std::numeric_limits<double>::infinity();
  if ((from + std::max(0.0, -along.dot(from)) * along).norm() > shape.radius_m) return nearest;
  for (const auto& [a, b, c] : shape.triangles)
    nearest = std::min(nearest, meets(from, along, shape.vertices_m[a], shape.vertices_m[b], shape.vertices_m[c]));
  if (!shape.triangles.empty() || shape.levels.empty()) return nearest;
  for (const Sphere& ball : shape.levels.back())
    nearest = std::min(nearest, meets(from, along, ball.center_m, ball.radius_m));
  return nearest;
}

std::optional<Vec3> gaze_point(const DrawnFrame& frame, std::span<const DrawnShape> shapes,
                               std::span<const DrawnPlane> planes) {
  const Vec3& from = frame.view.position_m;
  const Vec3 ray = frame.view.gaze.normalized();
  double nearest = std::numeric_limits<double>::infinity();
  for (const DrawnBody& body : frame.bodies) {
    if (shapes[body.shape].radius_m > 0) nearest = std::min(nearest, meets(from, ray, shapes[body.shape], body.pose));
  }
  for (const DrawnPlane& plane : planes) {
    if (plane.ground) nearest = std::min(nearest, distance_along(plane, from, ray).value_or(nearest));
  }
  if (!std::isfinite(nearest)) return std::nullopt;
  return from + nearest * ray;
}

struct Entry {
  Color color{};
  std::string text;
};

std::vector<Entry> entries_of(const DrawnFrame& frame, std::span<const DrawnShape> shapes) {
  std::size_t deepest = 0;
  bool polygons = false;
  bool given = false;
  bool untouched = false;
  for (const DrawnBody& body : frame.bodies) {
    if (shapes[body.shape].radius_m <= 0) continue;
    deepest = std::max(deepest, shapes[body.shape].levels.size());
    polygons = polygons || (!body.given && body.level == kPolygonBin);
    given = given || body.given;
    untouched = untouched || (!body.given && !body.level);
  }
  constexpr std::size_t kColors = 5;
  std::vector<Entry> entries;
  for (std::size_t level = 0; level < std::min(deepest, kColors); ++level) {
    const bool last = level + 1 == std::min(deepest, kColors);
    const char* const what = level == 0 ? " root sphere" : !last ? "" : deepest > kColors ? " and deeper" : " leaves";
    entries.push_back({level_color(static_cast<int>(level)), fmt::format("{}{}", level, what)});
  }
  if (polygons) entries.push_back({level_color(kPolygonBin), "polygons"});
  if (untouched) entries.push_back({kUntouchedColor, "touches nothing"});
  if (given) entries.push_back({kGivenColor, "static"});
  return entries;
}

}  // namespace

void draw_gaze_ring(const DrawnFrame& frame, std::span<const DrawnShape> shapes, std::span<const DrawnPlane> planes,
                    const Eye& eye, int samples_across, Image& image) {
  if (!frame.view.present) return;
  const std::optional<Vec3> point = gaze_point(frame, shapes, planes);
  if (!point) return;
  const Vec3 at = eye.to_eye * (*point - eye.position_m);
  if (at.z() <= 1e-4) return;
  const double x = (eye.center_x + eye.focal_samples * at.x() / at.z()) / samples_across;
  const double y = (eye.center_y - eye.focal_samples * at.y() / at.z()) / samples_across;
  const double radius = 0.035 * image.height_px;
  const double half = std::max(1.0, image.height_px / 480.0);  // of the width of the white line
  const double reach = radius + 2 * half + 2;
  if (!(x > -reach && y > -reach && x < image.width_px + reach && y < image.height_px + reach)) return;
  for (auto row = static_cast<std::int64_t>(y - reach); row <= static_cast<std::int64_t>(y + reach); ++row) {
    for (auto column = static_cast<std::int64_t>(x - reach); column <= static_cast<std::int64_t>(x + reach); ++column) {
      const double off =
          std::abs(std::hypot(static_cast<double>(column) + 0.5 - x, static_cast<double>(row) + 0.5 - y) - radius);
      blend(image, column, row, {0.1, 0.1, 0.12}, 0.75 * std::clamp(2 * half + 0.5 - off, 0.0, 1.0));
      blend(image, column, row, {1, 1, 1}, std::clamp(half + 0.5 - off, 0.0, 1.0));
    }
  }
}

void draw_legend(const DrawnFrame& frame, std::span<const DrawnShape> shapes, Image& image) {
  if (image.width_px < kLegendLeastPx) return;
  const std::uint32_t scale = std::max(1U, std::min(image.height_px / 360, image.width_px / 600));
  const std::uint32_t gap = 5 * scale;
  const std::uint32_t line_px = (kTextHeight + 5) * scale;
  const std::uint32_t swatch_px = (kTextHeight + 1) * scale;

  // Where each word goes, in lines.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> places;
  const std::string title = fmt::format("{}: frame {}, {:.2f} s", frame.scene, frame.frame, frame.time_s);
  const std::string about = frame.view.present ? "ring: gaze.  level reached:" : "level reached:";
  const std::vector<Entry> entries = entries_of(frame, shapes);
  std::uint32_t x = 2 * gap + text_width_px(about, scale) + 2 * gap;
  std::uint32_t line = 1;
  for (const Entry& entry : entries) {
    const std::uint32_t width = swatch_px + gap + text_width_px(entry.text, scale);
    if (x + width + gap > image.width_px) {
      x = 2 * gap;
      ++line;
    }
    places.emplace_back(x, line);
    x += width + 3 * gap;
  }
  const std::uint32_t height = (line + 1) * line_px + gap;
  if (3 * height > image.height_px) return;
  const std::uint32_t top = image.height_px - height;
  for (std::uint32_t y = top; y < image.height_px; ++y) {
    for (std::uint32_t column = 0; column < image.width_px; ++column) blend(image, column, y, {1, 1, 1}, 0.72);
  }
  const std::int64_t margin = std::int64_t{2} * gap;
  draw_text(image, title, margin, std::int64_t{top} + gap, scale, kLegendInk);
  draw_text(image, about, margin, std::int64_t{top} + gap + line_px, scale, kLegendInk);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto [left, row] = places[i];
    const std::uint32_t y = top + gap + row * line_px;
    for (std::uint32_t k = 0; k < swatch_px * swatch_px; ++k)
      blend(image, left + k % swatch_px, y + k / swatch_px, entries[i].color, 1);
    draw_text(image, entries[i].text, left + swatch_px + gap, y, scale, kLegendInk);
  }
}

}  // namespace poise::io
