// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/picture/frame_picture.h"
#include "app/picture/picture.h"
#include "app/picture/pixel_text.h"
#include "studies/strips_panels.h"

namespace poise::app {
namespace {

constexpr std::uint32_t kTextScale = 2;

struct Point {
  double x = 0, y = 0;
};

/// The shapes as the balls of a level alone, drawn over the meshes to look translucent.
std::vector<capture::CapturedShape> balls_of(std::vector<capture::CapturedShape> shapes, Level level) {
  for (capture::CapturedShape& shape : shapes) {
    shape.vertices_m.clear();
    shape.corners.clear();
    if (shape.levels.empty()) continue;
    shape.levels = {shape.levels[std::min<std::size_t>(level, shape.levels.size() - 1)]};
    // Balls of a coarse level reach beyond the shape.
    for (const capture::CapturedSphere& s : shape.levels[0])
      shape.radius_m = std::max(shape.radius_m, std::hypot(static_cast<double>(s.x_m), static_cast<double>(s.y_m),
                                                           static_cast<double>(s.z_m)) +
                                                    static_cast<double>(s.radius_m));
  }
  return shapes;
}

void blend(io::Image& image, const io::Image& over, double share) {
  for (std::size_t i = 0; i < image.rgb.size(); ++i)
    image.rgb[i] = static_cast<std::uint8_t>(std::lround(image.rgb[i] * (1 - share) + over.rgb[i] * share));
}

void put_image(io::Image& image, const io::Image& part, std::uint32_t left, std::uint32_t top) {
  for (std::uint32_t y = 0; y < part.height_px; ++y) {
    const std::size_t from = std::size_t{3} * y * part.width_px;
    const std::size_t to = 3 * (std::size_t{top + y} * image.width_px + left);
    std::copy_n(&part.rgb[from], 3 * part.width_px, &image.rgb[to]);
  }
}

/// Distance of a point to a line from a to b.
double distance_px(const Point& p, const Point& a, const Point& b) {
  const double length2 = (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
  const double t =
      std::clamp(((p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y)) / std::max(length2, 1e-9), 0.0, 1.0);
  return std::hypot(p.x - a.x - t * (b.x - a.x), p.y - a.y - t * (b.y - a.y));
}

void draw_line(io::Image& image, const Point& a, const Point& b, const std::array<std::uint8_t, 3>& color,
               double half) {
  for (std::uint32_t y = 0; y < image.height_px; ++y) {
    for (std::uint32_t x = 0; x < image.width_px; ++x) {
      const double share = std::clamp(half + 0.5 - distance_px({x + 0.5, y + 0.5}, a, b), 0.0, 1.0);
      const std::size_t at = 3 * (std::size_t{y} * image.width_px + x);
      for (std::size_t k = 0; share > 0 && k < 3; ++k)
        image.rgb[at + k] = static_cast<std::uint8_t>(std::lround(image.rgb[at + k] * (1 - share) + color[k] * share));
    }
  }
}

void draw_arrow(io::Image& image, const Point& from, const Point& to) {
  constexpr double kHeadPx = 11;
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  if (length < 2) return;
  const Point along{(to.x - from.x) / length, (to.y - from.y) / length};
  const double head = std::min(kHeadPx, 0.6 * length);
  const auto side = [&](double turn) {
    return Point{to.x - head * (along.x - turn * along.y), to.y - head * (along.y + turn * along.x)};
  };
  constexpr std::array<std::uint8_t, 3> kWhite = {255, 255, 255};
  for (const auto& [color, half] : {std::pair{kWhite, 3.2}, {kStripArrow, 1.7}}) {
    draw_line(image, from, to, color, half);
    draw_line(image, to, side(0.5), color, half);
    draw_line(image, to, side(-0.5), color, half);
  }
}

io::Image panel_of(const Strips& all, const Strip& strip, const io::PictureSettings& settings, std::size_t moment) {
  const io::FramePictures pictures(all.shapes, settings);
  const io::DrawnFrame frame = panel_frame(all, strip, pictures, moment);
  io::Image image = pictures.draw(frame);
  if (moment == 1 && strip.level != kPolygonBin)
    blend(image, io::FramePictures(balls_of(all.shapes, strip.level), settings).draw(frame), 0.55);
  if (moment + 1 != strip.moments.size()) return image;
  const io::Eye eye(frame.view, static_cast<int>(kPanelWidth), static_cast<int>(kPanelHeight));
  const auto in_image = [&](const Vec3& point_m) {
    const auto [x, y] = in_panel(eye, point_m);
    return Point{x, y};
  };
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3& from_m = frame.bodies[all.bodies[i]].pose.position_m;
    draw_arrow(image, in_image(from_m), in_image(from_m + kArrowS * strip.velocity_mps[i]));
  }
  return image;
}

}  // namespace

io::DrawnFrame panel_frame(const Strips& all, const Strip& strip, const io::FramePictures& pictures,
                           std::size_t moment) {
  io::DrawnFrame frame = strip.moments[moment];
  for (const std::uint64_t body : all.bodies) frame.bodies[body].level = strip.level;
  frame.view = pictures.view(frame);
  frame.view.present = true;
  if (moment != 1) return frame;
  // The camera turned to the collision, with half of its angle.
  const Vec3 middle = 0.5 * (frame.bodies[all.bodies[0]].pose.position_m + frame.bodies[all.bodies[1]].pose.position_m);
  if ((middle - frame.view.position_m).norm() > 0) frame.view.forward = (middle - frame.view.position_m).normalized();
  frame.view.vertical_fov_rad *= 0.55;
  return frame;
}

std::array<double, 2> in_panel(const io::Eye& eye, const Vec3& point_m) {
  const Vec3 at = eye.to_eye * (point_m - eye.position_m);
  return {eye.center_x + eye.focal_samples * at.x() / at.z(), eye.center_y - eye.focal_samples * at.y() / at.z()};
}

std::string strip_title(const Strip& strip) {
  std::string text = strip.level == kPolygonBin ? std::string("polygons")
                                                : fmt::format("level {}, {} balls", strip.level, strip.balls);
  if (!strip.met) return text + ": the bodies never meet";
  if (strip.gap_m == 0) return text + fmt::format(": answered at {:.3f} s, when the surfaces have met", strip.time_s);
  return text + fmt::format(": answered at {:.3f} s, when the surfaces are {:.1f} mm apart = {:.2f} radii",
                            strip.time_s, 1000 * strip.gap_m, strip.gap_radii);
}

std::string strip_end(const Strip& strip) {
  return fmt::format("{:.2f} and {:.2f} m/s", strip.velocity_mps[0].norm(), strip.velocity_mps[1].norm());
}

io::Image strips_picture(const Strips& strips, bool dark) {
  const auto themed = [dark](const ChartColor& color) { return dark ? dark_color(color, DarkPart::All) : color; };
  const ChartColor ground = themed(kChartGround), ink = themed(kChartInk), end_ink = themed(kStripArrow);
  io::PictureSettings settings;
  settings.size_px = {{kPanelWidth, kPanelHeight}};
  settings.plain = true;
  io::Image image;
  image.width_px = strips_width_px();
  image.height_px = strip_top_px(strips.strips.size());
  for (std::uint32_t i = 0; i < image.width_px * image.height_px; ++i)
    image.rgb.insert(image.rgb.end(), ground.begin(), ground.end());
  for (std::size_t column = 0; column < kStripMoments.size(); ++column)
    io::draw_text(image, kStripMoments[column], std::int64_t{panel_left_px(column)}, 12, kTextScale, ink);
  for (std::size_t row = 0; row < strips.strips.size(); ++row) {
    const Strip& strip = strips.strips[row];
    const std::uint32_t top = strip_top_px(row);
    io::draw_text(image, strip_title(strip), kStripGap, top + 4, kTextScale, ink);
    const std::string end = strip_end(strip);
    io::draw_text(image, end, std::int64_t{image.width_px} - kStripGap - io::text_width_px(end, kTextScale), top + 4,
                  kTextScale, end_ink);
    for (std::size_t column = 0; column < kStripMoments.size(); ++column)
      put_image(image, panel_of(strips, strip, settings, column), panel_left_px(column), top + kStripTitle);
  }
  return image;
}

}  // namespace poise::app
