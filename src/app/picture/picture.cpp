// SPDX-License-Identifier: MIT
#include "app/picture/picture.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace poise::io {
namespace {

using Color = std::array<double, 3>;

constexpr int kSamplesAcross = 2;  // per pixel, each way
constexpr std::size_t kMostSpheres = 128;
constexpr Color kUntouched = {0.62, 0.64, 0.67};

struct Ball {
  Vec3 center_m = Vec3::Zero();  // in the eye's frame: right, up, forward
  double radius_m = 0;
  Color color{};
};

struct Eye {
  Vec3 position_m = Vec3::Zero();
  Mat3 to_eye = Mat3::Identity();  // rows: right, up, forward
  double focal_samples = 1;        // distance of the image plane, in samples
  double center_x = 0, center_y = 0;
};

// A point of the image while it is drawn.
struct Sample {
  double depth_m = std::numeric_limits<double>::infinity();
  Color color{};
};

std::vector<int> touched_levels(const SceneRun& run) {
  std::vector<int> levels;
  for (const RunBody& body : run.bodies()) {
    if (levels.size() <= body.id.slot) levels.resize(body.id.slot + 1, -1);
  }
  for (const Contact& contact : run.world().contacts()) {
    for (const BodyId id : {contact.a, contact.b}) {
      if (id.slot < levels.size()) levels[id.slot] = std::max(levels[id.slot], int{contact.level});
    }
  }
  return levels;
}

std::vector<NodeIndex> drawn_nodes(const SphereTree& tree) {
  std::vector<NodeIndex> nodes = tree.nodes_at(tree.depth());
  for (Level level = tree.depth(); nodes.size() > kMostSpheres && level > 0; --level) {
    nodes = tree.nodes_at(static_cast<Level>(level - 1));
  }
  return nodes;
}

// The scene's camera, or one that looks at the middle of all moving bodies from far enough.
View view_of(const SceneRun& run, double aspect) {
  View view = run.view();
  if (view.present) return view;
  Vec3 least = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 most = -least;
  for (const RunBody& body : run.bodies()) {
    if (body.motion == MotionType::Static) continue;
    const Vec3 x = run.world().state(body.id).value().position_m;
    const Vec3 r = Vec3::Constant(run.shapes()[body.shape]->bounding_radius_m);
    least = least.cwiseMin(x - r);
    most = most.cwiseMax(x + r);
  }
  if (!least.allFinite()) least = most = Vec3::Zero();
  const double radius = 0.5 * (most - least).norm() + 0.1;
  view.aspect = aspect;
  view.forward = Vec3(-1, 1.2, -0.55).normalized();
  view.position_m = 0.5 * (least + most) - view.forward * (1.1 * radius / std::sin(0.5 * view.vertical_fov_rad));
  view.up = Vec3::UnitZ();
  return view;
}

Eye eye_of(const View& view, int width, int height) {
  Eye eye;
  eye.position_m = view.position_m;
  const Vec3 right = view.forward.cross(view.up).normalized();
  eye.to_eye.row(0) = right;
  eye.to_eye.row(1) = right.cross(view.forward);
  eye.to_eye.row(2) = view.forward;
  eye.focal_samples = 0.5 * height / std::tan(0.5 * view.vertical_fov_rad);
  eye.center_x = 0.5 * width;
  eye.center_y = 0.5 * height;
  return eye;
}

std::vector<Ball> balls_of(const SceneRun& run, const Eye& eye) {
  std::vector<std::vector<NodeIndex>> nodes;
  for (const ShapePtr& shape : run.shapes()) {
    nodes.push_back(shape->kind == ShapeKind::Tree ? drawn_nodes(shape->tree) : std::vector<NodeIndex>{});
  }
  const std::vector<int> levels = touched_levels(run);
  std::vector<Ball> balls;
  for (const RunBody& body : run.bodies()) {
    const BodyState state = run.world().state(body.id).value();
    const SphereTree& tree = run.shapes()[body.shape]->tree;
    const int level = levels[body.id.slot];
    const Color color = level < 0 ? kUntouched : level_color(level);
    for (const NodeIndex node : nodes[body.shape]) {
      const Sphere sphere = tree.sphere(node);
      const Vec3 center = state.position_m + state.orientation * sphere.center_m;
      balls.push_back({eye.to_eye * (center - eye.position_m), sphere.radius_m, color});
    }
  }
  return balls;
}

Color shaded(const Color& color, const Vec3& normal_eye) {
  // From the upper left, behind the viewer.
  static const Vec3 kLight = Vec3(-0.45, 0.75, -0.5).normalized();
  const double lit = 0.38 + 0.62 * std::max(0.0, normal_eye.dot(kLight));
  const double rim = 0.75 + 0.25 * std::abs(normal_eye.z());
  return {color[0] * lit * rim, color[1] * lit * rim, color[2] * lit * rim};
}

void draw_ball(const Ball& ball, const Eye& eye, int width, int height, std::vector<Sample>& samples) {
  if (ball.center_m.z() - ball.radius_m <= 1e-6) return;
  // The outline of a ball is an ellipse that reaches at most this far from its centre.
  const double reach = eye.focal_samples * ball.radius_m / (ball.center_m.z() - ball.radius_m) + 1;
  const double x = eye.center_x + eye.focal_samples * ball.center_m.x() / ball.center_m.z();
  const double y = eye.center_y - eye.focal_samples * ball.center_m.y() / ball.center_m.z();
  const auto clipped = [](double value, int most) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(most)));
  };
  const double c = ball.center_m.squaredNorm() - ball.radius_m * ball.radius_m;
  for (int row = clipped(y - 2 * reach, height); row < clipped(y + 2 * reach + 1, height); ++row) {
    for (int column = clipped(x - 2 * reach, width); column < clipped(x + 2 * reach + 1, width); ++column) {
      const Vec3 ray((column + 0.5 - eye.center_x) / eye.focal_samples, (eye.center_y - row - 0.5) / eye.focal_samples,
                     1);
      const double a = ray.squaredNorm();
      const double b = ray.dot(ball.center_m);
      const double discriminant = b * b - a * c;
      if (discriminant < 0) continue;
      const double depth = (b - std::sqrt(discriminant)) / a;
      Sample& sample =
          samples[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
      if (depth >= sample.depth_m) continue;
      sample.depth_m = depth;
      sample.color = shaded(ball.color, (depth * ray - ball.center_m) / ball.radius_m);
    }
  }
}

// Ground and sky where no ball is. The ground fades into the sky with distance.
Color background(const Vec3& ray_world, const Eye& eye, const std::vector<std::pair<Vec3, double>>& grounds) {
  const double up = 0.5 + 0.5 * ray_world.normalized().z();
  const Color sky = {0.86 + 0.1 * up, 0.89 + 0.08 * up, 0.93 + 0.06 * up};
  for (const auto& [normal, offset_m] : grounds) {
    const double slope = normal.dot(ray_world);
    const double t = (offset_m - normal.dot(eye.position_m)) / slope;
    if (slope >= 0 || !(t > 0)) continue;
    const Vec3 hit = eye.position_m + t * ray_world;
    const auto cell = static_cast<std::int64_t>(std::floor(hit.x())) + static_cast<std::int64_t>(std::floor(hit.y()));
    const double tone = cell % 2 == 0 ? 0.80 : 0.74;
    const double fade = std::exp(-t / 60.0);
    return {sky[0] + fade * (tone - sky[0]), sky[1] + fade * (tone - sky[1]), sky[2] + fade * (tone - sky[2])};
  }
  return sky;
}

std::vector<std::pair<Vec3, double>> ground_planes(const SceneRun& run) {
  std::vector<std::pair<Vec3, double>> grounds;
  for (const RunBody& body : run.bodies()) {
    const Shape& shape = *run.shapes()[body.shape];
    if (shape.kind != ShapeKind::Plane) continue;
    const BodyState state = run.world().state(body.id).value();
    const Vec3 normal = state.orientation * shape.plane_normal;
    if (normal.z() > 0.5) grounds.emplace_back(normal, shape.plane_offset_m + normal.dot(state.position_m));
  }
  return grounds;
}

std::uint8_t to_byte(double linear) { return static_cast<std::uint8_t>(std::clamp(255.0 * linear + 0.5, 0.0, 255.0)); }

}  // namespace

std::array<double, 3> level_color(int level) {
  // Five colours along viridis (van der Walt and Smith 2015).
  constexpr Color kColors[] = {
      {0.35, 0.10, 0.45}, {0.23, 0.32, 0.55}, {0.13, 0.57, 0.55}, {0.37, 0.79, 0.38}, {0.99, 0.91, 0.14}};
  return kColors[std::clamp(level, 0, 4)];
}

Image draw_run(const SceneRun& run, std::uint32_t width_px, std::uint32_t height_px) {
  const int width = static_cast<int>(width_px) * kSamplesAcross;
  const int height = static_cast<int>(height_px) * kSamplesAcross;
  const Eye eye = eye_of(view_of(run, static_cast<double>(width_px) / static_cast<double>(height_px)), width, height);
  std::vector<Sample> samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (const Ball& ball : balls_of(run, eye)) draw_ball(ball, eye, width, height, samples);

  const auto grounds = ground_planes(run);
  Image image{width_px, height_px, std::vector<std::uint8_t>(std::size_t{3} * width_px * height_px)};
  for (std::uint32_t row = 0; row < height_px; ++row) {
    for (std::uint32_t column = 0; column < width_px; ++column) {
      Color sum{};
      for (int sub = 0; sub < kSamplesAcross * kSamplesAcross; ++sub) {
        const int x = static_cast<int>(column) * kSamplesAcross + sub % kSamplesAcross;
        const int y = static_cast<int>(row) * kSamplesAcross + sub / kSamplesAcross;
        const Sample& sample =
            samples[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
        const Vec3 ray((x + 0.5 - eye.center_x) / eye.focal_samples, (eye.center_y - y - 0.5) / eye.focal_samples, 1);
        const Color color =
            std::isfinite(sample.depth_m) ? sample.color : background(eye.to_eye.transpose() * ray, eye, grounds);
        for (std::size_t k = 0; k < 3; ++k) sum[k] += color[k] / (kSamplesAcross * kSamplesAcross);
      }
      for (std::size_t k = 0; k < 3; ++k) {
        image.rgb[3 * (std::size_t{row} * width_px + column) + k] = to_byte(sum[k]);
      }
    }
  }
  return image;
}

Result<std::string> png_bytes(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = image.width_px;
  header.height = image.height_px;
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  std::string bytes;
  bool made = png_image_write_to_memory(&header, nullptr, &size, 0, image.rgb.data(), 0, nullptr) != 0;
  if (made) {
    bytes.resize(size);
    made = png_image_write_to_memory(&header, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr) != 0;
  }
  if (!made) return Error{ErrorKind::OutputFailed, fmt::format("PNG: {}", header.message)};
  bytes.resize(size);
  return bytes;
}

}  // namespace poise::io
