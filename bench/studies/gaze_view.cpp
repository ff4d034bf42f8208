// SPDX-License-Identifier: MIT
#include "studies/gaze_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace poise::app {
namespace {

constexpr double kDown = 40 * kGazeDegreeRad;
constexpr double kAngleOfView = 30 * kGazeDegreeRad;
// Of the positions at each end of an axis: bodies that have left the heap must not make it small. Chosen.
constexpr double kOutliers = 0.05;
constexpr double kLeastBoxM = 1e-3;
// Of the width of the box.
constexpr std::array<double, kGazePoints> kGazeAcross{0.15, 0.5, 0.85};

struct Box {
  Vec3 low, high;
};

Box box_of(std::span<const Vec3> positions_m) {
  Box box{Vec3::Zero(), Vec3::Zero()};
  std::vector<double> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const Vec3& position_m : positions_m) values.push_back(position_m[axis]);
    std::ranges::sort(values);
    const auto last = static_cast<double>(values.size() - 1);
    box.low[axis] = values[static_cast<std::size_t>(kOutliers * last)];
    box.high[axis] = values[static_cast<std::size_t>(std::lround((1 - kOutliers) * last))];
  }
  return box;
}

Vec3 right_of(const View& view) { return view.forward.cross(view.up).normalized(); }

// Looks at the corners of the box from a distance to its centre, so that they stand as far from the upper edge of the
// picture as from the lower one. `fits`: whether all are in the picture.
View view_from(const Box& box, double distance_m, bool& fits) {
  View view;
  view.present = true;
  view.vertical_fov_rad = kAngleOfView;
  const Vec3 middle = 0.5 * (box.low + box.high);
  view.position_m = middle + distance_m * Vec3(0, -std::cos(kDown), std::sin(kDown));
  std::array<Vec3, 8> corners;
  double lowest = std::numbers::pi;
  double highest = -std::numbers::pi;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = {(i & 1U) != 0 ? box.high.x() : box.low.x(), (i & 2U) != 0 ? box.high.y() : box.low.y(),
                  (i & 4U) != 0 ? box.high.z() : box.low.z()};
    const Vec3 ray = corners[i] - view.position_m;
    const double elevation = std::atan2(ray.z(), ray.y());
    lowest = std::min(lowest, elevation);
    highest = std::max(highest, elevation);
  }
  const double elevation = 0.5 * (lowest + highest);
  view.forward = Vec3(0, std::cos(elevation), std::sin(elevation));
  view.up = Vec3(0, -std::sin(elevation), std::cos(elevation));
  view.gaze = view.forward;
  fits = std::ranges::all_of(corners, [&](const Vec3& corner) { return on_screen(view, corner).inside; });
  return view;
}

}  // namespace

GazeCamera overlooking(std::span<const Vec3> positions_m) {
  const Box box = box_of(positions_m);
  const double size_m = std::max(kLeastBoxM, (box.high - box.low).norm());
  bool fits = false;
  // From 16 times its size the box is 4 degrees large.
  double near_m = 0;
  double far_m = 16 * size_m;
  constexpr int kHalvings = 40;
  for (int i = 0; i < kHalvings; ++i) {
    const double distance_m = 0.5 * (near_m + far_m);
    view_from(box, distance_m, fits);
    (fits ? far_m : near_m) = distance_m;
  }
  GazeCamera camera;
  camera.view = view_from(box, far_m, fits);
  for (std::size_t point = 0; point < kGazePoints; ++point) {
    Vec3 point_m = 0.5 * (box.low + box.high);
    point_m.x() = std::lerp(box.low.x(), box.high.x(), kGazeAcross[point]);
    camera.gazes[point] = (point_m - camera.view.position_m).normalized();
  }
  camera.view.gaze = camera.gazes[1];
  return camera;
}

ScreenPlace on_screen(const View& view, const Vec3& point_m) {
  const Vec3 ray = point_m - view.position_m;
  const double depth = ray.dot(view.forward);
  if (!(depth > 0)) return {};
  const Vec3 right = right_of(view);
  const double tangent_up = std::tan(0.5 * view.vertical_fov_rad);
  ScreenPlace place;
  place.across = 0.5 + 0.5 * ray.dot(right) / (depth * tangent_up * view.aspect);
  place.down = 0.5 - 0.5 * ray.dot(right.cross(view.forward)) / (depth * tangent_up);
  place.inside = place.across >= 0 && place.across < 1 && place.down >= 0 && place.down < 1;
  return place;
}

View gazing_at(const GazeCamera& camera, std::size_t gaze_point) {
  View view = camera.view;
  view.gaze = camera.gazes[gaze_point];
  return view;
}

double eccentricity_rad(const View& view, const Vec3& point_m) {
  const Vec3 ray = point_m - view.position_m;
  const double distance_m = ray.norm();
  if (!(distance_m > 0)) return 0;
  return std::acos(std::clamp(ray.dot(view.gaze) / distance_m, -1.0, 1.0));
}

}  // namespace poise::app
