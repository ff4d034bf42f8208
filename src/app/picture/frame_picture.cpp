// SPDX-License-Identifier: MIT
#include "app/picture/frame_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "app/picture/drawn_planes.h"
#include "app/picture/panel_raster.h"
#include "app/picture/picture_legend.h"
#include "geometry/primitives/bounds.h"
#include "parallel/executor.h"

namespace poise::io {
namespace {

using Color = std::array<double, 3>;

constexpr int kSamplesAcross = 2;  // per pixel, each way
constexpr int kBandRows = 32;      // pixels
constexpr Color kWall = {0.52, 0.60, 0.70};
constexpr double kWallShare = 0.28;  // of the colour of a wall in what is seen through it

Color scaled(const Color& color, double by) { return {by * color[0], by * color[1], by * color[2]}; }
Color mixed(const Color& a, const Color& b, double of_b) {
  return {a[0] + of_b * (b[0] - a[0]), a[1] + of_b * (b[1] - a[1]), a[2] + of_b * (b[2] - a[2])};
}

/// A camera that looks at the middle of all moving bodies from far enough.
View view_of_all(const DrawnFrame& frame, std::span<const DrawnShape> shapes) {
  geometry::Bounds box;
  for (const DrawnBody& body : frame.bodies) {
    if (body.given) continue;
    const Vec3 r = Vec3::Constant(shapes[body.shape].radius_m);
    box.add(body.pose.position_m - r);
    box.add(body.pose.position_m + r);
  }
  if (!box.low.allFinite()) box.low = box.high = Vec3::Zero();
  const double radius_m = 0.5 * (box.high - box.low).norm() + 0.1;
  View view;
  view.up = frame.up;
  const Vec3 ahead = three_quarter_view(frame.up, usual_front(frame.up)).row(2);
  view.forward = ahead.normalized();
  view.position_m = box.center() - view.forward * (1.1 * radius_m / std::sin(0.5 * view.vertical_fov_rad));
  return view;
}

View view_of(const PictureSettings& settings, const DrawnFrame& frame, std::span<const DrawnShape> shapes) {
  if (!settings.camera) return frame.view.present ? frame.view : view_of_all(frame, shapes);
  View view;
  view.position_m = settings.camera->position_m;
  view.forward = (settings.camera->look_at_m - settings.camera->position_m).normalized();
  // Straight up or down: any direction will do as upward in the picture.
  view.up = view.forward.cross(frame.up).norm() > 1e-6 ? frame.up
            : std::abs(frame.up.y()) < 0.5             ? Vec3(Vec3::UnitY())
                                                       : Vec3(Vec3::UnitZ());
  view.vertical_fov_rad = settings.camera->vertical_fov_rad;
  return view;
}

/// One strong light from behind the viewer's left shoulder, and what it does not reach.
class Light {
 public:
  Light(const Eye& eye, const DrawnFrame& frame, std::span<const DrawnShape> shapes)
      : towards_((-0.45 * Vec3(eye.to_eye.row(0)) - 0.35 * Vec3(eye.to_eye.row(2)) + 0.9 * frame.up).normalized()) {
    geometry::Bounds box;  // of the bodies that may be seen
    const double slope = 1.2 * std::hypot(eye.center_x, eye.center_y) / eye.focal_samples;
    for (const DrawnBody& body : frame.bodies) {
      const double r = shapes[body.shape].radius_m;
      const Vec3 at = eye.to_eye * (body.pose.position_m - eye.position_m);
      if (r <= 0 || at.head<2>().norm() > slope * at.z() + 4 * r || eye.focal_samples * r < kLeastShadow * at.z())
        continue;
      box.add(body.pose.position_m - Vec3::Constant(r));
      box.add(body.pose.position_m + Vec3::Constant(r));
    }
    if (!box.low.allFinite()) return;
    ParallelView view;
    view.center_m = box.center();
    view.to_eye.row(2) = -towards_;
    view.to_eye.row(0) = towards_.unitOrthogonal();
    view.to_eye.row(1) = Vec3(view.to_eye.row(0)).cross(-towards_);
    view.samples_per_m = kShadowSamples / (box.high - box.low).norm();
    raster_.emplace(view, kShadowSamples, kShadowSamples);
    for (const DrawnBody& body : frame.bodies) {
      const DrawnShape& shape = shapes[body.shape];
      if (shape.radius_m > 0 && (box.center() - body.pose.position_m).norm() < (box.high - box.low).norm())
        cast(shape, body.pose);
    }
  }

  [[nodiscard]] double unhindered(const Vec3& normal) const { return std::max(0.0, normal.dot(towards_)); }
  /// How much of the light comes to a point of a surface, 0 to 1.
  [[nodiscard]] double at(const Vec3& point_m, const Vec3& normal) const {
    const double straight = unhindered(normal);
    if (!raster_ || straight == 0) return straight;
    const double sample_m = 1 / raster_->view().samples_per_m;
    return straight * raster_->lit_share(point_m + 1.5 * sample_m * normal, 2 * sample_m);
  }

 private:
  static constexpr int kShadowSamples = 2048;
  static constexpr double kLeastShadow = 3;  // samples: the radius below which a body's shadow is not seen

  void cast(const DrawnShape& shape, const capture::Pose& pose) {
    const double radius_samples = shape.radius_m * raster_->view().samples_per_m;
    if (shape.triangles.empty() || radius_samples < 4) {
      for (const Sphere& ball : shape.balls(radius_samples))
        raster_->draw_ball(pose.position_m + pose.orientation * ball.center_m, ball.radius_m, 0);
      return;
    }
    std::vector<Vec3> corners;
    corners.reserve(shape.vertices_m.size());
    for (const Vec3& vertex_m : shape.vertices_m) corners.emplace_back(pose.position_m + pose.orientation * vertex_m);
    for (const auto& [a, b, c] : shape.triangles) raster_->draw_triangle(corners[a], corners[b], corners[c], 0);
  }

  Vec3 towards_;  // unit
  std::optional<PanelRaster> raster_;
};

/// Colours the samples of a picture. Const use from any thread.
struct FramePainter {
  const DrawnFrame& frame;
  const Eye& eye;
  const Light& light;
  std::span<const DrawnPlane> planes;
  double cell_m = 1;  // of the chequered ground

  [[nodiscard]] Color lit(const Color& color, const Vec3& point_m, const Vec3& normal) const {
    const double sky = 0.5 + 0.5 * normal.dot(frame.up);
    return scaled(color, 0.46 + 0.20 * sky + 0.48 * light.at(point_m, normal));
  }

  [[nodiscard]] static Color color_of(const DrawnBody& body) {
    if (body.given) return kGivenColor;
    return body.level ? level_color(*body.level) : kUntouchedColor;
  }

  [[nodiscard]] Color sky(const Vec3& ray) const {
    const double up = 0.5 + 0.5 * ray.normalized().dot(frame.up);
    return {0.86 + 0.1 * up, 0.89 + 0.08 * up, 0.93 + 0.06 * up};
  }

  [[nodiscard]] Color ground(const DrawnPlane& plane, const Vec3& ray, double t) const {
    const Vec3 hit = eye.position_m + t * ray;
    const Vec3 x = plane.normal.cross(std::abs(plane.normal.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY()).normalized();
    const Vec3 y = plane.normal.cross(x);
    const auto cell = [&](const Vec3& axis) { return static_cast<std::int64_t>(std::floor(axis.dot(hit) / cell_m)); };
    // Cells that are smaller than samples would flicker.
    const double slope = -plane.normal.dot(ray) / ray.norm();
    const double footprint_m = t * ray.norm() / (eye.focal_samples * std::max(slope, 1e-6));
    const double contrast = 0.03 * std::clamp(2 - 4 * footprint_m / cell_m, 0.0, 1.0);
    const double tone = 0.90 + ((cell(x) + cell(y)) % 2 == 0 ? contrast : -contrast);
    const double best = std::max(1e-6, light.unhindered(plane.normal));
    const Color color = scaled({tone, tone, tone}, 0.60 + 0.40 * light.at(hit, plane.normal) / best);
    return mixed(sky(ray), color, std::exp(-t * ray.norm() / (80 * cell_m)));
  }

  [[nodiscard]] Color sample(const BodyRaster& raster, int x, int y) const {
    const Vec3 ray = eye.to_eye.transpose() * eye.ray(x, y);
    double nearest = raster.depth_m(x, y);
    const std::uint32_t body = raster.body(x, y);
    Color color;
    const DrawnPlane* floor = nullptr;
    for (const DrawnPlane& plane : planes) {
      const std::optional<double> t = plane.ground ? distance_along(plane, eye.position_m, ray) : std::nullopt;
      if (!t || *t >= nearest) continue;
      nearest = *t;
      floor = &plane;
    }
    if (floor != nullptr) {
      color = ground(*floor, ray, nearest);
    } else if (body == BodyRaster::kNothing) {
      color = sky(ray);
    } else {
      color = lit(color_of(frame.bodies[body]), eye.position_m + nearest * ray, raster.normal(x, y));
      if (edge(raster, x, y)) color = scaled(color, 0.62);
    }
    for (const DrawnPlane& plane : planes) {
      const std::optional<double> t = plane.ground ? std::nullopt : distance_along(plane, eye.position_m, ray);
      if (t && *t < nearest) color = mixed(color, kWall, kWallShare);
    }
    return color;
  }

  /// Whether a body ends here before another or before what is behind, so that bodies of one colour are told apart.
  static bool edge(const BodyRaster& raster, int x, int y) {
    const std::uint32_t body = raster.body(x, y);
    const double depth_m = raster.depth_m(x, y);
    for (const auto& [across, down] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
      const std::uint32_t other = raster.body(x + across, y + down);
      if (other != BodyRaster::kNothing && other != body && raster.depth_m(x + across, y + down) > depth_m) return true;
    }
    return false;
  }
};

/// A tenth, one, ten ... metres, of the order of a few bodies.
double cell_of(const DrawnFrame& frame, std::span<const DrawnShape> shapes) {
  double sum = 0;
  double count = 0;
  for (const DrawnBody& body : frame.bodies) {
    if (body.given || shapes[body.shape].radius_m <= 0) continue;
    sum += std::log10(shapes[body.shape].radius_m);
    ++count;
  }
  return std::pow(10.0, std::round((count > 0 ? sum / count : 0) + 0.4));
}

}  // namespace

std::array<double, 3> level_color(int level) {
  constexpr Color kColors[] = {
      {0.49, 0.18, 0.60}, {0.25, 0.44, 0.80}, {0.13, 0.66, 0.55}, {0.58, 0.82, 0.30}, {0.99, 0.88, 0.20}};
  if (level >= kPolygonBin) return {0.97, 0.55, 0.20};
  return kColors[std::clamp(level, 0, 4)];
}

FramePictures::FramePictures(std::vector<capture::CapturedShape> shapes, const PictureSettings& settings)
    : captured_(std::move(shapes)), settings_(settings) {
  for (const capture::CapturedShape& shape : captured_) shapes_.emplace_back(shape);
}

View FramePictures::view(const DrawnFrame& frame) const { return view_of(settings_, frame, shapes_); }

Image FramePictures::draw(const DrawnFrame& frame) const {
  // That of a scene may be finer than any picture.
  const double finest = std::max({frame.resolution_px[0], frame.resolution_px[1], double{kMostPicturePx}});
  const auto px = [&](double size) {
    return static_cast<std::uint32_t>(std::clamp(size * (kMostPicturePx / finest), 1.0, double{kMostPicturePx}));
  };
  const std::array<std::uint32_t, 2> size_px =
      settings_.size_px.value_or(std::array{px(frame.resolution_px[0]), px(frame.resolution_px[1])});
  const int width = static_cast<int>(size_px[0]) * kSamplesAcross;
  const int height = static_cast<int>(size_px[1]) * kSamplesAcross;
  const Eye eye(view(frame), width, height);
  const Light light(eye, frame, shapes_);
  const std::vector<DrawnPlane> planes = drawn_planes(frame, captured_);
  const FramePainter painter{frame, eye, light, planes, cell_of(frame, shapes_)};

  Image image{size_px[0], size_px[1], std::vector<std::uint8_t>(std::size_t{3} * size_px[0] * size_px[1])};
  const auto band = [&](std::size_t which) {
    const int top = static_cast<int>(which) * kBandRows;
    const int below = std::min(top + kBandRows, static_cast<int>(size_px[1]));
    // One more row of samples on either side tells where bodies end.
    BodyRaster raster(eye, width, std::max(0, top * kSamplesAcross - 1), std::min(height, below * kSamplesAcross + 1));
    for (std::uint32_t i = 0; i < frame.bodies.size(); ++i) {
      const DrawnShape& shape = shapes_[frame.bodies[i].shape];
      if (shape.radius_m > 0) raster.draw(shape, frame.bodies[i].pose, i);
    }
    for (int row = top; row < below; ++row) {
      for (int column = 0; column < static_cast<int>(size_px[0]); ++column) {
        Color sum{};
        for (int sub = 0; sub < kSamplesAcross * kSamplesAcross; ++sub) {
          const Color color = painter.sample(raster, column * kSamplesAcross + sub % kSamplesAcross,
                                             row * kSamplesAcross + sub / kSamplesAcross);
          for (std::size_t k = 0; k < 3; ++k) sum[k] += color[k] / (kSamplesAcross * kSamplesAcross);
        }
        const std::size_t at = 3 * (static_cast<std::size_t>(row) * image.width_px + static_cast<std::size_t>(column));
        for (std::size_t k = 0; k < 3; ++k)
          image.rgb[at + k] = static_cast<std::uint8_t>(std::clamp(255.0 * sum[k] + 0.5, 0.0, 255.0));
      }
    }
  };
  const auto executor = parallel::make_executor(ExecutorKind::Threads, settings_.threads);
  const std::size_t bands = (size_px[1] + kBandRows - 1) / kBandRows;
  parallel::parallel_for(*executor, bands, 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t which = begin; which < end; ++which) band(which);
  });
  if (settings_.plain) return image;
  draw_gaze_ring(frame, shapes_, planes, eye, kSamplesAcross, image);
  draw_legend(frame, shapes_, image);
  return image;
}

}  // namespace poise::io
