// SPDX-License-Identifier: MIT
#include "simulation/cues.h"

#include <algorithm>
#include <cmath>

namespace poise::simulation {
namespace {

// Nearer than this nothing gets larger: a contact at the eye must not outweigh the world.
constexpr double kNearestM = 0.05;
constexpr double kLeastAcross = 0.1;

}  // namespace

bool in_frustum(const View& view, const Vec3& center_m, double radius_m) {
  const Vec3 to_center = center_m - view.position_m;
  const Vec3 right = view.forward.cross(view.up).normalized();
  const Vec3 up = right.cross(view.forward);
  const double depth = to_center.dot(view.forward);
  if (depth < -radius_m) return false;
  const double tangent_up = std::tan(0.5 * view.vertical_fov_rad);
  const double tangent_right = tangent_up * view.aspect;
  // Distance beyond each pair of side planes, along their normals.
  const double beyond_up = (std::abs(to_center.dot(up)) - depth * tangent_up) / std::hypot(1.0, tangent_up);
  const double beyond_right = (std::abs(to_center.dot(right)) - depth * tangent_right) / std::hypot(1.0, tangent_right);
  return beyond_up < radius_m && beyond_right < radius_m;
}

scheduler::PairCues cues_of(const View& view, const PairSighting& pair) {
  scheduler::PairCues cues;
  cues.closing_mps = std::max(0.0, pair.closing_mps);
  cues.importance = pair.importance;
  cues.frames_waited = pair.frames_waited;
  if (!view.present) return cues;
  const Vec3 ray = pair.point_m - view.position_m;
  const double distance = std::max(ray.norm(), kNearestM);
  const Vec3 direction = ray / distance;
  cues.visibility = in_frustum(view, pair.point_m, pair.extent_m) ? 1.0 : scheduler::kOutsideFrustum;
  const double along = std::min(1.0, std::abs(direction.dot(pair.normal)));
  cues.angle_radpm = std::max(kLeastAcross, std::sqrt(1.0 - along * along)) / distance;
  cues.eccentricity_rad = std::acos(std::clamp(direction.dot(view.gaze), -1.0, 1.0));
  return cues;
}

}  // namespace poise::simulation
