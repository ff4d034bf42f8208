// SPDX-License-Identifier: MIT
#include "frame/host_cues.h"

#include <algorithm>
#include <cmath>

namespace poise::simulation {

scheduler::PairView host_view_of(const ViewQuery& view_query, const PairView& pair, std::uint64_t pair_id,
                                 const scheduler::UserData& user_data) {
  scheduler::PairView seen;
  seen.pair_id = pair_id;
  seen.user_data = user_data;
  seen.point_m = {pair.point_m.x(), pair.point_m.y(), pair.point_m.z()};
  seen.normal = {pair.normal.x(), pair.normal.y(), pair.normal.z()};
  seen.extent_m = pair.extent_m;
  // The same numbers as the built-in cues go by.
  const scheduler::PairCues cues = cues_of(view_query, pair);
  seen.gap_rad = static_cast<double>(cues.gap_rad);
  seen.delay_s = static_cast<double>(cues.delay_s);
  seen.age_s = static_cast<double>(cues.age_s);
  seen.crowd = static_cast<double>(cues.crowd);
  seen.hidden = cues.hidden;
  seen.attended = cues.attended;
  seen.closing_mps = cues.closing_mps;
  seen.importance = static_cast<double>(cues.importance);
  seen.frames_waited = cues.frames_waited;
  seen.has_view = view_query.view.present;
  if (!seen.has_view) return seen;
  seen.in_frustum = in_frustum(view_query, pair.point_m, pair.extent_m);
  seen.distance_m = (pair.point_m - view_query.view.position_m).norm();
  seen.angle_radpm = cues.angle_radpm;
  seen.eccentricity_rad = cues.eccentricity_rad;
  return seen;
}

}  // namespace poise::simulation
