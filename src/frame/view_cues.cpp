// SPDX-License-Identifier: MIT
#include "frame/view_cues.h"

#include <algorithm>
#include <cmath>

#include "math/functions.h"

namespace poise::simulation {
ViewQuery::ViewQuery(const View& from) : view(from) {
  if (!from.present) return;
  right = from.forward.cross(from.up).normalized();
  up = right.cross(from.forward);
  tangent_up = math::tan(0.5 * from.vertical_fov_rad);
  tangent_right = tangent_up * from.aspect;
  per_up = 1.0 / std::sqrt(1.0 + tangent_up * tangent_up);
  per_right = 1.0 / std::sqrt(1.0 + tangent_right * tangent_right);
}

bool in_frustum(const ViewQuery& view_query, const Vec3& center_m, double radius_m) {
  const Vec3 to_center = center_m - view_query.view.position_m;
  const double depth = to_center.dot(view_query.view.forward);
  if (depth < -radius_m) return false;
  // Distance beyond each pair of side planes, along their normals.
  const double beyond_up = (std::abs(to_center.dot(view_query.up)) - depth * view_query.tangent_up) * view_query.per_up;
  const double beyond_right =
      (std::abs(to_center.dot(view_query.right)) - depth * view_query.tangent_right) * view_query.per_right;
  return beyond_up < radius_m && beyond_right < radius_m;
}

scheduler::PairCues cues_of(const ViewQuery& view_query, const PairView& pair, const scheduler::Policy& policy) {
  scheduler::PairCues cues;
  cues.angle_radpm = policy.plain_angle_radpm;
  cues.closing_mps = std::max(0.0, pair.closing_mps);
  cues.importance = static_cast<float>(pair.importance);
  cues.frames_waited = pair.frames_waited;
  cues.delay_s = static_cast<float>(pair.delay_s);
  cues.age_s = static_cast<float>(pair.age_s);
  cues.separation = static_cast<float>(pair.separation);
  cues.crowd = pair.crowd;
  cues.hidden = pair.hidden;
  cues.attended = pair.attended;
  cues.gap_rad = static_cast<float>(pair.gap_m * cues.angle_radpm);
  const View& view = view_query.view;
  if (!view.present) return cues;
  const Vec3 ray = pair.point_m - view.position_m;
  const double distance = std::max(ray.norm(), kNearestSeenM);
  const Vec3 direction = ray / distance;
  cues.visibility = in_frustum(view_query, pair.point_m, pair.extent_m) ? 1.0 : policy.outside_frustum;
  const double along = std::min(1.0, std::abs(direction.dot(pair.normal)));
  cues.angle_radpm = std::max(kLeastAcross, std::sqrt(1.0 - along * along)) / distance;
  cues.gap_rad = static_cast<float>(pair.gap_m * cues.angle_radpm);
  // The arc cosine takes as long as the rest.
  if (policy.eccentricity != 0 || policy.seen_threshold_rad > 0)
    cues.eccentricity_rad = math::acos(std::clamp(direction.dot(view.gaze), -1.0, 1.0));
  return cues;
}

}  // namespace poise::simulation
