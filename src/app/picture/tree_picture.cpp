// SPDX-License-Identifier: MIT
#include "app/picture/tree_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/picture/chart_theme.h"
#include "app/picture/panel_raster.h"
#include "app/picture/pixel_text.h"
#include "geometry/bvh/triangle_bvh.h"
#include "geometry/primitives/bounds.h"
#include "parallel/executor.h"

namespace poise::io {
namespace {

using Color = std::array<double, 3>;

constexpr int kTreeSamplesAcross = 3;  // per pixel, each way
constexpr Color kMesh = {0.83, 0.84, 0.86};
constexpr std::uint32_t kMostColumns = 5;
constexpr std::uint32_t kPanelGap = 10;
constexpr double kLeast = 0.001;  // shares of the diagonal at the two ends of the colours
constexpr double kMost = 0.1;

/// Ground and letters.
struct Paper {
  explicit Paper(bool dark) {
    const auto themed = [dark](const app::ChartColor& color) {
      return dark ? app::dark_color(color, app::DarkPart::Frame) : color;
    };
    ink = themed(app::kChartInk);
    std::ranges::transform(themed(app::kChartGround), ground.begin(), [](std::uint8_t part) { return part / 255.0; });
  }
  Color ground{};
  app::ChartColor ink{};
};

struct SphereImage {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
};

struct Panel {
  const SphereTree* tree = nullptr;  // null: the mesh itself
  Level level = 0;
  std::string title;
};

std::vector<SphereImage> balls_of(const Panel& panel) {
  std::vector<SphereImage> balls;
  for (const NodeIndex node : panel.tree->nodes_at(panel.level)) {
    const Sphere sphere = panel.tree->sphere(node);
    balls.push_back({sphere.center_m, sphere.radius_m});
  }
  return balls;
}

std::vector<Panel> panels_of(std::span<const DrawnTree> trees) {
  std::vector<Panel> panels;
  for (const DrawnTree& drawn : trees) {
    panels.push_back({nullptr, 0, drawn.name.empty() ? "mesh" : drawn.name});
    for (Level level = 0; level <= drawn.tree->depth(); ++level) {
      const std::size_t balls = drawn.tree->nodes_at(level).size();
      panels.push_back({drawn.tree, level, fmt::format("level {}: {} ball{}", level, balls, balls == 1 ? "" : "s")});
    }
  }
  return panels;
}

/// The view and the size of a panel, so that nothing that is drawn in any of them is cut off.
struct Frame {
  ParallelView view;  // samples_per_m is per sample, not per pixel
  std::uint32_t width_px = 0, height_px = 0;
};

Frame frame_of(const TriangleMesh& mesh, std::span<const DrawnTree> trees, const Mat3& to_eye, std::uint32_t width_px) {
  Frame frame;
  frame.view.to_eye = to_eye;
  geometry::Bounds box;
  const auto add = [&](const Vec3& center_m, double radius_m) {
    const Vec3 eye = frame.view.to_eye * center_m;
    box.add(eye - Vec3::Constant(radius_m));
    box.add(eye + Vec3::Constant(radius_m));
  };
  for (const Vec3& vertex_m : mesh.vertices_m) add(vertex_m, 0);
  for (const DrawnTree& drawn : trees) {
    for (NodeIndex node = 0; node < drawn.tree->node_count(); ++node) {
      const Sphere sphere = drawn.tree->sphere(node);
      add(sphere.center_m, sphere.radius_m);
    }
  }
  const Vec3 extent_m = (box.high - box.low).cwiseMax(1e-12);
  // Very tall things get narrower panels' worth of room instead of a very tall picture.
  const double across_m = std::max(extent_m.x(), extent_m.y() / 1.6);
  frame.width_px = width_px;
  frame.height_px = static_cast<std::uint32_t>(std::ceil(width_px * extent_m.y() / across_m)) + 1;
  frame.view.samples_per_m = kTreeSamplesAcross * width_px / across_m;
  frame.view.center_m = frame.view.to_eye.transpose() * (0.5 * (box.low + box.high));
  return frame;
}

double lit(const Vec3& normal_eye) {
  // A strong light from the upper left before the object, a weak one from the right, and some from everywhere.
  static const Vec3 kKey = Vec3(-0.5, 0.7, -0.55).normalized();
  static const Vec3 kFill = Vec3(0.8, 0.1, -0.5).normalized();
  return 0.62 + 0.38 * std::max(0.0, normal_eye.dot(kKey)) + 0.12 * std::max(0.0, normal_eye.dot(kFill));
}

/// Colours the samples of one panel. Const use from any thread.
struct Painter {
  const TriangleMesh& mesh;
  const geometry::TriangleBvh& bvh;
  double diagonal_m = 1;
  Color ground{};

  [[nodiscard]] Color mesh_color(const PanelRaster& raster, std::uint32_t item) const {
    const auto& t = mesh.triangles[item];
    const Vec3& a = mesh.vertices_m[t[0]];
    Vec3 normal = raster.view().to_eye * (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).normalized();
    if (normal.z() > 0) normal = -normal;
    const double light = lit(normal);
    return {kMesh[0] * light, kMesh[1] * light, kMesh[2] * light};
  }

  /// A thin dark line where one ball ends before another, so that they can be told apart.
  static bool outline(const PanelRaster& raster, int x, int y) {
    const std::uint32_t item = raster.item(x, y);
    return raster.item(x + 1, y) != item || raster.item(x, y + 1) != item;
  }

  /// The mean over the samples of a pixel. The distance is asked for once for each ball in it.
  [[nodiscard]] Color pixel(const PanelRaster& raster, const std::vector<SphereImage>& balls, int column,
                            int row) const {
    Color sum{};
    std::uint32_t known_item = PanelRaster::kNothing;
    Color known{};
    for (int sub = 0; sub < kTreeSamplesAcross * kTreeSamplesAcross; ++sub) {
      const int x = column * kTreeSamplesAcross + sub % kTreeSamplesAcross;
      const int y = row * kTreeSamplesAcross + sub / kTreeSamplesAcross;
      const std::uint32_t item = raster.item(x, y);
      Color color = ground;
      if (item != PanelRaster::kNothing && balls.empty()) {
        color = mesh_color(raster, item);
      } else if (item != PanelRaster::kNothing) {
        const Vec3 point_m = raster.point_m(x, y);
        if (item != known_item) known = protrusion_color(bvh.outside_distance_m(point_m) / diagonal_m);
        known_item = item;
        double light = lit(raster.view().to_eye * ((point_m - balls[item].center_m) / balls[item].radius_m));
        if (outline(raster, x, y)) light *= 0.6;
        color = {known[0] * light, known[1] * light, known[2] * light};
      }
      for (std::size_t k = 0; k < 3; ++k) sum[k] += color[k] / (kTreeSamplesAcross * kTreeSamplesAcross);
    }
    return sum;
  }
};

void put(Image& image, std::uint32_t x, std::uint32_t y, const Color& color) {
  const std::size_t at = 3 * (std::size_t{y} * image.width_px + x);
  for (std::size_t k = 0; k < 3; ++k)
    image.rgb[at + k] = static_cast<std::uint8_t>(std::clamp(255 * color[k] + 0.5, 0.0, 255.0));
}

void draw_panel(const Panel& panel, const Frame& frame, const Painter& painter, std::uint32_t left, std::uint32_t top,
                parallel::Executor& executor, Image& image) {
  PanelRaster raster(frame.view, static_cast<int>(frame.width_px) * kTreeSamplesAcross,
                     static_cast<int>(frame.height_px) * kTreeSamplesAcross);
  std::vector<SphereImage> balls;
  if (panel.tree == nullptr) {
    raster.draw_mesh(painter.mesh);
  } else {
    balls = balls_of(panel);
    for (std::uint32_t i = 0; i < balls.size(); ++i) raster.draw_ball(balls[i].center_m, balls[i].radius_m, i);
  }
  parallel::parallel_for(executor, frame.height_px, 4, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t row = begin; row < end; ++row) {
      for (std::uint32_t column = 0; column < frame.width_px; ++column) {
        put(image, left + column, top + static_cast<std::uint32_t>(row),
            painter.pixel(raster, balls, static_cast<int>(column), static_cast<int>(row)));
      }
    }
  });
}

/// The scale of the colours, in the lower left corner.
void draw_legend(Image& image, std::uint32_t top, std::uint32_t scale, const app::ChartColor& ink) {
  const std::string text = "stands out of the mesh by, % of its diagonal:";
  const std::uint32_t left = 2 * kPanelGap;
  draw_text(image, text, left, top, scale, ink);
  const std::uint32_t bar_left = left + text_width_px(text, scale) + 40 * scale / 2;
  const std::uint32_t bar_width =
      std::min(150 * scale, image.width_px > bar_left + 60 ? image.width_px - bar_left - 60 : 0);
  for (std::uint32_t x = 0; x < bar_width; ++x) {
    const Color color = protrusion_color(kLeast * std::pow(kMost / kLeast, (x + 0.5) / bar_width));
    for (std::uint32_t y = 0; y < kTextHeight * scale; ++y) put(image, bar_left + x, top + y, color);
  }
  for (const double percent : {0.1, 0.3, 1.0, 3.0, 10.0}) {
    const double share = std::log(percent / 100 / kLeast) / std::log(kMost / kLeast);
    const std::string tick = fmt::format("{}", percent);
    const auto middle = static_cast<std::int64_t>(bar_left + share * bar_width);
    draw_text(image, tick, middle - text_width_px(tick, scale) / 2, top + (kTextHeight + 3) * scale, scale, ink);
  }
}

}  // namespace

std::array<double, 3> protrusion_color(double share_of_diagonal) {
  constexpr Color kColors[] = {
      {0.36, 0.56, 0.72}, {0.50, 0.74, 0.68}, {0.95, 0.86, 0.52}, {0.93, 0.57, 0.30}, {0.74, 0.20, 0.18}};
  const double along = 4 * std::log(std::max(share_of_diagonal, 1e-30) / kLeast) / std::log(kMost / kLeast);
  const double place = std::clamp(along, 0.0, 4.0);
  const auto first = std::min(static_cast<std::size_t>(place), std::size_t{3});
  const double t = place - static_cast<double>(first);
  Color color{};
  for (std::size_t k = 0; k < 3; ++k) color[k] = (1 - t) * kColors[first][k] + t * kColors[first + 1][k];
  return color;
}

Result<Image> draw_trees(const TriangleMesh& mesh, std::span<const DrawnTree> trees,
                         const TreePictureSettings& settings) {
  if (mesh.triangles.empty()) return bad_input("picture: the mesh has no triangle, at least one is needed");
  if (trees.empty()) return bad_input("picture: there is no tree, at least one is needed");
  for (const DrawnTree& drawn : trees) {
    if (drawn.tree == nullptr || drawn.tree->node_count() == 0)
      return bad_input("picture: a tree has no node, at least one is needed");
  }
  if (settings.width_px < 200 || settings.width_px > 10000) {
    return bad_input(fmt::format("picture: width = {}, must be from 200 to 10000 pixels", settings.width_px));
  }
  const Vec3 front = settings.front.value_or(usual_front(settings.up));
  if (std::abs(settings.up.norm() - 1) > 1e-6 || std::abs(front.norm() - 1) > 1e-6 ||
      std::abs(front.dot(settings.up)) > 1e-6) {
    return bad_input("picture: up and front must be unit vectors square to each other");
  }
  const std::vector<Panel> panels = panels_of(trees);
  std::uint32_t most = 0;  // panels of one tree
  for (const DrawnTree& drawn : trees) most = std::max(most, drawn.tree->depth() + std::uint32_t{2});
  const std::uint32_t columns = most <= kMostColumns ? most : (most + 1) / 2;
  const std::uint32_t text = std::max(1U, settings.width_px / 800);
  const std::uint32_t title_px = (kTextHeight + 6) * text;
  const Frame frame =
      frame_of(mesh, trees, three_quarter_view(settings.up, front), settings.width_px / columns - kPanelGap);

  // Each tree begins a row of its own.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> points;  // column and row of each panel
  std::uint32_t row = 0;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const bool new_tree = i > 0 && panels[i].tree == nullptr;
    const bool full = i > 0 && points.back().first + 1 == columns;
    if (new_tree || full) ++row;
    points.emplace_back(new_tree || full || i == 0 ? 0 : points.back().first + 1, row);
  }
  const std::uint32_t row_px = frame.height_px + title_px + kPanelGap;
  const std::uint32_t legend_top = (row + 1) * row_px + kPanelGap;
  Image image{settings.width_px, legend_top + 24 * text, {}};
  image.rgb.resize(std::size_t{3} * image.width_px * image.height_px);
  const Paper paper(settings.dark);
  for (std::uint32_t i = 0; i < image.width_px * image.height_px; ++i)
    put(image, i % image.width_px, i / image.width_px, paper.ground);

  const geometry::TriangleBvh bvh(mesh, settings.solidity);
  const auto executor = parallel::make_executor(ExecutorKind::Threads, settings.threads);
  const Painter painter{mesh, bvh, std::max(mesh.diagonal_m(), 1e-30), paper.ground};
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const std::uint32_t left = points[i].first * (frame.width_px + kPanelGap) + kPanelGap / 2;
    const std::uint32_t top = points[i].second * row_px + kPanelGap;
    draw_panel(panels[i], frame, painter, left, top, *executor, image);
    const std::uint32_t width = text_width_px(panels[i].title, text);
    draw_text(image, panels[i].title, std::int64_t{left} + (std::int64_t{frame.width_px} - width) / 2,
              top + frame.height_px + text, text, paper.ink);
  }
  draw_legend(image, legend_top, text, paper.ink);
  return image;
}

}  // namespace poise::io
