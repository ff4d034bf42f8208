// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "studies/strips_panels.h"

namespace poise::app {
namespace {

constexpr double kNearM = 1e-3;  // what is nearer to the eye than this is left out

/// Something drawn, and how far it is.
struct Part {
  double depth_m = 0;
  std::string svg;
};

std::string lit_text(const std::array<double, 3>& color, double light) {
  std::array<int, 3> part{};
  for (std::size_t k = 0; k < 3; ++k) part[k] = static_cast<int>(std::lround(255 * std::min(1.0, color[k] * light)));
  return fmt::format("#{:02x}{:02x}{:02x}", part[0], part[1], part[2]);
}

std::string circle(const io::Eye& eye, const Vec3& center_m, double radius_m) {
  const Vec3 at = eye.to_eye * (center_m - eye.position_m);
  const auto [x, y] = in_panel(eye, center_m);
  return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"", x, y, eye.focal_samples * radius_m / at.z());
}

/// The triangles of a body that face the eye; where it has none, its balls of the deepest level.
void add_body(const io::Eye& eye, const io::DrawnShape& shape, const io::DrawnBody& body, std::vector<Part>& parts) {
  const std::array<double, 3> color = body.given ? io::kGivenColor : io::level_color(body.level.value_or(0));
  const Vec3 towards_light = eye.to_eye.transpose() * Vec3(-0.45, 0.75, -0.5).normalized();
  const auto world = [&](const Vec3& point) -> Vec3 { return body.pose.position_m + body.pose.orientation * point; };
  for (const auto& [a, b, c] : shape.triangles) {
    const std::array<Vec3, 3> corners{world(shape.vertices_m[a]), world(shape.vertices_m[b]),
                                      world(shape.vertices_m[c])};
    const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3;
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    const double depth_m = eye.to_eye.row(2).dot(middle - eye.position_m);
    if (!(normal.dot(middle - eye.position_m) < 0) || depth_m < kNearM) continue;
    std::string path;
    for (const Vec3& corner : corners) {
      const auto [x, y] = in_panel(eye, corner);
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? 'M' : 'L', x, y);
    }
    const double light = 0.62 + 0.42 * std::max(0.0, normal.dot(towards_light));
    parts.push_back({depth_m, fmt::format("<path d=\"{}z\" color=\"{}\"/>\n", path, lit_text(color, light))});
  }
  if (!shape.triangles.empty() || shape.levels.empty()) return;
  for (const Sphere& ball : shape.levels.back()) {
    const Vec3 center_m = world(ball.center_m);
    const double depth_m = eye.to_eye.row(2).dot(center_m - eye.position_m);
    if (depth_m < ball.radius_m + kNearM) continue;
    parts.push_back(
        {depth_m, circle(eye, center_m, ball.radius_m) + fmt::format(" color=\"{}\"/>\n", lit_text(color, 0.9))});
  }
}

/// The balls of a level over a body; together they are as translucent as one of them.
std::string balls_over(const io::Eye& eye, const io::DrawnShape& shape, const io::DrawnBody& body, Level level) {
  std::string svg;
  if (shape.levels.empty()) return svg;
  for (const Sphere& ball : shape.levels[std::min<std::size_t>(level, shape.levels.size() - 1)])
    svg += circle(eye, body.pose.position_m + body.pose.orientation * ball.center_m, ball.radius_m) + "/>\n";
  const std::array<double, 3> color = io::level_color(level);
  return fmt::format("<g opacity=\"0.4\" fill=\"{}\" stroke=\"{}\" stroke-width=\"0.7\">\n{}</g>\n", lit_text(color, 1),
                     lit_text(color, 0.6), svg);
}

std::string arrow(const std::array<double, 2>& from, const std::array<double, 2>& to) {
  const double length = std::hypot(to[0] - from[0], to[1] - from[1]);
  if (length < 2) return "";
  const double x = (to[0] - from[0]) / length, y = (to[1] - from[1]) / length, head = std::min(11.0, 0.6 * length);
  const std::string path =
      fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}", from[0], from[1], to[0],
                  to[1], to[0] - head * (x - 0.5 * y), to[1] - head * (y + 0.5 * x), to[0], to[1],
                  to[0] - head * (x + 0.5 * y), to[1] - head * (y - 0.5 * x));
  return fmt::format(
      "<path d=\"{0}\" stroke=\"white\" stroke-width=\"6\"/>\n<path d=\"{0}\" style=\"stroke: {1}\" "
      "stroke-width=\"3\"/>\n",
      path, color_text(kStripArrow));
}

std::string panel(const Strips& all, const std::vector<io::DrawnShape>& shapes, const Strip& strip,
                  const io::DrawnFrame& frame, std::size_t moment) {
  const io::Eye eye(frame.view, static_cast<int>(kPanelWidth), static_cast<int>(kPanelHeight));
  std::vector<Part> parts;
  for (const io::DrawnBody& body : frame.bodies) add_body(eye, shapes[body.shape], body, parts);
  std::ranges::stable_sort(parts, [](const Part& a, const Part& b) { return a.depth_m > b.depth_m; });
  // The thin stroke hides the seams between triangles.
  std::string svg = fmt::format(
      "<rect width=\"{}\" height=\"{}\" fill=\"#e6ecf2\"/>\n<g fill=\"currentColor\" "
      "stroke=\"currentColor\" stroke-width=\"0.5\">\n",
      kPanelWidth, kPanelHeight);
  for (const Part& part : parts) svg += part.svg;
  svg += "</g>\n";
  for (std::size_t i = 0; i < 2; ++i) {
    const io::DrawnBody& body = frame.bodies[all.bodies[i]];
    if (moment == 1 && strip.level != kPolygonBin) svg += balls_over(eye, shapes[body.shape], body, strip.level);
  }
  if (moment + 1 != strip.moments.size()) return svg;
  svg += "<g fill=\"none\">\n";
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3& from_m = frame.bodies[all.bodies[i]].pose.position_m;
    svg += arrow(in_panel(eye, from_m), in_panel(eye, from_m + kArrowS * strip.velocity_mps[i]));
  }
  return svg + "</g>\n";
}

}  // namespace

std::string strips_svg(const Strips& strips) {
  const io::FramePictures pictures(strips.shapes, {});
  std::vector<io::DrawnShape> shapes;
  for (const capture::CapturedShape& shape : strips.shapes) shapes.emplace_back(shape);
  const std::uint32_t width = strips_width_px(), height = strip_top_px(strips.strips.size());
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"16\" fill=\"{2}\">\n<rect width=\"{0}\" height=\"{1}\" "
      "fill=\"{3}\"/>\n",
      width, height, color_text(kChartInk), color_text(kChartGround));
  for (std::size_t column = 0; column < kStripMoments.size(); ++column)
    svg += fmt::format("<text x=\"{}\" y=\"26\">{}</text>\n", panel_left_px(column), kStripMoments[column]);
  for (std::size_t row = 0; row < strips.strips.size(); ++row) {
    const Strip& strip = strips.strips[row];
    const std::uint32_t top = strip_top_px(row);
    svg += fmt::format(
        "<text x=\"{}\" y=\"{}\">{}</text>\n<text x=\"{}\" y=\"{}\" text-anchor=\"end\" "
        "fill=\"{}\">{}</text>\n",
        kStripGap, top + 18, strip_title(strip), width - kStripGap, top + 18, color_text(kStripArrow),
        strip_end(strip));
    for (std::size_t column = 0; column < kStripMoments.size(); ++column) {
      // A picture in a picture, which cuts off what is beyond its edge.
      svg += fmt::format("<svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\">\n{}</svg>\n", panel_left_px(column),
                         top + kStripTitle, kPanelWidth, kPanelHeight,
                         panel(strips, shapes, strip, panel_frame(strips, strip, pictures, column), column));
    }
  }
  return svg_with_dark(svg + "</svg>\n", DarkPart::All);
}

}  // namespace poise::app
